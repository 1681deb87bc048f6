#pragma once

#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/experiment/problem.h"

namespace skein::app {

/// The same experiment without its hardware: emulated robots of the same types in place of the real ones, and rendered
/// pictures, with the same latency, in place of those of real cameras and films. Its name says that it is a rehearsal.
/// An experiment without hardware stays unchanged. Problems: those of its file with these keys changed.
tl::expected<Experiment, std::vector<Problem>> rehearsal(const Experiment& experiment);

}  // namespace skein::app
