#include "app/tools/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "app/experiment/experiment_file.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_table.h"
#include "core/math/elementary.h"
#include "core/simulation/random.h"

namespace skein::app {
namespace {

constexpr double longest = 100.0;            // [m]
constexpr std::uint64_t stream = 1'000'003;  // of chance: those below belong to the simulated robots
constexpr int most_tries = 10'000;

void read_span(TomlTable& t, const char* key, Span& span, const Range& range) {
  const toml::node* const found = t.node(key);
  if (!found) return;
  const auto pair = numbers_of<2>(*found);
  if (pair && range.holds((*pair)[0]) && range.holds((*pair)[1]) && (*pair)[0] <= (*pair)[1])
    span = {(*pair)[0], (*pair)[1]};
  else if (pair && (*pair)[0] > (*pair)[1])
    t.refuse(key, *found, fmt::format("[low, high]; here low, {}, is above high, {}", (*pair)[0], (*pair)[1]));
  else
    t.refuse(key, *found,
             fmt::format("[low, high], each {}{}", range.text(),
                         pair ? fmt::format("; here they are {} and {}", (*pair)[0], (*pair)[1]) : ""));
}

void read_texts(TomlTable& t, const char* key, std::vector<std::string>& texts) {
  const toml::node* const found = t.node(key);
  if (!found) return;
  const toml::array* const array = found->as_array();
  const bool good = array && std::all_of(array->begin(), array->end(), [](const auto& e) { return e.is_string(); });
  if (!good) return t.refuse(key, *found, R"(a list of texts, as in ["duration=60"])");
  for (const toml::node& element : *array) texts.push_back(*element.value_exact<std::string>());
}

/// A table of keys of the experiment, each with a range.
std::vector<std::pair<std::string, Span>> read_spans(TomlTable& table, const toml::node_view<const toml::node>& node) {
  std::vector<std::pair<std::string, Span>> spans;
  if (const toml::table* const keys = node.as_table())
    for (const auto& [key, value] : *keys) {
      Span span{};
      read_span(table, std::string(key.str()).c_str(), span, between(-1e9, 1e9));
      spans.emplace_back(key.str(), span);
    }
  return spans;
}

void read_tune(TomlTable t, const toml::table& document, Study::Tune& tune) {
  t.require("search", R"(the keys that are searched, as in { "controller.k_y" = [2, 15] })");
  TomlTable search = t.table("search");
  tune.search = read_spans(search, document["tune"]["search"]);
  if (t.has("search") && tune.search.empty())
    t.refuse("search", *t.node("search"), R"(at least one key with its range, as in { "controller.k_y" = [2, 15] })");
  for (const auto& [key, span] : tune.search)
    if (const toml::node* const found = search.node(key.c_str()); found && span[0] == span[1] && found->is_array())
      search.refuse(key, *found, "[low, high], low below high");
  t.integer("objectives", tune.objectives, 2, 100);
  t.integer("candidates", tune.candidates, 1, 1'000'000);
  t.integer("held_out", tune.held_out, 1, 1'000'000);
  t.number("delay_margin", tune.delay_margin, above(0.0, 10.0, "s"));
  t.number("limited_share", tune.limited_share, between(0.0, 1.0));
  t.number("effort", tune.effort, above(0.0, 1e6, "m/s^2"));
  t.finish();
}

void read_study(const toml::table& document, Study& study, Problems& problems) {
  TomlTable t(&document, "", problems);
  t.text("name", study.name);
  t.require("experiment", "the experiment file that the study runs, relative to the study's folder");
  t.text("experiment", study.experiment);
  read_texts(t, "set", study.sets);
  t.integer("runs", study.runs, 1, 10'000'000);
  t.integer("seed", study.seed, 0, std::numeric_limits<std::int64_t>::max() / 2);
  t.number("recovered_within", study.recovered_within, above(0.0, longest, "m"));
  t.number("formation_first_over", study.formation_first_over, between(0.0, longest, "m"));

  TomlTable vary = t.table("vary");
  study.vary = read_spans(vary, document["vary"]);
  if (t.has("hand")) {
    Study::Hand hand;
    TomlTable h = t.table("hand");
    h.number("t", hand.t, above(0.0, 86400.0, "s"));
    h.integer("robots", hand.robots, 1, 64);
    read_span(h, "distance", hand.distance, between(0.0, longest, "m"));
    if (const toml::node* const edge = h.node("edge")) {
      read_span(h, "edge", hand.edge.emplace(), between(0.0, longest, "m"));
      if (h.has("distance")) h.refuse("edge", *edge, "without distance: a hand has one of both");
    }
    h.number("clearance", hand.clearance, between(2.0 * core::standard_radius, longest, "m"));
    h.finish();
    study.hand = hand;
  }
  if (t.has("field")) {
    Study::Field field;
    TomlTable f = t.table("field");
    f.integer("count", field.count, 1, 1000);
    read_span(f, "radius", field.radius, above(0.0, longest, "m"));
    f.number("gap", field.gap, between(0.0, longest, "m"));
    f.number("clearance", field.clearance, between(core::standard_radius, longest, "m"));
    f.finish();
    study.field = field;
  }
  if (t.has("scatter")) {
    Study::Scatter scatter;
    TomlTable s = t.table("scatter");
    s.number("distance", scatter.distance, between(0.0, longest, "m"));
    s.number("heading", scatter.heading, between(0.0, core::pi, "rad"));
    s.number("clearance", scatter.clearance, between(2.0 * core::standard_radius, longest, "m"));
    s.finish();
    study.scatter = scatter;
  }
  if (t.has("crowd")) {
    Study::Crowd crowd;
    TomlTable c = t.table("crowd");
    Span robots{static_cast<double>(crowd.robots[0]), static_cast<double>(crowd.robots[1])};
    read_span(c, "robots", robots, between(1.0, 64.0));
    crowd.robots = {static_cast<std::int64_t>(std::ceil(robots[0])), static_cast<std::int64_t>(std::floor(robots[1]))};
    c.number("clearance", crowd.clearance, between(2.0 * core::standard_radius, longest, "m"));
    c.number("border", crowd.border, between(core::standard_radius, longest, "m"));
    c.number("wheels", crowd.wheels, between(0.0, 0.2));
    c.integer("runaways", crowd.runaways, 0, crowd.robots[0]);
    c.finish();
    study.crowd = crowd;
  }
  if (t.has("passage")) {
    Passage passage;
    TomlTable p = t.table("passage");
    p.choice("kind", passage.kind);
    read_span(p, "width", passage.width, between(1.0, 100.0));
    read_span(p, "length", passage.length, between(0.0, longest, "m"));
    Span robots{static_cast<double>(passage.robots[0]), static_cast<double>(passage.robots[1])};
    read_span(p, "robots", robots, between(1.0, 64.0));
    passage.robots = {static_cast<std::int64_t>(std::ceil(robots[0])),
                      static_cast<std::int64_t>(std::floor(robots[1]))};
    p.number("clearance", passage.clearance, between(2.0 * core::standard_radius, longest, "m"));
    p.finish();
    study.passage = passage;
  }
  if (t.has("tune")) {
    Study::Tune tune;
    read_tune(t.table("tune"), document, tune);
    study.tune = std::move(tune);
  }
  read_texts(t, "control", study.control);
  TomlTable compare = t.table("compare");
  if (const toml::table* const names = document["compare"].as_table())
    for (const auto& [name, sets] : *names) {
      if (name == "study" || name == "control") compare.refuse(name.str(), sets, "another name than study and control");
      study.compare.emplace_back(name.str(), std::vector<std::string>{});
      read_texts(compare, study.compare.back().first.c_str(), study.compare.back().second);
    }
  compare.finish();
  TomlTable expect = t.table("expect");
  expect.integer("collisions", study.expect.collisions, 0, 1'000'000'000);
  expect.flag("inside", study.expect.inside);
  expect.number("recovered", study.expect.recovered, between(0.0, 1.0));
  expect.number("formation_first", study.expect.formation_first, between(0.0, 1.0));
  expect.finish();
  t.finish();
}

struct Dice {
  core::Random random;
  double between(const Span& span) { return span[0] + (span[1] - span[0]) * random.uniform(); }
  double angle() { return core::pi * (1.0 - 2.0 * random.uniform()); }  // (-pi, pi]
};

/// How much larger the body is than those that clearances are meant for [m].
double beyond(const Experiment& e, std::size_t robot) {
  return e.robots[robot].radius - core::standard_radius;
}

tl::expected<std::string, std::string> place_obstacles(const Study::Field& field, const Experiment& e, Dice& dice) {
  const auto reference = make_reference(e);
  std::vector<core::Obstacle> placed;
  std::string text;
  for (int tries = 0; static_cast<std::int64_t>(placed.size()) < field.count; ++tries) {
    if (tries == most_tries) return tl::unexpected(std::string("there is no room for so many obstacles"));
    const double w = 0.5 * e.arena_width, h = 0.5 * e.arena_height;
    const double radius = dice.between(field.radius), x = dice.between({-w, w}), y = dice.between({-h, h});
    const auto clear_of = [&](const core::Pose& pose, std::size_t robot) {
      return core::math::hypot(pose.x - x, pose.y - y) >= radius + field.clearance + beyond(e, robot);
    };
    bool free = std::all_of(placed.begin(), placed.end(), [&](const core::Obstacle& o) {
      return core::math::hypot(o.x - x, o.y - y) >= o.radius + radius + field.gap;
    });
    for (std::size_t i = 0; free && i < e.robots.size(); ++i)
      free = clear_of(reference->at(i, 0.0).pose, i) && clear_of(reference->at(i, e.duration).pose, i);
    if (!free) continue;
    placed.push_back({x, y, radius});
    text += fmt::format("{}{{x={}, y={}, radius={}}}", text.empty() ? "" : ", ", x, y, radius);
  }
  return "obstacle=[" + text + "]";
}

tl::expected<std::vector<std::string>, std::string> scatter_starts(const Study::Scatter& scatter, const Experiment& e,
                                                                   Dice& dice) {
  const auto reference = make_reference(e);
  std::vector<core::Pose> placed;
  std::vector<std::string> sets;
  for (int tries = 0; placed.size() < e.robots.size(); ++tries) {
    if (tries == most_tries) return tl::unexpected(std::string("there is no room for so many robots"));
    const core::Pose start = reference->at(placed.size(), 0.0).pose;
    const RobotSpec& robot = e.robots[placed.size()];
    const double w = 0.5 * e.arena_width - robot.radius, h = 0.5 * e.arena_height - robot.radius;
    core::Pose there{dice.between({-w, w}), dice.between({-h, h}), 0.0};
    if (scatter.distance > 0.0) {
      const double by = dice.between({0.0, scatter.distance}), direction = dice.angle();
      there = {start.x + by * core::math::cos(direction), start.y + by * core::math::sin(direction), 0.0};
    }
    there.theta = core::wrap_angle(start.theta + dice.between({-scatter.heading, scatter.heading}));
    const bool free =
        std::abs(there.x) <= w && std::abs(there.y) <= h &&
        std::all_of(placed.begin(), placed.end(),
                    [&](const core::Pose& p) {
                      const auto j = static_cast<std::size_t>(&p - placed.data());
                      return core::distance(p, there) >= scatter.clearance + beyond(e, placed.size()) + beyond(e, j);
                    }) &&
        std::all_of(e.obstacles.begin(), e.obstacles.end(), [&](const core::Obstacle& o) {
          return core::math::hypot(there.x - o.x, there.y - o.y) >=
                 o.radius + scatter.clearance - core::standard_radius + beyond(e, placed.size());
        });
    if (!free) continue;
    placed.push_back(there);
    sets.push_back(fmt::format("robot.{}.start=[{}, {}, {}]", placed.size(), there.x, there.y, there.theta));
  }
  return sets;
}

/// A robot whose motors stick as they run, or one that drives anywhere.
std::string draw_runaway(Dice& dice) {
  const double at = dice.between({0.0, 10.0}), v = dice.between({0.03, 0.13}), omega = dice.between({-1.0, 1.0});
  if (dice.random.uniform() < 0.5) return fmt::format("runaway=[{}]", at);
  return fmt::format("runaway=[{}, {}, {}]", at, dice.random.uniform() < 0.5 ? -v : v, omega);
}

tl::expected<std::string, std::string> draw_crowd(const Study::Crowd& crowd, const Experiment& e, Dice& dice) {
  const double more = beyond(e, 0);  // all are as the defaults say
  const double w = 0.5 * e.arena_width - crowd.border - more, h = 0.5 * e.arena_height - crowd.border - more;
  const auto span = static_cast<double>(crowd.robots[1] - crowd.robots[0] + 1);
  const auto n = static_cast<std::size_t>(crowd.robots[0]) + static_cast<std::size_t>(span * dice.random.uniform());
  std::vector<core::Pose> starts, places;
  for (std::vector<core::Pose>* const drawn : {&starts, &places})
    for (int tries = 0; drawn->size() < n; ++tries) {
      if (tries == most_tries) return tl::unexpected(fmt::format("there is no room for {} robots", n));
      const core::Pose pose{dice.between({-w, w}), dice.between({-h, h}), dice.angle()};
      const bool free =
          std::all_of(drawn->begin(), drawn->end(),
                      [&](const core::Pose& p) { return core::distance(p, pose) >= crowd.clearance + 2.0 * more; }) &&
          std::all_of(e.obstacles.begin(), e.obstacles.end(), [&](const core::Obstacle& o) {
            return core::math::hypot(pose.x - o.x, pose.y - o.y) >=
                   o.radius + crowd.clearance - core::standard_radius + more;
          });
      if (free) drawn->push_back(pose);
    }
  std::string text;
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<std::string> truth;
    if (crowd.wheels > 0.0) {
      const double left = 1.0 + dice.between({-crowd.wheels, crowd.wheels});
      const double right = 1.0 + dice.between({-crowd.wheels, crowd.wheels});
      truth.push_back(fmt::format("wheel_diameter={}, wheel_ratio={}",
                                  e.robots[0].drive.wheel_diameter * 0.5 * (left + right), right / left));
    }
    if (static_cast<std::int64_t>(i) < crowd.runaways) truth.push_back(draw_runaway(dice));
    text +=
        fmt::format("{}{{start=[{}, {}, {}], trajectory={{path={{shape=\"line\", from=[{}, {}], to=[{}, {}]}}}}{}}}",
                    i ? ", " : "", starts[i].x, starts[i].y, starts[i].theta, starts[i].x, starts[i].y, places[i].x,
                    places[i].y, truth.empty() ? "" : fmt::format(", truth={{{}}}", fmt::join(truth, ", ")));
  }
  return "robot=[" + text + "]";
}

/// Anywhere along the edge of the arena, so far inside it.
core::Point beside_edge(const Experiment& e, double inside, Dice& dice) {
  const double w = 0.5 * e.arena_width - inside, h = 0.5 * e.arena_height - inside;
  const double along = 4.0 * (w + h) * dice.random.uniform();  // round the rectangle, from its lower left corner
  if (along < 2.0 * w) return {-w + along, -h};
  if (along < 2.0 * (w + h)) return {w, -h + along - 2.0 * w};
  if (along < 4.0 * w + 2.0 * h) return {w - (along - 2.0 * (w + h)), h};
  return {-w, h - (along - 4.0 * w - 2.0 * h)};
}

/// Where the robots are when the hand comes: on their places, since nothing has disturbed them yet.
tl::expected<std::string, std::string> perturb(const Study::Hand& hand, const Experiment& e, Dice& dice) {
  const auto reference = make_reference(e);
  const std::size_t n = e.robots.size();
  std::vector<core::Pose> poses;
  for (std::size_t i = 0; i < n; ++i) poses.push_back(reference->at(i, hand.t).pose);
  const auto most = static_cast<double>(std::min<std::size_t>(n, static_cast<std::size_t>(hand.robots)));
  const auto count = 1 + static_cast<std::size_t>(most * dice.random.uniform());
  std::vector<std::size_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = i;
  for (std::size_t i = 0; i < count; ++i)
    std::swap(order[i], order[i + static_cast<std::size_t>(static_cast<double>(n - i) * dice.random.uniform())]);

  std::string text;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t robot = order[k];
    const double from_edge = hand.clearance - core::standard_radius + beyond(e, robot);
    bool free = false;
    for (int tries = 0; !free; ++tries) {
      if (tries == most_tries) return tl::unexpected(fmt::format("there is no room to put robot {} down", robot + 1));
      const double by = hand.edge ? 0.0 : dice.between(hand.distance), direction = dice.angle(), turn = dice.angle();
      double dx = by * core::math::cos(direction), dy = by * core::math::sin(direction), room = from_edge;
      if (hand.edge) {
        room = e.robots[robot].radius;
        const core::Point at = beside_edge(e, room + dice.between(*hand.edge), dice);
        dx = at.x - poses[robot].x, dy = at.y - poses[robot].y;
      }
      const core::Pose there{poses[robot].x + dx, poses[robot].y + dy, core::wrap_angle(poses[robot].theta + turn)};
      free = std::abs(there.x) <= 0.5 * e.arena_width - room && std::abs(there.y) <= 0.5 * e.arena_height - room;
      for (std::size_t j = 0; free && j < n; ++j)
        free = j == robot || core::distance(there, poses[j]) >= hand.clearance + beyond(e, robot) + beyond(e, j);
      for (const core::Obstacle& o : e.obstacles)
        free = free && core::math::hypot(there.x - o.x, there.y - o.y) >= o.radius + from_edge;
      if (!free) continue;
      poses[robot] = there;
      text += fmt::format("{}{{t={}, robot={}, dx={}, dy={}, dtheta={}}}", text.empty() ? "" : ", ", hand.t, robot + 1,
                          dx, dy, turn);
    }
  }
  return "perturb=[" + text + "]";
}

/// The seed, and what [vary] draws: the first of a run's changes.
std::vector<std::string> varied(const Study& study, std::uint64_t seed, Dice& dice) {
  std::vector<std::string> sets{fmt::format("seed={}", seed)};
  for (const auto& [key, span] : study.vary) sets.push_back(fmt::format("{}={}", key, dice.between(span)));
  return sets;
}

using Sets = std::vector<std::string>;

Sets joined(Sets sets, const Sets& more) {
  sets.insert(sets.end(), more.begin(), more.end());
  return sets;
}

/// What chance changes in one of the first runs: in the first there may be no room.
Sets first_variation(const Study& study) {
  constexpr std::int64_t most = 20;
  for (std::int64_t run = 0; run < std::min(most, study.runs); ++run)
    if (auto sets = variation(study, study.seed + static_cast<std::uint64_t>(run))) return *std::move(sets);
  Dice dice{core::Random(study.seed, stream)};
  return varied(study, study.seed, dice);
}

/// Finds the mistakes in the keys that a study sets from run to run, each with its place in the study's file.
class StudyCheck {
 public:
  StudyCheck(const Study& study, const toml::table& document)
      : study_(study), document_(document), problems_(document, study.file) {}

