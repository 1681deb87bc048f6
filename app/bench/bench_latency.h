#pragma once

namespace skein::app {

/// The results of `skein camera latency` for stamps that are late by a known time, in lock-step with emulated robots,
/// and the mean distance of a robot at 0.13 m/s from its predicted place: without the correction, and with the latency
/// that was found. On stdout. Returns an ExitStatus: expectation_failed if a latency is off by more than 1 ms, or a
/// distance of 0.3 mm or more remains.
int bench_latency();

}  // namespace skein::app
