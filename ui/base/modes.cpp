#include "ui/base/modes.h"

#include <QStringList>

#include "ui/base/tr.h"

namespace skein::ui {
namespace {

QString standing(bool held) {
  return held ? tr("held") : tr("stopped");
}

}  // namespace

ModeStyle mode_style(std::uint8_t mode, const Colours& c, bool held) {
  if (mode & app::lost) return {app::lost, QStringLiteral("?"), tr("lost"), c.alarm};
  if (mode & app::late) return {app::late, QStringLiteral("…"), tr("late"), c.limited};
  if (mode & app::stopped)
    return {app::stopped, held ? QStringLiteral("H") : QStringLiteral("■"), standing(held), c.standing};
  if (mode & app::shielded) return {app::shielded, QStringLiteral("S"), tr("shielded"), c.shielded};
  if (mode & app::avoiding) return {app::avoiding, QStringLiteral("A"), tr("avoiding"), c.avoiding};
  if (mode & app::limited) return {app::limited, QStringLiteral("L"), tr("limited"), c.limited};
  if (mode & app::staging) return {app::staging, {}, tr("staging"), c.notice};
  return {app::tracking, {}, tr("tracking"), c.good};
}

ModeStyle may_be_driving_style(const Colours& c) {
  return {0, QStringLiteral("!"), tr("may be driving"), c.alarm};
}

QString mode_text(std::uint8_t mode, bool held) {
  QStringList names;
  if (mode & app::lost) names << tr("lost");
  if (mode & app::stopped) names << standing(held);
  if (mode & app::staging) names << tr("staging");
  if (mode & app::tracking) names << tr("tracking");
  if (mode & app::avoiding) names << tr("avoiding");
  if (mode & app::shielded) names << tr("shielded");
  if (mode & app::limited) names << tr("limited");
  if (mode & app::late) names << tr("late");
  return names.join(QStringLiteral("+"));
}

QString found_text(const app::RobotRecord& robot) {
  if (!(robot.pose_age < 1e6)) return tr("not seen");
  if (robot.is(app::lost)) return tr("lost");
  if (robot.pose_age > old_pose) return tr("bridged");
  switch (robot.measurement.how) {
    case core::How::none:
      return tr("simulated");
    case core::How::detected:
      return tr("acquired");
    case core::How::tracked:
      return tr("tracked");
    case core::How::recovered:
      return tr("recovered");
  }
  return {};
}

QString phase_text(app::Phase phase) {
  switch (phase) {
    case app::Phase::ready:
      return tr("Ready");
    case app::Phase::staging:
      return tr("Staging");
    case app::Phase::running:
      return tr("Running");
    case app::Phase::paused:
      return tr("Paused");
    case app::Phase::stopped:
      return tr("STOPPED");
    case app::Phase::finished:
      return tr("Finished");
  }
  return {};
}

Severity severity(const app::Event& event) {
  using namespace app::events;
  using app::one_of;
  return std::visit(
      app::Overloaded{
          [](const one_of<Stop, Lost, Outside, Runaway, CameraMoved, PicturesLate, CamerasDisagree, CameraLost> auto&) {
            return Severity::alarm;
          },
          [](const one_of<DeadlineMissed, Kidnap, Hold, GainHeld, PairGainHeld, VRise, app::events::Link,
                          app::events::NotSeen, CamerasDiffer, FilmBroken, NoWay, NoProgress, Controller,
                          NoNumber> auto&) { return Severity::warning; },
          [](const one_of<Found, Obeys, CameraFound> auto&) { return Severity::good; },
          [](const one_of<Start, Perturb, Move, Kick, Release, PutObstacle, Gain, PairGain, Parameter, Couple, Uncouple,
                          Schedule, ScheduleTracking, Pause, Resume> auto&) { return Severity::notice; },
          [](const one_of<app::events::Stage, Staged, Deadlock, Avoid, Clear> auto&) { return Severity::note; },
      },
      event);
}

QColor colour(Severity severity, const Colours& c) {
  switch (severity) {
    case Severity::alarm:
      return c.alarm;
    case Severity::warning:
      return c.warning;
    case Severity::good:
      return c.good;
    case Severity::notice:
      return c.notice;
    case Severity::note:
      return c.faint_text;
  }
  return c.text;
}

QString symbol(Severity severity) {
  switch (severity) {
    case Severity::alarm:
      return QStringLiteral("✗");
    case Severity::warning:
      return QStringLiteral("!");
    case Severity::good:
      return QStringLiteral("✓");
    case Severity::notice:
      return QStringLiteral("●");
    case Severity::note:
      return QStringLiteral("·");
  }
  return {};
}

QString severity_text(Severity severity) {
  switch (severity) {
    case Severity::alarm:
      return tr("alarm");
    case Severity::warning:
      return tr("warning");
    case Severity::good:
      return tr("good news");
    case Severity::notice:
      return tr("notice");
    case Severity::note:
      return tr("note");
  }
  return {};
}

}  // namespace skein::ui
