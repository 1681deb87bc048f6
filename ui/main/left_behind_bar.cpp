#include "ui/main/left_behind_bar.h"

#include <QHBoxLayout>
#include <chrono>

#include "app/guard/stop_run.h"
#include "ui/base/palette.h"

namespace skein::ui {
namespace {

constexpr int refresh_ms = 1000;  // a guard may be stopping the same robots, and may have done by now

}  // namespace

LeftBehindBar::LeftBehindBar(QWidget* parent)
    : QFrame(parent),
      text_(new QLabel(this)),
      stop_(new QPushButton(tr("Stop them now"), this)),
      forget_(new QPushButton(tr("They stand"), this)) {
  setObjectName(QStringLiteral("left_behind"));
  text_->setObjectName(QStringLiteral("left_behind_text"));
  text_->setTextFormat(Qt::PlainText);
  text_->setWordWrap(true);
  stop_->setObjectName(QStringLiteral("stop_left_behind"));
  stop_->setAccessibleName(stop_->text());
  stop_->setToolTip(tr("Connects to each of these robots, and stops it"));
  forget_->setObjectName(QStringLiteral("forget_left_behind"));
  forget_->setToolTip(
      tr("When you have seen that these robots stand or are switched off: ends this message, and the attempts to stop "
         "them"));
  forget_->hide();
  const Colours c = colours(palette());
  setStyleSheet(QStringLiteral("#left_behind { background: %1; } #left_behind_text { color: white; font-weight: 600; }")
                    .arg(c.alarm_fill.name()));
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(10, 6, 10, 6);
  layout->addWidget(text_, 1);
  layout->addWidget(stop_);
  layout->addWidget(forget_);
  connect(stop_, &QPushButton::clicked, this, &LeftBehindBar::stop);
  connect(forget_, &QPushButton::clicked, this, &LeftBehindBar::forget);
  connect(&timer_, &QTimer::timeout, this, &LeftBehindBar::refresh);
  timer_.start(refresh_ms);
  hide();
  QTimer::singleShot(0, this, &LeftBehindBar::refresh);  // once it is part of a window
}

LeftBehindBar::~LeftBehindBar() {
  if (stopping_.valid()) stopping_.wait();
}

void LeftBehindBar::refresh() {
  if (stopping_.valid()) {
    if (stopping_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    failed_ = !stopping_.get();
    if (!failed_) emit stopped();
  }
  QStringList runs;
  shown_ = app::bad_ends();
  for (const app::RunMarker& run : shown_)
    runs << tr("The run \"%1\" ended badly, and its robots may still be driving: %2.")
                .arg(QString::fromStdString(run.experiment), QString::fromStdString(run.names()));
  failed_ = failed_ && !runs.isEmpty();
  if (failed_) runs << tr("Not all robots have acknowledged the stop: switch those off by hand.");
  text_->setText(runs.join(QLatin1Char(' ')));
  stop_->setEnabled(true);
  stop_->setText(tr("Stop them now"));
  forget_->setVisible(failed_);
  forget_->setEnabled(true);
  setVisible(!runs.isEmpty());
}

void LeftBehindBar::stop() {
  stop_->setEnabled(false);
  stop_->setText(tr("Stopping …"));
  forget_->setEnabled(false);
  stopping_ = std::async(std::launch::async, [] { return app::stop_left_behind(app::bad_ends()); });
}

void LeftBehindBar::forget() {
  stop_->setEnabled(false);
  forget_->setEnabled(false);
  stopping_ = std::async(std::launch::async, [runs = shown_] {
    app::forget_left_behind(runs);
    return true;
  });
}

}  // namespace skein::ui
