#include "ui/run/live_session.h"

#include <chrono>
#include <cstdio>
#include <exception>
#include <utility>

#include "app/run/output.h"

namespace skein::ui {
namespace {

constexpr int frame_ms = 32;         // the screen's pace: faster than the eye minds, far slower than the machine can
constexpr int looks_per_status = 8;  // links change slowly, and asking for them makes strings
constexpr int rest_ms = 500;         // after the end of a run its last row has reached the recorder

/// A recording whose session is gone. There is nobody left to tell but the terminal.
void complete(app::CsvRecorder* recorder) {
  try {
    if (recorder) recorder->end();
  } catch (const std::exception& error) {
    app::complain(error.what());
  }
}

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

void LiveSession::open(const app::Experiment& experiment, bool start_at_once, const QString& video) {
  if (is_busy()) return;
  stop();
  experiment_ = experiment;
  start_at_once_ = start_at_once;
  stop_asked_ = false;
  close_asked_ = false;
  latest_.reset();
  robots_.clear();
  failure_.reset();
  film_is_broken_ = false;
  history_.clear();
  app::SessionOptions options;
  options.pictures = experiment.camera.kind() != app::CameraKind::absent;
  options.guard = true;
  const auto last_recorder = std::exchange(recorder_, std::make_shared<app::CsvRecorder>());
  record_file_.clear();
  options.sinks = {recorder_.get()};
  options.video = video.toStdString();
  changing_ = std::async(std::launch::async,
                         [old = std::move(session_), last_recorder, experiment, options,
                          recorder = recorder_]() mutable -> std::optional<Opened> {
                           if (old) old->close();
                           complete(last_recorder.get());
                           old.reset();  // before the new one: both want the same camera and robots
                           try {
                             return app::Session::open(experiment, app::Session::Clock::wall, options);
                           } catch (const std::exception& error) {
                             return tl::unexpected(std::string(error.what()));
                           }
                         });
}

void LiveSession::close() {
  close_asked_ = true;
  end();
}

void LiveSession::end() {
  stop();
  if (is_busy()) return;  // `settle` goes on from there
  latest_.reset();
  robots_.clear();
  record_file_.clear();
  history_.clear();
  changing_ = std::async(std::launch::async,
                         [old = std::move(session_), recorder = recorder_]() mutable -> std::optional<Opened> {
                           if (old) old->close();
                           complete(recorder.get());
                           old.reset();
                           return std::nullopt;
                         });
}

QString LiveSession::close_now() {
  stop();
  if (changing_.valid()) changing_.wait();
  settle();
  if (!session_) return {};
  session_->close();
  take_robots();
  return record_file_.isEmpty() ? QString() : record_to({});
}

void LiveSession::settle() {
  if (!changing_.valid() || changing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  std::optional<Opened> result = changing_.get();
  if (!result) {
    if (close_asked_) emit closed();
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
  if (wanted_speed_ != 1.0) set_speed(wanted_speed_);
  emit opened();
  if (stop_asked_) {
    session_->stop();
  } else if (start_at_once_) {
    start();
  }
}

void LiveSession::look() {
  constexpr double noticed = 1.0;  // the window's thread stood still for longer than this [s]
  const double away = since_look_.isValid() ? 1e-3 * static_cast<double>(since_look_.restart()) : 0.0;
  if (!since_look_.isValid()) since_look_.start();
  if (away > noticed && session_) emit was_away(away);
  settle();
  if (session_) {
    session_->drain([this](const app::TickRecord& record) {
      latest_ = record;
      history_.add(record);
      emit record_taken(record);
    });
    if (++looks_ % looks_per_status == 0) take_robots();
    if (const auto tested = session_->wheel_check()) {
      if (*tested)
        emit robot_tested(**tested);
      else
        emit test_failed(QString::fromStdString(tested->error()));
    }
    finish_recording();
  }
  emit frame();
}

void LiveSession::finish_recording() {
  const bool over = phase() == app::Phase::stopped || phase() == app::Phase::finished;
  if (!over || record_file_.isEmpty()) return since_over_.invalidate();
  if (!since_over_.isValid()) since_over_.start();
  if (!since_over_.hasExpired(rest_ms)) return;
  const QString file = record_file_;
  emit recorded(file, record_to({}));
}

void LiveSession::take_robots() {
  robots_ = session_->robots();
  const app::VideoStatus video = session_->video();
  if (!video.problem.empty() && !std::exchange(film_is_broken_, true))
    emit film_failed(QString::fromStdString(video.problem));
  if (const auto why = session_->failure()) failure_ = QString::fromStdString(*why);
}

void LiveSession::answer(const app::Session::Answer& done) {
  if (!done) emit refused(QString::fromStdString(done.error()));
}

void LiveSession::start() {
  if (!session_) return;
  emit starting();
  answer(session_->start());
}

void LiveSession::stage() {
  if (session_) answer(session_->stage());
}

void LiveSession::pause() {
  if (session_) answer(session_->pause());
}

void LiveSession::resume() {
  if (session_) answer(session_->resume());
}

void LiveSession::stop() noexcept {
  if (session_) session_->stop();
  if (!stop_asked_) since_stop_.start();
  stop_asked_ = true;
}

QString LiveSession::step() {
  if (!session_) return tr("No session is open.");
  if (phase() == app::Phase::ready) emit starting();
  const auto done = session_->step();
  return done ? QString() : QString::fromStdString(done.error());
}

QString LiveSession::set_speed(double speed) {
  wanted_speed_ = speed;
  if (!session_) return {};
  const auto done = session_->set_speed(speed);
  return done ? QString() : QString::fromStdString(done.error());
}

QString LiveSession::real_time_reason() const {
  return QString::fromStdString(app::real_time_reason(experiment_).value_or(std::string()));
}

QString LiveSession::record_to(const QString& file) {
  if (!recorder_) return tr("No session is open.");
  try {
    record_file_.clear();
    recorder_->end();
    if (file.isEmpty()) return {};
    recorder_->begin(file.toStdString(), experiment_, history_.rows());
    record_file_ = file;
    return {};
  } catch (const std::exception& error) {
    return QString::fromStdString(error.what());
  }
}

void LiveSession::set_gain(core::GainName name, double value, double seconds) {
  if (session_) answer(session_->set_gain(name, value, seconds));
}

double LiveSession::gain_border(core::GainName name) const {
  return session_ ? session_->gain_border(name) : 0.0;
}

void LiveSession::set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds) {
  if (session_) answer(session_->set_gain(name, i, j, value, seconds));
}

void LiveSession::couple(std::size_t i, std::size_t j, bool on) {
  if (session_) answer(session_->couple(i, j, on));
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

tl::expected<void, std::string> LiveSession::test_robot(std::size_t robot) {
  if (!session_) return tl::unexpected(tr("No session is open.").toStdString());
  return session_->check_wheels(robot);
}

std::optional<QString> LiveSession::unguarded() const {
  const auto why = session_ ? session_->unguarded() : std::nullopt;
  return why ? std::optional(QString::fromStdString(*why)) : std::nullopt;
}

QStringList LiveSession::alarms() {
  QStringList all;
  if (!session_) return all;
  for (const std::string& sentence : session_->alarms()) all << QString::fromStdString(sentence);
  return all;
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
