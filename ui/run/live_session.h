#pragma once

#include <QElapsedTimer>
#include <QObject>
#include <QStringList>
#include <QTimer>
#include <future>
#include <memory>
#include <optional>

#include "app/experiment/experiment.h"
#include "app/record/csv_file.h"
#include "app/session/session.h"
#include "ui/plots/run_history.h"

namespace skein::ui {

/// The session in the window's thread: thirty times a second it hands on what the control thread has left for it.
/// Opening and closing, which may wait for cameras and robots, happen aside, so that the window never waits.
class LiveSession final : public QObject {
  Q_OBJECT

 public:
  explicit LiveSession(QObject* parent = nullptr);
  ~LiveSession() override;  ///< stops the robots, and waits until the session is closed

  /// Ends the session that there is, robots first, and opens one on this experiment. `video`: keep the camera's frames
  /// in this film; empty: do not.
  void open(const app::Experiment& experiment, bool start_at_once, const QString& video = {});
  /// Ends the session; there is none then.
  void end();
  /// Ends the session for good; `closed` follows.
  void close();

  /// Ends the session here and now, for the end of the program; says what went wrong with the recording.
  QString close_now();

  bool is_open() const { return session_ != nullptr; }
  bool is_busy() const { return changing_.valid(); }  ///< opening or closing
  const app::Experiment& experiment() const { return experiment_; }
  app::Phase phase() const { return latest_ ? latest_->phase : app::Phase::ready; }
  /// The newest record of this session, if one has come.
  const app::TickRecord* latest() const { return latest_ ? &*latest_ : nullptr; }
  const std::vector<app::RobotStatus>& robots() const { return robots_; }
  std::optional<QString> failure() const { return failure_; }
  bool stop_asked() const { return stop_asked_; }  ///< by the operator
  /// A second after STOP: until then robots have had no fair chance to acknowledge it.
  bool stop_is_due() const { return !stop_asked_ || since_stop_.hasExpired(1000); }
  const RunHistory& history() const { return history_; }

  void start();
  void stage();  ///< every robot drives to its start
  void pause();
  void resume();
  void stop() noexcept;  ///< at once, in any state, also while a session is being opened
  /// Simulations only; empty answer: done, else why not. The speed holds for later sessions too, where they can.
  QString step();
  QString set_speed(double speed);
  double speed() const { return session_ ? session_->speed() : 1.0; }
  /// Why it lives in real time, if it does.
  QString real_time_reason() const;

  /// Writes this run, what was before included, to a CSV as it goes; no file: ends that. The answer says what went
  /// wrong; empty: nothing.
  QString record_to(const QString& file);
  QString record_file() const { return record_file_; }  ///< empty: nothing is recorded
  /// `seconds`: of the ramp; 0: as fast as it may.
  void set_gain(core::GainName name, double value, double seconds = 0.0);
  void set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds = 0.0);
  void couple(std::size_t i, std::size_t j, bool on);
  bool coupled(std::size_t i, std::size_t j) const { return !session_ || session_->coupled(i, j); }
  double gain(core::GainName name, std::size_t i, std::size_t j) const;
  double gain_target(core::GainName name, std::size_t i, std::size_t j) const;
  double gain_border(core::GainName name, std::size_t i, std::size_t j) const;
  double gain_border(core::GainName name) const;      ///< over the whole reference
  double gain_border_now(core::GainName name) const;  ///< at the newest record
  tl::expected<void, std::string> move_robot(std::size_t robot, const core::Pose& pose);
  tl::expected<void, std::string> kick_robot(std::size_t robot, double vx, double vy);
  tl::expected<void, std::string> hold_robot(std::size_t robot, bool hold);
  /// `robot_tested` follows.
  tl::expected<void, std::string> test_robot(std::size_t robot);
  /// Why nothing would stop the robots should this program be killed; nothing: something would, or need not.
  std::optional<QString> unguarded() const;
  /// What the operator must see of the guard and of STOP from outside, each once.
  QStringList alarms();
  std::uint64_t undrained_rows() const { return session_ ? session_->undrained_rows() : 0; }
  /// Number -1: a new one; radius 0: away with it.
  tl::expected<void, std::string> put_obstacle(int number, const core::Obstacle& obstacle);
  bool has_camera() const { return session_ && session_->has_camera(); }
  bool picture(app::Picture& out) { return session_ && session_->picture(out); }
  std::array<double, 2> pixel(double x, double y) const { return session_->pixel(x, y); }

 signals:
  void opened();
  void open_failed(const QString& reason);
  void record_taken(const skein::app::TickRecord& record);  ///< every one, in order
  void frame();                                             ///< after each look, thirty times a second
  void closed();
  void was_away(double seconds);             ///< the window's thread stood still so long; the control thread did not
  void film_failed(const QString& problem);  ///< nothing more is added to the film; the run goes on
  void robot_tested(const skein::app::WheelCheck& result);
  void test_failed(const QString& reason);
  void refused(const QString& why);                            ///< the session did not take what was asked of it
  void starting();                                             ///< the first row of a run is about to come
  void recorded(const QString& file, const QString& problem);  ///< a recording is complete; no problem: empty

 private:
  using Opened = tl::expected<std::unique_ptr<app::Session>, std::string>;

  void look();
  void settle();  // takes what the thread aside has brought
  void take_robots();
  void finish_recording();
  void answer(const app::Session::Answer& done);

  app::Experiment experiment_;
  std::shared_ptr<app::CsvRecorder> recorder_;  // of this session, which writes to it: it goes after it
  std::unique_ptr<app::Session> session_;
  std::future<std::optional<Opened>> changing_;  // nothing inside: closed, none opened
  bool start_at_once_ = false, stop_asked_ = false, close_asked_ = false, film_is_broken_ = false;
  QElapsedTimer since_stop_, since_look_, since_over_;
  double wanted_speed_ = 1.0;
  QString record_file_;
  std::optional<app::TickRecord> latest_;
  std::vector<app::RobotStatus> robots_;
  std::optional<QString> failure_;
  RunHistory history_;
  QTimer timer_;
  int looks_ = 0;
};

}  // namespace skein::ui
