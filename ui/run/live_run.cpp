#include "ui/run/live_run.h"

#include <chrono>
#include <cstdio>
#include <exception>
#include <utility>

#include "app/run/output.h"

namespace skein::ui {
namespace {

constexpr int frame_ms = 32;    // the screen's pace: faster than the eye minds, far slower than the machine can
constexpr int rest_ms = 500;    // after the end of a run its last row has reached the recorder
constexpr int stand_ms = 3000;  // by then its robots have had a fair chance to acknowledge their stop

/// A recording whose session is gone. There is nobody left to tell but the terminal.
void complete(app::CsvRecorder* recorder) {
  try {
    if (recorder) recorder->end();
  } catch (const std::exception& error) {
    app::complain(error.what());
  }
}

}  // namespace

/// A session that is being left, on a thread aside: robots and files take their time.
struct LiveRun::Left {
  std::shared_ptr<app::CsvRecorder> recorder;
  std::shared_ptr<app::RunKeeper> keeper;
  std::unique_ptr<app::Session> session;  // null: there was none; goes before the sinks
  app::Phase end;
  app::Experiment experiment;
  std::string film_that_goes;  // empty: none
  std::promise<app::SessionFacts> facts;

  void close() {
    if (session) {
      session->close();
      facts.set_value(app::facts_of(*session, end));
    }
    complete(recorder.get());
    session.reset();  // before a new one: both want the same camera and robots
    if (!film_that_goes.empty()) app::remove_film(experiment, film_that_goes);
  }
};

LiveRun::LiveRun(QObject* parent) : RunSource(parent) {
  timer_.setTimerType(Qt::PreciseTimer);
  connect(&timer_, &QTimer::timeout, this, &LiveRun::poll);
  timer_.start(frame_ms);
  clock_.start();
}

LiveRun::~LiveRun() {
  stop();
  if (changing_.valid()) changing_.wait();
}

void LiveRun::open(const app::Experiment& experiment, bool start_at_once, const FilmOfRun& film) {
  if (is_busy()) return;
  stop();
  Left left = leave();
  experiment_ = experiment;
  start_at_once_ = start_at_once;
  stop_asked_ = false;
  close_asked_ = false;
  latest_.reset();
  robots_.clear();
  circumstances_ = Circumstances(experiment);
  parameters_ = app::declared_parameters(experiment.controller.law);
  failure_.reset();
  film_is_broken_ = false;
  camera_ = {};
  tests_ = false;
  history_.clear();
  rows_missed_ = 0;
  app::SessionOptions options;
  options.pictures = experiment.camera.kind() != app::CameraKind::absent;
  options.paced = true;  // so that "Go on from here" finds the same past
  options.guard = true;
  options.await_camera = true;
  recorder_ = std::make_shared<app::CsvRecorder>();
  keeper_ = std::make_shared<app::RunKeeper>();
  keeper_ends_ = told_of_keeper_ = false;
  options.crops = &keeper_->crops();
  record_file_.clear();
  options.sinks = {recorder_.get(), keeper_.get()};
  film_ = film;
  options.video = film.file.toStdString();
  changing_ = std::async(std::launch::async,
                         [left = std::move(left), experiment, options, recorder = recorder_,
                          keeper = keeper_]() mutable -> std::optional<Opened> {
                           try {
                             left.close();
                             return app::Session::open(experiment, app::Session::Clock::wall, options);
                           } catch (const std::exception& error) {
                             return tl::unexpected(std::string(error.what()));
                           }
                         });
}

void LiveRun::close() {
  close_asked_ = true;
  end();
}

void LiveRun::end() {
  stop();
  if (is_busy()) return;  // `settle` goes on from there
  Left left = leave();
  latest_.reset();
  robots_.clear();
  circumstances_ = Circumstances(experiment_);
  record_file_.clear();
  history_.clear();
  changing_ = std::async(std::launch::async, [left = std::move(left)]() mutable -> std::optional<Opened> {
    try {
      left.close();
    } catch (const std::exception& error) {
      return tl::unexpected(std::string(error.what()));
    }
    return std::nullopt;
  });
}

QString LiveRun::close_now() {
  stop();
  if (changing_.valid()) changing_.wait();
  settle();
  if (!session_) return {};
  session_->close();
  take_robots();
  if (const std::string film = film_that_goes(); !film.empty()) app::remove_film(experiment_, film);
  if (keeps()) finish_keeping();
  for (Keeping& one : keepings_)
    if (const QString problem = one.problem.get(); !problem.isEmpty()) app::complain(problem.toStdString());
  keepings_.clear();
  return record_file_.isEmpty() ? QString() : record_to({});
}

void LiveRun::settle() {
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
  parameters_ = session_->law_parameters();
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
    if (const Done done = start(); !done) emit refused(QString::fromStdString(done.error()));
  }
}