  std::vector<Problem> all() && {
    check_ranges();
    check_hand();
    if (!problems_.empty()) return std::move(problems_).sorted();  // they would come again in each of the following
    for (const auto& [name, sets] : study_.compare) {
      Study other = study_;
      other.sets = joined(study_.sets, sets);
      const std::string where = "compare." + name;
      const toml::node* const place = document_["compare"][name].node();
      Dice dice{core::Random(study_.seed, stream)};
      if (try_out(joined(other.sets, varied(other, study_.seed, dice)), place, where))
        try_out(joined(other.sets, first_variation(other)), place, where);
    }
    if (!study_.control.empty())
      try_out(joined(joined(study_.sets, first_variation(study_)), study_.control), document_["control"].node(),
              "control");
    return std::move(problems_).sorted();
  }

 private:
  /// Whether there is such an experiment; else its problems, said of this place in the study.
  bool try_out(const Sets& sets, const toml::node* place, const std::string& where) {
    const auto experiment = parse_experiment(study_.text, study_.experiment, sets);
    if (experiment) return true;
    constexpr std::string_view set = "--set ";
    for (const Problem& problem : experiment.error()) {
      const bool of_a_key = problem.file.starts_with(set);
      const std::string what =
          of_a_key ? fmt::format("\"{}\": {}", problem.file.substr(set.size()), problem.text) : problem.message();
      problems_.add(place ? place->source() : toml::source_region{}, fmt::format("{}: {}", where, what));
    }
    return false;
  }

