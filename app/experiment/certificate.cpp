#include "app/experiment/certificate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace skein::app {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

void keep_smallest(Certificate::Worst& worst, double value, double t) noexcept {
  if (value < worst.value) worst = {value, t};
}
void keep_largest(Certificate::Worst& worst, double value, double t) noexcept {
  if (value > worst.value) worst = {value, t};
}

void keep_smallest(Certificate::Theorem::Least& least, double value, double t, std::size_t robot) noexcept {
  if (value < least.value) least = {value, t, robot};
}

/// Whether (18f, g) bound the law's commands by (14).
bool keeps_limits(core::Coupling coupling) noexcept {
  switch (coupling) {
    case core::Coupling::paper:
      return false;
    case core::Coupling::bounded:
      return true;
  }
  return false;
}

/// Since when each case of the theorem has held without a break, and the least velocities since then.
class CaseWatch {
 public:
  CaseWatch(double v_max, double omega_max) : nothing_v_(nothing * v_max), nothing_omega_(nothing * omega_max) {}

  void see(double t, std::span<const core::Twist> twists) {
    for (std::size_t i = 0; i < twists.size(); ++i) {
      const double v = std::abs(twists[i].v), omega = std::abs(twists[i].omega);
      keep_smallest(v_.least, v, t, i);
      keep_smallest(omega_.least, omega, t, i);
      see(v_, v > nothing_v_, v, t, i);
      see(omega_, omega > nothing_omega_, omega, t, i);
    }
  }

  Certificate::Theorem found(bool continuous_omega) const {
    using Case = Certificate::Theorem::Case;
    Certificate::Theorem theorem{v_.least, omega_.least, continuous_omega, 0.0, Case::neither};
    const auto take = [&](Case holds, const Since& since, auto& least) {
      theorem.holds = holds;
      theorem.from = since.from;
      least = since.after;
    };
    if (v_.after.value < infinite)
      take(Case::moving, v_, theorem.v);
    else if (omega_.after.value < infinite && continuous_omega)
      take(Case::stopping, omega_, theorem.omega);
    return theorem;
  }

 private:
  static constexpr double nothing = 1e-3;  // of a limit: between two ticks it may be a little smaller than at both

  struct Since {
    double from = 0.0;  // [s]
    Certificate::Theorem::Least least{infinite, 0.0, 0}, after{infinite, 0.0, 0};
  };
  static void see(Since& since, bool nonzero, double value, double t, std::size_t robot) {
    if (!nonzero) {
      since.from = std::nextafter(t, infinite);  // later than this tick
      since.after = {infinite, 0.0, 0};
    } else if (t >= since.from) {
      keep_smallest(since.after, value, t, robot);
    }
  }

  double nothing_v_, nothing_omega_;
  Since v_, omega_;
};

/// The ticks at which to look. A reference that repeats is the same in every lap between two changes: the first after
/// the one and the last before the other stand for all.
class Course {
 public:
  explicit Course(const Experiment& e) : rate_(e.rate), lap_(longest_lap(e)) {
    const double settle = 2.0 * e.period();  // a ramp begins and ends at ticks
    for (const GainChange& change : e.gain_changes) changes_.push_back({change.t, change.t + change.ramp + settle});
    for (const ReferenceChange& change : e.reference.changes)
      changes_.push_back({change.t, change.t + change.duration + settle});
    if (e.reference.kind == ReferenceSpec::Kind::independent)
      for (const RobotSpec& robot : e.robots)
        if (const double end = make_trajectory(robot.trajectory.value_or(TrajectorySpec{}), e.reference)->end();
            end < infinite)
          changes_.push_back({0.0, end + settle});
    changes_.push_back({e.duration, e.duration});
    std::sort(changes_.begin(), changes_.end(), [](const Change& a, const Change& b) { return a.from < b.from; });
  }

  std::int64_t next(std::int64_t k) {
    const double t = static_cast<double>(k) / rate_;
    for (; change_ < changes_.size() && changes_[change_].from <= t; ++change_)
      quiet_from_ = std::max(quiet_from_, changes_[change_].to);
    if (change_ == changes_.size() || t < quiet_from_ + lap_) return k + 1;
    return std::max(k + 1, static_cast<std::int64_t>(std::floor((changes_[change_].from - lap_) * rate_)));
  }

 private:
  struct Change {
    double from, to;  // [s]
  };

