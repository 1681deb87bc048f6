#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "core/avoidance/obstacle.h"
#include "core/avoidance/steering.h"
#include "core/control/gains.h"
#include "core/planning/formation_clock.h"
#include "core/planning/lattice.h"
#include "core/planning/merge.h"
#include "core/planning/route.h"
#include "core/planning/route_search.h"
#include "core/planning/sidestep.h"
#include "core/planning/traffic.h"
#include "core/reference/reference.h"

namespace skein::core {

/// Coordination by planned routes, after which come only the law, the limits and the shield. A robot whose nominal
/// reference is free follows that. A robot that would meet another, or has been put elsewhere, gets a route of its own:
///   to a place at rest     all robots concerned are planned one after the other, each through the traffic of those
///                          planned before (prioritised planning, restarted with the failed robot first)
///   to a place that moves  the fastest route that meets the place with its heading and speed (`Merge`); if robots
///                          that only follow their references block it, some of them yield: their clock stands for a
///                          moment and catches up, and robots that would come too near to them yield too;
///                          with a `FormationClock` the whole formation waits instead
/// Where the place itself drives into an obstacle, the robot leaves the lane in time, passes abreast of its place, and
/// returns to the lane (`Sidestep`).
/// While routes are driven, the planner searches for better ones, by which the last robot arrives sooner; robots change
/// to them on the way.
/// Routes are driven on clocks: a robot passes a point only after all robots due there earlier have left it, and a
/// robot that falls behind its reference holds its clock back. So a delay of one robot delays others but causes no
/// conflict. The reference is continuous and inside (18f, g). Work is limited by counts, not by time. Allocates in its
/// constructor only.
class Planner {
 public:
  enum class State {
    nominal,    ///< follows the formation's reference
    driving,    ///< on a route
    returning,  ///< after a route's end, towards its moving place as the law would drive it
    yielding,   ///< follows the formation's reference on a delayed clock, to let another robot pass
    passing,    ///< abreast of its place, beside an obstacle that stands on the lane
    waiting,    ///< stands: it is out of the group, is being planned, or there is no route
  };

  struct Setup {
    std::size_t robots = 0;
    std::size_t obstacles = 0;  ///< at most
    HalfSize arena;
    double shield_distance = 0.078;  ///< of two bodies of `radius` [m]
    double duration = 0.0;           ///< of the experiment [s]
    double shield_gamma = 4.0;       ///< [1/s]
    /// Of the largest body. [m]
    double radius = standard_radius;
    std::vector<double> smaller{};  ///< than that is each body; empty: all are as large [m]
    bool improve = true;            ///< better routes are searched for while robots drive; false: each keeps its first
  };
  /// `clock`: that of a formation that waits, on which the reference runs; null: the formation never waits. The planner
  /// steps it.
  Planner(const Setup& setup, const Reference& reference, FormationClock* clock = nullptr);

  /// Goes on from where `other` is, a planner of the same robots and the same arena, also in the middle of a search:
  /// the same scenes give the same bits. Its reference and clock stay its own. Not part of a step: it copies megabytes.
  void go_on_from(const Planner& other);

  struct Scene {
    double t = 0.0;          ///< of the experiment [s]
    bool to_starts = false;  ///< places stand where they are at t = 0
    std::span<const Pose> poses;
    std::span<const Twist> commands;    ///< the latest
    std::span<const std::uint8_t> out;  ///< lost or held: stands where it is
    /// Stands though it is commanded to drive: the others go around it, and it is planned anew once it drives.
    std::span<const std::uint8_t> stuck;
    std::span<const Obstacle> obstacles;
    double doubt = 0.0;  ///< uncertainty of the least certain pose [m]
    double hurry = 0.0;  ///< by how much the formation's clock may run faster, with no coupling released
    /// Of those that are out: who is only not seen at present. Empty: nobody.
    std::span<const std::uint8_t> unseen{};
  };
  /// One step of length dt [s]. `gains`: with the couplings as they are now.
  void step(const Scene& scene, const Gains& gains, double dt, std::span<const ReferencePoint> nominal,
            std::span<ReferencePoint> reference) noexcept;