  void check_ranges() {
    Dice dice{core::Random(study_.seed, stream)};
    const Sets drawn = varied(study_, study_.seed, dice);
    for (std::size_t k = 0; k < study_.vary.size(); ++k) {
      const auto& [key, span] = study_.vary[k];
      for (const double end : span) {
        Sets sets = drawn;
        sets[k + 1] = fmt::format("{}={}", key, end);  // behind the seed
        if (!try_out(joined(study_.sets, sets), document_["vary"][key].node(), "vary")) break;
      }
      if (!problems_.empty()) return;
    }
  }

  void check_hand() {
    if (!study_.hand || !problems_.empty()) return;
    Dice dice{core::Random(study_.seed, stream)};
    const auto e =
        parse_experiment(study_.text, study_.experiment, joined(study_.sets, varied(study_, study_.seed, dice)));
    if (!e) return;
    if (!(study_.hand->t < e->duration))
      problems_.add("hand.t", fmt::format("found {}, allowed: a time before the experiment's end at {} s",
                                          study_.hand->t, e->duration));
    if (study_.passage) return;  // chance says how many robots there are
    const auto robots = study_.crowd ? study_.crowd->robots[1] : static_cast<std::int64_t>(e->robots.size());
    if (study_.hand->robots > robots)
      problems_.add("hand.robots",
                    fmt::format("found {}, allowed: a whole number from 1 to {}, the experiment's robots",
                                study_.hand->robots, robots));
  }

