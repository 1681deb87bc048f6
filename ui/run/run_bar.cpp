#include "ui/run/run_bar.h"

#include <QAbstractItemView>
#include <QEvent>
#include <QHBoxLayout>
#include <QVBoxLayout>
#include <algorithm>
#include <iterator>

#include "ui/icons.h"
#include "ui/modes.h"
#include "ui/palette.h"

namespace skein::ui {
namespace {

constexpr double speeds[] = {0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0};  // times real time

}  // namespace

RunBar::RunBar(QWidget* parent)
    : QWidget(parent),
      name_(new QLabel(this)),
      phase_(new QLabel(this)),
      time_(new QLabel(this)),
      go_(new QPushButton(this)),
      step_(new QPushButton(this)),
      new_run_(new QPushButton(this)),
      record_(new QPushButton(tr("Record"), this)),
      stop_(new QPushButton(tr("STOP"), this)),
      speed_(new QComboBox(this)),
      time_line_(new TimeLine(this)) {
  setObjectName(QStringLiteral("run_bar"));
  name_->setObjectName(QStringLiteral("experiment_name"));
  phase_->setObjectName(QStringLiteral("phase"));
  phase_->setAccessibleName(tr("Phase of the run"));
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
  speed_->setMaxVisibleItems(static_cast<int>(std::size(speeds)));
  stop_->setObjectName(QStringLiteral("stop"));
  stop_->setAccessibleName(tr("STOP all robots"));
  stop_->setToolTip(tr("Stops all robots at once and ends the run (Space or Esc, always)"));
  stop_->setFocusPolicy(Qt::NoFocus);
  stop_->setMinimumSize(150, 56);

  QFont bold = font();
  bold.setBold(true);
  name_->setFont(bold);
  for (auto* button : {go_, step_, new_run_, record_}) {
    button->setMinimumHeight(36);
    button->setIconSize({18, 18});
  }
  speed_->setMinimumHeight(36);
  go_->setMinimumWidth(104);
  go_->setFont(bold);
  // As wide as the widest text: what follows does not jump about.
  time_->setMinimumWidth(fontMetrics().horizontalAdvance(QStringLiteral("0000.0 s / −0000.0 s")));
  phase_->setMinimumWidth(QFontMetrics(bold).horizontalAdvance(tr("● Running, at 10.0×")) + 8);
  time_->setAlignment(Qt::AlignRight | Qt::AlignVCenter);

  auto* texts = new QVBoxLayout;
  texts->setSpacing(2);
  texts->addStretch();
  texts->addWidget(name_);
  texts->addWidget(phase_);
  texts->addStretch();
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(10, 6, 10, 6);
  layout->setSpacing(8);
  layout->addLayout(texts);
  layout->addSpacing(4);
  layout->addWidget(go_);
  layout->addWidget(step_);
  layout->addWidget(speed_);
  layout->addWidget(new_run_);
  layout->addWidget(record_);
  layout->addWidget(time_line_, 1);
  layout->addWidget(time_);
  layout->addSpacing(6);
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
  nothing.busy = true;
  show_state(nothing);
}

void RunBar::show_experiment(const app::Experiment& experiment) {
  duration_ = experiment.duration;
  const QString name = QString::fromStdString(experiment.name);
  name_->setText(fontMetrics().elidedText(name, Qt::ElideRight, 150));
  name_->setToolTip(name);
  time_line_->show_experiment(experiment);
}

void RunBar::show_state(const RunState& state) {
  const QString shown = phase_text_of(state);
  if (phase_->text() != shown) phase_->setText(shown);
  time_->setText(tr("%1 s / −%2 s").arg(state.t, 0, 'f', 1).arg(std::max(0.0, duration_ - state.t), 0, 'f', 1));
  show_go(state);
  show_rest(state);
}

QString RunBar::phase_text_of(const RunState& state) {
  using app::Phase;
  const Colours c = colours(palette());
  QString text = state.busy ? tr("Opening …") : state.failed ? tr("Failed") : phase_text(state.phase);
  if (state.replay) text = state.phase == Phase::running ? tr("Replay") : tr("Replay, paused");
  // How fast it really goes, where that is not one second a second.
  const bool running = state.phase == Phase::running && !state.busy && !state.failed;
  if (!running || state.speed == 1.0 || state.t < since_t_) {
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
  if (running && state.speed != 1.0) text += tr(", at %1×").arg(pace_, 0, 'f', pace_ < 10.0 ? 1 : 0);
  const QColor colour = state.busy                      ? c.faint_text
                        : state.failed                  ? c.alarm
                        : state.phase == Phase::stopped ? c.alarm
                        : state.replay                  ? c.notice
                        : state.phase == Phase::running ? c.good
                        : state.phase == Phase::paused  ? c.warning
                                                        : c.notice;
  return QStringLiteral("<span style=\"color:%1; font-weight:600\">● %2</span>").arg(colour.name(), text);
}

void RunBar::show_go(const RunState& state) {
  using app::Phase;
  const bool over = state.phase == Phase::stopped || state.phase == Phase::finished;
  go_->setEnabled(!state.busy && !state.failed && !over && state.phase != Phase::staging);
  const QString look = state.phase == Phase::running  ? QStringLiteral("pause")
                       : state.replay                 ? QStringLiteral("play")
                       : state.phase == Phase::paused ? QStringLiteral("resume")
                                                      : QStringLiteral("start");
  if (look == look_) return;
  look_ = look;
  go_->setText(look == QStringLiteral("pause")    ? tr("Pause")
               : look == QStringLiteral("play")   ? tr("Play")
               : look == QStringLiteral("resume") ? tr("Resume")
                                                  : tr("Start"));
  go_->setAccessibleName(go_->text());
  go_->setToolTip(go_->text() + QStringLiteral(" (F5)"));
  go_->setIcon(icon(look == QStringLiteral("pause") ? look : QStringLiteral("start"), colours(palette()).text));
}

/// What a simulation or a replay can do and the real world cannot, and the recording.
void RunBar::show_rest(const RunState& state) {
  using app::Phase;
  const bool over = state.phase == Phase::stopped || state.phase == Phase::finished;
  const bool there = !state.busy && !state.failed;
  const bool paused = state.phase == Phase::ready || state.phase == Phase::paused;
  step_->setEnabled(there && paused && state.real_time.isEmpty());
  step_->setToolTip(!state.real_time.isEmpty() ? tr("Simulations only: %1").arg(state.real_time)
                    : paused                   ? tr("One tick on, and pause (F6)")
                                               : tr("One tick on (F6): pause first"));
  speed_->setEnabled(state.real_time.isEmpty());
  speed_->setToolTip(state.real_time.isEmpty() ? tr("How much faster than real time it goes (Ctrl+Up, Ctrl+Down)")
                                               : tr("Simulations only: %1").arg(state.real_time));
  if (!speed_->view()->isVisible()) speed_->setCurrentIndex(speed_->findData(state.speed));
  new_run_->setEnabled(!state.busy);
  const QString new_run = state.replay ? tr("Leave replay") : tr("New run");
  if (new_run_->text() != new_run) {
    new_run_->setText(new_run);
    new_run_->setAccessibleName(new_run);
    new_run_->setToolTip(state.replay ? tr("Back to the experiment, live (Ctrl+N)")
                                      : tr("Ends this run and sets the same experiment up again (Ctrl+N)"));
  }
  record_->setEnabled(!state.replay && (state.record_next || !over));
  record_->setChecked(state.record_next || !state.recording.isEmpty());
  record_->setToolTip(state.replay                 ? tr("A replay is recorded already")
                      : !state.recording.isEmpty() ? tr("Recording to %1").arg(state.recording)
                      : state.record_next
                          ? tr("Every run from now on is recorded, as CSV and the camera's film (Ctrl+R)")
                          : tr("Records this run, what was before included, and those "
                               "that follow, as CSV (Ctrl+R)"));
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
  look_.clear();  // the next show_state draws the other icon
  const QString sheet = QStringLiteral(
      "QPushButton { background: #c8102e; color: white; border: 2px solid #8f0b20; border-radius: 8px;"
      " font-weight: 800; font-size: 17pt; padding: 0 14px; }"
      "QPushButton:hover { background: #dc1f3e; } QPushButton:pressed { background: #8f0b20; }");
  if (stop_->styleSheet() != sheet) stop_->setStyleSheet(sheet);
}

}  // namespace skein::ui
