#pragma once

#include "ui/run/live_run.h"
#include "ui/run/replay_run.h"

namespace skein::ui {

/// The live run and the replay, and which of the two is shown.
class Runs final : public QObject {
  Q_OBJECT

 public:
  explicit Runs(QObject* parent = nullptr);

  LiveRun& live() { return live_; }
  const LiveRun& live() const { return live_; }
  const ReplayRun& replay() const { return replay_; }
  RunSource& shown() { return *shown_; }
  const RunSource& shown() const { return *shown_; }

  void show_live();
  /// Ends the live session first if there is one; `shown_changed` follows, at once or when the session is closed.
  void show_recording(ReplayRun::Recording recording);
  /// Thirty times a second: shows the recording that waits.
  void refresh();

 signals:
  void shown_changed();
  void session_ends();  ///< references to its parts must be dropped
  // Of the run that is shown, see RunSource:
  void row_added(const skein::app::TickRecord& record);
  void record_shown(const skein::app::TickRecord& record);
  void changed();

 private:
  LiveRun live_;
  ReplayRun replay_;
  RunSource* shown_ = &live_;
  ReplayRun::Recording waiting_;  // until the session is closed
};

}  // namespace skein::ui