  /// In which every robot has been everywhere; infinite where it does not repeat. [s]
  static double longest_lap(const Experiment& e) {
    const auto lap = [](const PathSpec& path, double speed) {
      return !path.closed ? infinite : speed > 0.0 ? make_path(path)->length() / speed : 0.0;
    };
    if (e.reference.kind != ReferenceSpec::Kind::independent) return lap(e.reference.path, e.reference.speed);
    double longest = 0.0;
    for (const RobotSpec& robot : e.robots) {
      const TrajectorySpec own = robot.trajectory.value_or(TrajectorySpec{});
      if (make_trajectory(own, e.reference)->end() < infinite) continue;  // it comes to rest
      longest = std::max(longest, own.from_rest_to_rest() ? infinite      // it turns on the spot then
                                                          : lap(own.path, own.speed.value_or(e.reference.speed)));
    }
    return longest;
  }

  double rate_, lap_, quiet_from_ = 0.0;
  std::vector<Change> changes_;
  std::size_t change_ = 0;  // the first that has not begun
};

/// The severest velocities of one robot's reference under the same gains: every margin grows smaller with |v_ref| and
/// with |omega_ref|, so that one that is as slow in both as an earlier one says nothing new.
class Severest {
 public:
  void clear() { seen_.clear(); }
  bool see(const core::Twist& twist) {
    const double v = std::abs(twist.v), omega = std::abs(twist.omega);
    is_new_ = std::none_of(seen_.begin(), seen_.end(), [&](const auto& s) { return v <= s.v && omega <= s.omega; });
    if (!is_new_) return false;
    std::erase_if(seen_, [&](const auto& s) { return s.v <= v && s.omega <= omega; });
    seen_.push_back({v, omega});
    return true;
  }
  bool is_new() const { return is_new_; }  ///< the one seen last

 private:
  std::vector<core::Twist> seen_;
  bool is_new_ = false;
};

std::string as_text(const Certificate::Theorem& theorem) {
  using Case = Certificate::Theorem::Case;
  const std::string v =
      fmt::format("{:.4g} m/s, robot {} at t = {:g} s", theorem.v.value, theorem.v.robot + 1, theorem.v.t);
  const std::string omega = fmt::format("{:.4g} rad/s, robot {} at t = {:g} s", theorem.omega.value,
                                        theorem.omega.robot + 1, theorem.omega.t);
  const std::string from = theorem.from > 0.0 ? fmt::format(" from t = {:.4g} s on", theorem.from) : "";
  switch (theorem.holds) {
    case Case::moving:
      return fmt::format("case 1{}, v_ref is nonzero (smallest: {}), bounded and uniformly continuous", from, v);
    case Case::stopping:
      return fmt::format(
          "case 2{}, v_ref vanishes ({}) while omega_ref is nonzero (smallest: {}) and uniformly continuous", from, v,
          omega);
    case Case::neither:
      break;
  }
  return fmt::format(
      "does not apply: v_ref vanishes ({}), which violates case 1, and omega_ref {}, which violates case 2; errors "
      "stay bounded but need not converge to zero",
      v, theorem.continuous_omega ? fmt::format("vanishes ({})", omega) : "jumps along the path");
}

std::array<std::pair<core::PairTable*, core::GainName>, core::pair_names.size()> parts_of(core::Gains& g) {
  using Name = core::GainName;
  return {{{&g.k_xx, Name::k_xx},
           {&g.k_tt, Name::k_tt},
           {&g.k_yy, Name::k_yy},
           {&g.c_xx, Name::c_xx},
           {&g.c_tt, Name::c_tt},
           {&g.c_yy, Name::c_yy},
           {&g.l_xx, Name::l_xx},
           {&g.l_tt, Name::l_tt}}};
}

void put(core::CouplingGains now, core::Gains& gains) {
  for (const auto& [target, name] : parts_of(gains)) *target = core::table(now, name);
}

void begin(const GainChange& change, core::GainSchedule& schedule, double ramp) {
  for (const core::GainName name : core::pair_names)
    if (change[name]) schedule.ramp(name, *change[name], ramp);
}

void put(const core::TrackingGains& now, core::Gains& gains) {
  if (gains.policy != core::GainPolicy::fixed) return;
  gains.k_x = now[core::TrackingGain::k_x];
  gains.k_theta = now[core::TrackingGain::k_theta];
}

