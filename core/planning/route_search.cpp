#include "core/planning/route_search.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double attach = 1.7;     // start and goal are joined with vertices within so many cells
constexpr double weight = 1.05;    // of what is left, against what was driven: fewer nodes, at most 5 % longer ways
constexpr double haste = 3.0;      // the same, where the nodes do not suffice: some way rather than none
constexpr double wait_step = 0.2;  // [s]
constexpr int most_waits = 60;
constexpr double departure_step = 1.0;     // of a robot that is shut in at its start [s]
constexpr std::size_t most_nodes = 60000;  // of one search
constexpr double turned_off = 0.02;        // of a robot that parts from one that is too near, at least [rad]
constexpr float unreached = std::numeric_limits<float>::infinity();

}  // namespace

RouteSearch::RouteSearch(const Lattice& lattice, std::size_t robots)
    : lattice_(&lattice),
      radius_(robots),
      taken_((lattice.size() + 2) * words),
      intervals_((lattice.size() + 2) * intervals_each),
      interval_count_(lattice.size() + 2),
      left_(lattice.size() + 2),
      best_((lattice.size() + 2) * headings * intervals_each),
      best_of_(best_.size()),
      first_((lattice.size() + 2) * intervals_each),
      is_exit_(lattice.size() + 2),
      seen_(lattice.size()) {
  others_.reserve(robots);
  near_.reserve(robots);
  close_.reserve(robots);
  boxes_.resize(robots * (Traffic::steps / block + 1));
  nodes_.reserve(most_nodes);
  open_.reserve(most_nodes);
  exits_.reserve(64);
  near_vertices_.reserve(lattice.size());
}

Lattice::Place RouteSearch::place(std::size_t vertex) const noexcept {
  if (vertex == goal()) return lattice_->inside(query_.to.x, query_.to.y);
  if (vertex == start()) return {query_.from.x, query_.from.y};
  return lattice_->place(vertex);
}

void RouteSearch::begin(const Query& query, const Traffic& traffic) noexcept {
  query_ = query;
  traffic_ = &traffic;
  ++search_;
  nodes_.clear();
  open_.clear();
  leg_count_ = 0;
  searching_ = true;
  found_ = false;
  close_.clear();
  const auto k0 = std::min(Traffic::steps - 1, static_cast<std::size_t>(query.begins / Traffic::step));
  for (std::size_t j = 0; j < radius_.size(); ++j) {
    if (j == query.robot || !traffic.present(j)) {
      radius_[j] = 0.0;
      continue;
    }
    const std::size_t last = Traffic::steps - 1;
    const double at_start = math::hypot(traffic.x(j, k0) - query.from.x, traffic.y(j, k0) - query.from.y);
    const double at_end = math::hypot(traffic.x(j, last) - query.to.x, traffic.y(j, last) - query.to.y);
    constexpr double less = 1e-3, rounding = 1e-6;
    const double closer = query.smaller.empty() ? 0.0 : query.smaller[query.robot] + query.smaller[j];
    const double least = query.least - closer,
                 nearest = std::min(at_start - rounding, std::max(at_start - less, least));
    radius_[j] = std::min(std::max(std::min(query.keep - closer, at_end - less), least), nearest);
    if (at_start < least) close_.push_back(static_cast<std::uint32_t>(j));
  }
  enclose_others();
  if (query.away_from.empty() && direct()) {
    searching_ = false;
    found_ = true;
    return;
  }
  stamp();
  estimate();
  weight_ = weight;
  // The start, if the robot may stand there now.
  const auto now = intervals(start());
  for (std::size_t k = 0; k < now.size(); ++k)
    if (now[k].begin <= query_.begins + Traffic::step && query_.begins <= now[k].end) {
      if (!query_.away_from.empty() && may_end(start(), k)) {
        searching_ = false;
        found_ = true;
        arrival_ = query_.begins;
        return;
      }
      nodes_.push_back({static_cast<float>(query_.begins), 0.0f, static_cast<float>(query_.begins),
                        static_cast<std::uint32_t>(state_of(start(), headings - 1, k)), nobody});
      open_.emplace_back(0.0f, 0u);
      return;
    }
  searching_ = false;
}

