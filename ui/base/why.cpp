#include "ui/base/why.h"
#include "ui/base/tr.h"

#include <cmath>
#include <optional>

namespace skein::ui {
namespace {

QString speed(double v) {
  return tr("%1 m/s").arg(v, 0, 'f', 3);
}
QString turning(double omega) {
  return tr("%1 rad/s").arg(omega, 0, 'f', 2);
}

/// The robot that is nearest, and how far away it is, in words; empty: there is no other whose place is known.
QString nearest(const app::TickRecord& record, std::size_t robot) {
  std::optional<std::size_t> who;
  double least = HUGE_VAL;
  const core::Pose here = place(record.robots[robot]);
  for (std::size_t k = 0; k < record.robots.size(); ++k) {
    const double away = core::distance(here, place(record.robots[k]));
    if (k == robot || !(away < least)) continue;
    least = away;
    who = k;
  }
  return who ? tr("robot %1, %2 cm away").arg(*who + 1).arg(100 * least, 0, 'f', 1) : QString();
}

QString limits(const app::RobotRecord& robot) {
  if (robot.limits & app::limit_wheels)
    return tr("limited by its wheels: the law asks %1 and %2, sent are %3 and %4")
        .arg(speed(robot.law.v), turning(robot.law.omega), speed(robot.command.v), turning(robot.command.omega));
  if (robot.limits & app::limit_link)
    return tr("limited by its blind distance: the law asks %1 and %2, sent are %3 and %4")
        .arg(speed(robot.law.v), turning(robot.law.omega), speed(robot.command.v), turning(robot.command.omega));
  if (robot.limits & app::limit_v)
    return tr("limited by (14): the law asks %1, sent is %2").arg(speed(robot.law.v), speed(robot.command.v));
  return tr("limited by (14): the law asks %1, sent is %2").arg(turning(robot.law.omega), turning(robot.command.omega));
}

/// Whose commands are not confirmed, so that it may not go on as the law asks.
QString unconfirmed(const app::LinkInput& link) {
  const QString link_says_nothing = tr("its link has not confirmed its commands");
  return std::isfinite(link.blind_way)
             ? tr("%1, it may have driven %2 cm since").arg(link_says_nothing).arg(100 * link.blind_way, 0, 'f', 1)
             : link_says_nothing;
}

QString why_out(const app::RobotRecord& robot) {
  if (robot.is(app::late)) return tr("stands: %1").arg(unconfirmed(robot.link.input));
  if (!std::isfinite(robot.law.v) || !std::isfinite(robot.law.omega))
    return tr("stands: the law gives no number for it");
  return tr("held, out of the group, until it is released");
}

}  // namespace

QString why(const app::TickRecord& record, std::size_t robot) {
  const app::RobotRecord& r = record.robots[robot];
  if (r.is(app::lost)) {
    const QString since = r.pose_age < 1e6 ? tr("its tag was not seen for %1 s").arg(r.pose_age, 0, 'f', 1)
                                           : tr("its tag was never seen");
    return tr("stands: %1").arg(since);
  }
  switch (record.phase) {
    case app::Phase::ready:
      return tr("stands: the run has not started");
    case app::Phase::paused:
      return tr("stands: the run is paused");
    case app::Phase::stopped:
      return tr("was told to stop: the run is over");
    case app::Phase::finished:
      return tr("stands: the run is over");
    case app::Phase::staging:
    case app::Phase::running:
      break;
  }
  if (r.is(app::stopped)) return why_out(r);
  if (r.is(app::late))
    return tr("slowed to %1 (the law asks %2): %3").arg(speed(r.command.v), speed(r.law.v), unconfirmed(r.link.input));
  if (record.phase == app::Phase::staging)
    return tr("drives to its start, %1 cm away").arg(100 * core::distance(place(r), r.nominal.pose), 0, 'f', 1);
  if (r.is(app::shielded)) {
    const QString of = nearest(record, robot);
    return of.isEmpty()
               ? tr("the shield sends %1, the law asks %2").arg(speed(r.command.v), speed(r.law.v))
               : tr("the shield sends %1 (the law asks %2) for %3").arg(speed(r.command.v), speed(r.law.v), of);
  }
  if (r.is(app::avoiding)) {
    const QString of = nearest(record, robot);
    const double off = core::distance(r.nominal.pose, r.reference.pose);
    return of.isEmpty() ? tr("on a detour, %1 cm from its place").arg(100 * off, 0, 'f', 1)
                        : tr("drives round %1, %2 cm from its place").arg(of).arg(100 * off, 0, 'f', 1);
  }
  if (r.is(app::limited)) return limits(r);
  return tr("tracks its place, %1 cm off").arg(100 * std::hypot(r.error.x, r.error.y), 0, 'f', 1);
}

}  // namespace skein::ui
