#pragma once

#include <QElapsedTimer>
#include <QLabel>
#include <set>
#include <vector>

#include "ui/modes.h"

namespace skein::ui {

/// The latest thing that matters, in its colour, along the bottom of the window.
class AlertStrip final : public QLabel {
  Q_OBJECT

 public:
  explicit AlertStrip(QWidget* parent = nullptr);
  void take(const app::TickRecord& record);
  /// The robots that are lost now, as "2, 3"; empty: none.
  QString lost_robots() const;
  void say(const QString& text, Severity severity);
  /// Stays until something graver comes or `clear`: STOP, a failure.
  void hold(const QString& text, Severity severity);
  void clear_alert();
  void refresh();  ///< lets old news fade

 protected:
  void paintEvent(QPaintEvent*) override;

 private:
  void watch(const app::TickRecord& record);
  void clear_text();
  void show_text();

  std::set<int> lost_;                 // a state, not news: said as long as it lasts
  std::vector<double> limited_since_;  // limits that bite, a state as well: since when, NaN: they do not [s]
  QString condition_;                  // what is said of them, as long as it lasts
  QString text_;
  Severity severity_ = Severity::note;
  bool held_ = false;
  QElapsedTimer since_;
};

}  // namespace skein::ui
