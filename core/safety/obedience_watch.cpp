#include "core/safety/obedience_watch.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"

namespace skein::core {
namespace {

/// So many sights in a row convince.
constexpr int convincing = 3;

}  // namespace

void ObedienceWatch::forget() noexcept {
  count_ = 0;
  stood_ = still_ = contradicted_ = 0;
  excused_until_ = Measurement::never;
}

bool ObedienceWatch::see(const Robot& robot, const PoseFilter& filter, const Measurement& newest) noexcept {
  constexpr double longest = 0.5;  // between the first and the newest [s]
  const bool seen_anew = add(robot, filter, newest);
  stuck_ = false;
  motion_.reset();
  if (robot.lost || count_ < frames) return false;
  const Measurement& first = first_sight();
  const double seconds = newest.captured_at - first.captured_at;
  if (!(seconds > 0.0 && seconds < longest)) return false;
  const double turned = wrap_angle(newest.pose.theta - first.pose.theta);
  const double heading = first.pose.theta + 0.5 * turned;
  const double v =
      ((newest.pose.x - first.pose.x) * math::cos(heading) + (newest.pose.y - first.pose.y) * math::sin(heading)) /
      seconds;
  motion_ = Twist{v, turned / seconds};
  const bool changed =
      seen_anew && robot.judged && !(robot.now < excused_until_) && judge(robot, filter, first, newest, v);
  stuck_ = stood_ >= convincing || still_ >= convincing;
  return changed;
}

/// Adds a sight; false: it is not new. A jump is a move by hand, and begins anew: robots may be moved by hand while
/// none drives.
bool ObedienceWatch::add(const Robot& robot, const PoseFilter& filter, const Measurement& newest) noexcept {
  const Measurement& before = newest_sight();
  if (count_ > 0 && !(before.captured_at < newest.captured_at)) return false;
  if (count_ > 0) {
    const Pose expected = filter.predict(before, newest.captured_at);
    const double jump = distance(expected, newest.pose);
    const double turn = std::abs(wrap_angle(expected.theta - newest.pose.theta));
    if (jump > robot.kidnap + trusted_deviations * (before.sigma_xy + newest.sigma_xy) ||
        turn > robot.kidnap / robot.to_wheel + trusted_deviations * (before.sigma_theta + newest.sigma_theta))
      count_ = 0, contradicted_ = 0;
  }
  blind_[count_ % frames] = robot.blind_way;
  seen_[count_++ % frames] = newest;
  return true;
}

bool ObedienceWatch::judge(const Robot& robot, const PoseFilter& filter, const Measurement& first,
                           const Measurement& newest, double v) noexcept {
  constexpr double contrary = 0.04;     // between expected and measured velocity, of its middle or of a wheel [m/s]
  constexpr double turns_little = 0.3;  // [rad/s]
  const double noise = trusted_deviations * (first.sigma_xy + newest.sigma_xy);
  const double blind = *std::max_element(blind_.begin(), blind_.end());
  const Pose expected = filter.predict(first, newest.captured_at);
  const double off = distance(expected, newest.pose);
  const double off_angle = std::abs(wrap_angle(expected.theta - newest.pose.theta));
  const double turned = std::abs(wrap_angle(newest.pose.theta - first.pose.theta));
  const double seconds = newest.captured_at - first.captured_at;
  const double noise_angle = trusted_deviations * (first.sigma_theta + newest.sigma_theta);
  const double little = noise_angle + turns_little * seconds;
  const bool drives = std::abs(v) >= too_slow, turns = turned > little;
  // A robot that reverses stands on average, but one that stands differs by no more than its commanded speed.
  const bool reverses = off > noise + distance(first.pose, expected);
  const bool otherwise = ((drives || reverses) && off > noise + blind + contrary * seconds) ||
                         (turns && off_angle > noise_angle + (blind + contrary * seconds) / robot.to_wheel);
  // Told to stand, or to creep, it shows nothing: what was found holds until it is seen to drive, or to turn. One that
  // turns by itself on the spot does not drive.
  const auto count = [](int& times, bool stays, bool moves) {
    if (stays)
      ++times;
    else if (moves || times < convincing)
      times = 0;
  };
  count(stood_, !drives && off > noise + blind + too_slow * seconds, drives);
  count(still_, !drives && !turns && off_angle > little + blind / robot.to_wheel, drives || turns);
  contradicted_ = (disobeys_ ? !drives && !turns : otherwise) ? contradicted_ + 1 : 0;
  if (contradicted_ < convincing) return false;
  contradicted_ = 0;
  disobeys_ = !disobeys_;
  return true;
}

}  // namespace skein::core