/// The gains at the start, and those that each change leads to.
std::vector<core::Gains> all_gains(const Experiment& experiment) {
  std::vector<core::Gains> all{make_gains(experiment)};
  core::GainSchedule schedule(experiment.controller.gains);
  core::TrackingSchedule tracking(make_tracking(experiment));
  for (const GainChange& change : experiment.gain_changes) {
    begin(change, schedule, 0.0);
    schedule.step(experiment.period());
    tracking.ramp(change.tracking, 0.0);
    all.push_back(all.front());
    put(schedule.now(), all.back());
    put(tracking.target(), all.back());
  }
  return all;
}

/// The loop with the smallest delay margin: of which robot, where along its reference, with which gains.
struct WeakestLoop {
  Certificate::Delay delay;
  core::Gains gains{};
  core::Twist reference{};
};

WeakestLoop weakest_loop(const Experiment& experiment, const std::stop_token& stop) {
  constexpr int samples = 500;
  const std::unique_ptr<const core::Reference> reference = make_reference(experiment);
  const std::size_t n = experiment.robots.size();

  // Of every robot the straightest, the tightest and the fastest piece, once each: they are mostly the same for all.
  struct Place {
    core::Twist twist;
    double t;
    std::size_t robot;
  };
  std::vector<Place> places;
  const auto add = [&](const Place& place) {
    const auto same = [&](const Place& p) {
      return std::abs(p.twist.v - place.twist.v) < 1e-9 &&
             std::abs(std::abs(p.twist.omega) - std::abs(place.twist.omega)) < 1e-9;
    };
    if (std::none_of(places.begin(), places.end(), same)) places.push_back(place);
  };
  for (std::size_t i = 0; i < n; ++i) {
    Place straight{reference->at(i, 0.0).twist, 0.0, i}, tight = straight, fast = straight;
    for (int k = 1; k < samples; ++k) {
      const double t = experiment.duration * k / samples;
      const Place place{reference->at(i, t).twist, t, i};
      const auto turn = [](const Place& p) { return std::abs(p.twist.omega); };
      if (turn(place) < turn(straight)) straight = place;
      if (turn(place) > turn(tight)) tight = place;
      if (place.twist.v > fast.twist.v) fast = place;
    }
    for (const Place& place : {straight, tight, fast}) add(place);
  }
  WeakestLoop least;
  least.delay.margin = {infinite, true};
  for (core::Gains& gains : all_gains(experiment))
    for (const Place& place : places) {
      if (stop.stop_requested()) return least;
      core::use_policy(gains, std::vector<core::Twist>(n, place.twist));
      const core::DelayMargin margin = core::delay_margin(gains, place.robot, place.twist, experiment.period());
      if (margin.delay < least.delay.margin.delay) least = {{margin, place.t, place.robot}, gains, place.twist};
    }
  return least;
}

/// At delays a little, and two and four times, beyond its margin.
std::vector<Certificate::Swing> swings(const WeakestLoop& loop, double period) {
  std::vector<Certificate::Swing> result;
  if (loop.delay.margin.unbounded) return result;
  const double beyond = 1.1 * loop.delay.margin.delay;
  for (const double delay : {beyond, std::max(0.1, 2.0 * beyond), std::max(0.2, 4.0 * beyond)})
    result.push_back({delay, core::swing(loop.gains, loop.delay.robot, loop.reference, period, delay)});
  return result;
}

}  // namespace

bool Certificate::holds() const noexcept {
  constexpr double rounding = -1e-12;
  return std::all_of(robots.begin(), robots.end(), [](const Robot& r) {
    return r.k_x.value > 0.0 && r.k_theta.value > 0.0 && r.b.value >= 0.0 && r.f.value >= rounding &&
           r.g.value >= rounding && r.v.value < 1.0 && r.omega.value < 1.0 && r.wheel.value <= 1.0;
  });
}

bool Certificate::reference_fits() const noexcept {
  return std::all_of(robots.begin(), robots.end(),
                     [](const Robot& r) { return r.v.value < 1.0 && r.omega.value < 1.0 && r.wheel.value <= 1.0; });
}

bool Certificate::keeps_tracking() const noexcept {
  constexpr double rounding = 1e-9;
  return std::all_of(robots.begin(), robots.end(), [&](const Robot& r) {
    return r.k_x.value >= (core::tracking_share - rounding) * r.v_max &&
           r.k_theta.value >= (core::tracking_share - rounding) * r.omega_max;
  });
}

