#include "app/tools/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <nlopt.hpp>
#include <optional>
#include <tuple>

#include "app/embedded/embedded.h"
#include "app/experiment/certificate.h"
#include "app/experiment/experiment_file.h"
#include "app/experiment/experiment_keys.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_edit.h"
#include "app/record/gnuplot.h"
#include "core/math/elementary.h"
#include "core/words.h"

namespace skein::app {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// The number that an experiment has at a key that can be searched; the error says what can be.
tl::expected<double, std::string> number_at(Experiment& experiment, const std::string& key) {
  if (const ExperimentKey* const known = find_experiment_key(key))
    if (const auto* const number = std::get_if<NumberKey>(&known->value)) return number->at(experiment);
  for (const core::GainName name : core::pair_names) {
    const bool gain = std::find(core::gain_names.begin(), core::gain_names.end(), name) != core::gain_names.end();
    if (key != (gain ? "controller.gains." : "controller.") + std::string(word(name))) continue;
    const core::PairTable& table = core::table(std::as_const(experiment).controller.gains, name);
    if (table.robots() < 2 || !table.uniform())
      return tl::unexpected(fmt::format("tune.search: {}: allowed: one value for all pairs of the experiment", key));
    return table(0, 1);
  }
  return tl::unexpected(
      fmt::format("tune.search: found \"{}\", allowed: a number of the experiment, as \"controller.k_y\" or "
                  "\"controller.gains.k_xx\"",
                  key));
}

/// What a search moves: every number between 0 and 1.
class Scale {
 public:
  explicit Scale(const Span& span) : span_(span), logarithmic_(span[0] > 0.0 && span[1] >= 10.0 * span[0]) {}

  /// To three digits: files stay readable, and finer differences have no effect.
  double value(double share) const {
    const double exact = logarithmic_ ? span_[0] * core::math::pow(span_[1] / span_[0], share)
                                      : span_[0] + (span_[1] - span_[0]) * share;
    return std::clamp(std::stod(fmt::format("{:.3g}", exact)), span_[0], span_[1]);
  }
  double share(double value) const {
    const double here = std::clamp(value, span_[0], span_[1]);
    return std::clamp(logarithmic_ ? core::math::log(here / span_[0]) / core::math::log(span_[1] / span_[0])
                                   : (here - span_[0]) / (span_[1] - span_[0]),
                      0.0, 1.0);
  }

 private:
  Span span_;
  bool logarithmic_;
};

struct Times {
  std::vector<double> formation, tracking;  // of every run [s]
};

/// The means of a study's runs; the error is why one could not be made.
tl::expected<std::pair<Merits, Times>, std::string> merits_of(const std::vector<RunOutcome>& outcomes, double longest) {
  Merits m;
  Times times;
  for (const RunOutcome& o : outcomes) {
    if (!o.failure.empty()) return tl::unexpected(fmt::format("seed {}: {}", o.seed, o.failure));
    times.formation.push_back(o.relative_settled.value_or(longest));
    times.tracking.push_back(o.tracking_settled.value_or(longest));
    m.formation += times.formation.back();
    m.tracking += times.tracking.back();
    m.limited_share += o.limited_share;
    m.effort += o.effort;
    m.collisions += o.collisions;
  }
  const auto n = static_cast<double>(outcomes.size());
  for (double* const sum : {&m.formation, &m.tracking, &m.limited_share, &m.effort}) *sum /= n;
  return std::pair(m, std::move(times));
}

bool dominates(const Merits& a, const Merits& b) noexcept {
  return a.formation <= b.formation && a.tracking <= b.tracking &&
         (a.formation < b.formation || a.tracking < b.tracking);
}

/// Costs of candidates that did not come so far; all larger than any that did. Within a kind the less it lacks, the
/// better.
constexpr double refused = 1e9, short_margin = 1e8, too_costly = 1e7;

class Tuner {
 public:
  Tuner(const Study& study, unsigned threads, const std::function<bool(std::int64_t)>& progress)
      : study_(study), tune_(*study.tune), threads_(threads), progress_(progress) {
    study_.control.clear();
    study_.compare.clear();
    for (const auto& [key, span] : tune_.search) scales_.emplace_back(span);
  }

