#include "app/tools/sweep_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <sstream>
#include <string_view>

#include "app/embedded/embedded.h"
#include "app/experiment/experiment_file.h"
#include "app/experiment/text_file.h"
#include "app/record/gnuplot.h"
#include "app/record/statistics.h"
#include "app/session/session.h"
#include "core/estimation/statistics.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using Done = tl::expected<void, std::string>;

constexpr std::size_t bins = 40, most_points = 400, most_plans = 6;

/// What a panel shows of a run; empty: it has no such value.
struct Quantity {
  const char* name;
  const char* label;
  double scale;  ///< to the label's unit
  std::optional<double> (*of)(const RunOutcome&);
  bool times;  ///< else a distance
};
constexpr auto if_number = [](double value) { return std::isnan(value) ? std::nullopt : std::optional<double>(value); };
constexpr std::array quantities{
    Quantity{"recovery", "all robots back on their places after [s]", 1.0,
             [](const RunOutcome& o) { return o.recovery; }, true},
    Quantity{"formation_settled", "distances (37) within 1 cm after [s]", 1.0,
             [](const RunOutcome& o) { return o.formation_settled; }, true},
    Quantity{"relative_settled", "relative positions within 1 cm after [s]", 1.0,
             [](const RunOutcome& o) { return o.relative_settled; }, true},
    Quantity{"tracking_settled", "tracking within 1 cm after [s]", 1.0,
             [](const RunOutcome& o) { return o.tracking_settled; }, true},
    Quantity{"min_distance", "smallest distance of two robots [mm]", 1e3,
             [](const RunOutcome& o) { return if_number(o.min_distance); }, false},
    Quantity{"obstacle_gap", "smallest gap to an obstacle [mm]", 1e3,
             [](const RunOutcome& o) { return if_number(o.obstacle_gap); }, false},
    Quantity{"final_error", "farthest from its place at the end [mm]", 1e3,
             [](const RunOutcome& o) { return if_number(o.final_error); }, false},
};

struct Variant {
  std::string name;
  const std::vector<RunOutcome>* runs;
};

std::vector<double> values_of(const Quantity& quantity, const std::vector<RunOutcome>& runs) {
  std::vector<double> values;
  for (const RunOutcome& run : runs)
    if (const auto value = quantity.of(run); run.failure.empty() && value) values.push_back(quantity.scale * *value);
  std::sort(values.begin(), values.end());
  return values;
}

Done draw(const fs::path& folder, const std::string& name, const std::string& head, std::string_view body) {
  const std::string script = (folder / (name + ".gp")).string();
  if (Done done = write_file(script, head + std::string(body)); !done) return done;
  if (Done done = draw_figure(folder.string(), name); !done)
    return tl::unexpected(fmt::format("{}: {}", script, done.error()));
  return {};
}

std::string quoted_list(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts) {
    list += list.empty() ? "\"" : ", \"";
    for (const char c : text) list += c == '"' || c == '\\' ? '\'' : c;
    list += '"';
  }
  return list;
}

std::string head_of(const Study& study, const char* name, const std::vector<Variant>& variants) {
  std::vector<std::string> names;
  names.reserve(variants.size());
  for (const Variant& v : variants) names.push_back(fmt::format("{} ({} runs)", v.name, v.runs->size()));
  return fmt::format(
      "# Study \"{}\", drawn by skein {}. To draw it again, edit this and run: gnuplot {}.gp\n"
      "variants = {}\narray name_of[variants] = [{}]\n",
      study.name, SKEIN_VERSION, name, variants.size(), quoted_list(names));
}

