#include "ui/main/pair_controller.h"

#include <algorithm>
#include <cmath>

#include "core/control/gain_room.h"
#include "ui/arena/arena_view.h"
#include "ui/base/sentence.h"
#include "ui/base/tr.h"
#include "ui/gains/gains_panel.h"

namespace skein::ui {
namespace {

/// What a gain is on its way to: the largest of all pairs, as the sliders show it.
double largest_target(const RunSource& run, core::GainName gain) {
  double largest = 0.0;
  for (std::size_t i = 0; i < run.experiment().robots.size(); ++i)
    for (std::size_t j = i + 1; j < run.experiment().robots.size(); ++j)
      largest = std::max(largest, run.gain_target(gain, i, j));
  return largest;
}

/// Where the gains of all pairs are going to; the pairs that are coupled as 1.
struct Targets {
  core::CouplingGains gains;
  core::PairTable coupled;
};

Targets targets_of(const RunSource& run) {
  const std::size_t n = run.experiment().robots.size();
  Targets targets{{core::PairTable(n), core::PairTable(n), core::PairTable(n)}, core::PairTable(n)};
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      for (const core::GainName name : core::gain_names)
        core::table(targets.gains, name).set(i, j, run.gain_target(name, i, j));
      targets.coupled.set(i, j, run.coupled(i, j) ? 1.0 : 0.0);
    }
  return targets;
}

constexpr double per_unit = 1e4, rounding = 1e-6;  // what is shown and typed has four places

double rounded_up(double value) {
  return std::ceil(value * per_unit - rounding) / per_unit;
}

QString four_places(double value) {
  return QString::number(value, 'f', 4);
}

/// Where no gain makes room. `fixed`: of k_x and k_theta, which the file then has.
QString slower_reference(core::GainName gain, bool fixed) {
  if (core::shares_limit_with(gain))
    return fixed ? tr("a larger one takes a slower reference, or a smaller k_theta in the file (18g)")
                 : tr("a larger one takes a slower reference (18g)");
  return fixed ? tr("a larger one takes a slower reference, or a smaller k_x in the file (18f)")
               : tr("a larger one takes a slower reference (18f)");
}

}  // namespace

PairController::PairController(Runs& runs, const Messages& messages, GainsPanel* gains, ArenaView* arena,
                               QObject* parent)
    : QObject(parent), runs_(runs), messages_(messages), gains_(gains), arena_(arena) {
  gains_->set_pairs([this](core::GainName gain, std::size_t i, std::size_t j) {
    const RunSource& run = runs_.shown();
    return PairModel::Pair{run.gain_target(gain, i, j), run.gain_limit(gain, i, j), run.coupled(i, j)};
  });
  connect(gains_, &GainsPanel::wanted, this, [this, &messages](core::GainName gain, double value) {
    messages.tell(runs_.shown().set_gain(gain, value, gains_->ramp()));
  });
  connect(gains_, &GainsPanel::pair_wanted, this, [this, &messages](core::GainName gain, int i, int j, double value) {
    messages.tell(
        runs_.shown().set_gain(gain, static_cast<std::size_t>(i), static_cast<std::size_t>(j), value, gains_->ramp()));
  });
  connect(gains_, &GainsPanel::couple_wanted, this, [this, &messages](int i, int j, bool on) {
    messages.tell(runs_.shown().couple(static_cast<std::size_t>(i), static_cast<std::size_t>(j), on));
  });
  connect(gains_, &GainsPanel::parameter_wanted, this, [this, &messages](const QString& name, double value) {
    messages.tell(runs_.shown().set_parameter(name.toStdString(), value));
  });
  connect(gains_, &GainsPanel::refused, this,
          [&messages](const QString& why) { messages.say(why, Severity::warning); });
  gains_->set_remedy([this](core::GainName gain, double wanted) { return remedy(gain, wanted); });
  connect(&runs.live(), &LiveRun::opened, this, [this] { demand_.reset(); });
  connect(arena_, &ArenaView::coupling_clicked, gains_, &GainsPanel::switch_pair);
}

void PairController::refresh() {
  const RunSource& run = runs_.shown();
  gains_->set_limits([&run](core::GainName gain) { return run.gain_limit(gain); },
                     [&run](core::GainName gain) { return run.gain_limit_now(gain); });
  gains_->follow_targets([&run](core::GainName gain) { return largest_target(run, gain); });
  gains_->follow_parameters(run.parameters());
  gains_->refresh_pairs();
  show_couplings();
}

