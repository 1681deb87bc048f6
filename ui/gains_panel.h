#pragma once

#include <QPushButton>
#include <QWidget>
#include <array>
#include <functional>

#include "app/experiment.h"
#include "app/tick_record.h"
#include "ui/gain_slider.h"
#include "ui/margin_bars.h"

namespace skein::ui {

/// The three coupling gains, and what they leave to tracking.
class GainsPanel final : public QWidget {
  Q_OBJECT

 public:
  using Border = std::function<double(core::GainName)>;

  explicit GainsPanel(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment, const Border& border);
  void take(const app::TickRecord& record);
  void set_borders(const Border& border);
  void reset_to_file();

 signals:
  void wanted(skein::core::GainName gain, double value);

 private:
  GainSlider* slider(core::GainName gain) const { return sliders_[static_cast<std::size_t>(gain)]; }

  app::Experiment experiment_;
  std::array<GainSlider*, 3> sliders_{};
  QPushButton* reset_;
  MarginBars* margins_;
};

}  // namespace skein::ui