/// Straight there at once.
bool RouteSearch::direct() noexcept {
  const Lattice::Place to = place(goal());
  double arrival = 0.0;
  const std::array<Lattice::Place, 2> points{place(start()), to};
  const double soonest =
      query_.begins +
      query_.pace.turn_time(wrap_angle(math::atan2(to.y - query_.from.y, to.x - query_.from.x) - query_.from.theta)) +
      query_.pace.drive_time(math::hypot(to.x - query_.from.x, to.y - query_.from.y)) + 1.0;
  if (!lattice_->free(points[0], points[1]) ||
      !retime(points, {query_.begins, query_.from.theta}, soonest, legs_, arrival))
    return false;
  leg_count_ = 1;
  arrival_ = arrival;
  return true;
}

/// Whether the robot may stay at a vertex that it reaches in this interval.
bool RouteSearch::may_end(std::size_t vertex, std::size_t interval) noexcept {
  if (query_.away_from.empty()) return vertex == goal();
  if (intervals(vertex)[interval].end < unreached) return false;
  const Lattice::Place here = place(vertex);
  for (std::size_t j = 0; j < query_.away_from.size(); ++j) {
    const Pose& other = query_.away_from[j];
    const double closer = query_.smaller.empty() ? 0.0 : query_.smaller[query_.robot] + query_.smaller[j];
    const bool own = j == query_.robot && (!query_.lets_pass || vertex == start());
    if (!own && math::hypot(here.x - other.x, here.y - other.y) < query_.keep - closer) return false;
  }
  return !query_.lets_pass || lets_pass(here);
}

/// Whether others can drive round a robot that stands there: the vertices near it, without those that it takes, and
/// those that others take in the end, are still joined with one another. In a door or a corridor they are not.
bool RouteSearch::lets_pass(const Lattice::Place& at) noexcept {
  constexpr std::size_t last = Traffic::steps - 1;
  const double reach = query_.keep + 3.0 * lattice_->cell();
  const auto from_there = [&](std::size_t v) {
    return math::hypot(lattice_->place(v).x - at.x, lattice_->place(v).y - at.y);
  };
  const auto is_left = [&](std::size_t v) {
    const Lattice::Place& p = lattice_->place(v);
    return from_there(v) >= query_.keep && std::all_of(others_.begin(), others_.end(), [&](std::uint32_t j) {
             return math::hypot(traffic_->x(j, last) - p.x, traffic_->y(j, last) - p.y) >= radius_[j];
           });
  };
  // Joined with one another, and with those from which they spread.
  const auto spread = [&](auto&& may) {
    for (std::size_t k = 0; k < near_vertices_.size(); ++k)
      for (std::size_t d = 0; d < Lattice::directions; ++d) {
        const std::size_t u = lattice_->neighbour(near_vertices_[k], d);
        if (u == lattice_->size() || seen_[u] == seen_now_ || from_there(u) >= reach || !may(u)) continue;
        seen_[u] = seen_now_;
        near_vertices_.push_back(static_cast<std::uint32_t>(u));
      }
  };
  const auto begin = [&] {
    ++seen_now_;
    near_vertices_.clear();
  };
  begin();
  lattice_->near(at.x, at.y, attach * lattice_->cell(), [&](std::size_t v) {
    if (!lattice_->free(at, lattice_->place(v))) return;
    seen_[v] = seen_now_;
    near_vertices_.push_back(static_cast<std::uint32_t>(v));
  });
  spread([](std::size_t) { return true; });
  std::size_t left = 0, first = 0;
  for (const std::uint32_t v : near_vertices_)
    if (is_left(v) && left++ == 0) first = v;
  if (left == 0) return false;
  begin();
  seen_[first] = seen_now_;
  near_vertices_.push_back(static_cast<std::uint32_t>(first));
  spread(is_left);
  if (near_vertices_.size() != left) return false;
  // The others' places as well: there may be no vertex beside one at the end of a dead end.
  for (std::size_t j = 0; j < query_.away_from.size(); ++j) {
    const Lattice::Place to{query_.away_from[j].x, query_.away_from[j].y};
    if (j == query_.robot || math::hypot(to.x - at.x, to.y - at.y) >= reach) continue;
    bool was_joined = false, is_joined = false;
    lattice_->near(to.x, to.y, attach * lattice_->cell(), [&](std::size_t v) {
      if (seen_[v] + 1 < seen_now_ || !lattice_->free(lattice_->place(v), to)) return;
      was_joined = true;
      is_joined = is_joined || seen_[v] == seen_now_;
    });
    if (was_joined && !is_joined) return false;
  }
  return true;
}