const core::ReferenceDemand& PairController::demand() {
  const app::Experiment& experiment = runs_.live().experiment();
  if (!demand_) demand_ = app::make_reference(experiment)->demand(experiment.controller.k_y);
  return *demand_;
}

/// What has to be done for (18f, g) to allow this value, which is beyond the gain's limit; empty: it is no live run.
QString PairController::remedy(core::GainName gain, double wanted) {
  const LiveRun& run = runs_.live();
  if (&runs_.shown() != &run || !run.is_open()) return {};
  const core::Gains gains = app::make_gains(run.experiment());
  const bool fixed = gains.policy == core::GainPolicy::fixed;
  const std::optional<core::GainName> other = core::shares_limit_with(gain);
  if (!other) return slower_reference(gain, fixed);
  const Targets targets = targets_of(run);
  const double shown = rounded_up(wanted);
  const auto to = core::lowered_for(gain, shown, *other, {gains, targets.gains, demand()}, targets.coupled, per_unit);
  if (!to)
    return tr("for %1 even %2 = 0 is not enough; %3")
        .arg(four_places(shown), gain_symbol(*other), slower_reference(gain, fixed));
  return tr("lower %1 from %2 to %3 to allow %4")
      .arg(gain_symbol(*other), four_places(core::table(targets.gains, *other).largest()), four_places(*to),
           four_places(shown));
}

/// The same for one pair: its other gain makes room, or else the two robots' pairs with the others.
QString PairController::remedy(core::GainName gain, std::size_t i, std::size_t j, double wanted) {
  const LiveRun& run = runs_.live();
  if (&runs_.shown() != &run || !run.is_open()) return {};
  const core::Gains gains = app::make_gains(run.experiment());
  const Targets targets = targets_of(run);
  const double shown = rounded_up(wanted);
  if (const auto other = core::shares_limit_with(gain))
    if (const auto to = core::lowered_for(gain, i, j, shown, *other, {gains, targets.gains, demand()}, per_unit))
      return tr("lower %1 of the same pair from %2 to %3 to allow %4")
          .arg(gain_symbol(*other), four_places(core::table(targets.gains, *other)(i, j)), four_places(*to),
               four_places(shown));
  const core::PairTable& table = core::table(targets.gains, gain);
  QStringList parts;
  for (const auto& [robot, partner] : {std::pair(i, j), std::pair(j, i)}) {
    const double less = core::given_up_for(gain, robot, partner, shown, {gains, targets.gains, demand()});
    if (less > table.row_sum(robot) - table(robot, partner))
      return slower_reference(gain, gains.policy == core::GainPolicy::fixed);
    if (less > 0.0) parts << tr("robot %1 by %2").arg(robot + 1).arg(four_places(rounded_up(less)));
  }
  return tr("lower %1 in the other pairs of %2 in total to allow %3")
      .arg(gain_symbol(gain), parts.join(tr(" and of ")), four_places(shown));
}

void PairController::explain(const app::TickRecord& record) {
  for (const app::Event& event : record.events) {
    if (const auto* const held = std::get_if<app::events::GainHeld>(&event)) {
      const QString what = remedy(held->gain, held->asked);
      if (!what.isEmpty())
        messages_.say(
            tr("%1 is held at %2, its limit: %3").arg(gain_symbol(held->gain)).arg(held->held, 0, 'g', 4).arg(what),
            Severity::warning);
    }
    if (const auto* const held = std::get_if<app::events::PairGainHeld>(&event)) {
      const QString what = remedy(held->gain, held->i, held->j, held->asked);
      if (!what.isEmpty())  // in the log too: below the slider of a single gain it goes on being said, of a pair
                            // nowhere
        messages_.note(tr("%1 of robots %2 and %3 is held at %4, its limit: %5")
                           .arg(gain_symbol(held->gain))
                           .arg(held->i + 1)
                           .arg(held->j + 1)
                           .arg(held->held, 0, 'g', 4)
                           .arg(what),
                       Severity::warning);
    }
  }
}

/// The lines between the robots: as broad as their gains are of what (18f, g) allow.
void PairController::show_couplings() {
  const RunSource& run = runs_.shown();
  const std::size_t n = run.experiment().robots.size();
  std::array<double, 3> limits{};
  for (const core::GainName gain : core::gain_names) limits[static_cast<std::size_t>(gain)] = run.gain_limit(gain);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      double shares = 0.0;
      for (const core::GainName gain : core::gain_names)
        if (const double limit = limits[static_cast<std::size_t>(gain)]; limit > 0.0)
          shares += run.gain(gain, i, j) / limit;
      arena_->set_coupling(i, j, shares / core::gain_names.size());
    }
}

}  // namespace skein::ui
