#include "ui/live_session.h"

#include <chrono>
#include <exception>
#include <utility>

namespace skein::ui {
namespace {

constexpr int frame_ms = 33;         // the screen's pace: faster than the eye minds, far slower than the machine can
constexpr int looks_per_status = 8;  // links change slowly, and asking for them makes strings

}  // namespace

LiveSession::LiveSession(QObject* parent) : QObject(parent) {
  timer_.setTimerType(Qt::PreciseTimer);
  connect(&timer_, &QTimer::timeout, this, &LiveSession::look);
  timer_.start(frame_ms);
}

LiveSession::~LiveSession() {
  stop();
  if (changing_.valid()) changing_.wait();
}

void LiveSession::open(const app::Experiment& experiment, bool start_at_once) {
  if (is_busy()) return;
  stop();
  experiment_ = experiment;
  start_at_once_ = start_at_once;
  stop_asked_ = false;
  close_asked_ = false;
  latest_.reset();
  robots_.clear();
  failure_.reset();
  history_.clear();
  app::SessionOptions options;
  options.pictures = experiment.camera.source != "none";
  options.guard = true;
  changing_ = std::async(std::launch::async,
                         [old = std::move(session_), experiment, options]() mutable -> std::optional<Opened> {
                           if (old) old->close();
                           old.reset();  // before the new one: both want the same camera and robots
                           try {
                             return app::Session::open(experiment, app::Session::Clock::wall, options);
                           } catch (const std::exception& error) {
                             return tl::unexpected(std::string(error.what()));
                           }
                         });
}

void LiveSession::close() {
  stop();
  close_asked_ = true;
  if (is_busy()) return;  // `settle` goes on from there
  changing_ = std::async(std::launch::async, [old = std::move(session_)]() mutable -> std::optional<Opened> {
    if (old) old->close();
    old.reset();
    return std::nullopt;
  });
}

void LiveSession::settle() {
  if (!changing_.valid() || changing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  std::optional<Opened> result = changing_.get();
  if (!result) {
    emit closed();
    return;
  }
  if (!result->has_value()) {
    failure_ = QString::fromStdString(result->error());
    if (close_asked_)
      emit closed();
    else
      emit open_failed(*failure_);
    return;
  }
  session_ = std::move(result->value());
  if (close_asked_) {
    close();
    return;
  }
  take_robots();
  if (stop_asked_) {
    session_->stop();
  } else if (start_at_once_) {
    session_->start();
  }
  emit opened();
}

void LiveSession::look() {
  settle();
  if (session_) {
    session_->drain([this](const app::TickRecord& record) {
      latest_ = record;
      history_.add(record);
      emit record_taken(record);
    });
    if (++looks_ % looks_per_status == 0) take_robots();
  }
  emit frame();
}

void LiveSession::take_robots() {
  robots_ = session_->robots();
  if (const auto why = session_->failure()) failure_ = QString::fromStdString(*why);
}

void LiveSession::start() {
  if (session_) session_->start();
}

void LiveSession::stage() {
  if (session_) session_->stage();
}

void LiveSession::pause() {
  if (session_) session_->pause();
}

void LiveSession::resume() {
  if (session_) session_->resume();
}

void LiveSession::stop() noexcept {
  if (session_) session_->stop();
  if (!stop_asked_) since_stop_.start();
  stop_asked_ = true;
}

void LiveSession::set_gain(core::GainName name, double value) {
  if (session_) session_->set_gain(name, value);
}

double LiveSession::gain_border(core::GainName name) const {
  return session_ ? session_->gain_border(name) : 0.0;
}

void LiveSession::set_gain(core::GainName name, std::size_t i, std::size_t j, double value) {
  if (session_) session_->set_gain(name, i, j, value);
}

void LiveSession::couple(std::size_t i, std::size_t j, bool on) {
  if (session_) session_->couple(i, j, on);
}

double LiveSession::gain(core::GainName name, std::size_t i, std::size_t j) const {
  return session_ ? session_->gain(name, i, j) : 0.0;
}

double LiveSession::gain_target(core::GainName name, std::size_t i, std::size_t j) const {
  return session_ ? session_->gain_target(name, i, j) : 0.0;
}

double LiveSession::gain_border(core::GainName name, std::size_t i, std::size_t j) const {
  return session_ ? session_->gain_border(name, i, j) : 0.0;
}

double LiveSession::gain_border_now(core::GainName name) const {
  return session_ && latest_ ? session_->gain_border(name, *latest_) : gain_border(name);
}

tl::expected<void, std::string> LiveSession::move_robot(std::size_t robot, const core::Pose& pose) {
  if (!session_) return tl::unexpected(tr("No session is open.").toStdString());
  return session_->move_robot(robot, pose);
}

tl::expected<void, std::string> LiveSession::kick_robot(std::size_t robot, double vx, double vy) {
  if (!session_) return tl::unexpected(tr("No session is open.").toStdString());
  return session_->kick_robot(robot, vx, vy);
}

tl::expected<void, std::string> LiveSession::hold_robot(std::size_t robot, bool hold) {
  if (!session_) return tl::unexpected(tr("No session is open.").toStdString());
  return session_->hold_robot(robot, hold);
}

tl::expected<void, std::string> LiveSession::put_obstacle(int number, const core::Obstacle& obstacle) {
  if (!session_) return tl::unexpected(tr("No session is open.").toStdString());
  if (number < 0) {
    const auto added = session_->add_obstacle(obstacle);
    return added ? tl::expected<void, std::string>() : tl::unexpected(added.error());
  }
  const auto k = static_cast<std::size_t>(number);
  return obstacle.radius > 0.0 ? session_->move_obstacle(k, obstacle) : session_->remove_obstacle(k);
}

}  // namespace skein::ui
