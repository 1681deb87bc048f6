#pragma once

#include <QObject>
#include <QString>
#include <memory>

class QTextToSpeech;

namespace skein::ui {

/// Speaks alarms, for an operator who watches the robots and not the screen. Where the machine has no speech engine it
/// beeps. Off until it is switched on.
class AlertVoice final : public QObject {
  Q_OBJECT

 public:
  explicit AlertVoice(QObject* parent = nullptr);
  ~AlertVoice() override;

  void set_on(bool on);
  bool is_on() const { return on_; }
  /// Whether there is a speech engine; without one, alarms are beeps.
  static bool can_speak();
  /// Replaces what is being spoken. Does nothing while it is off.
  void say(const QString& text);

 signals:
  void said(const QString& text);

 private:
  std::unique_ptr<QTextToSpeech> engine_;  // made when it is switched on: engines start a service of the desktop
  bool on_ = false;
};

}  // namespace skein::ui