void LiveRun::poll() {
  constexpr double noticed = 1.0;  // the window's thread stood still for longer than this [s]
  const double now = 1e-3 * static_cast<double>(clock_.elapsed());
  const double away = now - std::exchange(polled_at_, now);
  if (away > noticed && session_) emit was_away(away);
  settle();
  if (session_) {
    session_->drain([this](const app::TickRecord& record) {
      latest_ = record;
      circumstances_.note(record);
      note_parameters(record, parameters_);
      history_.add(record);
      emit row_added(record);
      emit record_shown(record);
    });
    if (statuses_.due(now)) take_robots();
    if (const auto tested = session_->wheel_check()) {
      tests_ = false;
      if (*tested)
        emit robot_tested(**tested);
      else
        emit test_failed(QString::fromStdString(tested->error()));
    }
    if (const std::uint64_t missed = session_->undrained_rows(); missed > rows_missed_) {
      emit rows_missed(static_cast<int>(missed - rows_missed_));
      rows_missed_ = missed;
    }
    finish_files();
  }
  tell_of_kept();
  emit frame(now);
}

void LiveRun::finish_files() {
  if (const std::string why = keeper_->problem(); !why.empty() && !std::exchange(told_of_keeper_, true))
    emit keeping_failed(QString::fromStdString(why));
  if (!is_over()) return since_over_.invalidate();
  if (!since_over_.isValid()) since_over_.start();
  if (!since_over_.hasExpired(rest_ms)) return;
  if (keeps() && (may_be_driving().empty() || since_over_.hasExpired(stand_ms))) finish_keeping();
  if (record_file_.isEmpty()) return;
  const QString file = record_file_;
  emit recorded(file, record_to({}));
}

/// The session is no longer this one's.
LiveRun::Left LiveRun::leave() {
  Left left{recorder_, keeper_, nullptr, how_it_ends(), experiment_, film_that_goes(), {}};
  if (session_ && keeps()) finish_keeping(left.facts.get_future(), {});
  left.session = std::move(session_);
  return left;
}

/// By what the session knows now.
void LiveRun::finish_keeping() {
  std::promise<app::SessionFacts> facts;
  facts.set_value(app::facts_of(*session_, how_it_ends()));
  finish_keeping(facts.get_future(), film_.of_kept_run ? session_->end_film() : nullptr);
}

/// Of a run that no folder has got, nor will get; empty: there is none.
std::string LiveRun::film_that_goes() const {
  const bool is_kept = keeper_ && !keeper_->folder().empty();
  return film_.only_there && !is_kept ? film_.file.toStdString() : std::string();
}

/// Aside: figures and hashes take seconds. The facts come when the session knows them.
void LiveRun::finish_keeping(std::future<app::SessionFacts> facts, std::function<app::VideoStatus()> end_film) {
  keeper_ends_ = true;
  const QString folder = kept_folder();
  keepings_.push_back({folder, std::async(std::launch::async, [keeper = keeper_, facts = std::move(facts),
                                                               end_film = std::move(end_film), film = film_,
                                                               experiment = experiment_]() mutable {
                         try {
                           app::SessionFacts known = facts.get();
                           if (end_film) known.video = end_film();
                           const std::string file = film.file.toStdString();
                           const auto ended = keeper->end(known, film.of_kept_run ? file : std::string());
                           if (film.only_there && ended) app::remove_film(experiment, file);
                           return ended ? QString() : QString::fromStdString(ended.error());
                         } catch (const std::exception& error) {
                           return QString::fromStdString(error.what());
                         }
                       })});
}

