#include "ui/run/player.h"

#include <algorithm>

namespace skein::ui {
namespace {

constexpr int frame_ms = 33;

std::size_t rows_until(const app::RecordedRun& run, double t) {
  const auto after = std::partition_point(run.rows.begin(), run.rows.end(),
                                          [&](const app::TickRecord& row) { return row.t <= t + 1e-9; });
  return static_cast<std::size_t>(after - run.rows.begin());
}

}  // namespace

Player::Player(QObject* parent) : QObject(parent) {
  timer_.setTimerType(Qt::PreciseTimer);
  connect(&timer_, &QTimer::timeout, this, &Player::look);
}

void Player::load(Run run) {
  pause();
  run_ = std::move(run);
  next_ = 0;
  t_ = run_ ? first_time() : 0.0;
}

void Player::play() {
  if (!run_) return;
  if (t_ >= last_time()) seek(first_time());
  playing_ = true;
  since_.start();
  timer_.start(frame_ms);
}

void Player::pause() {
  playing_ = false;
  timer_.stop();
}

void Player::set_speed(double speed) {
  speed_ = speed;
}

void Player::look() {
  t_ = std::min(last_time(), t_ + speed_ * 1e-3 * static_cast<double>(since_.restart()));
  hand_on(rows_until(*run_, t_));
  if (t_ >= last_time()) pause();
  emit moved();
}

void Player::hand_on(std::size_t end) {
  for (; next_ < end; ++next_) emit record_taken(run_->rows[next_]);
}

void Player::step(int ticks) {
  if (!run_) return;
  pause();
  const auto last = static_cast<std::ptrdiff_t>(run_->rows.size()) - 1;
  const auto row = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(next_) - 1 + ticks, 0, last);
  seek(run_->rows[static_cast<std::size_t>(row)].t);
}

void Player::seek(double t) {
  if (!run_) return;
  t_ = std::clamp(t, first_time(), last_time());
  const std::size_t end = std::max<std::size_t>(1, rows_until(*run_, t_));
  next_ = std::min(end - 1, rows_until(*run_, t_ - memory));
  hand_on(end);
  emit moved();
}

}  // namespace skein::ui
