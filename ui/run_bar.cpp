#include "ui/run_bar.h"

#include <QEvent>
#include <QHBoxLayout>
#include <QVBoxLayout>
#include <algorithm>

#include "ui/icons.h"
#include "ui/modes.h"
#include "ui/palette.h"

namespace skein::ui {

RunBar::RunBar(QWidget* parent)
    : QWidget(parent),
      name_(new QLabel(this)),
      phase_(new QLabel(this)),
      time_(new QLabel(this)),
      go_(new QPushButton(this)),
      new_run_(new QPushButton(tr("New run"), this)),
      stop_(new QPushButton(tr("STOP"), this)),
      time_line_(new TimeLine(this)) {
  setObjectName(QStringLiteral("run_bar"));
  name_->setObjectName(QStringLiteral("experiment_name"));
  phase_->setObjectName(QStringLiteral("phase"));
  phase_->setAccessibleName(tr("Phase of the run"));
  time_->setObjectName(QStringLiteral("time"));
  time_->setToolTip(tr("elapsed / remaining"));
  go_->setObjectName(QStringLiteral("go"));
  new_run_->setObjectName(QStringLiteral("new_run"));
  new_run_->setAccessibleName(new_run_->text());
  new_run_->setToolTip(tr("Ends this run and sets the same experiment up again (Ctrl+N)"));
  stop_->setObjectName(QStringLiteral("stop"));
  stop_->setAccessibleName(tr("STOP all robots"));
  stop_->setToolTip(tr("Stops all robots at once and ends the run (Space or Esc, always)"));
  stop_->setFocusPolicy(Qt::NoFocus);
  stop_->setMinimumSize(150, 56);

  QFont bold = font();
  bold.setBold(true);
  name_->setFont(bold);
  for (auto* button : {go_, new_run_}) {
    button->setMinimumHeight(36);
    button->setIconSize({18, 18});
  }
  go_->setMinimumWidth(104);
  go_->setFont(bold);
  // As wide as the widest text: what follows does not jump about.
  time_->setMinimumWidth(fontMetrics().horizontalAdvance(QStringLiteral("0000.0 s / −0000.0 s")));
  phase_->setMinimumWidth(QFontMetrics(bold).horizontalAdvance(tr("● Opening …")) + 8);
  time_->setAlignment(Qt::AlignRight | Qt::AlignVCenter);

  auto* texts = new QVBoxLayout;
  texts->setSpacing(2);
  texts->addStretch();
  texts->addWidget(name_);
  texts->addWidget(phase_);
  texts->addStretch();
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(10, 6, 10, 6);
  layout->setSpacing(10);
  layout->addLayout(texts);
  layout->addSpacing(6);
  layout->addWidget(go_);
  layout->addWidget(new_run_);
  layout->addWidget(time_line_, 1);
  layout->addWidget(time_);
  layout->addSpacing(6);
  layout->addWidget(stop_);

  connect(go_, &QPushButton::clicked, this, &RunBar::go);
  connect(new_run_, &QPushButton::clicked, this, &RunBar::new_run);
  // On the way down: nobody waits for the finger to lift.
  connect(stop_, &QPushButton::pressed, this, &RunBar::stop);
  dress();
  show_phase(app::Phase::ready, 0.0, true, false);
}

void RunBar::show_experiment(const app::Experiment& experiment) {
  duration_ = experiment.duration;
  const QString name = QString::fromStdString(experiment.name);
  name_->setText(fontMetrics().elidedText(name, Qt::ElideRight, 190));
  name_->setToolTip(name);
  time_line_->show_experiment(experiment);
}

void RunBar::show_phase(app::Phase phase, double t, bool busy, bool failed) {
  using app::Phase;
  const Colours c = colours(palette());
  const QString text = busy ? tr("Opening …") : failed ? tr("Failed") : phase_text(phase);
  const QColor colour = busy                      ? c.faint_text
                        : failed                  ? c.alarm
                        : phase == Phase::stopped ? c.alarm
                        : phase == Phase::running ? c.good
                        : phase == Phase::paused  ? c.warning
                                                  : c.notice;
  const QString shown =
      QStringLiteral("<span style=\"color:%1; font-weight:600\">● %2</span>").arg(colour.name(), text);
  if (phase_->text() != shown) phase_->setText(shown);
  time_->setText(tr("%1 s / −%2 s").arg(t, 0, 'f', 1).arg(std::max(0.0, duration_ - t), 0, 'f', 1));

  const bool over = phase == Phase::stopped || phase == Phase::finished;
  go_->setEnabled(!busy && !failed && !over);
  new_run_->setEnabled(!busy);
  const QString look = phase == Phase::running  ? QStringLiteral("pause")
                       : phase == Phase::paused ? QStringLiteral("resume")
                                                : QStringLiteral("start");
  if (look == look_) return;
  look_ = look;
  go_->setText(look == QStringLiteral("pause")    ? tr("Pause")
               : look == QStringLiteral("resume") ? tr("Resume")
                                                  : tr("Start"));
  go_->setAccessibleName(go_->text());
  go_->setToolTip(go_->text() + QStringLiteral(" (F5)"));
  go_->setIcon(icon(look == QStringLiteral("pause") ? look : QStringLiteral("start"), c.text));
}

void RunBar::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) dress();
  QWidget::changeEvent(event);
}

void RunBar::dress() {
  const Colours c = colours(palette());
  new_run_->setIcon(icon(QStringLiteral("new-run"), c.text));
  look_.clear();  // the next show_phase draws the other icon
  const QString sheet = QStringLiteral(
      "QPushButton { background: #c8102e; color: white; border: 2px solid #8f0b20; border-radius: 8px;"
      " font-weight: 800; font-size: 17pt; padding: 0 14px; }"
      "QPushButton:hover { background: #dc1f3e; } QPushButton:pressed { background: #8f0b20; }");
  if (stop_->styleSheet() != sheet) stop_->setStyleSheet(sheet);
}

}  // namespace skein::ui