  const Study& study_;
  const toml::table& document_;
  Problems problems_;
};

}  // namespace

std::vector<Problem> check_study(const Study& study, std::int64_t more) {
  constexpr auto largest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (const std::uint64_t seeds = static_cast<std::uint64_t>(study.runs) + static_cast<std::uint64_t>(more);
      study.seed > largest - (seeds - 1))
    return {{study.file, 0, 0,
             fmt::format("seed: found {}, allowed: at most {}, so that each of {} runs has one", study.seed,
                         largest - (seeds - 1), seeds)}};
  const auto document = parse_toml(study.definition, study.file);
  if (!document) return document.error();
  // What the command line sets is said as it is.
  if (const auto base = parse_experiment(study.text, study.experiment, study.sets); !base) return base.error();
  return StudyCheck(study, *document).all();
}

tl::expected<Study, std::vector<Problem>> load_study(const std::string& path) {
  const auto text = read_text(path);
  if (!text) return tl::unexpected(text.error());
  auto document = parse_toml(*text, path, FileKind::study);
  if (!document) return tl::unexpected(document.error());
  Study study;
  study.file = path;
  study.definition = *text;
  study.name = std::filesystem::path(path).stem().string();
  Problems problems(*document, path);
  read_study(*document, study, problems);
  if (!problems.empty()) return tl::unexpected(std::move(problems).sorted());

  study.experiment = (std::filesystem::path(path).parent_path() / study.experiment).lexically_normal().string();
  auto experiment_text = read_text(study.experiment);
  if (!experiment_text) return tl::unexpected(experiment_text.error());
  study.text = std::move(*experiment_text);
  const auto experiment = parse_experiment(study.text, study.experiment, study.sets);
  if (!experiment) return tl::unexpected(experiment.error());
  if (const bool simulated = std::all_of(experiment->robots.begin(), experiment->robots.end(),
                                         [](const RobotSpec& r) { return !r.has_link(); });
      !simulated || experiment->camera.kind() != CameraKind::absent)
    return tl::unexpected(std::vector<Problem>{
        {path, 0, 0,
         "experiment: allowed: one whose robots all have link \"sim\" and whose camera is \"none\", so that runs go as "
         "fast as the machine does and repeat"}});
  return study;
}