  tl::expected<Tuned, std::string> result() {
    if (auto own = try_own(); !own) return tl::unexpected(own.error());
    for (std::int64_t k = 0; k < tune_.objectives; ++k) {
      objective_ = k;
      search(static_cast<unsigned long>(study_.seed) + static_cast<unsigned long>(k));
      if (stopped_) return tl::unexpected(fmt::format("stopped after {} runs: nothing is written", tuned_.runs));
    }
    find_front();
    if (auto measured = measure_held_out(); !measured) return tl::unexpected(measured.error());
    return std::move(tuned_);
  }

 private:
  using Done = tl::expected<void, std::string>;

  Done try_own() {
    auto experiment = parse_experiment(study_.text, study_.experiment, study_.sets);
    if (!experiment) return tl::unexpected(experiment.error().front().message());
    longest_ = experiment->duration - study_.hand->t;
    if (!(longest_ > 0.0)) return tl::unexpected(std::string("hand.t: allowed: before the end of the experiment"));
    for (const auto& [key, span] : tune_.search) {
      const auto value = number_at(*experiment, key);
      if (!value) return tl::unexpected(value.error());
      tuned_.own.values.push_back(*value);
    }
    const auto certified = certify_all({});
    if (!certified)
      return tl::unexpected("the experiment's own gains are the control, and `skein check` refuses them: " +
                            certified.error());
    tuned_.own.delay_margin = *certified;
    const auto merits = run({});
    if (!merits) return tl::unexpected(stopped_ ? "stopped before the search: nothing is written" : merits.error());
    tuned_.own.searched = *merits;
    const auto never = [&](const std::vector<double>& times) {
      return std::all_of(times.begin(), times.end(), [&](double time) { return time >= longest_; });
    };
    if (never(newest_times_.formation) && never(newest_times_.tracking))
      return tl::unexpected(
          fmt::format("with the experiment's own gains none of {} kicks has settled {:g} s later, at the end of the "
                      "experiment: there is nothing to compare with, allowed: a longer duration, or smaller kicks",
                      study_.runs, longest_));
    delay_margin_ = tune_.delay_margin.value_or(tuned_.own.delay_margin);
    limited_share_ = tune_.limited_share.value_or(tuned_.own.searched.limited_share);
    effort_ = tune_.effort.value_or(tuned_.own.searched.effort);
    if (lack(tuned_.own.delay_margin, tuned_.own.searched) <= 0.0) tuned_.tried.push_back(tuned_.own);
    return {};
  }

  /// The smaller delay margin of the experiment as its file has it and as the study runs it, both with these values;
  /// the error says what is wrong with one of them.
  tl::expected<double, std::string> certify_all(const std::vector<std::string>& sets) const {
    double margin = infinite;
    for (const bool as_run : {false, true}) {
      std::vector<std::string> all = as_run ? study_.sets : std::vector<std::string>{};
      all.insert(all.end(), sets.begin(), sets.end());
      const auto experiment = parse_experiment(study_.text, study_.experiment, all);
      if (!experiment) return tl::unexpected(experiment.error().front().message());
      const Certificate certificate = certify(*experiment);
      if (!certificate.sound()) return tl::unexpected("its certificate does not hold:\n" + as_lines(certificate));
      margin = std::min(margin, certificate.delay.margin.delay);
    }
    return margin;
  }

  tl::expected<Merits, std::string> run(const std::vector<std::string>& sets) {
    Study study = study_;
    study.sets.insert(study.sets.end(), sets.begin(), sets.end());
    const std::int64_t before = tuned_.runs;
    const std::vector<RunOutcome> outcomes = sweep(study, threads_, [&](std::size_t made) {
      stopped_ = stopped_ || !progress_(before + static_cast<std::int64_t>(made));
      return !stopped_;
    });
    tuned_.runs += static_cast<std::int64_t>(outcomes.size());
    if (static_cast<std::int64_t>(outcomes.size()) < study.runs) stopped_ = true;
    if (stopped_) return tl::unexpected(std::string("stopped"));
    auto merits = merits_of(outcomes, longest_);
    if (!merits) return tl::unexpected(merits.error());
    newest_times_ = std::move(merits->second);
    return merits->first;
  }