Certificate certify(const Experiment& experiment, const std::stop_token& stop) {
  const std::unique_ptr<const core::Reference> reference = make_reference(experiment);
  core::Gains gains = make_gains(experiment);
  core::GainSchedule schedule(experiment.controller.gains);
  core::TrackingSchedule tracking(make_tracking(experiment));
  const std::size_t n = experiment.robots.size();

  Certificate certificate;
  certificate.fixed = gains.policy == core::GainPolicy::fixed;
  certificate.v_max = experiment.controller.v_max;
  certificate.omega_max = experiment.controller.omega_max;
  certificate.rate = experiment.rate;
  if (const LawSpec& law = experiment.controller.law; !law.of_the_paper())
    certificate.other_law = law.own() ? law.command + law.library : std::string(word(law.kind));
  certificate.coupling = gains.coupling;
  Certificate::Robot start;
  start.k_x.value = start.k_theta.value = start.b.value = start.f.value = start.g.value = infinite;
  start.v.value = start.omega.value = start.wheel.value = -infinite;
  certificate.robots.assign(n, start);
  for (std::size_t i = 0; i < n; ++i)
    certificate.robots[i].v_max = gains.v_max[i], certificate.robots[i].omega_max = gains.omega_max[i];

  CaseWatch cases(certificate.v_max, certificate.omega_max);

  std::vector<core::ReferencePoint> points(n);
  std::vector<core::Twist> twists(n);
  std::vector<Severest> severest(n);
  bool gains_move = true;  // at the start they have not been looked at yet
  std::size_t next_change = 0;
  Course course(experiment);
  for (std::int64_t k = 0; k < experiment.ticks() && !stop.stop_requested(); k = course.next(k)) {
    const double t = static_cast<double>(k) / experiment.rate;
    for (; next_change < experiment.gain_changes.size() && t >= experiment.gain_changes[next_change].t; ++next_change) {
      const GainChange& change = experiment.gain_changes[next_change];
      begin(change, schedule, change.ramp);
      tracking.ramp(change.tracking, change.ramp);
      gains_move = true;
    }
    if (gains_move) {
      if (k > 0) schedule.step(experiment.period()), tracking.step(experiment.period());
      put(schedule.now(), gains);
      put(tracking.now(), gains);
      certificate.coupled = certificate.coupled || gains.k_xx.largest() > 0.0 || gains.k_tt.largest() > 0.0;
      for (Severest& robot : severest) robot.clear();
      gains_move = !(schedule.now() == schedule.target() && tracking.now() == tracking.target());
    }
    reference->at(t, points);
    bool any = false;
    for (std::size_t i = 0; i < n; ++i) {
      twists[i] = points[i].twist;
      any = severest[i].see(twists[i]) || any;
    }
    cases.see(t, twists);
    if (!any) continue;
    core::use_policy(gains, twists);
    for (std::size_t i = 0; i < n; ++i) {
      if (!severest[i].is_new()) continue;
      Certificate::Robot& robot = certificate.robots[i];
      const core::CommandLimits limits = make_limits(experiment, i);
      const double v = std::abs(twists[i].v), omega = std::abs(twists[i].omega);
      keep_smallest(robot.k_x, gains.k_x[i], t);
      keep_smallest(robot.k_theta, gains.k_theta[i], t);
      const core::Margins margins = core::margins(gains, i, twists[i]);
      keep_smallest(robot.b, margins.b, t);
      keep_smallest(robot.f, margins.f, t);
      keep_smallest(robot.g, margins.g, t);
      keep_largest(robot.v, v / limits.v_max, t);
      keep_largest(robot.omega, omega / limits.omega_max, t);
      keep_largest(robot.wheel, (v + 0.5 * limits.drive.track * omega) / limits.drive.max_wheel_speed(), t);
    }
  }
  certificate.theorem = cases.found(reference->smooth());
  const WeakestLoop weakest = weakest_loop(experiment, stop);
  certificate.delay = weakest.delay;
  certificate.swings = swings(weakest, experiment.period());
  return certificate;
}

Certificate::Delay smallest_delay_margin(const Experiment& experiment, const std::stop_token& stop) {
  return weakest_loop(experiment, stop).delay;
}

