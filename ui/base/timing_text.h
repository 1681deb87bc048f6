#pragma once

#include <QString>

#include "app/run/timing.h"

namespace skein::ui {

/// The timing certificate of a run in words: how late its ticks begin, compared with a thread that does nothing else,
/// and at which priority. Empty: there was no tick.
QString timing_text(const app::Timing& timing);

}  // namespace skein::ui
