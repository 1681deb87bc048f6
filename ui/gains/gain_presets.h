#pragma once

#include <QString>
#include <array>
#include <vector>

#include "app/experiment/experiment.h"

namespace skein::ui {

/// A set of coupling gains under a name, one value for all pairs each, in the order of `core::gain_names`.
struct GainPreset {
  QString name;
  std::array<double, 3> values{};
  bool own = false;  ///< the operator's: it can be forgotten
};

/// The file's, the paper's, none, half and twice the file's; then what the operator has kept.
std::vector<GainPreset> gain_presets(const app::Experiment& experiment);
/// Saves a preset; one of the same name is replaced.
void keep_gain_preset(const GainPreset& preset);
void forget_gain_preset(const QString& name);

}  // namespace skein::ui
