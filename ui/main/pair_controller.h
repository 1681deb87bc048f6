#pragma once

#include <optional>

#include "core/control/gain_schedule.h"
#include "ui/main/messages.h"

namespace skein::ui {

class ArenaView;
class GainsPanel;

/// Gains and couplings of the run that is shown: sliders, the table of pairs, the lines in the arena.
class PairController final : public QObject {
  Q_OBJECT

 public:
  PairController(Runs& runs, const Messages& messages, GainsPanel* gains, ArenaView* arena, QObject* parent = nullptr);
  void refresh();  ///< five times a second, and whenever the present moment is moved
  /// Explains how to make room for a gain that this record holds at its limit.
  void explain(const app::TickRecord& record);

 private:
  void show_couplings();
  QString remedy(core::GainName gain, double wanted);
  QString remedy(core::GainName gain, std::size_t i, std::size_t j, double wanted);
  const core::ReferenceDemand& demand();

  Runs& runs_;
  const Messages& messages_;
  GainsPanel* gains_;
  ArenaView* arena_;
  std::optional<core::ReferenceDemand> demand_;  // of the live experiment, once it is needed
};

}  // namespace skein::ui
