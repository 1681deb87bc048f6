#pragma once

#include <QFrame>
#include <QLabel>
#include <QPushButton>
#include <QTimer>
#include <future>
#include <vector>

#include "app/guard/run_marker.h"

namespace skein::ui {

/// A red bar over the arena as long as robots of an earlier run may be driving, because the run died before they were
/// known to stand. Looks for such runs now and then; hidden if there are none. Where a stop has failed, the operator
/// may say that the robots stand.
class LeftBehindBar final : public QFrame {
  Q_OBJECT

 public:
  explicit LeftBehindBar(QWidget* parent = nullptr);
  ~LeftBehindBar() override;  ///< waits for the stops that are under way
  /// In few words; empty: there are no such robots.
  QString brief() const { return isHidden() ? QString() : tr("Robots of an earlier run may be driving"); }

 signals:
  void stopped();  ///< all of them are known to stand

 private:
  void refresh();
  void stop();
  void forget();

  QLabel* text_;
  QPushButton* stop_;
  QPushButton* forget_;
  QTimer timer_;
  std::vector<app::RunMarker> shown_;  // the runs that the text names: only these are forgotten
  std::future<bool> stopping_;
  bool failed_ = false;  // the last attempt
};

}  // namespace skein::ui