/// Takes the others' ways out of the vertices' time.
void RouteSearch::stamp() noexcept {
  std::fill(taken_.begin(), taken_.end(), 0);
  std::fill(interval_count_.begin(), interval_count_.end(), std::uint8_t{255});
  const Lattice::Place ends[2] = {place(goal()), place(start())};
  for (std::size_t j = 0; j < radius_.size(); ++j) {
    if (radius_[j] <= 0.0) continue;
    const std::size_t still = traffic_->still_from(j);
    const auto mark = [&](std::size_t v, std::size_t first, std::size_t last) {
      constexpr std::uint64_t all = ~std::uint64_t{0};
      std::uint64_t* const row = &taken_[v * words];
      if (last >= still) last = Traffic::steps - 1;
      const std::uint64_t begin = all << (first % 64), end = all >> (63 - last % 64);
      if (first / 64 == last / 64) {
        row[first / 64] |= begin & end;
        return;
      }
      row[first / 64] |= begin;
      for (std::size_t w = first / 64 + 1; w < last / 64; ++w) row[w] = all;
      row[last / 64] |= end;
    };
    for (std::size_t k = 0; k <= still; ++k) {
      const double x = traffic_->x(j, k), y = traffic_->y(j, k), r = radius_[j];
      std::size_t last = k;  // it turns or waits there until then
      while (last < still && traffic_->x(j, last + 1) == x && traffic_->y(j, last + 1) == y) ++last;
      lattice_->near(x, y, r, [&](std::size_t v) { mark(v, k, last); });
      for (std::size_t e = 0; e < 2; ++e) {
        const double dx = ends[e].x - x, dy = ends[e].y - y;
        if (dx * dx + dy * dy < r * r) mark(goal() + e, k, last);
      }
      k = last;
    }
  }
}

/// The distance from every vertex to the goal, without other robots.
void RouteSearch::estimate() noexcept {
  std::fill(left_.begin(), left_.end(), unreached);
  std::fill(is_exit_.begin(), is_exit_.end(), std::uint8_t{0});
  if (!query_.away_from.empty()) return std::fill(left_.begin(), left_.end(), 0.0f);
  const Lattice::Place to = place(goal());
  open_.clear();
  left_[goal()] = 0.0f;
  exits_.clear();
  lattice_->near(to.x, to.y, attach * lattice_->cell(), [&](std::size_t v) {
    if (exits_.size() == exits_.capacity() || !lattice_->free(lattice_->place(v), to)) return;
    exits_.push_back(static_cast<std::uint32_t>(v));
    is_exit_[v] = 1;
    left_[v] = static_cast<float>(math::hypot(lattice_->place(v).x - to.x, lattice_->place(v).y - to.y));
    open_.emplace_back(left_[v], static_cast<std::uint32_t>(v));
  });
  const auto later = [](const auto& a, const auto& b) { return a > b; };
  std::make_heap(open_.begin(), open_.end(), later);
  while (!open_.empty()) {
    const auto [d, v] = open_.front();
    std::pop_heap(open_.begin(), open_.end(), later);
    open_.pop_back();
    if (d > left_[v]) continue;
    for (std::size_t k = 0; k < Lattice::directions; ++k) {
      const std::size_t u = lattice_->neighbour(v, k);
      if (u == lattice_->size()) continue;
      const auto way = d + static_cast<float>(lattice_->edge(v, k).way);
      if (way >= left_[u]) continue;
      left_[u] = way;
      open_.emplace_back(way, static_cast<std::uint32_t>(u));
      std::push_heap(open_.begin(), open_.end(), later);
    }
  }
  open_.clear();
}

