#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "app/run/link_state.h"
#include "app/run/parameter_name.h"
#include "core/avoidance/obstacle.h"
#include "core/control/gain_schedule.h"
#include "core/estimation/not_seen.h"
#include "core/geometry/pose.h"

namespace skein::app {

/// Why a robot makes no progress towards its place, the first that applies.
enum class Hindrance : std::uint8_t {
  lost,       ///< no pose within the bridge time
  held,       ///< stopped by the operator or its link
  runaway,    ///< it does not drive as commanded
  outside,    ///< over the edge of the arena
  no_way,     ///< planning finds no route to its place
  turn,       ///< on a planned route: it waits for others to pass first
  shield,     ///< the shield holds it back from a robot, an obstacle or the edge
  avoidance,  ///< it follows a modified reference
  limits,     ///< (14) or its wheels reduce the law's command
  law,        ///< none of these: the law itself
};

/// As a word for logs (core/words.h).
constexpr std::string_view word(Hindrance hindrance) noexcept {
  switch (hindrance) {
    case Hindrance::lost:
      return "lost";
    case Hindrance::held:
      return "held";
    case Hindrance::runaway:
      return "runaway";
    case Hindrance::outside:
      return "outside";
    case Hindrance::no_way:
      return "no_way";
    case Hindrance::turn:
      return "turn";
    case Hindrance::shield:
      return "shield";
    case Hindrance::avoidance:
      return "avoidance";
    case Hindrance::limits:
      return "limits";
    case Hindrance::law:
      return "law";
  }
  return {};
}

/// How a run's own controller answered at a tick.
enum class ControllerState : std::uint8_t {
  answered,  ///< in time
  late,      ///< not before its deadline
  ended,     ///< its process exited, or was killed because it was late for too long
};

/// As a word for logs (core/words.h).
constexpr std::string_view word(ControllerState state) noexcept {
  switch (state) {
    case ControllerState::answered:
      return "answered";
    case ControllerState::late:
      return "late";
    case ControllerState::ended:
      return "ended";
  }
  return {};
}

/// What can happen at a tick: one small struct each, with its word in logs and in the CSV. Robots and obstacles count
/// from 0 here, from 1 in words.
namespace events {

struct Start {  ///< by the operator or the program
  static constexpr std::string_view word = "start";
};
struct Pause {
  static constexpr std::string_view word = "pause";
};
struct Resume {
  static constexpr std::string_view word = "resume";
};
struct Stop {  ///< the operator's STOP, or a failure
  static constexpr std::string_view word = "stop";
};
struct Perturb {  ///< a [[perturb]] of the file moved a simulated robot
  static constexpr std::string_view word = "perturb";
  std::size_t robot = 0;
  double dx = 0.0, dy = 0.0, dtheta = 0.0;  ///< world frame [m, rad]
};
struct Kidnap {  ///< a robot was found this far from its expected pose: it was carried
  static constexpr std::string_view word = "kidnap";
  std::size_t robot = 0;
  double dx = 0.0, dy = 0.0, dtheta = 0.0;  ///< world frame [m, rad]
};
struct Move {  ///< the operator put a simulated robot there
  static constexpr std::string_view word = "move";
  std::size_t robot = 0;
  core::Pose pose;
};
struct Hold {  ///< a robot is held, out of the group: by the operator, or because its link was lost
  static constexpr std::string_view word = "hold";
  std::size_t robot = 0;
};
struct Release {  ///< it may drive again
  static constexpr std::string_view word = "release";
  std::size_t robot = 0;
};
struct Kick {  ///< the operator sent a simulated robot sliding
  static constexpr std::string_view word = "kick";
  std::size_t robot = 0;
  double vx = 0.0, vy = 0.0;  ///< world frame [m/s]
};
struct PutObstacle {  ///< the operator put an obstacle there, or removed it
  static constexpr std::string_view word = "obstacle";
  std::size_t number = 0;
  core::Obstacle obstacle;  ///< radius 0: removed
};
struct Gain {  ///< the operator's new target for all pairs
  static constexpr std::string_view word = "gain";
  core::GainName gain = core::GainName::k_xx;
  double from = 0.0, to = 0.0;
  double ramp = 0.0;  ///< as requested; 0: as fast as allowed [s]
};
struct Schedule {  ///< a [[gain_change]] of the file begins
  static constexpr std::string_view word = "schedule";
  core::GainName gain = core::GainName::k_xx;
  double from = 0.0, to = 0.0;
};
struct ScheduleTracking {  ///< the same for a tracking gain; the largest of all robots
  static constexpr std::string_view word = "schedule";
  core::TrackingGain gain = core::TrackingGain::k_x;
  double from = 0.0, to = 0.0;
};
struct GainHeld {  ///< (18) forbids more than `held`
  static constexpr std::string_view word = "gain_held";
  core::GainName gain = core::GainName::k_xx;
  double asked = 0.0, held = 0.0;
};
struct PairGain {  ///< the operator's new target for one pair
  static constexpr std::string_view word = "pair_gain";
  std::size_t i = 0, j = 0;
  core::GainName gain = core::GainName::k_xx;
  double from = 0.0, to = 0.0;
  double ramp = 0.0;  ///< as requested; 0: as fast as allowed [s]
};
struct PairGainHeld {
  static constexpr std::string_view word = "pair_gain_held";
  std::size_t i = 0, j = 0;
  core::GainName gain = core::GainName::k_xx;
  double asked = 0.0, held = 0.0;
};
struct Parameter {  ///< the operator's new value of a parameter that the law declares
  static constexpr std::string_view word = "parameter";
  ParameterName name;
  double from = 0.0, to = 0.0;
};
struct Couple {  ///< two robots are coupled again
  static constexpr std::string_view word = "couple";
  std::size_t i = 0, j = 0;
};
struct Uncouple {  ///< they are no longer coupled
  static constexpr std::string_view word = "uncouple";
  std::size_t i = 0, j = 0;
};
struct Lost {  ///< no pose within the bridge time: the robot was stopped
  static constexpr std::string_view word = "lost";
  std::size_t robot = 0;
};
struct Found {  ///< its pose is back
  static constexpr std::string_view word = "found";
  std::size_t robot = 0;
};
struct Avoid {  ///< it entered a detection region
  static constexpr std::string_view word = "avoid";
  std::size_t robot = 0;
};
struct Clear {  ///< it is back on the nominal reference
  static constexpr std::string_view word = "clear";
  std::size_t robot = 0;
};
struct Stage {  ///< all robots drive to their starts: requested by the operator or the program
  static constexpr std::string_view word = "stage";
};
struct Staged {  ///< every robot stands at its start
  static constexpr std::string_view word = "staged";
};
struct Deadlock {  ///< no progress because of field or shield: the robot takes a detour
  static constexpr std::string_view word = "deadlock";
  std::size_t robot = 0;
};
struct DeadlineMissed {
  static constexpr std::string_view word = "deadline_missed";
  int ticks = 0;  ///< that were skipped
};
struct VRise {  ///< V has risen by this much without a known cause
  static constexpr std::string_view word = "v_rise";
  double rise = 0.0;
};
struct Link {  ///< a robot's link has been lost for longer than the bridge time, or is up again
  static constexpr std::string_view word = "link";
  std::size_t robot = 0;
  LinkState state = LinkState::up;
};
inline constexpr std::size_t only_camera = static_cast<std::size_t>(-1);
/// All visible tags moved by one rigid motion that the robots did not make, or look larger or smaller at once; or most
/// marks on the floor are not where they were when the camera was calibrated.
struct CameraMoved {
  static constexpr std::string_view word = "camera_moved";
  std::size_t camera = only_camera;  ///< which of several
  std::size_t tags = 0;
  double by = 0.0;        ///< their mean displacement [m]
  double turn = 0.0;      ///< counter-clockwise [rad]
  std::size_t marks = 0;  ///< marks that have moved; 0: the robots' tags showed it
  double scale = 0.0;     ///< how much larger the tags look, as a part; 0: they moved
};
/// Robots obey so much later than the known delays explain: pictures are older than their time stamps say.
struct PicturesLate {
  static constexpr std::string_view word = "pictures_late";
  double by = 0.0;  ///< [s]
};
struct CamerasDisagree {  ///< two cameras see a robot at different places: one of them has been moved
  static constexpr std::string_view word = "cameras_disagree";
  std::size_t robot = 0;
  std::size_t camera = 0, other = 0;
  double by = 0.0;  ///< [m]
};
struct CamerasDiffer {  ///< they see a robot apart, by less than makes all robots stop: calibrations or clocks differ
  static constexpr std::string_view word = "cameras_differ";
  std::size_t robot = 0;
  std::size_t camera = 0, other = 0;
  double by = 0.0;  ///< [m]
};
struct CameraLost {  ///< one of several cameras delivers no frames
  static constexpr std::string_view word = "camera_lost";
  std::size_t camera = 0;
};
struct CameraFound {  ///< and it does again
  static constexpr std::string_view word = "camera_found";
  std::size_t camera = 0;
};
struct NotSeen {  ///< why its tag has not been seen for half a second
  static constexpr std::string_view word = "not_seen";
  std::size_t robot = 0;
  core::NotSeen why = core::NotSeen::not_found;
};
struct FilmBroken {  ///< writing the camera's film failed; the run goes on without it
  static constexpr std::string_view word = "film_broken";
};

inline constexpr std::size_t nobody = static_cast<std::size_t>(-1);
struct NoWay {  ///< planning finds no route to its place: it stands, and planning continues
  static constexpr std::string_view word = "no_way";
  std::size_t robot = 0;
  std::size_t other = nobody;  ///< stands at its place
  double margin = 0.0;         ///< routes keep so much more from obstacles, because poses are uncertain [m]
};
struct NoProgress {  ///< it has made no progress towards its place for 3 s
  static constexpr std::string_view word = "no_progress";
  std::size_t robot = 0;
  double distance = 0.0;  ///< to its place [m]
  Hindrance hindrance = Hindrance::law;
};
struct Outside {  ///< its body is over the edge of the arena
  static constexpr std::string_view word = "outside";
  std::size_t robot = 0;
  double over = 0.0;  ///< how far [m]
};

struct Runaway {  ///< it does not drive as commanded; it is commanded to stand
  static constexpr std::string_view word = "runaway";
  std::size_t robot = 0;
  double v = 0.0;  ///< as measured [m/s]
};
struct Obeys {  ///< it stands as commanded: it may drive again
  static constexpr std::string_view word = "obeys";
  std::size_t robot = 0;
};

struct Controller {  ///< the run's own controller is late, has ended, or answers in time again
  static constexpr std::string_view word = "controller";
  ControllerState state = ControllerState::answered;
};
struct NoNumber {  ///< the law's output is not a number, or excessive: the robot stands until it is valid
  static constexpr std::string_view word = "no_number";
  std::size_t robot = 0;
};

}  // namespace events

/// An event of a tick; `describe` gives its words for the log.
using Event = std::variant<events::Start, events::Pause, events::Resume, events::Stop, events::Perturb, events::Kidnap,
                           events::Move, events::Hold, events::Release, events::Kick, events::PutObstacle, events::Gain,
                           events::Schedule, events::GainHeld, events::PairGain, events::PairGainHeld, events::Couple,
                           events::Uncouple, events::Lost, events::Found, events::Avoid, events::Clear, events::Stage,
                           events::Staged, events::Deadlock, events::DeadlineMissed, events::VRise, events::Link,
                           events::CameraMoved, events::NotSeen, events::FilmBroken, events::NoWay, events::NoProgress,
                           events::Outside, events::Controller, events::NoNumber, events::CamerasDisagree,
                           events::CameraLost, events::CameraFound, events::Runaway, events::Obeys, events::Parameter,
                           events::ScheduleTracking, events::CamerasDiffer, events::PicturesLate>;
static_assert(std::is_trivially_copyable_v<Event>, "the tick and its channels copy events without allocating");

/// For std::visit: one function for each alternative. An alternative that is in none of them does not compile.
template <typename... Function>
struct Overloaded : Function... {
  using Function::operator()...;
};
template <typename... Function>
Overloaded(Function...) -> Overloaded<Function...>;
template <typename Alternative, typename... List>
concept one_of = (std::same_as<std::remove_cvref_t<Alternative>, List> || ...);

/// Whether the event is one of these.
template <typename... Kind>
constexpr bool is(const Event& event) noexcept {
  return (std::holds_alternative<Kind>(event) || ...);
}

/// The robot that the event concerns; none: it concerns all, a pair or an obstacle.
std::optional<std::size_t> robot_of(const Event& event) noexcept;

/// The events of one tick: a bounded list. It allocates only in `reserve`; events that do not fit are
/// counted.
class EventList {
 public:
  /// The largest number of events in one tick: all changes before a start are reported at the start.
  static constexpr std::size_t room_for(std::size_t robots) noexcept {
    constexpr std::size_t others = 96 + most_parameters, of_a_robot = 5,
                          of_a_pair = 4;  // a pair: three gains, and whether it is coupled
    return others + of_a_robot * robots + of_a_pair * (robots * (robots - 1) / 2);
  }

