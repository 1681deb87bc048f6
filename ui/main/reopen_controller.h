#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/experiment/problem.h"
#include "ui/base/aside.h"
#include "ui/main/messages.h"

namespace skein::ui {

/// Changes what holds for a whole run (the form of the coupling, the timetable of the gains): before the start, sets
/// the same experiment up again with one key of its file changed.
class ReopenController final : public QObject {
  Q_OBJECT

 public:
  ReopenController(const LiveRun& live, const Messages& messages, QObject* parent = nullptr);
  void reopen_with(const QString& set);  ///< "key=value"
  /// Whether a changed experiment is being prepared: one of many robots with long timetables takes seconds.
  bool is_busy() const { return preparing_.is_busy(); }
  void drop() { preparing_.drop(); }  ///< what is being prepared is no longer wanted
  void refresh() { take({}); }        ///< thirty times a second

 signals:
  void experiment_wanted(const skein::app::Experiment& experiment);
  void refused();  ///< what the panels show does not hold: they must show the experiment as it is

 private:
  void take(std::chrono::milliseconds patience);
  bool can_change() const;

  const LiveRun& live_;
  const Messages& messages_;
  Aside<tl::expected<app::Experiment, std::vector<app::Problem>>> preparing_;
  std::string from_;  // the text of the experiment that is changed
};

}  // namespace skein::ui