std::span<const RouteSearch::Interval> RouteSearch::intervals(std::size_t vertex) noexcept {
  Interval* const all = &intervals_[vertex * intervals_each];
  std::uint8_t& count = interval_count_[vertex];
  if (count == 255) {
    count = 0;
    const std::uint64_t* const row = &taken_[vertex * words];
    const auto next = [&](std::size_t k, bool set) {  // the first step from k on that is taken, or is not
      while (k < Traffic::steps) {
        const std::uint64_t word = (set ? row[k / 64] : ~row[k / 64]) >> (k % 64);
        if (word != 0) return std::min(Traffic::steps, k + static_cast<std::size_t>(std::countr_zero(word)));
        k = (k / 64 + 1) * 64;
      }
      return Traffic::steps;
    };
    for (std::size_t k = next(0, false); k < Traffic::steps && count < intervals_each;) {
      const std::size_t end = next(k, true);
      all[count++] = {
          static_cast<float>(Traffic::step * static_cast<double>(k)),
          end == Traffic::steps ? unreached : static_cast<float>(Traffic::step * (static_cast<double>(end) - 1.0))};
      k = next(end, false);
    }
  }
  return {all, count};
}

std::size_t RouteSearch::advance(std::size_t budget) noexcept {
  std::size_t spent = 0;
  const auto later = [](const auto& a, const auto& b) { return a > b; };
  while (searching_ && spent < budget) {
    if (open_.empty()) {
      searching_ = false;
      break;
    }
    if (nodes_.size() + 64 > nodes_.capacity()) {
      // A long way round something has many turns, which the estimate of what is left does not know: nearly all that
      // lies before them seems to be sooner. Where every place will do, nothing is left anywhere.
      searching_ = weight_ < haste && query_.away_from.empty();
      if (!searching_) break;
      weight_ = haste;
      ++search_;  // no state is reached
      nodes_.erase(nodes_.begin() + 1, nodes_.end());
      open_.assign(1, {0.0f, 0u});  // the start
    }
    const auto [f, node] = open_.front();
    std::pop_heap(open_.begin(), open_.end(), later);
    open_.pop_back();
    const Node& n = nodes_[node];
    if (node != 0 && (best_of_[n.state] != search_ || n.g > best_[n.state])) continue;
    if (node != 0 && lattice_->has_obstacles() && comes_too_late(node)) continue;
    spent += query_.lets_pass ? 4 : 1;
    if (may_end(n.state / intervals_each / headings, n.state % intervals_each)) {
      finish(node);
      break;
    }
    expand(node);
  }
  return spent;
}

/// Drives to a vertex, as soon as it is free: in each of its intervals a state of its own.
void RouteSearch::reach(std::uint32_t parent, std::size_t vertex, std::size_t heading, double ready,
                        double duration) noexcept {
  const std::size_t from_state = nodes_[parent].state;
  const std::size_t from = from_state / intervals_each / headings;
  const double may_stay = intervals(from)[from_state % intervals_each].end;
  const auto all = intervals(vertex);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const double leaves = std::max(ready, static_cast<double>(all[k].begin));
    // A robot that waits starts anew.
    const double takes =
        duration + (leaves > ready + 1e-6 && heading < Lattice::directions ? query_.pace.start_time() : 0.0);
    const double arrives = leaves + takes;
    if (arrives > may_stay) break;
    if (arrives > all[k].end) continue;
    double g = arrives;
    if (vertex == goal()) {
      if (all[k].end < unreached) continue;  // another robot passes later
    }
    const std::size_t state = state_of(vertex, heading, k);
    if (best_of_[state] == search_ && best_[state] <= g) continue;
    best_of_[state] = search_;
    best_[state] = static_cast<float>(g);
    const double left = weight_ * left_[vertex] / query_.pace.v;
    nodes_.push_back({static_cast<float>(g), static_cast<float>(g + left), static_cast<float>(leaves),
                      static_cast<std::uint32_t>(state), parent});
    open_.emplace_back(static_cast<float>(g + left), static_cast<std::uint32_t>(nodes_.size() - 1));
    std::push_heap(open_.begin(), open_.end(), [](const auto& a, const auto& b) { return a > b; });
  }
}

