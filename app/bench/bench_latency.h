#pragma once

namespace skein::app {

/// What `skein camera latency` finds of stamps that are late by a known time, in lock-step with emulated robots, and
/// how far a robot at 0.13 m/s is from where it is predicted to be, in the mean: without the correction, and with what
/// was found. On stdout. Returns an ExitStatus: expectation_failed where a latency is found worse than to 1 ms, or 0.3
/// mm and more are left.
int bench_latency();

}  // namespace skein::app
