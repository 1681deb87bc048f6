#pragma once

#include <QElapsedTimer>
#include <QLabel>
#include <map>
#include <optional>
#include <vector>

#include "app/run/status.h"
#include "ui/base/modes.h"

namespace skein::ui {

/// The most important message now, in its colour, along the bottom of the window: states as long as they last, news for
/// a while. Each says what has happened and what the program did.
class AlertStrip final : public QLabel {
  Q_OBJECT

 public:
  explicit AlertStrip(QWidget* parent = nullptr);
  void show_record(const app::TickRecord& record, const std::vector<app::RobotStatus>& robots = {});
  /// The robots that are lost now, as "2, 3"; empty: none.
  QString lost_robots() const;
  /// Where else in the window the same text is shown.
  enum class Also { nowhere, in_banner };
  /// For a while, also in place of a held message, unless that is an alarm. A warning or alarm that has just been said
  /// stays beside what is said after it: neither takes the other's place before it can be read.
  void say(const QString& text, Severity severity, Also also = Also::nowhere);
  /// Stays until `clear`, over the states and the events of the run: STOP, a failure, the verdict on a recording.
  void hold(const QString& text, Severity severity);
  /// Robots, from 1, whose battery is low; empty: none.
  void warn_batteries(const QStringList& robots);
  /// Nothing stops the robots if this program is killed: shown unless something more severe is, until `clear`.
  void warn_unguarded(const QString& text) { stand(State::unguarded, text, Severity::warning); }
  /// Not all of this run is kept: shown as long as it lasts, unless something more severe is.
  void warn_unkept(const QString& text) { stand(State::unkept, text, Severity::warning); }
  /// The text while there is no other message.
  void rest_on(const QString& text);
  void clear_alert();
  /// The warning or alarm that is shown now; empty: there is none.
  QString loud() const { return shown_.severity >= Severity::warning ? shown_.text : QString(); }
  /// The same where the banner does not say it already.
  QString loud_beside_banner() const;
  Severity severity() const { return shown_.severity; }
  void refresh();  ///< lets old news fade

 signals:
  /// What an operator who does not look must hear: an alarm, or a low battery, once when it begins.
  void alarmed(const QString& text);

 protected:
  void paintEvent(QPaintEvent*) override;

 private:
  /// The first is shown if two are equally severe.
  enum class State { lost, link, battery, v_rises, no_way, limited, unguarded, unkept };
  struct Said {
    QString text;
    Severity severity = Severity::note;
    Also also = Also::nowhere;
    friend bool operator==(const Said&, const Said&) = default;
  };

  void watch(const app::TickRecord& record);
  void watch_ways(const app::TickRecord& record);
  void stand(State state, const QString& text, Severity severity, Also also = Also::nowhere);  // empty: it is over
  void choose();
  void choose_beside_held();
  /// The news, beside the graver ones before them if those are still to be read.
  Said news() const;
  void show(const Said& shown);
  void show_text();

  std::map<int, QString> lost_;  // robots without a tag, from 1, and why it is not seen; empty: not known
  struct NoWay {
    QString sentence;
    double said_at;   // [s]
    double stood_at;  // for the last time [s]
  };
  std::map<int, NoWay> no_way_;        // robots that stand since they have no route, from 1
  std::vector<double> limited_since_;  // limits that bite: since when, NaN: not limited [s]
  double v_rose_at_ = 0.0;             // [s]
  std::map<State, Said> states_;
  Said news_, grave_;                  // what was said last, and the gravest of what is still to be read
  QElapsedTimer since_, grave_since_;  // invalid: none
  std::optional<Said> held_;
  Said shown_;
  QString at_rest_ = tr("All well");
};

}  // namespace skein::ui