/// In which a robot has come to a vertex. [rad]
double RouteSearch::heading_at(const Node& node) noexcept {
  const std::size_t v = node.state / intervals_each / headings, came = node.state / intervals_each % headings;
  const std::size_t from = nodes_[node.parent].state / intervals_each / headings;
  if (came < Lattice::directions) return lattice_->edge(from, came).heading;
  const Lattice::Place here = place(v), before = place(from);
  return math::atan2(here.y - before.y, here.x - before.x);
}

/// Whether the robot, had it come to the vertex on the way that was first there, could turn on the spot and drive on
/// from there no later. It may wait and turn there as long as the interval lasts. While others take turns in a passage,
/// nearly all ways are such detours.
bool RouteSearch::comes_too_late(std::uint32_t node) noexcept {
  const Node& n = nodes_[node];
  const std::size_t v = n.state / intervals_each / headings;
  if (v == goal()) return false;
  First& first = first_[v * intervals_each + n.state % intervals_each];
  if (first.search != search_) {
    first = {node, search_};
    return false;
  }
  const Node& before = nodes_[first.node];
  const double turns = query_.pace.turn_time(wrap_angle(heading_at(n) - heading_at(before)));
  return n.g > before.g + turns + query_.pace.start_time();
}

/// Whether a way to a vertex may be the soonest yet in one of its intervals, if it takes no longer than to drive.
bool RouteSearch::may_be_sooner(const Node& node, std::size_t vertex, std::size_t heading, double drives) noexcept {
  const double may_stay = intervals(node.state / intervals_each / headings)[node.state % intervals_each].end;
  const auto all = intervals(vertex);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const double arrives = std::max(static_cast<double>(node.g), static_cast<double>(all[k].begin)) + drives;
    if (arrives > may_stay) return false;
    const std::size_t state = state_of(vertex, heading, k);
    if (arrives <= all[k].end && (best_of_[state] != search_ || best_[state] > arrives)) return true;
  }
  return false;
}

void RouteSearch::expand(std::uint32_t node) noexcept {
  const Node n = nodes_[node];
  const std::size_t v = n.state / intervals_each / headings;
  const Lattice::Place here = place(v);
  const double start_time = query_.pace.start_time();
  const bool begins = n.parent == nobody;
  const double theta = begins ? query_.from.theta : heading_at(n);
  double waits = 0.0;  // at the start [s]
  const auto drive = [&](std::size_t to, std::size_t heading, const Lattice::Edge& edge) {
    const double turn = edge.way > 1e-9 ? wrap_angle(edge.heading - theta) : 0.0;
    const bool straight = !begins && std::abs(turn) < 0.02;
    const double ready = n.g + (straight ? 0.0 : query_.pace.turn_time(turn)) + waits;
    double duration = edge.way / query_.pace.v + (straight ? 0.0 : start_time);
    // Between two vertices that are far enough from another robot a line comes nearer to it. Of two that stand close
    // together each would wait for the other to leave first.
    if (begins && !clear_line(here, place(to), ready, ready + duration)) return;
    if (to == goal()) duration += start_time * 0.5;
    reach(node, to, heading, ready, duration);
  };
  const auto line_to = [&](const Lattice::Place& there) {
    const double dx = there.x - here.x, dy = there.y - here.y;
    return Lattice::Edge{math::hypot(dx, dy), math::atan2(dy, dx)};
  };
  if (begins) {
    // A robot that was put on an obstacle, or over the edge, has so much farther to the nearest vertex.
    const double inside = std::max(0.0, -lattice_->room(here.x, here.y));
    const Lattice::Place to = place(goal());
    // Where others bar every line, as in a corner, it waits until they have left.
    for (; waits < most_waits * wait_step && open_.empty(); waits += departure_step) {
      lattice_->near(here.x, here.y, attach * lattice_->cell() + inside, [&](std::size_t u) {
        if (left_[u] < unreached && lattice_->free(here, lattice_->place(u)))
          drive(u, headings - 1, line_to(lattice_->place(u)));
      });
      if (query_.away_from.empty() && math::hypot(to.x - here.x, to.y - here.y) < attach * lattice_->cell() &&
          lattice_->free(here, to))
        drive(goal(), headings - 1, line_to(to));
    }
    return;
  }
  for (std::size_t d = 0; d < Lattice::directions; ++d) {
    const std::size_t u = lattice_->neighbour(v, d);
    if (u == lattice_->size() || !(left_[u] < unreached)) continue;
    const Lattice::Edge& edge = lattice_->edge(v, d);
    if (may_be_sooner(n, u, d, edge.way / query_.pace.v)) drive(u, d, edge);
  }
  if (is_exit_[v]) drive(goal(), 0, line_to(place(goal())));
}

