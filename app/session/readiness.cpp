#include "app/session/readiness.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/experiment/at_start.h"
#include "app/session/plant.h"
#include "comms/protocol.h"

namespace skein::app {
namespace {

using State = Check::State;
using What = Check::What;

std::string numbers(const std::vector<std::size_t>& robots) {
  std::vector<std::size_t> from_one(robots);
  for (std::size_t& robot : from_one) ++robot;
  return fmt::format("robot{} {}", from_one.size() == 1 ? "" : "s", fmt::join(from_one, ", "));
}

Check camera(const Experiment& e, const CameraStatus& status) {
  const MarksStatus& marks = status.marks;
  const CameraKind kind = e.camera.kind();
  const bool real = kind == CameraKind::live;
  if (kind == CameraKind::absent) return {What::camera, State::holds, "none: poses come from the simulation", real};
  for (std::size_t k = 0; k < e.cameras(); ++k) {
    const std::string file = e.calibration_file(k);
    const std::string prefix = camera_prefix(e, k);
    if (file.empty() && kind != CameraKind::synthetic)
      return {What::camera, State::fails, prefix + "camera.calibration names no file", real};
    if (!file.empty() && !std::filesystem::exists(file))
      return {What::camera, State::fails, fmt::format("{}there is no {}", prefix, file), real};
  }
  // No calibration helps a camera that delivers nothing.
  if (!status.down.empty() && !status.partly)
    return {What::camera, State::fails, fmt::format("{}; the start waits for it", status.down), true, false};
  const bool stops = e.failure.camera_moved == FailureSpec::CameraMoved::all_stop;
  if (!marks.exchanged.empty()) return {What::camera, State::fails, marks.exchanged, stops, false};
  if (marks.moved)
    return {What::camera, State::fails, camera_moved_sentence(e, *marks.moved, "no robot drives"), stops};
  const auto farthest = std::max_element(status.pairs.begin(), status.pairs.end(),
                                         [](const auto& a, const auto& b) { return a.apart < b.apart; });
  if (farthest != status.pairs.end() && farthest->apart > 0.0)
    return {What::camera, State::fails, camera_pair_sentence(e, *farthest), contradict(e, *farthest)};
  if (!status.down.empty())  // of the robots that only it sees the tags tell
    return {What::camera, State::fails, status.down + "; robots that no other camera sees stand", false, false};
  if (!marks.known)
    return {What::camera, State::waits,
            marks.sentence.empty() ? "the marks on the floor are being looked for" : marks.sentence, false};
  std::string found = e.cameras() > 1                ? fmt::format("{} cameras", e.cameras())
                      : e.camera.calibration.empty() ? "the synthetic camera's own"
                                                     : e.camera.calibration;
  if (!marks.sentence.empty()) found += "; " + marks.sentence;
  for (const std::string& sentence : status.unguarded) found += "; " + sentence;
  return {What::camera, State::holds, found, real};
}

/// What a camera sets by itself changes its picture, its rate and the time of capture in the middle of a run.
Check settings(const Experiment& e, const CameraStatus& camera) {
  if (e.camera.kind() != CameraKind::live) return {What::settings, State::holds, "no real camera", false};
  if (!camera.down.empty()) return {What::settings, State::waits, "not known: the camera does not deliver", false};
  if (camera.automatics.empty())
    return {What::settings, State::holds, "the camera sets none of exposure, gain and focus by itself", false};
  return {What::settings, State::fails,
          fmt::format("automatic {} {} on: picture, rate and time of capture may change during the run",
                      fmt::join(camera.automatics, ", "), camera.automatics.size() == 1 ? "is" : "are"),
          false};
}

Check tags(const Experiment& e, const TickRecord* record, std::span<const UnseenTag> why_lost, bool all_cameras_down) {
  if (!record) return {What::tags, State::waits, "no poses yet", true};
  std::vector<std::size_t> unseen;
  for (std::size_t i = 0; i < record->robots.size(); ++i)
    if (record->robots[i].is(lost)) unseen.push_back(i);
  if (unseen.empty())
    return {What::tags, State::holds, fmt::format("all {} robots have a fresh pose", e.robots.size()), true};
  // Reasons that are known, each once; then the robots whose tags nobody has looked for yet.
  struct Reason {
    std::string of_any_tag;  // to compare
    std::size_t first;
    std::vector<std::size_t> others;
  };
  std::vector<Reason> known;
  std::erase_if(unseen, [&](std::size_t i) {
    if (i >= why_lost.size() || why_lost[i].sentence.empty()) return false;
    std::string of_any_tag = why_lost[i].sentence;
    const std::string number = fmt::format("tag {} ", e.robots[i].tag);
    if (const auto at = of_any_tag.find(number); at != std::string::npos) of_any_tag.erase(at, number.size());
    const auto same =
        std::find_if(known.begin(), known.end(), [&](const Reason& r) { return r.of_any_tag == of_any_tag; });
    if (same == known.end())
      known.push_back({std::move(of_any_tag), i, {}});
    else
      same->others.push_back(i);
    return true;
  });
  std::string reasons;
  for (const Reason& one : known) {
    reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", numbers({one.first}), why_lost[one.first].sentence);
    if (!one.others.empty()) reasons += fmt::format("; {}: likewise", numbers(one.others));
  }
  bool looking = false;
  if (!unseen.empty()) {
    std::vector<int> ids;
    ids.reserve(unseen.size());
    for (const std::size_t i : unseen) ids.push_back(e.robots[i].tag);
    const bool one = ids.size() == 1;
    const std::string of_tags = fmt::format("tag{} {}", one ? "" : "s", fmt::join(ids, ", "));
    reasons += fmt::format("{}{}: ", reasons.empty() ? "" : "; ", numbers(unseen));
    looking = e.camera.kind() != CameraKind::absent && !all_cameras_down;
    if (looking)
      reasons += fmt::format("{} {} being looked for", of_tags, one ? "is" : "are");
    else if (all_cameras_down)
      reasons += fmt::format("{} picture that can be used",
                             e.cameras() == 1 ? "the camera delivers no" : "no camera delivers a");
    else
      reasons += "the simulation gives no pose of " + of_tags;
  }
  return {What::tags, looking && known.empty() ? State::waits : State::fails, reasons, true};
}

Check links(const Experiment& e, std::span<const RobotStatus> robots) {
  if (robots.size() != e.robots.size()) return {What::links, State::waits, "not known yet", true};
  std::vector<std::size_t> down;
  std::string why;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (reachable(robots[i].link)) continue;
    down.push_back(i);
    if (why.empty()) why = robots[i].reason.empty() ? std::string(word(robots[i].link)) : robots[i].reason;
  }
  const bool simulated =
      std::all_of(robots.begin(), robots.end(), [](const auto& r) { return r.link == LinkState::simulated; });
  if (down.empty()) return {What::links, State::holds, simulated ? "simulated robots need none" : "all up", true};
  return {What::links, State::fails, fmt::format("{}: {}", numbers(down), why), true};
}

/// A low battery turns wheels too slowly, and dies in the middle of a run; but the operator may know better.
Check batteries(std::span<const RobotStatus> robots) {
  if (robots.empty()) return {What::batteries, State::waits, "not known yet", false};
  std::vector<std::size_t> low;
  double lowest = none;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (robots[i].battery_low) low.push_back(i);
    lowest = std::fmin(lowest, robots[i].battery);
  }
  if (!low.empty())
    return {What::batteries, State::fails,
            fmt::format("{} {} low: charge", numbers(low), low.size() == 1 ? "is" : "are"), false};
  return {What::batteries, State::holds,
          std::isnan(lowest) ? std::string("no robot reports a low battery") : fmt::format("{:.2f} V and more", lowest),
          false};
}

