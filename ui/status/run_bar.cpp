#include "ui/status/run_bar.h"

#include <QAbstractItemView>
#include <QEvent>
#include <QHBoxLayout>
#include <QVBoxLayout>
#include <algorithm>
#include <iterator>

#include "app/session/session.h"
#include "ui/base/icons.h"
#include "ui/base/modes.h"
#include "ui/base/palette.h"

namespace skein::ui {
namespace {

constexpr double speeds[] = {app::Session::slowest, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0,
                             app::Session::fastest};  // times real time

}  // namespace

RunBar::RunBar(QWidget* parent)
    : QWidget(parent),
      rest_(new QWidget(this)),
      name_(new ElidingLabel),
      phase_(new ElidingLabel),
      time_(new QLabel),
      go_(new FoldingButton),
      new_run_(new FoldingButton),
      record_(new FoldingButton(tr("Record"))),
      step_(new QPushButton),
      stop_(new QPushButton(tr("STOP"), this)),
      speed_(new QComboBox),
      time_line_(new TimeLine) {
  // Of the rest, nothing has a parent before it is laid out: Tab goes from the left to the right.
  setObjectName(QStringLiteral("run_bar"));
  name_->setObjectName(QStringLiteral("experiment_name"));
  phase_->setObjectName(QStringLiteral("phase"));
  time_->setObjectName(QStringLiteral("time"));
  time_->setToolTip(tr("elapsed / remaining"));
  go_->setObjectName(QStringLiteral("go"));
  step_->setObjectName(QStringLiteral("step"));
  step_->setAccessibleName(tr("One tick on"));
  new_run_->setObjectName(QStringLiteral("new_run"));
  record_->setObjectName(QStringLiteral("record"));
  record_->setAccessibleName(tr("Record the run as CSV"));
  record_->setCheckable(true);
  speed_->setObjectName(QStringLiteral("speed"));
  speed_->setAccessibleName(tr("Speed"));
  for (const double speed : speeds) speed_->addItem(tr("%1×").arg(speed), speed);
  speed_->setCurrentIndex(speed_->findData(1.0));
  speed_->setSizeAdjustPolicy(QComboBox::AdjustToContents);
  speed_->setMaxVisibleItems(static_cast<int>(std::size(speeds)));
  stop_->setObjectName(QStringLiteral("stop"));
  stop_->setAccessibleName(tr("STOP all robots"));
  stop_->setToolTip(tr("Stops all robots at once and ends the run (Space or Esc, always)"));
  stop_->setFocusPolicy(Qt::NoFocus);

  QFont bold = font();
  bold.setBold(true);
  name_->setFont(bold);
  for (QPushButton* button : std::initializer_list<QPushButton*>{go_, step_, new_run_, record_}) {
    button->setMinimumHeight(36);
    button->setIconSize({18, 18});
  }
  speed_->setMinimumHeight(36);
  go_->setFont(bold);
  phase_->setFont(bold);
  time_->setAlignment(Qt::AlignRight | Qt::AlignVCenter);

  texts_ = new QVBoxLayout;
  texts_->setSpacing(2);
  texts_->addStretch();
  texts_->addWidget(name_);
  texts_->addWidget(phase_);
  texts_->addStretch();
  beside_ = new QHBoxLayout;
  beside_->setSpacing(8);
  beside_->addLayout(texts_);
  beside_->addSpacing(4);
  beside_->addWidget(go_);
  beside_->addWidget(step_);
  beside_->addWidget(speed_);
  beside_->addWidget(new_run_);
  beside_->addWidget(record_);
  beside_->addWidget(time_line_);
  below_ = new QHBoxLayout;
  below_->setSpacing(8);
  auto* lines = new QVBoxLayout;
  lines->setSpacing(2);
  lines->addLayout(beside_, 1);
  lines->addLayout(below_);
  auto* before_stop = new QHBoxLayout(rest_);
  before_stop->setContentsMargins(0, 0, 0, 0);
  before_stop->setSpacing(8);
  before_stop->addLayout(lines, 1);
  before_stop->addWidget(time_);
  // STOP first: the rest has what it leaves, however little that is, and never asks for a window wider than a screen.
  rest_->setMinimumWidth(1);
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(10, 6, 10, 6);
  layout->setSpacing(14);
  layout->addWidget(rest_, 1);
  layout->addWidget(stop_);

  connect(go_, &QPushButton::clicked, this, &RunBar::go);
  connect(step_, &QPushButton::clicked, this, &RunBar::step);
  connect(new_run_, &QPushButton::clicked, this, &RunBar::new_run);
  connect(record_, &QPushButton::clicked, this, &RunBar::record_wanted);
  connect(speed_, &QComboBox::activated, this,
          [this](int index) { emit speed_wanted(speed_->itemData(index).toDouble()); });
  // On the way down: nobody waits for the finger to lift.
  connect(stop_, &QPushButton::pressed, this, &RunBar::stop);
  dress();
  RunState nothing;
  nothing.words = tr("Opening …");
  nothing.new_run_text = tr("New run");
  show_state(nothing);
  set_tightness(0);
}

void RunBar::set_tightness(int tightness) {
  const bool below = tightness >= 3, folds = tightness >= (below ? 4 : 1);  // below the buttons, they have room again
  has_short_time_ = tightness >= (below ? 5 : 2);
  const bool folds_go = tightness >= 6;
  new_run_->set_folded(folds);
  record_->set_folded(folds);
  go_->set_folded(folds_go);
  const int around = go_->iconSize().width() + 40;
  const int widest = QFontMetrics(go_->font()).horizontalAdvance(tr("Resume")) + around;
  go_->setMinimumWidth(folds_go ? 44 : std::max(104, widest));
  // As wide as the widest text: what follows does not jump about.
  time_->setMinimumWidth(fontMetrics().horizontalAdvance(has_short_time_ ? QStringLiteral("0000.0 s")
                                                                         : QStringLiteral("0000.0 s / −0000.0 s")));
  const bool phase_below = tightness >= tightest;
  name_->setVisible(!phase_below);  // the window's title has it
  phase_->setMinimumWidth(phase_below ? 0
                                      : QFontMetrics(phase_->font()).horizontalAdvance(tr("● Running, at 10.0×")) + 8);
  if (phase_below)
    put(phase_, below_, 0);
  else
    put(phase_, texts_, texts_->indexOf(name_) + 1);
  put(time_line_, below ? below_ : beside_, -1);
  time_line_->set_flat(below);
  beside_->setStretchFactor(texts_, below ? 1 : 0);  // who has the room that is left
  show_time();
  // Each by itself: the outermost would go by what those inside remember of other texts.
  for (QLayout* line : rest_->findChildren<QLayout*>()) line->invalidate();
}

/// Into this line at this place, out of another: nobody would have to do without it to go through a replay.
void RunBar::put(QWidget* widget, QBoxLayout* into, int place) {
  if (into->indexOf(widget) >= 0) return;
  for (QBoxLayout* line : std::initializer_list<QBoxLayout*>{texts_, beside_, below_}) line->removeWidget(widget);
  into->insertWidget(place, widget);
}

void RunBar::fit() {
  const QMargins around = layout()->contentsMargins();
  const int room = width() - around.left() - around.right() - layout()->spacing() - stop_->minimumWidth();
  for (int tightness = 0; tightness <= tightest; ++tightness) {
    set_tightness(tightness);
    if (rest_->layout()->minimumSize().width() <= room) break;
  }
}

void RunBar::resizeEvent(QResizeEvent* event) {
  QWidget::resizeEvent(event);
  fit();
}

void RunBar::show_time() {
  const QString now = tr("%1 s").arg(t_, 0, 'f', 1);
  if (!has_time_)
    time_->clear();
  else if (!end_ || has_short_time_)
    time_->setText(now);
  else
    time_->setText(tr("%1 / −%2 s").arg(now).arg(std::max(0.0, *end_ - t_), 0, 'f', 1));
}

void RunBar::show_experiment(const app::Experiment& experiment) {
  const QString name = QString::fromStdString(experiment.name);
  name_->setText(name);
  name_->setToolTip(name);
  time_line_->show_experiment(experiment);
}

void RunBar::show_state(const RunState& state) {
  const QString shown = phase_text_of(state);
  if (phase_->text() != shown) phase_->setText(shown);
  if (phase_->toolTip() != shown) phase_->setToolTip(shown);
  phase_->set_ink(colour(state.tone, colours(palette())));
  t_ = state.t;
  end_ = state.end;
  has_time_ = state.has_time;
  show_time();
  show_go(state);
  show_rest(state);
}

QString RunBar::phase_text_of(const RunState& state) {
  QString text = state.words;
  // How fast it really goes, where that is not one second a second.
  if (!state.moves || state.speed == 1.0 || state.t < since_t_) {
    since_.invalidate();
    pace_ = state.speed;
  } else if (since_.isValid() && since_.hasExpired(1000)) {
    pace_ = (state.t - since_t_) / (1e-3 * static_cast<double>(since_.restart()));
    since_t_ = state.t;
  }
  if (!since_.isValid()) {
    since_.start();
    since_t_ = state.t;
  }
  if (state.moves && state.speed != 1.0) text += tr(", at %1×").arg(pace_, 0, 'f', pace_ < 10.0 ? 1 : 0);
  return QStringLiteral("● ") + text;
}

void RunBar::show_go(const RunState& state) {
  go_->setEnabled(state.may_go);
  if (state.go == shown_go_) return;
  shown_go_ = state.go;
  QString tip;
  switch (state.go) {
    case RunState::Go::start:
      go_->setText(tr("Start"));
      break;
    case RunState::Go::pause:
      go_->setText(tr("Pause"));
      break;
    case RunState::Go::resume:
      go_->setText(tr("Resume"));
      break;
    case RunState::Go::play:
      go_->setText(tr("Play"));
      break;
    case RunState::Go::again:
      go_->setText(tr("Set up"));
      tip = tr("Sets the same experiment up again; nothing moves yet (F5)");
      break;
  }
  go_->setAccessibleName(go_->text());
  go_->setToolTip(tip.isEmpty() ? go_->text() + QStringLiteral(" (F5)") : tip);
  const bool pauses = state.go == RunState::Go::pause;
  go_->setIcon(icon(pauses ? QStringLiteral("pause") : QStringLiteral("start"), colours(palette()).text));
}

void RunBar::show_rest(const RunState& state) {
  const auto show = [](QWidget* button, const Offer& offer) {
    button->setEnabled(offer.possible);
    button->setToolTip(offer.tip);
  };
  show(step_, state.step);
  show(speed_, state.change_speed);
  if (!speed_->view()->isVisible()) speed_->setCurrentIndex(speed_->findData(state.speed));
  show(new_run_, state.new_run);
  if (new_run_->text() != state.new_run_text) {
    new_run_->setText(state.new_run_text);
    new_run_->setAccessibleName(state.new_run_text);
    fit();
  }
  show(record_, state.record);
  record_->setChecked(state.records);
}

void RunBar::pick_speed(int steps) {
  const int index = std::clamp(speed_->currentIndex() + steps, 0, speed_->count() - 1);
  if (speed_->isEnabled() && index != speed_->currentIndex()) emit speed_wanted(speed_->itemData(index).toDouble());
}

void RunBar::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) dress();
  QWidget::changeEvent(event);
}

void RunBar::dress() {
  const Colours c = colours(palette());
  new_run_->setIcon(icon(QStringLiteral("new-run"), c.text));
  step_->setIcon(icon(QStringLiteral("step"), c.text));
  record_->setIcon(icon(QStringLiteral("record"), c.alarm));
  shown_go_.reset();  // the next show_state draws the other icon
  const QString sheet = QStringLiteral(
      "QPushButton { background: #c8102e; color: white; border: 2px solid #8f0b20; border-radius: 8px;"
      " font-weight: 800; font-size: 17pt; padding: 0 14px; }"
      "QPushButton:hover { background: #dc1f3e; } QPushButton:pressed { background: #8f0b20; }");
  if (stop_->styleSheet() == sheet) return;
  stop_->setStyleSheet(sheet);
  stop_->ensurePolished();
  stop_->setMinimumSize(QSize(150, 56).expandedTo(stop_->minimumSizeHint()));  // a desktop may enlarge its text, too
}

}  // namespace skein::ui