  /// By how much, in shares, a point misses the constraints that its runs show; at most 0: it keeps them.
  double lack(double delay_margin, const Merits& m) const noexcept {
    constexpr double rounding = 1e-9;
    const auto over = [](double value, double most) {
      return value > most * (1.0 + rounding) ? (value - most) / std::max(most, 1e-3) : 0.0;
    };
    return over(delay_margin_, delay_margin) + over(m.limited_share, limited_share_) + over(m.effort, effort_) +
           static_cast<double>(m.collisions);
  }

  /// What the present search minimises.
  double cost(const Merits& m) const {
    if (objective_ == 0) return m.formation;
    if (objective_ == 1) return m.tracking;
    // Chebyshev's distance from the best of each objective at the ends of the front, in units of its extent.
    const double weight = static_cast<double>(objective_ - 1) / static_cast<double>(tune_.objectives - 1);
    const Merits &f = fastest_formation_, &t = fastest_tracking_;
    const double x = (m.formation - f.formation) / std::max(1e-6, t.formation - f.formation);
    const double y = (m.tracking - t.tracking) / std::max(1e-6, f.tracking - t.tracking);
    constexpr double augmentation = 0.05;  // so that no point of equal distance dominates the result
    return std::max((1.0 - weight) * x, weight * y) + augmentation * (x + y);
  }

  double try_candidate(const std::vector<double>& shares) {
    TunedPoint point;
    for (std::size_t i = 0; i < shares.size(); ++i) point.values.push_back(scales_[i].value(shares[i]));
    ++tuned_.candidates;
    const std::vector<std::string> sets = sets_of(tune_, point);
    const auto margin = certify_all(sets);
    const auto uncertified = [&](double its_cost, const std::string& why) {
      if (tuned_.uncertified++ == 0)
        tuned_.first_uncertified = fmt::format("{}: {}", fmt::join(sets, " "), why.substr(0, why.find(":\n")));
      return its_cost;
    };
    if (!margin) return uncertified(refused, margin.error());
    point.delay_margin = *margin;
    if (*margin < delay_margin_ * (1.0 - 1e-9))
      return uncertified(
          short_margin + (delay_margin_ - *margin) / delay_margin_,
          fmt::format("its delay margin is {:.4g} s, allowed: at least {:.4g} s", *margin, delay_margin_));
    const auto merits = run(sets);
    if (!merits) return refused;
    point.searched = *merits;
    if (const double missing = lack(*margin, *merits); missing > 0.0)
      return ++tuned_.unaffordable, too_costly + missing;
    tuned_.tried.push_back(point);
    return cost(point.searched);
  }

  /// The best point so far for the present search, or the experiment's own.
  const TunedPoint& best_so_far() const {
    const auto best =
        std::min_element(tuned_.tried.begin(), tuned_.tried.end(),
                         [&](const TunedPoint& a, const TunedPoint& b) { return cost(a.searched) < cost(b.searched); });
    return best == tuned_.tried.end() ? tuned_.own : *best;
  }

  void search(unsigned long seed) {
    if (objective_ >= 2 && tuned_.tried.empty()) return;  // nothing keeps the constraints: there is no front to divide
    if (objective_ == 2) {
      const auto least = [&](double Merits::*value) {
        return std::min_element(
                   tuned_.tried.begin(), tuned_.tried.end(),
                   [=](const TunedPoint& a, const TunedPoint& b) { return a.searched.*value < b.searched.*value; })
            ->searched;
      };
      fastest_formation_ = least(&Merits::formation);
      fastest_tracking_ = least(&Merits::tracking);
    }
    const TunedPoint start = best_so_far();
    std::vector<double> shares;
    for (std::size_t i = 0; i < scales_.size(); ++i) shares.push_back(scales_[i].share(start.values[i]));
    nlopt::srand(seed);
    nlopt::opt optimiser(nlopt::GN_CRS2_LM, static_cast<unsigned>(shares.size()));
    optimiser.set_lower_bounds(0.0);
    optimiser.set_upper_bounds(1.0);
    optimiser.set_maxeval(static_cast<int>(tune_.candidates));
    // It begins with random candidates: a quarter of all where NLopt's own number would leave none for the search.
    const auto n = static_cast<std::int64_t>(shares.size());
    const auto first = std::clamp<std::int64_t>(tune_.candidates / 4, 2 * (n + 1), 10 * (n + 1));
    optimiser.set_population(static_cast<unsigned>(first));
    const nlopt::vfunc try_it = [](const std::vector<double>& x, std::vector<double>&, void* data) {
      auto& [tuner, self] = *static_cast<std::pair<Tuner*, nlopt::opt*>*>(data);
      // CRS2 looks at its limit between two steps, and a step may try two candidates.
      const double found = tuner->left_-- > 0 ? tuner->try_candidate(x) : refused;
      if (tuner->stopped_ || tuner->left_ < 0) self->force_stop();
      return found;
    };
    left_ = tune_.candidates;
    std::pair<Tuner*, nlopt::opt*> data{this, &optimiser};
    optimiser.set_min_objective(try_it, &data);
    try {
      double least = infinite;
      optimiser.optimize(shares, least);
    } catch (const nlopt::forced_stop&) {  // its candidates are used up, or stopped_ says why
    }
  }

