#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/planning/lattice.h"
#include "core/planning/route.h"
#include "core/planning/traffic.h"

namespace skein::core {

/// The fastest route of one robot through the others' traffic: safe-interval path planning (Phillips and
/// Likhachev, 2011) on the lattice, with the heading as part of the state, then straightened. Work is counted in
/// nodes and done in slices of fixed size per tick, so that every run repeats it. Allocates in its constructor
/// only.
class RouteSearch {
 public:
  RouteSearch(const Lattice& lattice, std::size_t robots);
  /// A copy goes on with its own lattice and traffic, which are copies themselves.
  void look_at(const Lattice& lattice, const Traffic& traffic) noexcept {
    lattice_ = &lattice;
    traffic_ = &traffic;
  }

  struct Query {
    std::size_t robot = 0;
    Pose from;              ///< at rest, at time 0 of the traffic + `begins`
    double begins = 0.0;    ///< [s]
    Pose to;                ///< at rest, for ever
    double keep = 0.1;      ///< between two midpoints [m]
    double least = 0.0785;  ///< smaller limit if both goals are closer than that [m]
    Pace pace;
    std::span<const double> smaller{};  ///< than `keep` and `least` are for: each body [m]; empty: none is
    /// If not empty, the route leads not to `to` but to the nearest place where the robot blocks no other: no robot
    /// passes there later, and it is none of these, which are the others' places. It may be where the robot stands:
    /// then there are no legs.
    std::span<const Pose> away_from{};
    /// That place must let others pass as well, round it and round those who stand near it in the end.
    bool lets_pass = false;
  };
  void begin(const Query& query, const Traffic& traffic) noexcept;
  /// Continues with up to this many nodes; returns the number expanded.
  std::size_t advance(std::size_t nodes) noexcept;
  bool searching() const noexcept { return searching_; }
  bool found() const noexcept { return found_; }  ///< a route; false after the search: there is none
  /// If a route was found: the legs, with times relative to the query's, and when the robot has arrived and turned. [s]
  std::span<const Leg> legs() const noexcept { return {legs_.data(), leg_count_}; }
  double arrival() const noexcept { return arrival_; }

 private:
  struct Interval {
    float begin, end;  // [s]
  };
  struct Node {
    float g, f;    // arrival, and with what is left [s]
    float leaves;  // its parent, driving [s]
    std::uint32_t state, parent;
  };
  static constexpr std::size_t words = Traffic::steps / 64;
  static constexpr std::size_t intervals_each = 12;
  static constexpr std::size_t headings = Lattice::directions + 1;  // the last: straight from the start
  static constexpr std::uint32_t nobody = 0xffffffff;

  bool may_end(std::size_t vertex, std::size_t interval) noexcept;
  bool lets_pass(const Lattice::Place& at) noexcept;
  void stamp() noexcept;
  void estimate() noexcept;
  std::span<const Interval> intervals(std::size_t vertex) noexcept;
  void expand(std::uint32_t node) noexcept;
  void reach(std::uint32_t parent, std::size_t vertex, std::size_t heading, double ready, double duration) noexcept;
  void finish(std::uint32_t node) noexcept;
  double heading_at(const Node& node) noexcept;
  bool comes_too_late(std::uint32_t node) noexcept;
  bool may_be_sooner(const Node& node, std::size_t vertex, std::size_t heading, double drives) noexcept;
  bool direct() noexcept;
  /// When and in which direction a robot has come to a point. [s, rad]
  struct Moment {
    double t, theta;
  };
  bool append(const Lattice::Place& from, const Lattice::Place& to, bool last, double latest, Moment& at,
              Leg& leg) noexcept;
  bool retime(std::span<const Lattice::Place> points, Moment at, double latest, std::span<Leg> legs,
              double& arrival) noexcept;
  void straighten() noexcept;
  void enclose_others() noexcept;
  void find_near(const Lattice::Place& from, const Lattice::Place& to, double begins, double ends) noexcept;
  bool clear(double x, double y, double t) const noexcept;
  bool parts(const Lattice::Place& from, const Lattice::Place& to, double leaves, double arrives) noexcept;
  bool clear_line(const Lattice::Place& from, const Lattice::Place& to, double leaves, double arrives) noexcept;
  bool stays_clear(const Lattice::Place& at, double t) noexcept;

  Lattice::Place place(std::size_t vertex) const noexcept;
  std::size_t goal() const noexcept { return lattice_->size(); }
  std::size_t start() const noexcept { return lattice_->size() + 1; }
  std::size_t state_of(std::size_t vertex, std::size_t heading, std::size_t interval) const noexcept {
    return (vertex * headings + heading) * intervals_each + interval;
  }

  const Lattice* lattice_;
  const Traffic* traffic_ = nullptr;
  Query query_;
  bool searching_ = false, found_ = false;
  double weight_ = 1.0;         // of what is left, against what was driven
  std::vector<double> radius_;  // to keep from each robot [m]
  /// What a robot does not leave for a while.
  struct Box {
    double left, right, bottom, top;
  };
  static constexpr std::size_t block = 16;    // of the traffic's steps, for which there is a box
  std::vector<std::uint32_t> others_;         // who is to be kept from
  std::vector<Box> boxes_;                    // of each of these, block after block; the last one is for ever
  std::size_t blocks_ = 0, still_from_ = 0;   // from this step on all of them stand
  std::vector<std::uint32_t> close_;          // those of them that are nearer at the start than the shield asks for
  std::vector<std::uint32_t> near_;           // those of them that a part of a line may come near to
  std::vector<std::uint64_t> taken_;          // a bit for each step of each vertex
  std::vector<Interval> intervals_;           // of each vertex
  std::vector<std::uint8_t> interval_count_;  // 255: not looked for yet
  std::vector<float> left_;                   // distance from each vertex to the goal [m]
  std::vector<float> best_;                   // arrival at each state
  std::vector<std::uint32_t> best_of_;        // the search that it belongs to
  struct First {
    std::uint32_t node, search;
  };
  std::vector<First> first_;  // that was expanded at each vertex, in each of its intervals
  std::vector<Node> nodes_;
  std::vector<std::pair<float, std::uint32_t>> open_;
  std::vector<std::uint32_t> exits_;  // vertices that see the goal
  std::vector<std::uint8_t> is_exit_;
  std::vector<std::uint32_t> near_vertices_, seen_;  // seen_: the count of `seen_now_` then
  std::uint32_t seen_now_ = 0;
  std::uint32_t search_ = 0;
  std::array<Leg, Route::most_legs> legs_{};
  std::size_t leg_count_ = 0;
  double arrival_ = 0.0;
};

}  // namespace skein::core