/// The way back along the parents, straight pieces as one leg.
void RouteSearch::finish(std::uint32_t node) noexcept {
  searching_ = false;
  std::array<std::uint32_t, 512> chain{};
  std::size_t count = 0;
  for (std::uint32_t at = node; at != nobody; at = nodes_[at].parent) {
    if (count == chain.size()) return;
    chain[count++] = at;
  }
  leg_count_ = 0;
  double theta = 0.0;
  for (std::size_t k = count - 1; k-- > 0;) {
    const Node& n = nodes_[chain[k]];
    const Lattice::Place to = place(n.state / intervals_each / headings);
    const Lattice::Place from = place(nodes_[n.parent].state / intervals_each / headings);
    const double direction = math::atan2(to.y - from.y, to.x - from.x);
    const bool goes_on =
        leg_count_ > 0 && std::abs(wrap_angle(direction - theta)) < 0.02 && n.leaves <= nodes_[n.parent].g + 1e-3f;
    if (goes_on) {
      Leg& leg = legs_[leg_count_ - 1];
      leg.x = to.x, leg.y = to.y, leg.arrives_at = n.g;
      continue;
    }
    if (leg_count_ == legs_.size()) return;
    legs_[leg_count_++] = {to.x, to.y, n.leaves, n.g};
    theta = direction;
  }
  arrival_ = nodes_[node].g + query_.pace.turn_time(wrap_angle(query_.to.theta - theta));
  found_ = true;
  straighten();
}

/// Where the others are within, in each block of time: most lines stay clear of most of them, which few boxes tell.
void RouteSearch::enclose_others() noexcept {
  others_.clear();
  still_from_ = 0;
  for (std::size_t j = 0; j < radius_.size(); ++j)
    if (radius_[j] > 0.0) {
      others_.push_back(static_cast<std::uint32_t>(j));
      still_from_ = std::max(still_from_, traffic_->still_from(j));
    }
  constexpr std::size_t last = Traffic::steps - 1;
  still_from_ = std::min(still_from_, last);
  blocks_ = (still_from_ + block - 1) / block + 1;
  for (std::size_t m = 0; m < others_.size(); ++m) {
    const std::size_t j = others_[m];
    for (std::size_t b = 0; b < blocks_; ++b) {
      const std::size_t first = std::min(b * block, last), end = std::min(first + block, traffic_->still_from(j));
      Box& box = boxes_[b * others_.size() + m];
      box = {traffic_->x(j, first), traffic_->x(j, first), traffic_->y(j, first), traffic_->y(j, first)};
      for (std::size_t k = first + 1; k <= std::min(end, last); ++k) {
        const double x = traffic_->x(j, k), y = traffic_->y(j, k);
        box = {std::min(box.left, x), std::max(box.right, x), std::min(box.bottom, y), std::max(box.top, y)};
      }
    }
  }
}