Check gains(const Certificate* certificate) {
  if (!certificate) return {What::gains, State::waits, "whether (18) holds is being computed", true};
  if (!certificate->other_law.empty())
    return {What::gains, State::holds,
            fmt::format("not checked: (18) holds for (15), and {} drives", certificate->other_law), true};
  double forward = 1.0, turning = 1.0;
  bool positive = true;
  for (const Certificate::Robot& r : certificate->robots) {
    forward = std::min(forward, r.k_x.value / certificate->v_max);
    turning = std::min(turning, r.k_theta.value / certificate->omega_max);
    positive = positive && r.b.value >= 0.0;
  }
  const bool hold = positive && forward > 0.0 && turning > 0.0;
  return {What::gains, hold ? State::holds : State::fails,
          hold ? fmt::format("(18) holds: {:.0f} % of v_max, {:.0f} % of omega_max left", 100 * forward, 100 * turning)
               : "(18) is violated: weaker couplings are needed",
          true};
}

Check reference(const Certificate* certificate) {
  if (!certificate) return {What::reference, State::waits, "what it asks of the wheels is being computed", true};
  double v = 0.0, omega = 0.0, wheel = 0.0;
  for (const Certificate::Robot& r : certificate->robots) {
    v = std::max(v, r.v.value);
    omega = std::max(omega, r.omega.value);
    wheel = std::max(wheel, r.wheel.value);
  }
  return {What::reference, v < 1.0 && omega < 1.0 && wheel <= 1.0 ? State::holds : State::fails,
          fmt::format("v {:.0f} %, omega {:.0f} %, wheels {:.0f} % of their limits", 100 * v, 100 * omega, 100 * wheel),
          true};
}

