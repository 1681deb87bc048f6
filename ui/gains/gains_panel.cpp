#include "ui/gains/gains_panel.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QMenu>
#include <QScrollArea>
#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "core/words.h"
#include "ui/base/dialogs.h"
#include "ui/base/menus.h"
#include "ui/base/sentence.h"

namespace skein::ui {
namespace {

/// Something of the gains that goes to a new value, and back.
template <typename Value>
class Changed final : public QUndoCommand {
 public:
  using Apply = std::function<void(Value)>;
  Changed(const QString& what, Value from, Value to, Apply apply)
      : QUndoCommand(what), from_(from), to_(to), apply_(std::move(apply)) {}
  void undo() override { apply_(from_); }
  void redo() override { apply_(to_); }

 private:
  Value from_, to_;
  Apply apply_;
};

QString form_text(core::Coupling form) {
  switch (form) {
    case core::Coupling::paper:
      return GainsPanel::tr("as printed (15)");
    case core::Coupling::bounded:
      return GainsPanel::tr("bounded");
  }
  return {};
}

}  // namespace

GainsPanel::GainsPanel(QWidget* parent)
    : QWidget(parent),
      undo_button_(new QToolButton),
      redo_button_(new QToolButton),
      presets_(new QToolButton),
      reset_(new QPushButton(tr("File's values"))),
      coupling_(new QComboBox),
      ramp_(new NumberField),
      parameters_(new ParameterPanel),
      tabs_(new QTabWidget),
      margins_(new MarginBars),
      delay_(new QLabel),
      pairs_(new PairTable),
      schedule_(new ScheduleEditor) {
  setObjectName(QStringLiteral("gains"));
  // Nothing above has a parent before it is laid out: Tab goes from the top down.
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  layout->setSpacing(7);
  for (const core::GainName gain : core::gain_names) {
    auto* slider = new GainSlider(gain, this);
    sliders_[static_cast<std::size_t>(gain)] = slider;
    connect(slider, &GainSlider::wanted, this, &GainsPanel::change);
    connect(slider, &GainSlider::refused, this, &GainsPanel::refused);
    connect(slider, &GainSlider::held, this, &GainsPanel::held);
    connect(slider, &GainSlider::let_go, this, &GainsPanel::let_go);
    controls_.push_back(slider);
    layout->addWidget(slider);
  }

  of_gains_.assign(sliders_.begin(), sliders_.end());
  layout->addWidget(parameters_);
  connect(parameters_, &ParameterPanel::wanted, this, &GainsPanel::change_parameter);
  connect(parameters_, &ParameterPanel::refused, this, &GainsPanel::refused);
  connect(ramp_, &NumberField::refused, this,
          [this](const QString& why) { emit refused(tr("Change within: %1").arg(why)); });
  connect(parameters_, &ParameterPanel::held, this, &GainsPanel::parameter_held);
  connect(parameters_, &ParameterPanel::let_go, this, &GainsPanel::let_go);

  auto* row = new QHBoxLayout;
  row->setSpacing(4);
  const auto tool = [&](QToolButton* button, const QString& name, const QString& text, const QString& tip) {
    button->setObjectName(name);
    button->setText(text);
    button->setAccessibleName(tip);
    button->setToolTip(tip);
    row->addWidget(button);
  };
  tool(undo_button_, QStringLiteral("undo_gain"), QStringLiteral("↶"), tr("Undo the last change of a gain (Ctrl+Z)"));
  tool(redo_button_, QStringLiteral("redo_gain"), QStringLiteral("↷"), tr("Redo it (Ctrl+Shift+Z)"));
  tool(presets_, QStringLiteral("gain_presets"), tr("Presets"), tr("Sets of gains, and your own"));
  presets_->setPopupMode(QToolButton::InstantPopup);
  presets_->setMenu(new QMenu(presets_));
  connect(presets_->menu(), &QMenu::aboutToShow, this, &GainsPanel::fill_presets);
  for (auto* button : {undo_button_, redo_button_}) button->setEnabled(false);
  connect(undo_button_, &QToolButton::clicked, &undo_, &QUndoStack::undo);
  connect(redo_button_, &QToolButton::clicked, &undo_, &QUndoStack::redo);
  connect(&undo_, &QUndoStack::canUndoChanged, undo_button_, &QWidget::setEnabled);
  connect(&undo_, &QUndoStack::canRedoChanged, redo_button_, &QWidget::setEnabled);
  reset_->setObjectName(QStringLiteral("reset_gains"));
  reset_->setAccessibleName(reset_->text());
  reset_->setToolTip(tr("Back to the file's values: one for all pairs, the largest where each pair has its own."));
  connect(reset_, &QPushButton::clicked, this, [this] { use(gain_presets(experiment_).front()); });
  row->addWidget(reset_, 1);
  layout->addLayout(row);

  auto* over = new QHBoxLayout;
  ramp_->setObjectName(QStringLiteral("gain_ramp"));
  ramp_->setAccessibleName(tr("How long a change of a gain takes, in seconds"));
  ramp_->setRange(0.0, 600.0);
  ramp_->setDecimals(1);
  ramp_->setSuffix(tr(" s"));
  ramp_->setSpecialValueText(tr("as fast as is safe"));
  ramp_->setToolTip(
      tr("During a run a gain goes to its new value along a ramp of this length. Never faster than from zero to full "
         "authority in 5 s: Theorem 1 requires continuous gains. Before a start it changes at once."));
  of_gains_.push_back(new QLabel(tr("Change within"), this));
  over->addWidget(of_gains_.back());
  over->addWidget(ramp_, 1);
  layout->addLayout(over);

  auto* form = new QHBoxLayout;
  auto* label = new QLabel(tr("Coupling"), this);
  coupling_->setObjectName(QStringLiteral("coupling"));
  coupling_->setAccessibleName(tr("Form of the couplings"));
  for (const core::Coupling coupling : core::all_of<core::Coupling>())
    coupling_->addItem(form_text(coupling), QString::fromUtf8(word(coupling).data()));
  coupling_->setToolTip(
      tr("As printed, the forward and heading couplings may exceed their gains, and commands are limited after the "
         "law; bounded, (18f, g) imply the limits (14). Can be changed before the start only."));
  connect(coupling_, &QComboBox::activated, this, [this] {
    emit experiment_wanted(QStringLiteral("controller.coupling=") + coupling_->currentData().toString());
  });
  form->addWidget(label);
  form->addWidget(coupling_, 1);
  layout->addLayout(form);
  controls_.insert(controls_.end(), {presets_, reset_, ramp_, parameters_});
  of_gains_.insert(of_gains_.end(), {presets_, reset_, ramp_, label, coupling_, tabs_});

  auto* scroll = new QScrollArea(this);  // for groups of many robots
  scroll->setFrameShape(QFrame::NoFrame);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->viewport()->setAutoFillBackground(false);
  scroll->setWidget(margins_);
  margins_->setAutoFillBackground(false);
  scroll->setAccessibleName(tr("Margins, robot by robot"));  // it takes the focus, to be scrolled
  tabs_->setObjectName(QStringLiteral("gain_tabs"));
  tabs_->setAccessibleName(tr("Margins and schedule"));
  tabs_->setDocumentMode(true);
  delay_->setObjectName(QStringLiteral("delay_margin"));
  delay_->setToolTip(
      tr("The smallest delay margin of all robots with this reference, from a pose to the wheels' response, and the "
         "present delay. Prediction compensates the known part of the delay: the loops tolerate more than this."));
  delay_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  auto* margins = new QWidget;
  auto* margins_layout = new QVBoxLayout(margins);
  margins_layout->setContentsMargins(0, 2, 0, 0);
  margins_layout->setSpacing(2);
  margins_layout->addWidget(scroll, 1);
  margins_layout->addWidget(delay_);
  tabs_->addTab(margins, tr("Margins"));
  tabs_->addTab(pairs_, tr("Pairs"));
  tabs_->addTab(schedule_, tr("Schedule"));
  tabs_->setTabToolTip(0, tr("What reference and couplings leave to tracking"));
  tabs_->setTabToolTip(1, tr("The gains of every pair of robots; couplings that are switched off"));
  tabs_->setTabToolTip(2, tr("Gains that change by themselves during the run"));
  layout->addWidget(tabs_, 1);
  layout->addStretch();
  connect(pairs_, &PairTable::gain_wanted, this, &GainsPanel::change_pair);
  connect(pairs_, &PairTable::couple_wanted, this, &GainsPanel::couple_pair);
  connect(pairs_, &PairTable::refused, this, &GainsPanel::refused);
  connect(schedule_, &ScheduleEditor::refused, this, &GainsPanel::refused);
  connect(schedule_, &ScheduleEditor::wanted, this,
          [this](const QString& changes) { emit experiment_wanted(QStringLiteral("gain_change=") + changes); });
}

void GainsPanel::show_experiment(const app::Experiment& experiment, const GainValue& limit) {
  experiment_ = experiment;
  undo_.clear();
  for (const core::GainName gain : core::gain_names) {
    const double value = core::table(experiment.controller.gains, gain).largest();
    slider(gain)->reset(value, limit(gain));
    targets_[static_cast<std::size_t>(gain)] = value;
  }
  const app::LawSpec& law = experiment.controller.law;
  for (QWidget* part : of_gains_) part->setVisible(law.uses_gains());
  parameters_->setVisible(!law.of_the_paper());
  parameters_->clear(law.own()
                         ? tr("The experiment's controller has declared no parameters.")
                         : tr("The law %1 has no parameters to change.").arg(QString::fromUtf8(word(law.kind).data())));
  setEnabled(has_anything_to_set(experiment));
  coupling_->setCurrentIndex(coupling_->findData(QString::fromUtf8(word(experiment.controller.coupling).data())));
  margins_->show_experiment(experiment);
  pairs_->show_robots(experiment.robots.size());
  schedule_->show_experiment(experiment);
}

void GainsPanel::show_record(const app::TickRecord& record) {
  slider(core::GainName::k_xx)->set_now(record.k_xx);
  slider(core::GainName::k_tt)->set_now(record.k_tt);
  slider(core::GainName::k_yy)->set_now(record.k_yy);
  // The file's own changes and what was held at the limit come back as events; both say where the gain goes now.
  const auto goes_to = [this](core::GainName gain, double target) {
    if (gain > core::gain_names.back()) return;  // slopes and weights have no slider
    slider(gain)->set_target(target);
    targets_[static_cast<std::size_t>(gain)] = target;
  };
  for (const app::Event& event : record.events) {
    if (const auto* const asked = std::get_if<app::events::Gain>(&event)) goes_to(asked->gain, asked->to);
    if (const auto* const due = std::get_if<app::events::Schedule>(&event)) goes_to(due->gain, due->to);
    if (const auto* const held = std::get_if<app::events::GainHeld>(&event)) {
      goes_to(held->gain, held->held);
      slider(held->gain)->note_held(held->asked, held->held);
    }
  }
  margins_->show_record(record);
}

void GainsPanel::set_limits(const GainValue& over_all, const GainValue& now) {
  for (const core::GainName gain : core::gain_names) slider(gain)->set_limit(over_all(gain), now(gain));
}

void GainsPanel::set_remedy(const Remedy& remedy) {
  for (const core::GainName gain : core::gain_names)
    slider(gain)->set_remedy([remedy, gain](double wanted) { return remedy(gain, wanted); });
}

void GainsPanel::follow_targets(const GainValue& target) {
  for (const core::GainName gain : core::gain_names) {
    const double value = target(gain);
    slider(gain)->follow_target(value);
    if (std::abs(slider(gain)->target() - value) < 0.5e-4) targets_[static_cast<std::size_t>(gain)] = value;
  }
}

void GainsPanel::show_delay_margin(const QString& text, bool short_) {
  const Colours c = colours(palette());
  const QString shown =
      short_ ? QStringLiteral("<b style=\"color:%1\">%2</b>").arg(c.alarm.name(), text.toHtmlEscaped()) : text;
  if (delay_->text() != shown) delay_->setText(shown);
}

void GainsPanel::set_fixed(const QString& why) {
  const bool fixed = !why.isEmpty();
  for (QWidget* control : controls_) control->setEnabled(!fixed);
  undo_button_->setEnabled(!fixed && undo_.canUndo());
  redo_button_->setEnabled(!fixed && undo_.canRedo());
  pairs_->set_fixed(fixed);
  setToolTip(why);
}

void GainsPanel::set_before_start(bool before) {
  coupling_->setEnabled(before);
  schedule_->set_editable(before);
}

void GainsPanel::change(core::GainName gain, double value) {
  const double from = targets_[static_cast<std::size_t>(gain)];
  const QString what = tr("%1 to %2").arg(gain_symbol(gain)).arg(value, 0, 'g', 4);
  undo_.push(new Changed<double>(what, from, value, [this, gain](double to) {
    slider(gain)->set_target(to);
    targets_[static_cast<std::size_t>(gain)] = to;
    emit wanted(gain, to);
  }));
}

void GainsPanel::change_pair(core::GainName gain, int i, int j, double value) {
  if (!ask_) return;
  const double from = ask_(gain, static_cast<std::size_t>(i), static_cast<std::size_t>(j)).target;
  const QString what = tr("%1 of %2 and %3").arg(gain_symbol(gain)).arg(i + 1).arg(j + 1);
  undo_.push(
      new Changed<double>(what, from, value, [this, gain, i, j](double to) { emit pair_wanted(gain, i, j, to); }));
}

void GainsPanel::couple_pair(int i, int j, bool on) {
  const QString what = tr("coupling of %1 and %2").arg(i + 1).arg(j + 1);
  undo_.push(new Changed<bool>(what, !on, on, [this, i, j](bool to) { emit couple_wanted(i, j, to); }));
}

void GainsPanel::change_parameter(const QString& name, double from, double to) {
  undo_.push(new Changed<double>(tr("%1 to %2").arg(name).arg(to, 0, 'g', 4), from, to, [this, name](double value) {
    parameters_->set(name, value);
    emit parameter_wanted(name, value);
  }));
}

void GainsPanel::set_no_preview(const QString& why) {
  for (GainSlider* slider : sliders_) slider->set_no_preview(why);
  parameters_->set_no_preview(why);
}

bool GainsPanel::has_anything_to_set(const app::Experiment& experiment) {
  return experiment.robots.size() > 1 || !experiment.controller.law.uses_gains();
}

QWidget* GainsPanel::first_control() const {
  if (experiment_.controller.law.uses_gains()) return slider(core::GainName::k_xx)->first_control();
  return parameters_->first_control();
}

void GainsPanel::switch_pair(int i, int j) {
  if (ask_)
    couple_pair(i, j, !ask_(core::GainName::k_xx, static_cast<std::size_t>(i), static_cast<std::size_t>(j)).coupled);
}

void GainsPanel::refresh_pairs() {
  if (ask_ && pairs_->isVisible()) pairs_->refresh(ask_);  // asking for a crowd takes time
}

void GainsPanel::use(const GainPreset& preset) {
  undo_.beginMacro(preset.name);
  // Down first: what one of them gives back, another may need below the common limit of (18g).
  for (const bool down : {true, false})
    for (const core::GainName gain : core::gain_names) {
      const double value = preset.values[static_cast<std::size_t>(gain)];
      if ((value <= targets_[static_cast<std::size_t>(gain)]) == down) change(gain, value);
    }
  undo_.endMacro();
}

void GainsPanel::fill_presets() {
  QMenu* menu = presets_->menu();
  clear_menu(menu);
  QMenu* forget = nullptr;
  for (const GainPreset& preset : gain_presets(experiment_)) {
    if (preset.own && !forget) {
      menu->addSeparator();
      forget = new QMenu(tr("Forget"), menu);
    }
    QAction* action = menu->addAction(preset.name, this, [this, preset] { use(preset); });
    action->setToolTip(
        tr("k_xx %1, k_θθ %2, k_yy %3").arg(preset.values[0]).arg(preset.values[1]).arg(preset.values[2]));
    if (preset.own) forget->addAction(preset.name, this, [name = preset.name] { forget_gain_preset(name); });
  }
  menu->addSeparator();
  menu->addAction(tr("Save the present gains …"), this, &GainsPanel::keep_as_preset)
      ->setObjectName(QStringLiteral("keep_preset"));
  if (forget) menu->addMenu(forget);
}

void GainsPanel::keep_as_preset() {
  ask_name(this, QStringLiteral("preset_dialog"), tr("Save the present gains"),
           [values = targets_](const QString& name) {
             keep_gain_preset({name, values, true});
           });
}

}  // namespace skein::ui