tl::expected<std::vector<std::string>, std::string> variation(const Study& study, std::uint64_t seed) {
  Dice dice{core::Random(seed, stream)};
  std::vector<std::string> sets = varied(study, seed, dice);
  const auto with = [&](const auto& chance) -> tl::expected<void, std::string> {
    std::vector<std::string> so_far = study.sets;
    so_far.insert(so_far.end(), sets.begin(), sets.end());
    const auto experiment = parse_experiment(study.text, study.experiment, so_far);
    if (!experiment) return tl::unexpected(experiment.error().front().message());
    const auto more = chance(*experiment);
    if (!more) return tl::unexpected(more.error());
    sets.insert(sets.end(), more->begin(), more->end());
    return {};
  };
  const auto one = [](tl::expected<std::string, std::string> set) -> tl::expected<Sets, std::string> {
    if (!set) return tl::unexpected(set.error());
    return Sets{*std::move(set)};
  };
  if (study.field)
    if (auto done = with([&](const Experiment& e) { return one(place_obstacles(*study.field, e, dice)); }); !done)
      return tl::unexpected(done.error());
  if (study.crowd)
    if (auto done = with([&](const Experiment& e) { return one(draw_crowd(*study.crowd, e, dice)); }); !done)
      return tl::unexpected(done.error());
  if (study.passage)
    if (auto done = with([&](const Experiment& e) { return draw_passage(*study.passage, e, seed); }); !done)
      return tl::unexpected(done.error());
  if (study.scatter)
    if (auto done = with([&](const Experiment& e) { return scatter_starts(*study.scatter, e, dice); }); !done)
      return tl::unexpected(done.error());
  if (study.hand)
    if (auto done = with([&](const Experiment& e) { return one(perturb(*study.hand, e, dice)); }); !done)
      return tl::unexpected(done.error());
  return sets;
}

}  // namespace skein::app