Check places(const Experiment& e, const TickRecord* record) {
  if (!record) return {What::places, State::waits, "no poses yet", false};
  std::vector<std::size_t> away, unseen;
  double farthest = 0.0, turned = 0.0;
  const StartTolerance tolerance = start_tolerance(e.staging);
  for (std::size_t i = 0; i < record->robots.size(); ++i) {
    const RobotRecord& robot = record->robots[i];
    if (robot.is(lost)) {
      unseen.push_back(i);
      continue;
    }
    // A simulated one may begin anywhere, if it need not drive to its start first.
    const core::Pose& place = e.staging.automatic ? robot.nominal.pose : e.robots[i].start.value_or(robot.nominal.pose);
    farthest = std::max(farthest, core::distance(robot.pose, place));
    turned = std::max(turned, std::abs(core::wrap_angle(robot.pose.theta - place.theta)));
    if (!at_start(robot.pose, place, tolerance)) away.push_back(i);
  }
  if (away.empty() && !unseen.empty())
    return {What::places, State::fails,
            fmt::format("{} not seen: {} not known", numbers(unseen),
                        unseen.size() == 1 ? "its position is" : "their positions are"),
            false};
  if (away.empty())
    return {What::places, State::holds, fmt::format("all robots within {:.0f} mm", std::ceil(1000 * farthest)), false};
  return {
      What::places, State::fails,
      fmt::format(
          "{} not in place, up to {:.0f} cm away{}", numbers(away), 100 * farthest,
          turned > tolerance.heading ? fmt::format(", turned by up to {:.0f} degrees", turned * 180.0 / core::pi) : ""),
      false};
}

}  // namespace

std::vector<Check> readiness(const Experiment& experiment, const Certificate* certificate, const TickRecord* record,
                             std::span<const RobotStatus> robots, const CameraStatus& cameras) {
  return {camera(experiment, cameras),
          settings(experiment, cameras),
          tags(experiment, record, cameras.why_lost, !cameras.down.empty() && !cameras.partly),
          links(experiment, robots),
          batteries(robots),
          gains(certificate),
          reference(certificate),
          places(experiment, record)};
}

bool is_low(const RobotSpec& robot, double battery) {
  comms::LinkAddress usual;
  usual.protocol = robot.type->protocol;
  const std::optional<double> least = comms::protocol_of(usual).charge_below;
  return least && battery < *least;  // of NaN: no
}

std::optional<double> fitting_tag_size(std::size_t robots, std::span<const UnseenTag> unseen) {
  constexpr double agreement = 0.03;  // of the smallest and the largest: half of what the tracker accepts
  const bool wrong = std::any_of(unseen.begin(), unseen.end(),
                                 [](const UnseenTag& tag) { return tag.why == core::NotSeen::wrong_size; });
  if (!wrong || unseen.size() < robots) return {};
  double smallest = none, largest = none;
  for (const UnseenTag& tag : unseen) {
    smallest = std::fmin(smallest, tag.size);
    largest = std::fmax(largest, tag.size);
  }
  if (largest > (1.0 + agreement) * smallest) return {};
  return std::round(1e3 * 0.5 * (smallest + largest)) / 1e3;
}

bool may_start(std::span<const Check> checks) noexcept {
  return std::all_of(checks.begin(), checks.end(), [](const Check& check) { return !check.hard || check.holds(); });
}

bool all_hold(std::span<const Check> checks) noexcept {
  return std::all_of(checks.begin(), checks.end(), [](const Check& check) { return check.holds(); });
}

}  // namespace skein::app
