#include "ui/base/why.h"
#include "ui/base/tr.h"

#include <algorithm>
#include <cmath>

namespace skein::ui {
namespace {

QString speed(double v) {
  return tr("%1 m/s").arg(v, 0, 'f', 3);
}
QString turning(double omega) {
  return tr("%1 rad/s").arg(omega, 0, 'f', 2);
}

/// What stands or drives nearest to a robot: in words with its distance, and the gap between the two bodies [m].
struct Nearest {
  QString words;  // empty: there is nothing whose place is known
  double gap = HUGE_VAL;
};

Nearest nearest(const app::TickRecord& record, std::size_t robot, const Circumstances& now, bool edge_too) {
  Nearest found;
  const core::Pose here = place(record.robots[robot]);
  const auto radius = [&](std::size_t i) { return i < now.radii.size() ? now.radii[i] : core::standard_radius; };
  for (std::size_t k = 0; k < record.robots.size(); ++k) {
    const double away = core::distance(here, place(record.robots[k])), gap = away - radius(robot) - radius(k);
    if (k != robot && gap < found.gap) found = {tr("robot %1, %2 cm away").arg(k + 1).arg(100 * away, 0, 'f', 1), gap};
  }
  const auto between = [](double gap) { return tr("%1 cm between them").arg(100 * gap, 0, 'f', 1); };
  for (std::size_t k = 0; k < now.obstacles.size(); ++k) {
    const core::Obstacle& o = now.obstacles[k];
    const double gap = std::hypot(here.x - o.x, here.y - o.y) - o.radius - radius(robot);
    if (o.radius > 0.0 && gap < found.gap)
      found = {tr("obstacle %1, %2").arg(QString::number(k + 1), between(gap)), gap};
  }
  const double room = std::min(now.half_width - std::abs(here.x), now.half_height - std::abs(here.y)) - radius(robot);
  if (edge_too && room < found.gap) found = {tr("the arena's edge, %1").arg(between(room)), room};
  return found;
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

QString why_out(const app::RobotRecord& robot, int number, const Circumstances& now) {
  if (now.held.contains(number)) return tr("stands, held out of the group until it is released");
  if (robot.is(app::late)) return tr("stands: %1").arg(unconfirmed(robot.link.input));
  if (now.disobedient.contains(number)) return tr("commanded to stand: it did not drive as it was commanded");
  if (!std::isfinite(robot.law.v) || !std::isfinite(robot.law.omega))
    return tr("stands: the law gives no number for it");
  return tr("stands, out of the group");
}

/// Who or what has moved it, while it is not in place again.
QString moved(const app::TickRecord& record, int number, const Circumstances& now) {
  using namespace app::events;
  const auto found = now.moved.find(number);
  if (found == now.moved.end()) return {};
  const auto& [how, t] = found->second;
  return (app::is<Kick>(how)      ? tr("; kicked %1 s ago")
          : app::is<Kidnap>(how)  ? tr("; carried away %1 s ago")
          : app::is<Perturb>(how) ? tr("; pushed by the experiment %1 s ago")
                                  : tr("; moved by hand %1 s ago"))
      .arg(record.t - t, 0, 'f', 1);
}

/// What it does while it drives.
QString driving(const app::TickRecord& record, std::size_t robot, const Circumstances& now) {
  const app::RobotRecord& r = record.robots[robot];
  if (r.is(app::late))
    return tr("slowed to %1 (the law asks %2): %3").arg(speed(r.command.v), speed(r.law.v), unconfirmed(r.link.input));
  if (record.phase == app::Phase::staging)
    return tr("drives to its start, %1 cm away").arg(100 * core::distance(place(r), r.nominal.pose), 0, 'f', 1);
  if (r.is(app::shielded)) {
    const QString of = nearest(record, robot, now, true).words;
    return of.isEmpty()
               ? tr("the shield sends %1, the law asks %2").arg(speed(r.command.v), speed(r.law.v))
               : tr("the shield sends %1 (the law asks %2) for %3").arg(speed(r.command.v), speed(r.law.v), of);
  }
  if (r.is(app::avoiding)) {
    constexpr double leaves = 1.1;  // a region, at this multiple of its size
    const Nearest in_the_way = nearest(record, robot, now, false);
    const double off = core::distance(r.nominal.pose, r.reference.pose);
    return in_the_way.gap > leaves * now.detects - 2 * core::standard_radius
               ? tr("on a detour, %1 cm from its place").arg(100 * off, 0, 'f', 1)
               : tr("drives round %1, %2 cm from its place").arg(in_the_way.words).arg(100 * off, 0, 'f', 1);
  }
  if (r.is(app::limited)) return limits(r);
  return tr("tracks its place, %1 cm off").arg(100 * std::hypot(r.error.x, r.error.y), 0, 'f', 1);
}

}  // namespace

QString why(const app::TickRecord& record, std::size_t robot, const Circumstances& now) {
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
      if (record.paused()) return tr("stands: the way to its start is paused");
      break;
    case app::Phase::running:
      break;
  }
  const int number = static_cast<int>(robot);
  if (r.is(app::stopped)) return why_out(r, number, now);
  return driving(record, robot, now) + moved(record, number, now);
}

}  // namespace skein::ui
