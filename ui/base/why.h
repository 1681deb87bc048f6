#pragma once

#include <QString>

#include "app/run/tick_record.h"
#include "ui/base/circumstances.h"

namespace skein::ui {

/// Why a robot (from 0) does what it does at this tick: one sentence with its numbers. The strongest cause comes first:
/// a tag that is not seen, a link that is lost, the shield, avoidance, limits.
QString why(const app::TickRecord& record, std::size_t robot, const Circumstances& now);

}  // namespace skein::ui
