#pragma once

#include <QElapsedTimer>
#include <QTimer>
#include <functional>
#include <future>
#include <memory>
#include <optional>

#include "app/experiment/experiment.h"
#include "app/record/csv_file.h"
#include "app/runs/run_keeper.h"
#include "app/session/session.h"
#include "ui/base/throttle.h"
#include "ui/run/run_source.h"

namespace skein::ui {

/// Where the camera's frames go.
struct FilmOfRun {
  QString file;              ///< empty: nowhere
  bool of_kept_run = false;  ///< the run's folder gets a film
  bool only_there = false;   ///< the file itself is temporary
};

/// The session in the window's thread: thirty times per second it passes on the control thread's records. Opening and
/// closing, which may wait for cameras and robots, happen on another thread, so that the window never waits.
class LiveRun final : public RunSource {
  Q_OBJECT

 public:
  explicit LiveRun(QObject* parent = nullptr);
  ~LiveRun() override;  ///< stops the robots, and waits until the session is closed

  /// Ends the present session, robots first, and opens one for this experiment.
  void open(const app::Experiment& experiment, bool start_at_once, const FilmOfRun& film = {});
  /// Ends the session, without a new one.
  void end();
  /// Ends the session for good; `closed` follows.
  void close();

  /// Ends the session at once, for the end of the program; reports errors of the recording.
  QString close_now();

  const app::Experiment& experiment() const override { return experiment_; }
  QString file() const override { return file_; }
  /// `text`: of the file, as it was read.
  void set_file(const QString& file, const QString& text) {
    file_ = file;
    file_text_ = text;
  }
  /// The experiment may differ from it: by --set, and by what the window has changed.
  QString file_text() const { return file_text_; }
  QString title() const override { return QString::fromStdString(experiment_.name); }
  app::Phase phase() const override { return latest_ ? latest_->phase : app::Phase::ready; }
  bool is_paused() const { return latest_ && latest_->paused(); }
  RunState state() const override;
  /// The newest record of this session, if one has come.
  const app::TickRecord* latest() const override { return latest_ ? &*latest_ : nullptr; }
  double t() const override { return latest_ ? latest_->t : 0.0; }
  RunHistory::Rows rows() const override { return history_.rows(); }
  bool is_complete() const override { return false; }
  std::vector<Notice> findings() const override { return {}; }
  const std::vector<app::RobotStatus>& robots() const override { return robots_; }
  bool is_open() const override { return session_ != nullptr; }
  bool is_busy() const override { return changing_.valid(); }
  bool is_before_start() const override;
  QString why_fixed() const override;
  Notice banner() const override;
  Notice lasting_alert() const override;

  std::optional<QString> failure() const { return failure_; }
  std::optional<app::Timing> timing() const override {
    return session_ ? session_->timing_so_far() : std::optional<app::Timing>();
  }
  bool stop_asked() const override { return stop_asked_; }
  const Circumstances& circumstances() const override { return circumstances_; }
  std::vector<std::size_t> may_be_driving() const override;
  /// Whether a second has passed since STOP: before that, robots have not had enough time to acknowledge it.
  bool stop_is_due() const { return !stop_asked_ || since_stop_.hasExpired(1000); }
  /// Robots are driving, or will be driving again as soon as the run is resumed.
  bool is_under_way() const;
  /// Robots stand, none is being tested, and no start is pending: STOP would have no effect.
  bool all_stand() const;
  const RunHistory& history() const { return history_; }

  Done start();
  Done stage();  ///< every robot drives to its start
  Done pause();
  Done resume();
  void stop() noexcept;  ///< at once, in any state, also while a session is being opened
  Done go() override;
  /// Simulations only.
  Done step() override;
  /// Simulations only. The speed holds for later sessions too, where they can.
  Done set_speed(double speed) override;
  bool seek(double) override { return false; }
  double speed() const { return session_ ? session_->speed() : 1.0; }
  /// Why it runs in real time, if it does.
  QString real_time_reason() const;

  /// Records this run live to a CSV, including its beginning; no file: ends the recording. Returns the error; empty:
  /// none.
  QString record_to(const QString& file);
  /// Keeps the run that is about to start in a folder of its own; `kept` follows when it is over. Returns as record_to
  /// does.
  QString keep(const app::KeepRequest& request);
  bool keeps() const { return keeper_ && keeper_->keeps() && !keeper_ends_; }
  QString kept_folder() const { return keeper_ ? QString::fromStdString(keeper_->folder()) : QString(); }
  /// The tags that were not seen in this run.
  std::vector<app::TagCrop> crops() const { return keeper_ ? keeper_->crops().all() : std::vector<app::TagCrop>(); }
  QString record_file() const { return record_file_; }  ///< empty: nothing is recorded
  /// The next run will be recorded; for `state`.
  void set_records_next(bool on) { records_next_ = on; }