/// Who may come too near to a line that is driven between these times, at most a block of time later.
void RouteSearch::find_near(const Lattice::Place& from, const Lattice::Place& to, double begins, double ends) noexcept {
  constexpr double rounding = 1e-6;  // [m]
  const auto block_at = [&](double t) {
    const double k = std::clamp(t / Traffic::step, 0.0, static_cast<double>(Traffic::steps - 1));
    return std::min(blocks_ - 1, static_cast<std::size_t>(k) / block);
  };
  const double left = std::min(from.x, to.x) - rounding, right = std::max(from.x, to.x) + rounding;
  const double bottom = std::min(from.y, to.y) - rounding, top = std::max(from.y, to.y) + rounding;
  near_.clear();
  const std::size_t first = block_at(begins), last = block_at(ends);
  for (std::size_t m = 0; m < others_.size(); ++m) {
    const double r = radius_[others_[m]];
    for (std::size_t b = first; b <= last; ++b) {
      const Box& box = boxes_[b * others_.size() + m];
      if (box.left > right + r || box.right < left - r || box.bottom > top + r || box.top < bottom - r) continue;
      near_.push_back(others_[m]);
      break;
    }
  }
}

/// Whether a robot at (x, y) at time t of the traffic keeps its distance from those that are near.
bool RouteSearch::clear(double x, double y, double t) const noexcept {
  const double at = std::clamp(t / Traffic::step, 0.0, static_cast<double>(Traffic::steps - 1));
  const auto k = static_cast<std::size_t>(at);
  const std::size_t next = std::min(k + 1, Traffic::steps - 1);
  const double share = at - static_cast<double>(k);
  for (const std::uint32_t j : near_) {
    const double r = radius_[j];
    const double o_x = traffic_->x(j, k), dx = o_x + share * (traffic_->x(j, next) - o_x) - x;
    if (std::abs(dx) >= r) continue;
    const double o_y = traffic_->y(j, k), dy = o_y + share * (traffic_->y(j, next) - o_y) - y;
    if (dx * dx + dy * dy < r * r) return false;
  }
  return true;
}

/// Whether a robot that sets off along a line comes no nearer to any that is nearer at the start than the shield asks
/// for: the shield would stop it for good, be it by a hundredth of a millimetre, which no sample of the line shows.
bool RouteSearch::parts(const Lattice::Place& from, const Lattice::Place& to, double leaves, double arrives) noexcept {
  const double way = math::hypot(to.x - from.x, to.y - from.y),
               share = std::min(1.0, Traffic::step / (arrives - leaves));
  if (!(way > 0.0)) return true;
  const auto k = std::min(Traffic::steps - 2, static_cast<std::size_t>(leaves / Traffic::step));
  for (const std::uint32_t j : close_) {
    const double closer = query_.smaller.empty() ? 0.0 : query_.smaller[query_.robot] + query_.smaller[j];
    const double x = traffic_->x(j, k) - from.x, y = traffic_->y(j, k) - from.y, d = math::hypot(x, y);
    if (d >= query_.least - closer) continue;
    const double v_x = share * (to.x - from.x) - (traffic_->x(j, k + 1) - traffic_->x(j, k));
    const double v_y = share * (to.y - from.y) - (traffic_->y(j, k + 1) - traffic_->y(j, k));
    if (v_x * x + v_y * y > -turned_off * math::hypot(v_x, v_y) * d + 1e-9) return false;
  }
  return true;
}

bool RouteSearch::clear_line(const Lattice::Place& from, const Lattice::Place& to, double leaves,
                             double arrives) noexcept {
  if (!close_.empty() && !parts(from, to, leaves, arrives)) return false;
  const double duration = arrives - leaves;
  const auto samples = static_cast<int>(std::ceil(duration / Traffic::step)) + 1;
  struct Sample {
    Lattice::Place at;
    double t;
  };
  const auto sample = [&](int k) {
    const double share = static_cast<double>(k) / samples;
    return Sample{{from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)}, leaves + share * duration};
  };
  for (int first = 0; first <= samples; first += static_cast<int>(block)) {
    const int last = std::min(first + static_cast<int>(block) - 1, samples);
    const Sample begin = sample(first), end = sample(last);
    find_near(begin.at, end.at, begin.t, end.t);
    for (int k = first; k <= last && !near_.empty(); ++k)
      if (const Sample here = sample(k); !clear(here.at.x, here.at.y, here.t)) return false;
  }
  return true;
}