/// Histograms and distributions of times, or of distances; nothing where there are none.
Done draw_distributions(const fs::path& folder, const Study& study, const std::vector<Variant>& variants, bool times) {
  const char* const name = times ? "times" : "distances";
  std::string histograms, distributions;
  std::vector<std::string> labels, from, to;
  for (const Quantity& quantity : quantities) {
    if (quantity.times != times) continue;
    std::vector<std::vector<double>> values;
    std::vector<double> all;
    for (const Variant& v : variants) {
      values.push_back(values_of(quantity, *v.runs));
      all.insert(all.end(), values.back().begin(), values.back().end());
    }
    if (all.empty()) continue;
    // Half a per cent at each end is left to the table: one run must not flatten all others.
    double low = quantile(all, 0.0025), high = quantile(all, 0.9975);
    if (low < 0.3 * high) low = 0.0;
    // Values that are all the same, or written with the same digits, have an axis too.
    if (!(high - low > 1e-4 * std::abs(high))) high = low + 1.0;
    const double width = (high - low) / static_cast<double>(bins);
    for (std::size_t v = 0; v < variants.size(); ++v) {
      std::vector<std::size_t> counts(bins, 0);
      for (const double value : values[v])
        if (value >= low && value <= high)
          ++counts[std::min(bins - 1, static_cast<std::size_t>((value - low) / width))];
      const auto whole = static_cast<std::int64_t>(variants[v].runs->size());
      const auto share = [&](std::size_t count) {
        return static_cast<double>(count) / static_cast<double>(std::max<std::int64_t>(1, whole));
      };
      histograms +=
          fmt::format("# {}, {}: from [the label's unit], share\n{:.6g} 0\n", quantity.name, variants[v].name, low);
      for (std::size_t b = 0; b < bins; ++b)
        histograms += fmt::format("{:.6g} {:.6g}\n", low + static_cast<double>(b + 1) * width, share(counts[b]));
      histograms += fmt::format("{:.6g} 0\n\n\n", high);
      distributions += fmt::format("# {}, {}: value, share, low, high\n", quantity.name, variants[v].name);
      const std::size_t n = values[v].size(), every = std::max<std::size_t>(1, n / most_points);
      const auto point = [&](double value, std::size_t count) {
        const Share s = share_of(static_cast<std::int64_t>(count), whole);
        distributions += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g}\n", value, s.value, s.low, s.high);
      };
      point(std::min(low, n > 0 ? values[v].front() : low), 0);
      for (std::size_t i = 0; i < n; ++i)
        if ((i + 1) % every == 0 || i + 1 == n) point(values[v][i], i + 1);
      point(std::max(high, n > 0 ? values[v].back() : high), n);
      distributions += "\n\n";
    }
    labels.emplace_back(quantity.label);
    from.push_back(fmt::format("{:.6g}", low));
    to.push_back(fmt::format("{:.6g}", high));
  }
  if (labels.empty()) return remove_figure(folder.string(), name), Done();
  std::string head = head_of(study, name, variants);
  head += fmt::format("figure = \"{}\"\npanels = {}\narray label_of[panels] = [{}]\narray from[panels] = [{}]\n", name,
                      labels.size(), quoted_list(labels), fmt::join(from, ", "));
  head += fmt::format("array to[panels] = [{}]\n\n", fmt::join(to, ", "));
  Done done = write_file((folder / fmt::format("histograms-{}.dat", name)).string(), histograms);
  if (done) done = write_file((folder / fmt::format("distributions-{}.dat", name)).string(), distributions);
  return done ? draw(folder, name, head, embedded::distributions_gp) : done;
}

struct NamedShare {
  const char* name;
  const char* label;
  std::optional<bool> (*of)(const RunOutcome&);
};
constexpr std::array shares{
    NamedShare{"recovered", "recovered", [](const RunOutcome& o) { return std::optional(o.recovery.has_value()); }},
    NamedShare{"without_collision", "no collision", [](const RunOutcome& o) { return std::optional(!o.collided()); }},
    NamedShare{"inside", "inside the arena", [](const RunOutcome& o) { return std::optional(!(o.outside > 0.0)); }},
    NamedShare{"formation_first", "distances first", [](const RunOutcome& o) { return o.formation_first; }},
    NamedShare{"relative_first", "relative pos. first", [](const RunOutcome& o) { return o.relative_first; }},
};

Share share_in(const NamedShare& share, const std::vector<RunOutcome>& runs) {
  std::int64_t part = 0, whole = 0;
  for (const RunOutcome& run : runs)
    if (const auto yes = run.failure.empty() ? share.of(run) : std::nullopt) part += *yes, ++whole;
  return share_of(part, whole);
}

Done draw_shares(const fs::path& folder, const Study& study, const std::vector<Variant>& variants) {
  std::string data, names;
  int rows = 0;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    int row = 0;
    data += fmt::format("# {}: row, share, low, high\n", variants[v].name);
    for (const NamedShare& share : shares) {
      if (share_in(share, *variants.front().runs).whole == 0) continue;
      ++row;
      const Share s = share_in(share, *variants[v].runs);
      if (s.whole > 0) data += fmt::format("{} {:.6g} {:.6g} {:.6g}\n", row, s.value, s.low, s.high);
      if (v == 0) names += fmt::format("{}'{}' {}", row > 1 ? ", " : "", share.label, row), rows = row;
    }
    data += "\n\n";
  }
  if (rows == 0) return remove_figure(folder.string(), "shares"), Done();
  if (Done done = write_file((folder / "shares.dat").string(), data); !done) return done;
  return draw(folder, "shares",
              head_of(study, "shares", variants) + fmt::format("rows = {}\nnames = \"{}\"\n\n", rows, names),
              embedded::shares_gp);
}

