#pragma once

namespace skein::app {

/// Two cameras over one floor whose calibrations disagree in known ways: how far the second one's poses are off before
/// and after `skein calibrate joint`. Returns an ExitStatus: expectation_failed where a goal is missed.
int bench_joint();

}  // namespace skein::app