  void find_front() {
    for (const TunedPoint& p : tuned_.tried) {
      const auto beats = [&](const TunedPoint& q) { return dominates(q.searched, p.searched); };
      const auto same = [&](const TunedPoint& q) {
        return q.searched.formation == p.searched.formation && q.searched.tracking == p.searched.tracking;
      };
      if (beats(tuned_.own) || p.values == tuned_.own.values) continue;
      if (std::any_of(tuned_.tried.begin(), tuned_.tried.end(), beats)) continue;
      if (std::none_of(tuned_.front.begin(), tuned_.front.end(), same)) tuned_.front.push_back(p);
    }
    std::sort(tuned_.front.begin(), tuned_.front.end(),
              [](const TunedPoint& a, const TunedPoint& b) { return a.searched.formation < b.searched.formation; });
    double least = infinite;
    for (std::size_t i = 0; i < tuned_.front.size(); ++i) {
      const Merits &m = tuned_.front[i].searched, &own = tuned_.own.searched;
      const double worse = std::max(m.formation / own.formation, m.tracking / own.tracking);
      if (worse < least) least = worse, tuned_.chosen = i;
    }
  }

  Done measure_held_out() {
    study_.seed += static_cast<std::uint64_t>(study_.runs);
    study_.runs = tune_.held_out;
    const auto measure = [&](TunedPoint& point, const std::vector<std::string>& sets) -> Done {
      const auto merits = run(sets);
      if (!merits)
        return tl::unexpected(stopped_ ? fmt::format("stopped after {} runs: nothing is written", tuned_.runs)
                                       : merits.error());
      point.held_out = *merits;
      return {};
    };
    Done done = measure(tuned_.own, {});
    const Times own = newest_times_;
    for (TunedPoint& point : tuned_.front) {
      if (done) done = measure(point, sets_of(tune_, point));
      if (!done) break;
      const auto more = [&](std::vector<double> Times::*which) {
        std::vector<double> differences;
        for (std::size_t k = 0; k < (own.*which).size(); ++k)
          differences.push_back((newest_times_.*which)[k] - (own.*which)[k]);
        return paired_difference(std::move(differences));
      };
      point.formation_more = more(&Times::formation);
      point.tracking_more = more(&Times::tracking);
    }
    return done;
  }

  Study study_;
  const Study::Tune tune_;
  unsigned threads_;
  const std::function<bool(std::int64_t)>& progress_;
  std::vector<Scale> scales_;
  double longest_ = 0.0;                                            // after the kick [s]
  double delay_margin_ = 0.0, limited_share_ = 0.0, effort_ = 0.0;  // constraints
  std::int64_t objective_ = 0, left_ = 0;                           // of the candidates of the present search
  Merits fastest_formation_, fastest_tracking_;  // the ends of the front, from the first two searches
  Times newest_times_;
  bool stopped_ = false;
  Tuned tuned_;
};

}  // namespace

bool TunedPoint::better_in_both(const TunedPoint& own) const noexcept {
  return held_out.formation < own.held_out.formation && held_out.tracking < own.held_out.tracking &&
         formation_more.high < 0.0 && tracking_more.high < 0.0;
}

std::int64_t most_runs(const Study& study) {
  const Study::Tune& t = *study.tune;
  return study.runs * (1 + t.objectives * t.candidates);
}

