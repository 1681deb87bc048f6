#pragma once

#include <QString>
#include <optional>

#include "ui/base/modes.h"

namespace skein::ui {

/// A control: whether it is enabled, and its tool tip.
struct Offer {
  bool possible = false;
  QString tip;
};

/// A line for the operator: across the arena, or in the alert strip.
struct Notice {
  QString text;
  Severity severity = Severity::note;
};

/// Where a run is and what can be done with it, as bar and menus show it. A live run and a replay fill it in
/// differently; code that shows it need not distinguish the two.
struct RunState {
  /// What the first button does; `again`: sets the experiment up again, and nothing moves.
  enum class Go { start, pause, resume, play, again };

  QString words;                   ///< "Running", "Replay, paused" ...
  Severity tone = Severity::note;  ///< of the words
  bool moves = false;              ///< time goes by
  double t = 0.0;                  ///< time of the experiment [s]
  bool has_time = true;            ///< false: there is nothing to run
  std::optional<double> end;       ///< when it will be over [s]; none: it is over
  double speed = 1.0;              ///< requested, times real time
  Go go = Go::start;
  bool may_go = false;
  Offer step, change_speed, new_run, record;
  QString new_run_text;
  bool records = false;   ///< this run, or the next one
  bool may_save = false;  ///< there is a run that no file has yet
};

}  // namespace skein::ui
