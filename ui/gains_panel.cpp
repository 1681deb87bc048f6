#include "ui/gains_panel.h"

#include <QLabel>
#include <QScrollArea>
#include <QVBoxLayout>

namespace skein::ui {

GainsPanel::GainsPanel(QWidget* parent)
    : QWidget(parent), reset_(new QPushButton(tr("Back to the file's values"), this)), margins_(new MarginBars) {
  setObjectName(QStringLiteral("gains"));
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  layout->setSpacing(8);
  for (const core::GainName gain : core::gain_names) {
    auto* slider = new GainSlider(gain, this);
    sliders_[static_cast<std::size_t>(gain)] = slider;
    connect(slider, &GainSlider::wanted, this, &GainsPanel::wanted);
    layout->addWidget(slider);
  }
  reset_->setObjectName(QStringLiteral("reset_gains"));
  reset_->setAccessibleName(reset_->text());
  reset_->setToolTip(tr("One value for all pairs: the largest, where the file gives each pair its own."));
  connect(reset_, &QPushButton::clicked, this, &GainsPanel::reset_to_file);
  layout->addWidget(reset_);
  layout->addSpacing(2);

  auto* title = new QLabel(tr("Left to tracking"), this);
  QFont bold = title->font();
  bold.setBold(true);
  title->setFont(bold);
  layout->addWidget(title);
  auto* scroll = new QScrollArea(this);  // for groups of many robots
  scroll->setFrameShape(QFrame::NoFrame);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->viewport()->setAutoFillBackground(false);
  margins_->setAutoFillBackground(false);
  scroll->setWidget(margins_);
  margins_->setAutoFillBackground(false);
  layout->addWidget(scroll, 1);
}

void GainsPanel::show_experiment(const app::Experiment& experiment, const Border& border) {
  experiment_ = experiment;
  for (const core::GainName gain : core::gain_names)
    slider(gain)->reset(core::table(experiment.controller.gains, gain).largest(), border(gain));
  setEnabled(experiment.robots.size() > 1);  // one robot alone has nobody to couple to
  margins_->show_experiment(experiment);
}

void GainsPanel::take(const app::TickRecord& record) {
  slider(core::GainName::k_xx)->set_now(record.k_xx);
  slider(core::GainName::k_tt)->set_now(record.k_tt);
  slider(core::GainName::k_yy)->set_now(record.k_yy);
  // The file's own changes and what was held at the border come back as events; both say where the gain goes now.
  for (const app::Event& event : record.events)
    if (event.kind == app::Event::Kind::gain || event.kind == app::Event::Kind::schedule ||
        event.kind == app::Event::Kind::gain_held)
      slider(event.gain)->set_target(event.values[1]);
  margins_->take(record);
}

void GainsPanel::set_borders(const Border& border) {
  for (const core::GainName gain : core::gain_names) slider(gain)->set_border(border(gain));
}

void GainsPanel::reset_to_file() {
  for (const core::GainName gain : core::gain_names) {
    const double value = core::table(experiment_.controller.gains, gain).largest();
    slider(gain)->set_target(value);
    emit wanted(gain, value);
  }
}

}  // namespace skein::ui
