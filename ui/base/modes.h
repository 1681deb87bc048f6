#pragma once

#include <QColor>
#include <QString>
#include <cstdint>

#include "app/run/event.h"
#include "app/run/tick_record.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// How a mode looks: never by colour alone.
struct ModeStyle {
  std::uint8_t mode;
  QString symbol;  ///< one character; empty: nothing unusual
  QString name;
  QColor colour;
};

/// The style of the most severe of a robot's modes. `held`: it stands alone, until the operator lets it go.
ModeStyle mode_style(std::uint8_t mode, const Colours& colours, bool held = false);
/// The style of a robot that was commanded to stand and has not acknowledged it: whatever its mode, it may be driving.
ModeStyle may_be_driving_style(const Colours& colours);
/// All that apply, joined by "+".
QString mode_text(std::uint8_t mode, bool held = false);

/// A pose that is older than this is predicted from the last measurement, not measured: half the time after which a
/// robot counts as lost. [s]
inline constexpr double old_pose = 0.1;
/// Where a robot's pose comes from: "tracked", "bridged" ...
QString found_text(const app::RobotRecord& robot);

QString phase_text(app::Phase phase);

/// How much attention an event requires.
enum class Severity { note, good, notice, warning, alarm };
Severity severity(const app::Event& event);
QColor colour(Severity severity, const Colours& colours);
QString symbol(Severity severity);  ///< one character: never shown by colour alone
QString severity_text(Severity severity);

}  // namespace skein::ui
