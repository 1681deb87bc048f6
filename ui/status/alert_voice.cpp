#include "ui/status/alert_voice.h"

#include <QApplication>
#include <QTextToSpeech>

namespace skein::ui {

AlertVoice::AlertVoice(QObject* parent) : QObject(parent) {
  setObjectName(QStringLiteral("alert_voice"));
}

AlertVoice::~AlertVoice() = default;

bool AlertVoice::can_speak() {
  return !QTextToSpeech::availableEngines().isEmpty();
}

void AlertVoice::set_on(bool on) {
  on_ = on;
  if (on && !engine_ && can_speak()) engine_ = std::make_unique<QTextToSpeech>();
  if (!on && engine_) engine_->stop();
}

void AlertVoice::say(const QString& text) {
  if (!on_) return;
  if (engine_ && engine_->state() != QTextToSpeech::State::Error)
    engine_->say(text);
  else
    QApplication::beep();
  emit said(text);
}

}  // namespace skein::ui