  State state(std::size_t i) const noexcept { return robots_[i].state; }
  /// The share of its couplings that robot i has: they are released while it is on a route, and restored.
  double share(std::size_t i) const noexcept { return robots_[i].share; }
  /// Planning has found no route for robot i, and keeps trying.
  bool no_way(std::size_t i) const noexcept { return robots_[i].no_way; }
  /// What routes keep from obstacles and edges beyond the shield's distance, because poses are uncertain [m].
  double margin() const noexcept { return margin_.kept; }
  /// The robot that stood at the place of robot i when its route was planned, or none (robots()).
  std::size_t taken_by(std::size_t i) const noexcept { return robots_[i].taken_by; }
  /// The robot for which robot i waits to pass first, or none (robots()).
  std::size_t waits_for(std::size_t i) const noexcept { return robots_[i].waits_for; }
  /// Time that the route of robot i still takes until it is at its place [s]; NaN while it has none that leads there.
  double time_left(std::size_t i) const noexcept;
  /// Nodes expanded in the latest step.
  std::size_t nodes() const noexcept { return spent_; }
  void reset() noexcept;

  static constexpr std::size_t holds = 5;  ///< durations of yielding that are tried

 private:
  struct Start {
    Pose from;
    double v;
  };
  /// The robots that search for a way to a place that drives on: at most two at once, one after the other, in both
  /// orders, while others yield or not. The trials come in a fixed order and take as many ticks as they need; each
  /// starts from where the robots are by then. The best one is repeated with a whole tick's work before it is driven.
  struct Merging {
    static constexpr std::size_t most = 2;
    struct Trial {
      std::size_t care = 0, hold = 0, first = 0;  // hold 0: no robot yields; else those with robot `first`
      bool backwards = false;
    };
    std::array<std::size_t, most> robots{};
    std::size_t count = 0, searched = 0;  // searched: by the search under way; 0: there is none
    Trial next, best;
    bool decided = false;                 // everything has been tried
    std::array<bool, most> urgent{};      // another robot soon reaches the place where it stands without a way
    bool around = false;                  // past all obstacles on the lane of the place
    bool somebody_yields = false;         // in this step, by an earlier decision
    double began = 0.0, best_ends = 0.0;  // [s]
    std::array<Pose, most> from;
    std::array<Pace, most> paces;
    std::array<double, most> v{}, soonest{};
    std::array<Route, most> routes;
    std::array<double, most> joins{};
    std::vector<std::uint8_t> yields;
    std::array<std::vector<std::uint8_t>, holds> last_yields;  // for each duration, with the robot asked before
    std::vector<std::size_t> order;                            // in which robots are asked to yield
    std::vector<std::size_t> comes;  // when each reaches the robot that stands [Traffic::step]
    Delay delay;
  };

  struct Robot {
    State state = State::nominal;
    double clock = 0.0, rate = 0.0;  // [s], its share of real time
    double due = 0.0;                // time of the experiment at which its clock was 0, without delays [s]
    double share = 1.0;
    double held_for = 0.0;  // how long its clock has hardly advanced [s]
    double barred = 0.0;    // how long the shield has kept it from its route [s]
    double retry = 0.0;     // no new plan before [s]
    double patience = 0.0;  // time to the next attempt after finding no way; grows with each failure [s]
    double joins = 0.0;     // for a moving place: when its route meets it, on its clock [s]
    double looks_at = 0.0;  // on its way there: no new search for a better one before [s]
    Merging::Trial looks;   // the behaviour of the others that this search assumes
    double keeps = 0.0;     // distance from others' routes used in planning [m]
    ReferencePoint reference;
    Pose before;          // its pose at the previous step
    bool is_new = false;  // seen for the first time, or planning begins
    std::size_t waits_for = 0, taken_by = 0;
    bool no_way = false, needs_plan = false;
    bool makes_room = false;  // there is no way to its place: it drives to where it blocks no other robot
    bool gives_way = false;   // as all have done or do, since their order left no way to one of them
    bool all_anew = false;    // and all robots with it
    bool stood = false;       // it was out, or stuck
    double stood_for = 0.0;   // how long [s]
    double unseen_for = 0.0;  // how long it has not been seen [s]
    bool looks_far = false;   // its whole way, once it has one: it may have been barred
    Route route;
    Sidestep aside;  // while it passes an obstacle
  };