/// All intervals as a table.
std::string interval_table(const std::vector<Variant>& variants) {
  std::string text = "quantity,variant,runs,value,low,high\n";
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : std::string(); };
  for (const NamedShare& share : shares)
    for (const Variant& v : variants)
      if (const Share s = share_in(share, *v.runs); s.whole > 0)
        text += fmt::format("{},{},{},{},{},{}\n", share.name, v.name, s.whole, number(s.value), number(s.low),
                            number(s.high));
  for (const Quantity& quantity : quantities) {
    for (const Variant& v : variants) {
      std::vector<double> values;
      for (const RunOutcome& run : *v.runs)
        if (const auto value = quantity.of(run); run.failure.empty() && value) values.push_back(*value);
      if (values.empty()) continue;
      const PairedDifference median = paired_difference(std::move(values));
      text += fmt::format("{}_median,{},{},{},{},{}\n", quantity.name, v.name, median.pairs, number(median.median),
                          number(median.low), number(median.high));
    }
    for (std::size_t other = 1; other < variants.size(); ++other) {
      std::vector<double> differences;
      for (std::size_t i = 0; i < std::min(variants[0].runs->size(), variants[other].runs->size()); ++i) {
        const RunOutcome &a = (*variants[0].runs)[i], &b = (*variants[other].runs)[i];
        const auto x = quantity.of(a), y = quantity.of(b);
        if (a.seed == b.seed && a.failure.empty() && b.failure.empty() && x && y) differences.push_back(*x - *y);
      }
      if (differences.empty()) continue;
      const PairedDifference d = paired_difference(std::move(differences));
      text += fmt::format("{}_median,{} minus {},{},{},{},{}\n", quantity.name, variants[0].name, variants[other].name,
                          d.pairs, number(d.median), number(d.low), number(d.high));
    }
  }
  return text;
}

/// Where every robot should have been and where it was, in the order of time.
class Plan final : public RecordSink {
 public:
  void record(const TickRecord& record) override {
    if (!counts(record.phase)) return;
    ways_.resize(record.robots.size());
    for (std::size_t i = 0; i < record.robots.size(); ++i) {
      const RobotRecord& r = record.robots[i];
      ways_[i] +=
          fmt::format("{:.5f} {:.5f} {:.5f} {:.5f}\n", r.nominal.pose.x, r.nominal.pose.y, r.truth.x, r.truth.y);
    }
    ++rows_;
  }
  std::string text() const {
    std::string all;
    for (const std::string& way : ways_) all += way + "\n\n";
    return all;
  }
  std::size_t robots() const noexcept { return ways_.size(); }
  std::size_t rows() const noexcept { return rows_; }

 private:
  std::vector<std::string> ways_;
  std::size_t rows_ = 0;
};

std::string what_happened(const RunOutcome& run) {
  if (run.collided())
    return fmt::format("seed {}: {} collision{}", run.seed, run.collisions, run.collisions > 1 ? "s" : "");
  if (!run.recovery) return fmt::format("seed {}: {:.0f} mm off at the end", run.seed, 1e3 * run.final_error);
  return fmt::format("seed {}: {:.1f} s, nearest {:.0f} mm", run.seed, *run.recovery, 1e3 * run.min_distance);
}

