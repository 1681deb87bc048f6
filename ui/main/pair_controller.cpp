#include "ui/main/pair_controller.h"

#include <algorithm>

#include "ui/arena/arena_view.h"
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
    : QObject(parent), runs_(runs), gains_(gains), arena_(arena) {
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
