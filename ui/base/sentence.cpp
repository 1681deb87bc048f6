#include "ui/base/sentence.h"

#include <QRegularExpression>
#include <algorithm>
#include <cmath>

#include "ui/base/number_text.h"
#include "ui/base/tr.h"

namespace skein::ui {

QString gain_symbol(core::GainName gain) {
  using core::GainName;
  switch (gain) {
    case GainName::k_tt:
      return QStringLiteral("k_θθ");
    case GainName::c_tt:
      return QStringLiteral("c_θθ");
    case GainName::l_tt:
      return QStringLiteral("l_θθ");
    case GainName::k_xx:
    case GainName::k_yy:
    case GainName::c_xx:
    case GainName::c_yy:
    case GainName::l_xx:
      break;
  }
  return QString::fromLatin1(core::word(gain).data());
}

QString gain_symbol(core::TrackingGain gain) {
  switch (gain) {
    case core::TrackingGain::k_x:
      return QStringLiteral("k_x");
    case core::TrackingGain::k_theta:
      break;
  }
  return QStringLiteral("k_θ");
}

QString reason_text(core::NotSeen why) {
  switch (why) {
    case core::NotSeen::not_found:
      return tr("its tag is nowhere in the picture");
    case core::NotSeen::wrong_size:
      return tr("its tag has another size than the calibration says");
    case core::NotSeen::lifted:
      return tr("its tag looks larger than the others: it is held up, or printed larger");
    case core::NotSeen::tilted:
      return tr("its tag does not lie flat");
    case core::NotSeen::doubled:
      return tr("its tag is there twice");
    case core::NotSeen::covered:
      return tr("part of its tag is covered or blurred");
    case core::NotSeen::at_border:
      return tr("the border of the picture cuts its tag");
    case core::NotSeen::too_small:
      return tr("its tag has too few pixels");
    case core::NotSeen::too_bright:
      return tr("the picture, or a part of its tag, is too bright");
    case core::NotSeen::in_shadow:
      return tr("its tag lies in shadow");
    case core::NotSeen::blurred:
      return tr("the picture is blurred");
    case core::NotSeen::mirrored:
      return tr("the camera mirrors the picture");
    case core::NotSeen::other_family:
      return tr("a tag with its number, but of a family other than 36h11, is in the picture");
  }
  return {};
}

QString version_number(const QString& version) {
  static const QRegularExpression number(QStringLiteral("\\d+(\\.\\d+)*"));
  const QRegularExpressionMatch match = number.match(version);
  return match.hasMatch() ? match.captured() : version;
}

QString sentence(const app::Event& event) {
  using namespace app::events;
  const auto number = [](double value) { return QString::number(value, 'g', 4); };
  const auto within = [&](double ramp) { return ramp > 0.0 ? tr(" within %1 s").arg(number(ramp)) : QString(); };
  return std::visit(
      app::Overloaded{
          [&](const DeadlineMissed& e) {
            return e.ticks == 1
                       ? tr("A tick came too late: the machine was busy; it was skipped, and robots kept their last "
                            "commands")
                       : tr("%1 ticks came too late: the machine was busy; they were skipped, and robots kept their "
                            "last "
                            "commands")
                             .arg(e.ticks);
          },
          [&](const GainHeld& e) {
            return tr("%1 is held at %2, its limit: (18) allows no more")
                .arg(gain_symbol(e.gain))
                .arg(e.held, 0, 'g', 4);
          },
          [&](const PairGainHeld& e) {
            return tr("%1 of robots %2 and %3 is held at %4, its limit: (18) allows no more")
                .arg(gain_symbol(e.gain))
                .arg(e.i + 1)
                .arg(e.j + 1)
                .arg(e.held, 0, 'g', 4);
          },
          [&](const Couple& e) { return tr("Robots %1 and %2 are coupled again").arg(e.i + 1).arg(e.j + 1); },
          [&](const Uncouple& e) { return tr("Robots %1 and %2 are no longer coupled").arg(e.i + 1).arg(e.j + 1); },
          [&](const CameraMoved& e) {
            if (e.scale != 0.0)
              return (e.scale > 0.0 ? tr("The camera moved, or its zoom or focus changed: all %1 tags look %2 % larger "
                                         "at once. Poses are wrong until the camera is calibrated again")
                                    : tr("The camera moved, or its zoom or focus changed: all %1 tags look %2 % "
                                         "smaller at once. Poses are wrong until the camera is calibrated again"))
                  .arg(e.tags)
                  .arg(100.0 * std::abs(e.scale), 0, 'f', 1);
            return (e.marks > 0 ? tr("The camera moved, or the floor under it: %1 marks on the floor are %2 mm from "
                                     "where they were. Poses are wrong until the camera is calibrated again")
                                      .arg(e.marks)
                                : tr("The camera moved, or the floor under it: all %1 tags moved by %2 mm at once. "
                                     "Poses are wrong until the camera is calibrated again")
                                      .arg(e.tags))
                .arg(1000.0 * e.by, 0, 'f', 0);
          },
          [&](const PicturesLate& e) {
            return tr("The camera shows robots that obey their commands %1 s later than the known delays explain: its "
                      "pictures are older than their time stamps say. It is not known where the robots are")
                .arg(e.by, 0, 'f', 1);
          },
          [&](const CamerasDisagree& e) {
            return tr("Cameras %1 and %2 see robot %3 %4 mm apart: one of them has moved. Poses are wrong until it is "
                      "calibrated again")
                .arg(e.camera + 1)
                .arg(e.other + 1)
                .arg(e.robot + 1)
                .arg(1000.0 * e.by, 0, 'f', 0);
          },
          [&](const CamerasDiffer& e) {
            return tr("Cameras %1 and %2 see robot %3 %4 mm apart: their calibrations do not agree, or the time stamps "
                      "of one are late")
                .arg(std::min(e.camera, e.other) + 1)
                .arg(std::max(e.camera, e.other) + 1)
                .arg(e.robot + 1)
                .arg(1000.0 * e.by, 0, 'f', 0);
          },
          [&](const CameraLost& e) {
            return tr("Camera %1 is lost: robots that no other camera sees stand").arg(e.camera + 1);
          },
          [&](const CameraFound& e) { return tr("Camera %1 delivers frames again").arg(e.camera + 1); },
          [&](const app::events::NotSeen& e) {
            return tr("The camera does not see robot %1: %2").arg(e.robot + 1).arg(reason_text(e.why));
          },
          [&](const FilmBroken&) {
            return tr("The film broke off (is the disk full?): no more frames are recorded, the run goes on");
          },
          [&](const app::events::Link& e) {
            switch (e.state) {
              case app::LinkState::up:
                return tr("The link of robot %1 is up again; release the robot when it may drive").arg(e.robot + 1);
              case app::LinkState::simulated:
              case app::LinkState::recorded:
              case app::LinkState::down:
              case app::LinkState::connecting:
              case app::LinkState::synchronising:
              case app::LinkState::stale:
              case app::LinkState::failed:
              case app::LinkState::closed:
                break;
            }
            return tr("The link of robot %1 is lost: it was told to stop").arg(e.robot + 1);
          },
          [&](const Parameter& e) {
            return tr("%1 of the law goes from %2 to %3")
                .arg(QString::fromUtf8(e.name.text().data()), number(e.from), number(e.to));
          },
          [&](const Perturb& e) { return tr("Robot %1 was moved by the experiment").arg(e.robot + 1); },
          [&](const Move& e) { return tr("Robot %1 was moved by hand").arg(e.robot + 1); },
          [&](const Kidnap& e) {
            return tr("Robot %1 is not where it drove: it was carried or pushed").arg(e.robot + 1);
          },
          [&](const Hold& e) { return tr("Robot %1 is held: it stands, the others drive on").arg(e.robot + 1); },
          [&](const Release& e) { return tr("Robot %1 drives again").arg(e.robot + 1); },
          [&](const Kick& e) {
            return tr("Robot %1 was kicked, %2 m/s").arg(e.robot + 1).arg(std::hypot(e.vx, e.vy), 0, 'f', 2);
          },
          [&](const PutObstacle& e) {
            return e.obstacle.radius > 0.0 ? tr("Obstacle %1 stands at x %2 m, y %3 m")
                                                 .arg(e.number + 1)
                                                 .arg(fixed(e.obstacle.x, 2), fixed(e.obstacle.y, 2))
                                           : tr("Obstacle %1 was removed").arg(e.number + 1);
          },
          [&](const NoWay& e) {
            if (e.other != nobody)
              return tr("Robot %1 stands: robot %2 is at its place").arg(e.robot + 1).arg(e.other + 1);
            if (e.margin > 0.0)
              return tr("Robot %1 waits: no route to its place leaves the %2 mm of extra room to obstacles that its "
                        "uncertain pose needs")
                  .arg(e.robot + 1)
                  .arg(fixed(1e3 * e.margin, 1));
            return tr("Robot %1 stands: there is no route to its place").arg(e.robot + 1);
          },
          [&](const NoProgress& e) {
            return tr("Robot %1 has made no progress to its place for 3 s, %2 m away (%3)")
                .arg(e.robot + 1)
                .arg(e.distance, 0, 'f', 2)
                .arg(QString::fromUtf8(word(e.hindrance).data()));
          },
          [&](const Outside& e) { return tr("Robot %1 is over the edge of the arena").arg(e.robot + 1); },
          [&](const Runaway& e) {
            constexpr double turns_only = 0.02;  // [m/s]
            const QString does =
                std::abs(e.v) < turns_only ? tr("turns on the spot") : tr("drives at %1 m/s").arg(e.v, 0, 'f', 2);
            return tr("Robot %1 %2 though it is told otherwise: it is told to stand, the others keep clear")
                .arg(e.robot + 1)
                .arg(does);
          },
          [&](const Obeys& e) { return tr("Robot %1 stands, and may drive again").arg(e.robot + 1); },
          [&](const Controller& e) {
            switch (e.state) {
              case app::ControllerState::answered:
                return tr("The controller answers in time again");
              case app::ControllerState::late:
                return tr("The controller is late: its robots stand, or the built-in law drives");
              case app::ControllerState::ended:
                break;
            }
            return tr("The controller has ended");
          },
          [&](const NoNumber& e) {
            return tr("Robot %1 stands: the law's output for it is not a number").arg(e.robot + 1);
          },
          [](const Start&) { return tr("The run starts"); },
          [](const Pause&) { return tr("Paused: the robots stand"); },
          [](const Resume&) { return tr("The run goes on"); },
          [](const Stop&) { return tr("STOP: all robots"); },
          [&](const Gain& e) {
            return tr("%1 goes from %2 to %3").arg(gain_symbol(e.gain), number(e.from), number(e.to)) + within(e.ramp);
          },
          [&](const app::one_of<Schedule, ScheduleTracking> auto& e) {
            return tr("%1 goes from %2 to %3, as the experiment says")
                .arg(gain_symbol(e.gain), number(e.from), number(e.to));
          },
          [&](const PairGain& e) {
            return tr("%1 of robots %2 and %3 goes from %4 to %5")
                       .arg(gain_symbol(e.gain))
                       .arg(e.i + 1)
                       .arg(e.j + 1)
                       .arg(number(e.from), number(e.to)) +
                   within(e.ramp);
          },
          [](const Lost& e) { return tr("Robot %1 is lost: no tag seen, it stands").arg(e.robot + 1); },
          [](const Found& e) { return tr("Robot %1 is seen again").arg(e.robot + 1); },
          [](const Avoid& e) { return tr("Robot %1 leaves its reference to avoid a collision").arg(e.robot + 1); },
          [](const Clear& e) { return tr("Robot %1 is back on its reference").arg(e.robot + 1); },
          [](const app::events::Stage&) { return tr("All robots drive to their starts"); },
          [](const Staged&) { return tr("All robots stand at their starts"); },
          [](const Deadlock& e) { return tr("Robot %1 was held up, and takes a way round").arg(e.robot + 1); },
          [&](const VRise& e) { return tr("V rose by %1, and nothing that is known explains it").arg(number(e.rise)); },
      },
      event);
}

QString sentence(const app::Event& event, const std::vector<app::RobotStatus>& robots) {
  QString what = sentence(event);
  const auto* const link = std::get_if<app::events::Link>(&event);
  if (!link || link->state == app::LinkState::up || link->robot >= robots.size()) return what;
  const std::string& reason = robots[link->robot].reason;
  return reason.empty() ? what : tr("%1 (%2)").arg(what, QString::fromStdString(reason));
}

}  // namespace skein::ui