  void let_formation_wait(const Scene& scene, const Gains& gains) noexcept;
  void find_conflicts(const Scene& scene, std::span<const ReferencePoint> nominal) noexcept;
  void watch(std::size_t i, const Scene& scene, const Gains& gains, std::span<const ReferencePoint> nominal,
             bool to_the_end) noexcept;
  Start begin_route(std::size_t i, const Scene& scene) noexcept;
  void plan(const Scene& scene, const Gains& gains, std::span<const ReferencePoint> nominal) noexcept;
  /// Begins the search for robot i's route from a pose at rest; it leaves at `begins`, on the traffic's clock [s].
  void begin_search(std::size_t i, const Pose& from, double begins, const Scene& scene) noexcept;
  /// Continues the search with the rest of this tick's work. Whether it has ended.
  bool continue_search() noexcept;
  void begin_group(const Scene& scene, std::span<const ReferencePoint> nominal, bool everybody) noexcept;
  void go_on_with_group(const Scene& scene, std::span<const ReferencePoint> nominal) noexcept;
  void begin_group_anew() noexcept;
  bool include_who_follows(const Scene& scene) noexcept;
  bool all_gave_way() const noexcept;
  bool let_all_give_way() noexcept;
  bool improve(const Scene& scene) noexcept;
  void wait_for_a_way(std::size_t i) noexcept;
  void wait_here(std::size_t i, const Pose& pose) noexcept;
  void end_group(const Scene& scene) noexcept;
  void improve_on_the_way(const Scene& scene, std::span<const ReferencePoint> nominal) noexcept;
  bool begin_improvement(const Scene& scene) noexcept;
  void ask_for_improvement(const Scene& scene, std::span<const ReferencePoint> nominal) noexcept;
  bool may_turn_off(std::size_t i, const Scene& scene) const noexcept;
  bool gets_in_the_way(std::size_t i, std::size_t j, const Scene& scene) const noexcept;
  double arrives(std::size_t i) const noexcept;
  double clock_for(std::size_t j, std::size_t i, double t) const noexcept;
  void expect(std::size_t j, const Scene& scene, std::span<const ReferencePoint> nominal) noexcept;
  void plan_merges(const Scene& scene, const Gains& gains, std::span<const ReferencePoint> nominal) noexcept;
  double merge(const Merging::Trial& trial, const Scene& scene, Merge::Query like, double before) noexcept;
  bool advance_trial(const Scene& scene, std::span<const ReferencePoint> nominal, bool may_yield) noexcept;
  Merge::Query expect_all(const Scene& scene, const Gains& gains, std::span<const ReferencePoint> nominal) noexcept;
  void seek(std::size_t k, const Start& from, const Gains& gains) noexcept;
  void find_alone(const Merge::Query& like) noexcept;
  double hurry_of_all(const Gains& gains) const noexcept;
  bool let_yield(const Merging::Trial& trial, const Scene& scene, double hurry, double slope) noexcept;
  void go(const Scene& scene) noexcept;
  void look_again(std::size_t i, const Scene& scene, const Gains& gains,
                  std::span<const ReferencePoint> nominal) noexcept;
  void sort_who_comes(const Scene& scene) noexcept;
  bool who_yields(std::size_t first, const Scene& scene, const Delay& delay) noexcept;
  void follow_yielding(std::size_t i, double t) noexcept;
  bool pass_obstacle(std::size_t i, const Scene& scene, const Gains& gains,
                     std::span<const ReferencePoint> nominal) noexcept;
  bool meets_nobody(std::size_t i, const Sidestep& way, const Scene& scene,
                    std::span<const ReferencePoint> nominal) noexcept;
  Pose expected_at(std::size_t j, double ahead, const Scene& scene,
                   std::span<const ReferencePoint> nominal) const noexcept;
  void set_off(std::size_t i, double due) noexcept;
  void run_clock(std::size_t i, const Scene& scene, double dt) noexcept;
  bool must_wait(std::size_t i, double ahead) noexcept;
  double may_run(std::size_t i, const Scene& scene) noexcept;
  bool rests(std::size_t i, const Scene& scene) const noexcept;
  bool is_back(std::size_t i, const Scene& scene, const Pose& place) const noexcept;
  static bool out_of_sight(std::size_t i, const Scene& scene) noexcept {
    return !scene.unseen.empty() && scene.unseen[i];
  }
  bool pauses(std::size_t i, const Scene& scene) const noexcept;
  /// Stands, and nobody knows for how long.
  bool stands(std::size_t i, const Scene& scene) const noexcept {
    return scene.stuck[i] || (scene.out[i] && !pauses(i, scene));
  }
  Pose goal(std::size_t i, const Scene& scene) const noexcept;
  bool is_taken(std::size_t i, const Scene& scene) noexcept;
  void know_paces(const Gains& gains) noexcept;
  bool follow_doubt(double doubt, double dt) noexcept;
  /// The smallest distance of two of the largest bodies on routes: the shield's, with room for rounding. [m]
  double least_apart() const noexcept { return setup_.shield_distance + 5e-4; }
  /// By how much this pair may come closer together than two of the largest bodies. [m]
  double closer(std::size_t i, std::size_t j) const noexcept {
    return setup_.smaller.empty() ? 0.0 : setup_.smaller[i] + setup_.smaller[j];
  }
  const Lattice& lattice(std::size_t i) const noexcept { return lattices_[lattice_of_[i]]; }
  double lag(std::size_t i) const noexcept { return now_ - robots_[i].due - robots_[i].clock; }