/// Whether a robot that stands from then on keeps its distance from all others.
bool RouteSearch::stays_clear(const Lattice::Place& at, double t) noexcept {
  while (t < Traffic::step * Traffic::steps) {
    const bool all_stand = t >= Traffic::step * static_cast<double>(still_from_ + 1);
    find_near(at, at, t, t + Traffic::step * block);
    for (std::size_t k = 0; k < block && t < Traffic::step * Traffic::steps; ++k, t += Traffic::step)
      if (!clear(at.x, at.y, t)) return false;
    if (all_stand) break;
  }
  return true;
}

/// The soonest leg from a point to the next. False: there is none, or it arrives after `latest`.
bool RouteSearch::append(const Lattice::Place& from, const Lattice::Place& to, bool last, double latest, Moment& at,
                         Leg& leg) noexcept {
  const double way = math::hypot(to.x - from.x, to.y - from.y);
  const double heading = way > 1e-6 ? math::atan2(to.y - from.y, to.x - from.x) : at.theta;
  const double turned = at.t + query_.pace.turn_time(wrap_angle(heading - at.theta));
  const double takes = query_.pace.drive_time(way);
  double stood = at.t;
  for (int wait = 0; wait < most_waits; ++wait) {
    const double leaves = turned + wait * wait_step;
    if (leaves + takes > latest || !clear_line(from, from, stood, leaves)) return false;
    stood = leaves;
    if (!clear_line(from, to, leaves, leaves + takes) || (last && !stays_clear(to, leaves + takes))) continue;
    leg = {to.x, to.y, leaves, leaves + takes};
    at = {leaves + takes, heading};
    return true;
  }
  return false;
}

/// The soonest times of legs through these points, one leg after the other. False where there are none, or none that
/// arrive until `latest`.
bool RouteSearch::retime(std::span<const Lattice::Place> points, Moment at, double latest, std::span<Leg> legs,
                         double& arrival) noexcept {
  for (std::size_t k = 0; k + 1 < points.size(); ++k)
    if (!append(points[k], points[k + 1], k + 2 == points.size(), latest, at, legs[k])) return false;
  arrival = at.t + query_.pace.turn_time(wrap_angle(query_.to.theta - at.theta));
  return true;
}

/// Leaves out corners as long as that brings the robot there sooner.
void RouteSearch::straighten() noexcept {
  constexpr int most_trials = 60;
  std::array<Lattice::Place, Route::most_legs + 1> points{}, rest{};
  std::array<Leg, Route::most_legs> legs{};
  std::size_t count = 1;
  points[0] = place(start());
  for (std::size_t k = 0; k < leg_count_; ++k) points[count++] = {legs_[k].x, legs_[k].y};
  Moment at{query_.begins, query_.from.theta};  // at corner i
  double arrival = 0.0;
  if (retime({points.data(), count}, at, arrival_, legs, arrival) && arrival < arrival_) {
    for (std::size_t k = 0; k + 1 < count; ++k) legs_[k] = legs[k];
    arrival_ = arrival;
  }
  int trials = 0;
  for (std::size_t i = 0; i + 2 < count; ++i) {
    for (std::size_t j = count - 1; j > i + 1 && trials < most_trials; --j) {
      if (!lattice_->free(points[i], points[j])) continue;
      ++trials;
      std::size_t left = 0;
      rest[left++] = points[i];
      for (std::size_t k = j; k < count; ++k) rest[left++] = points[k];
      if (!retime({rest.data(), left}, at, arrival_, {legs.data() + i, left - 1}, arrival) ||
          arrival >= arrival_ - 1e-9)
        continue;
      arrival_ = arrival;
      count = i + left;
      leg_count_ = count - 1;
      std::copy_n(rest.begin(), left, points.begin() + static_cast<std::ptrdiff_t>(i));
      legs_ = legs;
      break;
    }
    // What comes before a corner is the same in all that follows.
    if (i + 2 < count && !append(points[i], points[i + 1], false, arrival_, at, legs[i])) return;
  }
}

}  // namespace skein::core