  Done set_gain(core::GainName name, double value, double seconds = 0.0) override;
  Done set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds = 0.0) override;
  const std::vector<app::LawParameter>& parameters() const override { return parameters_; }
  Done set_parameter(const std::string& name, double value) override;
  Done couple(std::size_t i, std::size_t j, bool on) override;
  bool coupled(std::size_t i, std::size_t j) const override { return !session_ || session_->coupled(i, j); }
  double gain(core::GainName name, std::size_t i, std::size_t j) const override;
  double gain_target(core::GainName name, std::size_t i, std::size_t j) const override;
  double gain_limit(core::GainName name, std::size_t i, std::size_t j) const override;
  double gain_limit(core::GainName name) const override;
  double gain_limit_now(core::GainName name) const override;
  Done move_robot(std::size_t robot, const core::Pose& pose) override;
  Done kick_robot(std::size_t robot, double vx, double vy) override;
  Done hold_robot(std::size_t robot, bool hold) override;
  /// `robot_tested` follows.
  Done test_robot(std::size_t robot);
  /// Why nothing would stop the robots if this program were killed; none: a guard would, or need not.
  std::optional<QString> unguarded() const;
  /// Sentences that the operator must see about the guard and about STOP from outside, each once.
  QStringList alarms();
  Done put_obstacle(int number, const core::Obstacle& obstacle) override;
  const app::CameraStatus& camera() const { return camera_; }  ///< of the run's cameras
  bool has_camera() const { return session_ && session_->has_camera(); }
  bool picture(app::Picture& out) { return session_ && session_->picture(out); }
  std::array<double, 2> pixel(double x, double y) const { return session_->pixel(x, y); }

 signals:
  void opened();
  void open_failed(const QString& reason);
  void frame(double now);  ///< after each poll, up to thirty times a second; the window's clock [s]
  void closed();
  void was_away(double seconds);             ///< the window's thread stalled for so long; the control thread did not
  void film_failed(const QString& problem);  ///< nothing more is added to the film; the run goes on
  void robot_tested(const skein::app::WheelCheck& result);
  void test_failed(const QString& reason);
  void refused(const QString& why);  ///< the session refused a command
  void starting();                   ///< the first row of a run is about to come
  void rows_missed(int rows);        ///< by this thread, which stalled for too long; the recording has them
  void recorded(const QString& file, const QString& problem);  ///< a recording is complete; no problem: empty
  void kept(const QString& folder, const QString& problem);    ///< the same of a run's folder
  void keeping_failed(const QString& problem);  ///< nothing more of this run reaches its folder; the run goes on

 private:
  using Opened = tl::expected<std::unique_ptr<app::Session>, std::string>;

  void poll();
  void settle();  // takes the results of the other thread
  void take_robots();
  void finish_files();
  struct Left;
  Left leave();
  void finish_keeping();
  void finish_keeping(std::future<app::SessionFacts> facts, std::function<app::VideoStatus()> end_film);
  std::string film_that_goes() const;
  void begin_run();
  void tell_of_kept();
  app::Phase how_it_ends() const { return is_over() ? phase() : app::Phase::stopped; }
  bool is_opening() const { return session_ ? !latest_ : is_busy(); }
  bool has_failed() const { return !session_ && !is_busy(); }
  /// It ended by itself so long ago [ms].
  bool is_finished_for(int ms) const {
    return phase() == app::Phase::finished && since_over_.isValid() && since_over_.hasExpired(ms);
  }
  bool is_over() const { return phase() == app::Phase::stopped || phase() == app::Phase::finished; }
  QString stopped_text() const;
  QString acknowledgements() const;
  Done post(const std::function<Done(app::Session&)>& what);
  /// The same for a change that, once the run is over, would only alter its record.
  Done change(const std::function<Done(app::Session&)>& what);

  app::Experiment experiment_;
  QString file_, file_text_;
  std::shared_ptr<app::CsvRecorder> recorder_;  // of this session, which writes to it: must outlive it
  std::shared_ptr<app::RunKeeper> keeper_;      // the same
  std::unique_ptr<app::Session> session_;
  std::future<std::optional<Opened>> changing_;  // nothing inside: closed, none opened
  bool start_at_once_ = false, stop_asked_ = false, close_asked_ = false, film_is_broken_ = false;
  bool tests_ = false;  // a robot turns its wheels
  QElapsedTimer since_stop_, since_over_;
  double wanted_speed_ = 1.0;
  QString record_file_;
  FilmOfRun film_;
  std::optional<app::TickRecord> latest_;
  std::vector<app::RobotStatus> robots_;
  Circumstances circumstances_;
  std::vector<app::LawParameter> parameters_;
  app::CameraStatus camera_;
  std::optional<QString> failure_;
  RunHistory history_;
  struct Keeping {
    QString folder;
    std::future<QString> problem;
  };
  std::vector<Keeping> keepings_;  // that are being completed
  bool keeper_ends_ = false, told_of_keeper_ = false;
  bool records_next_ = false;
  std::uint64_t rows_missed_ = 0;  // of this session
  QTimer timer_;
  QElapsedTimer clock_;  // the window's
  double polled_at_ = 0.0;
  Throttle statuses_{0.25};  // links change slowly, and reading them allocates strings
};

}  // namespace skein::ui