tl::expected<Tuned, std::string> tune(const Study& study, unsigned threads,
                                      const std::function<bool(std::int64_t)>& progress) {
  if (!study.tune) return tl::unexpected(std::string("the study has no table [tune], which says what is searched"));
  if (!study.hand)
    return tl::unexpected(std::string("the study has no table [hand]: without kicks there is no recovery to measure"));
  for (const auto& [key, span] : study.tune->search)
    if (std::any_of(study.vary.begin(), study.vary.end(), [&](const auto& varied) { return varied.first == key; }))
      return tl::unexpected(fmt::format("tune.search: {}: allowed: a key that [vary] leaves alone", key));
  return Tuner(study, threads, progress).result();
}

std::vector<std::string> sets_of(const Study::Tune& tune, const TunedPoint& point) {
  std::vector<std::string> sets;
  for (std::size_t i = 0; i < point.values.size(); ++i)
    sets.push_back(fmt::format("{}={}", tune.search[i].first, point.values[i]));
  return sets;
}

tl::expected<std::string, std::string> experiment_with(const Study& study, const TunedPoint& point,
                                                       const std::string& file) {
  std::string text = study.text;
  for (std::size_t i = 0; i < point.values.size(); ++i) {
    auto changed = with_toml_value(text, study.tune->search[i].first, fmt::format("{}", point.values[i]));
    if (!changed)
      return tl::unexpected(fmt::format("{}: {}: {}", study.experiment, study.tune->search[i].first, changed.error()));
    text = std::move(*changed);
  }
  const auto folder = [](const std::string& of) { return std::filesystem::absolute(of).parent_path(); };
  if (std::error_code unknown; std::filesystem::equivalent(folder(file), folder(study.experiment), unknown))
    return text;
  auto whole = whole_text(text, study.experiment);
  if (!whole) return tl::unexpected(whole.error().front().message());
  return *std::move(whole);
}

std::string as_table(const Study& study, const Tuned& tuned) {
  std::string text = fmt::format(
      "{:<8} {:>9} {:>9}  {:>9} {:>9}  {:>26} {:>26}  {:>12} {:>7} {:>7} {:>10}\n{:<8} {:>19}  {:>19}  {:>26} {:>26}  "
      "{:>12} {:>7} {:>7} {:>10}\n",
      "", "formation", "tracking", "formation", "tracking", "formation more [s]", "tracking more [s]", "delay margin",
      "limited", "effort", "collisions", "point", "searched kicks [s]", "kicks held out [s]", "paired median, 95 %",
      "paired median, 95 %", "[s]", "[%]", "[m/s^2]", "");
  const auto more = [](const PairedDifference& d) {
    return fmt::format("{:+.2f} ({:+.2f} to {:+.2f})", d.median, d.low, d.high);
  };
  const auto row = [&](const std::string& name, const TunedPoint& p, bool own) {
    text +=
        fmt::format("{:<8} {:>9.2f} {:>9.2f}  {:>9.2f} {:>9.2f}  {:>26} {:>26}  {:>12.4f} {:>7.2f} {:>7.3f} {:>10}\n",
                    name, p.searched.formation, p.searched.tracking, p.held_out.formation, p.held_out.tracking,
                    own ? "" : more(p.formation_more), own ? "" : more(p.tracking_more), p.delay_margin,
                    100.0 * p.held_out.limited_share, p.held_out.effort, p.searched.collisions + p.held_out.collisions);
  };
  row("own", tuned.own, true);
  for (std::size_t i = 0; i < tuned.front.size(); ++i)
    row(fmt::format("{}{}", i + 1, i == tuned.chosen ? " chosen" : ""), tuned.front[i], false);
  text += '\n';
  for (std::size_t i = 0; i < tuned.front.size(); ++i)
    text += fmt::format("point {}: {}\n", i + 1, fmt::join(sets_of(*study.tune, tuned.front[i]), " "));
  return text;
}