Done draw_worst(const fs::path& folder, const Study& study, const std::vector<RunOutcome>& runs) {
  std::vector<std::string> titles, files, robots, obstacles, last;
  double width = 0.0, height = 0.0;
  for (const std::uint64_t seed : worst_seeds(runs, most_plans)) {
    const auto experiment = experiment_of(study, seed);
    if (!experiment) return tl::unexpected(experiment.error());
    Plan plan;
    auto session = Session::open(*experiment, Session::Clock::virtual_, {false, {&plan}});
    if (!session) return tl::unexpected(session.error());
    (*session)->run();
    (*session)->close();
    files.push_back(fmt::format("worst-{}.dat", files.size() + 1));
    if (Done done = write_file((folder / files.back()).string(), plan.text()); !done) return done;
    const auto run = std::find_if(runs.begin(), runs.end(), [&](const RunOutcome& o) { return o.seed == seed; });
    titles.push_back(what_happened(*run));
    robots.push_back(fmt::format("{}", plan.robots()));
    last.push_back(fmt::format("{}", plan.rows() > 0 ? plan.rows() - 1 : 0));
    std::string discs;
    for (const core::Obstacle& o : experiment->obstacles) discs += fmt::format("{} {} {} ", o.x, o.y, o.radius);
    obstacles.push_back(discs);
    width = experiment->arena_width, height = experiment->arena_height;
  }
  if (files.empty()) return remove_figure(folder.string(), "worst"), Done();
  std::string head =
      fmt::format("# Study \"{}\", drawn by skein {}. To draw it again, edit this and run: gnuplot worst.gp\n",
                  study.name, SKEIN_VERSION);
  head += fmt::format("plans = {}\narena_width = {}\narena_height = {}\n", files.size(), width, height);
  head += fmt::format("array title_of[plans] = [{}]\narray file_of[plans] = [{}]\narray obstacles_of[plans] = [{}]\n",
                      quoted_list(titles), quoted_list(files), quoted_list(obstacles));
  head += fmt::format("array robots_of[plans] = [{}]\narray last_of[plans] = [{}]\n\n", fmt::join(robots, ", "),
                      fmt::join(last, ", "));
  return draw(folder, "worst", head, embedded::worst_gp);
}

}  // namespace

Share share_of(std::int64_t part, std::int64_t whole) {
  if (whole <= 0) return {part, whole, none, none, none};
  const auto n = static_cast<double>(whole);
  const double p = static_cast<double>(part) / n, square = core::z_95 * core::z_95 / n;
  const double middle = (p + 0.5 * square) / (1.0 + square);
  const double half = core::z_95 * std::sqrt(p * (1.0 - p) / n + 0.25 * square / n) / (1.0 + square);
  // Rounding must not leave a share outside its interval.
  return {part, whole, p, std::clamp(middle - half, 0.0, p), std::clamp(middle + half, p, 1.0)};
}

PairedDifference paired_difference(std::vector<double> values) {
  const std::size_t n = values.size();
  if (n == 0) return {0, none, none, none};
  std::sort(values.begin(), values.end());
  const double median = n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
  // The largest k with P(fewer than k of n lie below the median) <= 2.5 %: then [k-th smallest, k-th largest] holds it.
  double below = 0.0, log_chance = -static_cast<double>(n) * core::math::log(2.0);
  std::size_t k = 0;
  for (; k < n; ++k) {
    below += core::math::exp(log_chance);
    if (below > 0.025) break;
    log_chance += core::math::log(static_cast<double>(n - k)) - core::math::log(static_cast<double>(k + 1));
  }
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {n, median, k > 0 ? values[k - 1] : -infinity, k > 0 ? values[n - k] : infinity};
}

std::vector<std::uint64_t> worst_seeds(const std::vector<RunOutcome>& outcomes, std::size_t most) {
  std::vector<const RunOutcome*> runs;
  for (const RunOutcome& run : outcomes)
    if (run.failure.empty()) runs.push_back(&run);
  // Larger is worse, the first thing that differs decides.
  const auto badness = [](const RunOutcome& o) {
    return std::tuple(o.collisions, !o.recovery, o.recovery ? *o.recovery : o.final_error);
  };
  std::stable_sort(runs.begin(), runs.end(), [&](const auto* a, const auto* b) { return badness(*a) > badness(*b); });
  runs.resize(std::min(most, runs.size()));
  std::vector<std::uint64_t> seeds;
  seeds.reserve(runs.size());
  for (const RunOutcome* run : runs) seeds.push_back(run->seed);
  return seeds;
}

Done write_sweep_report(const std::string& directory, const Study& study, const Outcomes& outcomes) {
  const fs::path folder(directory);
  std::vector<Variant> variants;
  for (const auto& [name, list] : outcomes.variants())
    if (name != "control" || !list->empty()) variants.push_back({name, list});
  if (!study.compare.empty()) variants.front().name = study.name;  // as in the table of what it is compared with
  std::ostringstream runs;
  write_outcomes(runs, outcomes);
  Done done = write_file((folder / "runs.csv").string(), runs.str());
  if (done)
    done = write_file(
        (folder / "summary.json").string(),
        as_json(summarise(study, outcomes.study, outcomes.control), summaries_of_compared(study, outcomes)) + '\n');
  if (done) done = write_file((folder / "intervals.csv").string(), interval_table(variants));
  for (const bool times : {true, false})
    if (done) done = draw_distributions(folder, study, variants, times);
  if (done) done = draw_shares(folder, study, variants);
  if (done) done = draw_worst(folder, study, outcomes.study);
  return done;
}

}  // namespace skein::app