  EventList() = default;
  explicit EventList(std::size_t limit) { reserve(limit); }
  /// Limits the list to this many events, and allocates for them.
  void reserve(std::size_t limit) {
    limit_ = limit;
    events_.reserve(limit);
  }
  void limit_to(std::size_t limit) noexcept { limit_ = limit; }

  void add(const Event& event) {
    if (events_.size() < limit_)
      events_.push_back(event);
    else
      ++dropped_;
  }
  /// Whether there is an event of this kind.
  template <typename Kind>
  bool contains() const noexcept {
    for (const Event& event : events_)
      if (is<Kind>(event)) return true;
    return false;
  }
  /// The same for one robot or obstacle.
  template <typename Kind>
  bool contains(std::size_t number) const noexcept {
    for (const Event& event : events_)
      if (const Kind* const found = std::get_if<Kind>(&event)) {
        if constexpr (requires { found->number; }) {
          if (found->number == number) return true;
        } else {
          if (found->robot == number) return true;
        }
      }
    return false;
  }
  void clear() noexcept {
    events_.clear();
    dropped_ = 0;
  }
  auto begin() const noexcept { return events_.begin(); }
  auto end() const noexcept { return events_.end(); }
  std::size_t size() const noexcept { return events_.size(); }
  std::size_t limit() const noexcept { return limit_; }
  bool empty() const noexcept { return events_.empty(); }
  bool full() const noexcept { return events_.size() >= limit_; }
  std::size_t room() const noexcept { return limit_ - std::min(limit_, events_.size()); }
  std::size_t dropped() const noexcept { return dropped_; }

 private:
  std::vector<Event> events_;
  std::size_t limit_ = room_for(4);
  std::size_t dropped_ = 0;
};

/// One event in words without commas, robots from 1, for the CSV, the log and the window: "perturb r2 dx=0.05 dy=0.15
/// dtheta=0", "gain k_xx 0.008 -> 0.01", "lost r3", "stop".
std::string describe(const Event& event);
/// The event with this description by `describe`; none: it is not a description.
std::optional<Event> parse_event(std::string_view text);
/// Whether it is an operator's action, which an experiment file can contain as well: moves, kicks, holds, obstacles,
/// gains.
bool is_action(const Event& event) noexcept;
/// As `parse_event`, but only actions with finite numbers; none: any other text.
std::optional<Event> parse_action(std::string_view text);
/// All events of a tick, joined by "; ", "+N more" where some were dropped.
std::string describe(const EventList& events);

}  // namespace skein::app
