#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "app/experiment/experiment.h"
#include "core/control/delay_margin.h"

namespace skein::app {

/// The certificate of an experiment before it runs: the margins of (18) and of the actuators, at the worst point of the
/// whole reference and of the gains' changes.
struct Certificate {
  struct Worst {
    double value = 0.0;
    double t = 0.0;  ///< when [s]
  };
  struct Robot {
    Worst k_x;      ///< smallest k_x of (36) [m/s]; (18a) and (18f) require more than 0
    Worst k_theta;  ///< smallest k_theta of (36) [rad/s]; (18a) and (18g) require more than 0
    Worst b;        ///< smallest of its coupling parameters (18b)
    Worst f, g;     ///< smallest margins of (18f) [m/s] and (18g) [rad/s]: 0 where tracking gets all the authority
    Worst v;        ///< largest |v_ref| as a share of v_max
    Worst omega;    ///< largest |omega_ref| as a share of omega_max
    double v_max = 0.0, omega_max = 0.0;  ///< (14) of this robot
    Worst wheel;                          ///< largest |v_ref| + |omega_ref| track/2 as a share of a wheel's limit
  };
  /// The case of Theorem 1 to which the reference belongs, over the run. Every reference has bounded velocities, and a
  /// v_ref that is uniformly continuous.
  struct Theorem {
    enum class Case {
      moving,    ///< case 1: every v_ref is nonzero
      stopping,  ///< case 2: some v_ref vanishes, every omega_ref is nonzero and uniformly continuous
      neither,   ///< errors stay bounded, but need not converge to zero
    };
    struct Least {
      double value = 0.0;
      double t = 0.0;
      std::size_t robot = 0;
    };
    Least v;      ///< smallest |v_ref| [m/s], at its first occurrence
    Least omega;  ///< smallest |omega_ref| [rad/s]
    bool continuous_omega = true;
    double from =
        0.0;  ///< time from which that case holds; before it, references were still setting off or coming to rest [s]
    Case holds = Case::neither;
  };
  /// The smallest delay margin over all robots and places, with the gains of the start or of any of their
  /// changes.
  struct Delay {
    core::DelayMargin margin;
    double t = 0.0;  ///< where along the reference [s]
    std::size_t robot = 0;
  };
  /// How far the robot of the smallest margin swings there at a longer delay, if nothing predicts its pose.
  struct Swing {
    double delay = 0.0;  ///< [s]
    double size = 0.0;   ///< largest distance from its place, couplings aside [m]
  };
  std::vector<Robot> robots;
  Theorem theorem;
  Delay delay;
  std::vector<Swing> swings;  ///< with increasing delays; none where no delay is too long
  double v_max = 0.0, omega_max = 0.0;
  bool fixed = false;  ///< the tracking gains are given
  double rate = 0.0;   ///< at which the loop is sampled [Hz]
  /// Empty: the law is (15), and the whole certificate applies. Otherwise the law that drives: only the reference's
  /// demands on the robots are certified.
  std::string other_law;
  core::Coupling coupling = core::Coupling::paper;
  bool coupled = false;  ///< some k_xx or k_tt is above 0

  /// (18a-g) hold and the reference is inside the actuators' limits, everywhere.
  bool holds() const noexcept;
  /// The sampled loop is stable at least without delay. Continuous time, and so (18), does not exclude gains that are
  /// too large for the sampling.
  bool sampled_loop_stable() const noexcept { return delay.margin.delay > 0.0; }
  /// Tracking keeps `core::tracking_share` of v_max and omega_max, everywhere: (18a) alone allows too little to drive a
  /// robot.
  bool keeps_tracking() const noexcept;
  /// The reference is inside the actuators' limits, everywhere.
  bool reference_fits() const noexcept;
  /// All of these, as far as they apply to the law that drives.
  bool sound() const noexcept {
    return other_law.empty() ? holds() && sampled_loop_stable() && keeps_tracking() : reference_fits();
  }
};

/// Goes through the whole reference at the experiment's rate; of laps that are alike, through the first and the last.
/// If `stop` is requested, returns at once, with a certificate that is not valid.
Certificate certify(const Experiment& experiment, const std::stop_token& stop = {});

/// The smallest over all robots on the straightest, the tightest and the fastest part of their references.
Certificate::Delay smallest_delay_margin(const Experiment& experiment, const std::stop_token& stop = {});

/// As `key: value` lines.
std::string as_lines(const Certificate& certificate);

}  // namespace skein::app
