// Couplings, pair by pair: the lines in the arena and the table beside the sliders.
#include "ui/arena/arena_view.h"
#include "ui/gains/gains_panel.h"
#include "ui/main/main_window.h"

namespace skein::ui {

void MainWindow::connect_pairs() {
  gains_->set_pairs([this](core::GainName gain, std::size_t i, std::size_t j) {
    return PairModel::Pair{live_.gain_target(gain, i, j), live_.gain_border(gain, i, j), live_.coupled(i, j)};
  });
  connect(gains_, &GainsPanel::pair_wanted, this, [this](core::GainName gain, int i, int j, double value) {
    live_.set_gain(gain, static_cast<std::size_t>(i), static_cast<std::size_t>(j), value, gains_->ramp());
  });
  connect(gains_, &GainsPanel::couple_wanted, this, [this](int i, int j, bool on) {
    live_.couple(static_cast<std::size_t>(i), static_cast<std::size_t>(j), on);
  });
  connect(arena_, &ArenaView::coupling_clicked, gains_, &GainsPanel::switch_pair);
}

void MainWindow::show_pairs() {
  gains_->refresh_pairs();
  std::array<double, 3> borders{};
  for (const core::GainName gain : core::gain_names) borders[static_cast<std::size_t>(gain)] = live_.gain_border(gain);
  show_couplings(borders, [this](core::GainName gain, std::size_t i, std::size_t j) { return live_.gain(gain, i, j); });
}

/// The lines between the robots: as broad as their gains are of what (18f, g) allow.
void MainWindow::show_couplings(const std::array<double, 3>& borders,
                                const std::function<double(core::GainName, std::size_t, std::size_t)>& gain_of) {
  const std::size_t n = shown_experiment().robots.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      double shares = 0.0;
      for (const core::GainName gain : core::gain_names)
        if (const double border = borders[static_cast<std::size_t>(gain)]; border > 0.0)
          shares += gain_of(gain, i, j) / border;
      arena_->set_coupling(i, j, shares / core::gain_names.size());
    }
}

}  // namespace skein::ui
