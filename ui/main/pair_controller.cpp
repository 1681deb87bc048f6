#include "ui/main/pair_controller.h"

#include <algorithm>
#include <cmath>

#include "core/control/gain_room.h"
#include "ui/arena/arena_view.h"
#include "ui/base/sentence.h"
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

/// What has to be done for (18f, g) to allow this value, which is beyond the gain's limit; empty: it is no live run.
QString PairController::remedy(core::GainName gain, double wanted) {
  const LiveRun& run = runs_.live();
  if (&runs_.shown() != &run || !run.is_open()) return {};
  const app::Experiment& experiment = run.experiment();
  const core::Gains gains = app::make_gains(experiment);
  const bool fixed = gains.policy == core::GainPolicy::fixed;
  const std::optional<core::GainName> other = core::shares_limit_with(gain);
  if (!other)
    return fixed ? tr("that takes a slower reference, or a smaller k_x in the file (18f)")
                 : tr("that takes a slower reference (18f)");
  if (!demand_) demand_ = app::make_reference(experiment)->demand(experiment.controller.k_y);
  const std::size_t n = experiment.robots.size();
  core::CouplingGains targets{core::PairTable(n), core::PairTable(n), core::PairTable(n)};
  core::PairTable coupled(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      for (const core::GainName name : core::gain_names)
        core::table(targets, name).set(i, j, run.gain_target(name, i, j));
      coupled.set(i, j, run.coupled(i, j) ? 1.0 : 0.0);
    }
  constexpr double per_unit = 1e4, rounding = 1e-6;  // what is shown and typed has four places
  const double shown = std::ceil(wanted * per_unit - rounding) / per_unit;
  const auto to = core::lowered_for(gain, shown, *other, gains, targets, coupled, *demand_, per_unit);
  if (!to)
    return fixed ? tr("for %1 even %2 = 0 is not enough; that takes a slower reference, or a smaller k_theta in the "
                      "file (18g)")
                       .arg(shown, 0, 'f', 4)
                       .arg(gain_symbol(*other))
                 : tr("for %1 even %2 = 0 is not enough; that takes a slower reference (18g)")
                       .arg(shown, 0, 'f', 4)
                       .arg(gain_symbol(*other));
  return tr("lower %1 from %2 to %3 to allow %4")
      .arg(gain_symbol(*other))
      .arg(core::table(targets, *other).largest(), 0, 'f', 4)
      .arg(*to, 0, 'f', 4)
      .arg(shown, 0, 'f', 4);
}

void PairController::explain(const app::TickRecord& record) {
  for (const app::Event& event : record.events) {
    const auto* const held = std::get_if<app::events::GainHeld>(&event);
    if (held == nullptr) continue;
    const QString what = remedy(held->gain, held->asked);
    if (!what.isEmpty())
      messages_.say(
          tr("%1 is held at %2, its limit: %3").arg(gain_symbol(held->gain)).arg(held->held, 0, 'g', 4).arg(what),
          Severity::warning);
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