std::string as_lines(const Certificate& certificate) {
  std::string text;
  for (std::size_t i = 0; i < certificate.robots.size(); ++i) {
    const Certificate::Robot& r = certificate.robots[i];
    if (!certificate.other_law.empty()) {
      text += fmt::format(
          "robot_{}_reference: at most {:.0f} % of v_max, {:.0f} % of omega_max, {:.0f} % of a wheel (t = {:g} s)\n",
          i + 1, 100.0 * r.v.value, 100.0 * r.omega.value, 100.0 * r.wheel.value, r.wheel.t);
      continue;
    }
    text += fmt::format("robot_{}_smallest_k_x: {:.4g} m/s ({:.0f} % of v_max) at t = {:g} s\n", i + 1, r.k_x.value,
                        100.0 * r.k_x.value / r.v_max, r.k_x.t);
    text += fmt::format("robot_{}_smallest_k_theta: {:.4g} rad/s ({:.0f} % of omega_max) at t = {:g} s\n", i + 1,
                        r.k_theta.value, 100.0 * r.k_theta.value / r.omega_max, r.k_theta.t);
    if (certificate.fixed) {
      text += fmt::format("robot_{}_smallest_margin_f: {:.4g} m/s at t = {:g} s\n", i + 1, r.f.value, r.f.t);
      text += fmt::format("robot_{}_smallest_margin_g: {:.4g} rad/s at t = {:g} s\n", i + 1, r.g.value, r.g.t);
    }
    text += fmt::format(
        "robot_{}_reference: at most {:.0f} % of v_max, {:.0f} % of omega_max, {:.0f} % of a wheel (t = {:g} s)\n",
        i + 1, 100.0 * r.v.value, 100.0 * r.omega.value, 100.0 * r.wheel.value, r.wheel.t);
  }
  if (!certificate.other_law.empty()) {
    text += fmt::format(
        "law: {}\ncertified: only the reference, which {}: theorem 1, (18) and the delay margin hold for "
        "(15) only; `skein check --controller` tests this law\n",
        certificate.other_law, certificate.reference_fits() ? "fits the robots" : "does NOT FIT the robots");
    return text;
  }
  text += fmt::format("theorem_1: {}\n", as_text(certificate.theorem));
  text += fmt::format(
      "theorem_1_silent: while a robot follows a modified reference, is shielded or limited, with delay and "
      "sampling{}; the CSV's mode says at which ticks\n",
      certificate.theorem.continuous_omega || certificate.fixed
          ? ""
          : ", and k_theta of (36) jumps wherever omega_ref does");
  text += fmt::format(
      "limits_14: {}\n",
      keeps_limits(certificate.coupling) || !certificate.coupled
          ? "follow from (18f, g)"
          : "do NOT follow from (18f, g) with coupling = \"paper\", whose terms are not bounded by k_xx and "
            "k_tt; commands are limited after the law, and V may then rise");
  text += fmt::format("delay_margin: {}{:.4g} s (robot {} at t = {:g} s)\n",
                      certificate.delay.margin.unbounded ? "more than " : "", certificate.delay.margin.delay,
                      certificate.delay.robot + 1, certificate.delay.t);
  if (!certificate.swings.empty()) {
    std::string sizes;
    for (const Certificate::Swing& s : certificate.swings)
      sizes += fmt::format("{}{:.2g} mm at {:.0f} ms", sizes.empty() ? "" : ", ", 1e3 * s.size, 1e3 * s.delay);
    text += fmt::format("swing: {}: beyond the margin errors do not settle, but stay bounded (without prediction)\n",
                        sizes);
  }
  text +=
      fmt::format("sampled_loop: {}\n",
                  certificate.sampled_loop_stable()
                      ? fmt::format("stable at {:g} Hz with a delay below the margin", certificate.rate)
                      : fmt::format("UNSTABLE at {:g} Hz even without delay: errors oscillate and do not converge; use "
                                    "smaller c_x, c_theta or k",
                                    certificate.rate));
  text +=
      fmt::format("tracking_authority: {}\n",
                  certificate.keeps_tracking()
                      ? fmt::format("at least {:.0f} % of v_max and omega_max", 100.0 * core::tracking_share)
                      : fmt::format("TOO SMALL: k_x or k_theta falls below {:.0f} % of v_max or omega_max, and errors "
                                    "hardly decrease; use a slower reference or smaller couplings",
                                    100.0 * core::tracking_share));
  text += fmt::format("conditions_18: {}\n", certificate.holds() ? "hold over the whole reference" : "VIOLATED");
  return text;
}

}  // namespace skein::app
