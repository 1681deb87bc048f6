#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::app {

/// The text of the experiment with the operator's actions in a run of it as [[operator]] tables: `skein run` repeats
/// them at the same times. `rows`: of the run, in order. Robots that stood elsewhere at its start are put there at t =
/// 0.
std::string text_as_done(const Experiment& experiment, const std::vector<const TickRecord*>& rows);

/// The text with other gains in [controller.gains]: a number if all pairs have the same, else every pair's. The error
/// names the gain that cannot be written, and the reason.
tl::expected<std::string, std::string> text_with_gains(std::string text, const core::CouplingGains& gains);

}  // namespace skein::app