void LiveRun::tell_of_kept() {
  std::erase_if(keepings_, [&](Keeping& one) {
    if (one.problem.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    emit kept(one.folder, one.problem.get());
    return true;
  });
}

void LiveRun::take_robots() {
  robots_ = session_->robots();
  camera_ = session_->camera_status();
  const app::VideoStatus video = session_->video();
  if (!video.problem.empty() && !std::exchange(film_is_broken_, true))
    emit film_failed(QString::fromStdString(video.problem));
  if (const auto why = session_->failure()) failure_ = QString::fromStdString(*why);
}

void LiveRun::begin_run() {
  if (!keeps()) keeper_->crops().begin({});  // those from before are of no run
  emit starting();
}

RunSource::Done LiveRun::start() {
  if (session_) begin_run();
  return post([](app::Session& session) { return session.start(); });
}

RunSource::Done LiveRun::stage() {
  if (session_ && phase() == app::Phase::ready) begin_run();  // the way to the starts belongs to the run
  return post([](app::Session& session) { return session.stage(); });
}

RunSource::Done LiveRun::pause() {
  return post([](app::Session& session) { return session.pause(); });
}

RunSource::Done LiveRun::resume() {
  return post([](app::Session& session) { return session.resume(); });
}

void LiveRun::stop() noexcept {
  if (session_) session_->stop();
  if (!stop_asked_) since_stop_.start();
  stop_asked_ = true;
}

RunSource::Done LiveRun::go() {
  switch (phase()) {
    case app::Phase::ready:
      return start();
    case app::Phase::running:
    case app::Phase::staging:
    case app::Phase::paused:
      return is_paused() ? resume() : pause();
    case app::Phase::stopped:
    case app::Phase::finished:
      return {};
  }
  return {};
}

RunSource::Done LiveRun::post(const std::function<Done(app::Session&)>& what) {
  if (!session_) return tl::unexpected(tr("No session is open.").toStdString());
  return what(*session_);
}

RunSource::Done LiveRun::change(const std::function<Done(app::Session&)>& what) {
  if (session_ && is_over()) return tl::unexpected(why_fixed().toStdString());
  return post(what);
}

RunSource::Done LiveRun::step() {
  if (phase() == app::Phase::running) {
    return pause();
  }
  if (session_ && phase() == app::Phase::ready) begin_run();
  const Done done = post([](app::Session& session) { return session.step(); });
  return done ? done : tl::unexpected(tr("No steps: %1").arg(QString::fromStdString(done.error())).toStdString());
}

RunSource::Done LiveRun::set_speed(double speed) {
  wanted_speed_ = speed;
  if (!session_) return {};
  const Done done = session_->set_speed(speed);
  return done ? done
              : tl::unexpected(
                    tr("The speed cannot be changed: %1").arg(QString::fromStdString(done.error())).toStdString());
}

QString LiveRun::real_time_reason() const {
  return QString::fromStdString(app::real_time_reason(experiment_).value_or(std::string()));
}

QString LiveRun::record_to(const QString& file) {
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

QString LiveRun::keep(const app::KeepRequest& request) {
  if (!keeper_) return tr("No session is open.");
  if (keeps()) return {};
  const auto begun = keeper_->begin(request, experiment_);
  return begun ? QString() : QString::fromStdString(begun.error());
}

RunSource::Done LiveRun::set_gain(core::GainName name, double value, double seconds) {
  return change([&](app::Session& session) { return session.set_gain(name, value, seconds); });
}

RunSource::Done LiveRun::set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds) {
  return change([&](app::Session& session) { return session.set_gain(name, i, j, value, seconds); });
}

RunSource::Done LiveRun::set_parameter(const std::string& name, double value) {
  return change([&](app::Session& session) { return session.set_parameter(name, value); });
}

RunSource::Done LiveRun::couple(std::size_t i, std::size_t j, bool on) {
  return change([&](app::Session& session) { return session.couple(i, j, on); });
}

double LiveRun::gain(core::GainName name, std::size_t i, std::size_t j) const {
  return session_ ? session_->gain(name, i, j) : 0.0;
}

double LiveRun::gain_target(core::GainName name, std::size_t i, std::size_t j) const {
  return session_ ? session_->gain_target(name, i, j) : 0.0;
}

double LiveRun::gain_limit(core::GainName name) const {
  return session_ ? session_->gain_limit(name) : app::none;
}

double LiveRun::gain_limit(core::GainName name, std::size_t i, std::size_t j) const {
  return session_ ? session_->gain_limit(name, i, j) : app::none;
}

double LiveRun::gain_limit_now(core::GainName name) const {
  return session_ && latest_ ? session_->gain_limit(name, *latest_) : gain_limit(name);
}

RunSource::Done LiveRun::move_robot(std::size_t robot, const core::Pose& pose) {
  return change([&](app::Session& session) { return session.move_robot(robot, pose); });
}

RunSource::Done LiveRun::kick_robot(std::size_t robot, double vx, double vy) {
  return change([&](app::Session& session) { return session.kick_robot(robot, vx, vy); });
}

RunSource::Done LiveRun::hold_robot(std::size_t robot, bool hold) {
  return change([&](app::Session& session) { return session.hold_robot(robot, hold); });
}

RunSource::Done LiveRun::test_robot(std::size_t robot) {
  Done begun = post([&](app::Session& session) { return session.check_wheels(robot); });
  tests_ = tests_ || begun.has_value();
  return begun;
}

RunSource::Done LiveRun::put_obstacle(int number, const core::Obstacle& obstacle) {
  return change([&](app::Session& session) -> Done {
    if (number < 0) {
      const auto added = session.add_obstacle(obstacle);
      return added ? Done() : tl::unexpected(added.error());
    }
    const auto k = static_cast<std::size_t>(number);
    return obstacle.radius > 0.0 ? session.move_obstacle(k, obstacle) : session.remove_obstacle(k);
  });
}

std::optional<QString> LiveRun::unguarded() const {
  const auto why = session_ ? session_->unguarded() : std::nullopt;
  return why ? std::optional(QString::fromStdString(*why)) : std::nullopt;
}

QStringList LiveRun::alarms() {
  QStringList all;
  if (!session_) return all;
  for (const std::string& sentence : session_->alarms()) all << QString::fromStdString(sentence);
  return all;
}

}  // namespace skein::ui