  static constexpr double never = std::numeric_limits<double>::infinity();
  static constexpr double put_elsewhere = 0.03;         // from a moving place, or a route: a new plan [m]
  static constexpr double sees_ahead = 3.0;             // who or what is in its way [s]
  static constexpr double leaves_within = 4.0;          // a robot without a route is assumed to stand until then [s]
  static constexpr std::size_t nodes_each_tick = 1300;  // some 2 us each on a processor of 2.6 GHz
  static constexpr double looks_elsewhere = 0.35;       // heading error that causes one, as the law turns slowly [rad]

  const Reference* reference_;
  FormationClock* clock_;
  Setup setup_;
  std::vector<Lattice> lattices_;        // one for each size of body
  std::vector<std::size_t> lattice_of_;  // each robot
  Traffic traffic_, expected_;
  RouteSearch search_;
  Merge merge_;
  SidestepSearch sidesteps_;
  std::vector<Pace> paces_;     // of routes
  double fastest_pace_ = 0.09;  // of all [m/s]
  std::vector<Robot> robots_;
  std::vector<Pose> goals_;        // final poses of references
  std::vector<double> rest_from_;  // since when, or infinity [s]
  std::vector<bool> coupled_;
  std::vector<Pose> on_route_;  // where those that drive are to be now
  std::vector<double> shift_;   // [i n + j]: robot j's schedule as robot i's plan takes it, minus robot j's own [s]
  std::vector<Obstacle> obstacles_;
  double now_ = 0.0, keep_ = 0.1;
  double formation_t_ = 0.0;  // now, on the formation's clock [s]
  ReferenceDemand demand_;    // for that; a formation evaluates its whole path to find it
  std::size_t tick_ = 0, spent_ = 0;
  bool begun_ = false, to_starts_ = false;

  /// What routes keep from obstacles and edges beyond the shield's distance, because poses are uncertain.
  struct Margin {
    double kept = 0.0;                 // [m]
    double least = never, most = 0.0;  // doubt since it was last compared with that [m]
    double lasts = 0.0;                // so long [s]
    double shuts = 0.0;                // how long a robot has had no way [s]
    bool known = false, given_up = false;
  } margin_;

  struct Group {
    bool active = false, everybody = false, asking = false;
    bool give_way = false;                                             // all go where others can pass
    double began = 0.0, lead = 0.0, until = 0.0;                       // [s]
    std::size_t next = 0;                                              // in the order
    enum class Others { leave, stay, absent } others = Others::leave;  // assumed behaviour of robots without a route
    int attempt = 0;
    std::vector<std::size_t> order;
    std::vector<std::uint8_t> member, planned;
    std::vector<Pose> from;      // poses of members after braking
    std::vector<double> stands;  // since when, after `began` [s]
    std::vector<Pose> places;    // where robots rest or will rest; NaN: it moves
    std::vector<Route> routes, best;
    double best_arrival = 0.0;  // of the last of all, after `began` [s]
    int improvements = 0;
  } group_;

  /// A trial to let the last robot arrive sooner.
  struct Improvement {
    enum class Role : std::uint8_t {
      keeps_on,   // its route stays
      gives_way,  // it turns off its route if it is in the way of a new one
      asked,      // it turns off its route, and has no new one yet
      planned,
    };
    std::vector<Role> role;
    std::vector<double> from;   // where they turn off, on their clocks [s]
    std::vector<Route> routes;  // the new ones; up to the turn-off while they have none
    std::size_t asked = 0;      // number of robots with this role; 0: no trial
    std::size_t next = 0;       // the robot whose route is searched for
    bool searching = false;
    double began = 0.0, limit = 0.0;  // of arrivals [s]
    std::size_t failures = 0;         // in a row
    /// Knuth's generator (MMIX), whose upper bits are random.
    std::linear_congruential_engine<std::uint64_t, 6364136223846793005U, 1442695040888963407U, 0U> draw{0U};
    void ask(std::size_t i) noexcept;
    double random() noexcept;  // from 0 to 1
  } improvement_;

  Delay yield_;  // of all that yield
  Merging merging_;
};

}  // namespace skein::core