std::string as_csv(const Study& study, const Tuned& tuned) {
  std::string text = "point,chosen";
  for (const auto& [key, span] : study.tune->search) text += "," + key;
  text += ",delay_margin";
  for (const char* kicks : {"searched", "held_out"})
    for (const char* merit : {"formation", "tracking", "limited_share", "effort", "collisions"})
      text += fmt::format(",{}_{}", kicks, merit);
  for (const char* more : {"formation_more", "tracking_more"}) text += fmt::format(",{0},{0}_low,{0}_high", more);
  text += '\n';
  const auto row = [&](const std::string& name, const TunedPoint& p, bool chosen) {
    text += fmt::format("{},{},{},{}", name, chosen ? 1 : 0, fmt::join(p.values, ","), p.delay_margin);
    for (const Merits& m : {p.searched, p.held_out})
      text += fmt::format(",{},{},{},{},{}", m.formation, m.tracking, m.limited_share, m.effort, m.collisions);
    for (const PairedDifference& d : {p.formation_more, p.tracking_more})
      text += d.pairs > 0 ? fmt::format(",{},{},{}", d.median, d.low, d.high) : ",,,";
    text += '\n';
  };
  row("own", tuned.own, false);
  for (std::size_t i = 0; i < tuned.front.size(); ++i) row(fmt::format("{}", i + 1), tuned.front[i], i == tuned.chosen);
  return text;
}

std::string verdict(const Tuned& tuned) {
  if (tuned.front.empty()) {
    std::string none =
        "no candidate is certified, within the constraints and not dominated by the experiment's own gains";
    if (tuned.candidates == 0 || tuned.uncertified < tuned.candidates) return none;
    return fmt::format("{}: none is certified. The first is {}", none, tuned.first_uncertified);
  }
  std::vector<std::size_t> better;
  for (std::size_t i = 0; i < tuned.front.size(); ++i)
    if (tuned.front[i].better_in_both(tuned.own)) better.push_back(i + 1);
  if (better.empty())
    return "no point of the front is better than the experiment's own gains in both objectives on the kicks held out, "
           "in its means and with 95 % confidence in its paired medians";
  return fmt::format(
      "better than the experiment's own gains in both objectives on the kicks held out, in their means and with 95 % "
      "confidence in their paired medians: {} {}",
      better.size() > 1 ? "points" : "point", fmt::join(better, ", "));
}

tl::expected<void, std::string> write_front(const std::string& directory, const Study& study, const Tuned& tuned) {
  const std::filesystem::path folder(directory);
  std::string data = "# tried: formation, tracking on the kicks of the search [s]\n";
  for (const TunedPoint& p : tuned.tried)
    data += fmt::format("{:.6g} {:.6g}\n", p.searched.formation, p.searched.tracking);
  const auto block = [&](const char* name, const std::vector<TunedPoint>& points) {
    data += fmt::format("\n\n# {}: formation, tracking on the kicks of the search, on the kicks held out [s], point\n",
                        name);
    for (std::size_t i = 0; i < points.size(); ++i)
      data += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {}\n", points[i].searched.formation, points[i].searched.tracking,
                          points[i].held_out.formation, points[i].held_out.tracking, i + 1);
  };
  block("front", tuned.front);
  block("the experiment's own gains", {tuned.own});
  block("chosen", tuned.front.empty() ? std::vector<TunedPoint>{} : std::vector{tuned.front[tuned.chosen]});
  const std::string head = fmt::format(
      "# Study \"{}\", drawn by skein {}. To draw it again, edit this and run: gnuplot front.gp\n"
      "# Means of {} kicks of the search and of {} kicks held out; {} candidates kept the constraints.\n\n",
      study.name, SKEIN_VERSION, study.runs, study.tune->held_out, tuned.tried.size());
  auto done = write_file((folder / "front.dat").string(), data);
  if (done) done = write_file((folder / "front.csv").string(), as_csv(study, tuned));
  if (done) done = write_file((folder / "front.gp").string(), head + std::string(embedded::front_gp));
  for (std::size_t i = 0; done && i < tuned.front.size(); ++i) {
    const std::string file = (folder / fmt::format("point-{}.toml", i + 1)).string();
    const auto text = experiment_with(study, tuned.front[i], file);
    if (!text) return tl::unexpected(text.error());
    done = write_file(file, *text);
  }
  // An earlier search may have found more.
  for (std::size_t i = tuned.front.size() + 1; done; ++i)
    if (std::error_code error; !std::filesystem::remove(folder / fmt::format("point-{}.toml", i), error)) break;
  if (done && tuned.front.empty()) remove_figure(directory, "front");
  if (done && !tuned.front.empty()) done = draw_figure(directory, "front");
  return done;
}

}  // namespace skein::app
