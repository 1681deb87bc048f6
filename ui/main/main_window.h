#pragma once

#include <QDockWidget>
#include <QLabel>
#include <QMainWindow>
#include <QPointer>
#include <QToolBar>
#include <functional>
#include <future>

#include "app/session/readiness.h"
#include "ui/modes.h"
#include "ui/palette.h"
#include "ui/run/live_session.h"
#include "ui/run/player.h"
#include "ui/run/run_bar.h"

namespace skein::ui {

class AlertStrip;
class ArenaView;
class CalibrationDialog;
class CheckList;
class EventPanel;
class GainsPanel;
class PlotsPanel;
class RobotButtons;
class RobotsPanel;

/// The operator's window: arena, gains, plots, robots, log, and STOP. It wires the panels to the session; what is
/// shown is the panels' business, what is true the session's.
class MainWindow final : public QMainWindow {
  Q_OBJECT

 public:
  MainWindow();
  ~MainWindow() override;

  void open(const app::Experiment& experiment, bool start_at_once);
  /// Reads an experiment file and opens it, or says what is wrong with it; plays a recorded run (.csv).
  void open_file(const QString& file);
  /// Where the open experiment comes from, for the editor and the list of recent files; empty: nobody knows.
  void set_experiment_file(const QString& file);
  void save_csv(const QString& file);
  void save_plot(const QString& file, bool everything = false);
  /// Records this run to the file as it goes, what was before included, and those that follow to files beside it.
  void record_to(const QString& file);
  void set_theme(Theme theme);  ///< and keep to it, instead of following the desktop

  /// Reads a recorded run and plays it in place of the experiment, which ends.
  void open_recording(const QString& file);
  /// Draws a recorded run pale behind the one that is shown.
  void compare_with(const QString& file);

  /// Without a display: stops all robots, waits for their answers, completes the recording; says how that went.
  QString close_session();

  const LiveSession& live() const { return live_; }
  const Player& player() const { return player_; }

 public slots:
  void stop();
  void go();    ///< Start, Pause or Resume
  void step();  ///< a simulation, one tick on
  void set_speed(double speed);
  void record(bool on);
  void new_run();

 signals:
  void saved(const QString& file, const QString& problem);  ///< no problem: empty

 protected:
  void closeEvent(QCloseEvent*) override;
  void changeEvent(QEvent*) override;
  void dragEnterEvent(QDragEnterEvent*) override;
  void dropEvent(QDropEvent*) override;

 private:
  // main_window.cpp: what the window is made of, and what comes from the session
  void build_panels();
  void connect_panels();
  void default_layout();
  QDockWidget* dock(QWidget* panel, const QString& title, const QString& name, Qt::DockWidgetArea area);
  void show_experiment();
  void show_experiment_of(const app::Experiment& experiment);
  void on_opened();
  void on_open_failed(const QString& reason);
  void on_record(const app::TickRecord& record);
  void on_frame();
  void show_state();
  void show_numbers(const app::TickRecord& record);
  QString stopped_text() const;
  QString acknowledgements() const;
  void tell(const tl::expected<void, std::string>& done);  ///< why it was refused, if it was
  void select_robot(int robot);
  /// Whether anything that stands still now could have been moving: then the key that asked for it is spent.
  bool stop_by_key();

  // main_window_checks.cpp: what has to hold before a start
  void begin_checks();
  std::vector<app::Check> judge();
  void show_checks();
  void show_delay();
  void start_if_ready(bool overrule);
  void mend(app::Check::What what);
  void bring_to_places();
  void calibrate_camera();

  void reopen_with(const QString& set);

  // main_window_robots.cpp: one robot at a time, and what robots with links need
  void connect_robots();
  void test_robot(int robot);
  void show_test(const app::WheelCheck& test);
  void warn_unguarded();
  // main_window_pairs.cpp: couplings, pair by pair
  void connect_pairs();
  void show_pairs();
  void show_couplings(const std::array<double, 3>& borders,
                      const std::function<double(core::GainName, std::size_t, std::size_t)>& gain_of);
  // main_window_run.cpp: what the operator does with a run
  void connect_run();
  void build_run_menu(QMenu* run);
  RunState run_state() const;
  void record_if_wanted();
  QString recordings_directory() const;
  QString recording_path(const app::Experiment& experiment, const QString& ending) const;
  void note(const QString& text, Severity severity);  ///< in the log and the status bar

  // main_window_replay.cpp: a recorded run, and one to compare with
  void connect_replay();
  void build_replay_menu(QMenu* file);
  void load(const QString& file, bool to_compare);
  void take_loaded();
  void start_replay(const Player::Run& run);
  void leave_replay();
  void seek(double t);
  void show_replay();
  void compare(const Player::Run& other);
  void compare_with_now();
  void show_other(double t);
  double recorded_border(core::GainName gain, const app::TickRecord& record) const;
  const app::Experiment& shown_experiment() const;

  // main_window_files.cpp: experiments and recordings as files
  void build_files_menu(QMenu* file);
  void ask_open();
  void remember_file(const QString& file);
  bool real_robots_move();  ///< and says that nothing is opened meanwhile

  // main_window_editor.cpp: the experiment as a text
  void build_editor_menu(QMenu* file);
  void edit(const QString& text, const QString& file);
  void edit_present();
  QString experiment_as_done() const;

  // main_window_actions.cpp: menus, dialogs, settings
  void build_menus(QMenuBar* menus);
  void build_arena_tools(QToolBar* tools);
  void dress_icons();
  void ask_save_csv();
  void ask_save_plot(bool everything);
  void show_problem(const QString& title, const QString& text, const QString& details = {});
  void restore_settings();
  void store_settings();

  LiveSession live_;
  RunBar* run_bar_;
  ArenaView* arena_;
  GainsPanel* gains_;
  PlotsPanel* plots_;
  RobotsPanel* robots_;
  RobotButtons* robot_buttons_;
  EventPanel* log_;
  AlertStrip* alert_;
  CheckList* checks_;
  QLabel* pace_;
  QDockWidget *gains_dock_, *plots_dock_, *robots_dock_, *log_dock_;
  QAction *picture_, *regions_, *trails_, *dark_, *go_action_, *new_run_action_, *save_csv_action_;
  QAction *fit_, *zoom_in_, *zoom_out_, *full_screen_, *couplings_, *grid_, *checks_action_;
  std::array<QAction*, 4> tools_{};  ///< of the arena, in the order of ArenaTool

  std::future<app::Certificate> certifying_;
  std::optional<app::Certificate> certificate_;

  QString experiment_file_;  // empty: none, or nobody knows
  Player player_;
  Player::Run other_, waiting_;  // compared with; to be played once the session is closed
  struct Loading {
    bool to_compare;
    std::future<tl::expected<app::RecordedRun, std::string>> run;
  };
  std::optional<Loading> loading_;
  struct Saving {
    QString file;
    std::future<QString> problem;
  };
  std::optional<Saving> saving_;
  QPointer<CalibrationDialog> calibrating_;         // waits until the session has let the camera go
  bool records_ = false;                            // this run and those that follow
  bool may_close_ = false;                          // all robots are stopped and the session is gone
  const Theme desktop_at_start_ = desktop_theme();  // before any palette of ours
  bool theme_chosen_ = false;                       // else the desktop's
  bool testing_ = false;                            // a robot turns its wheels
  bool teaches_ = false;                            // the hint stands until a robot was moved
  app::Phase shown_phase_ = app::Phase::ready;
  int frames_ = 0;
  std::uint64_t rows_missed_ = 0;  // by the window, of this session
};

}  // namespace skein::ui
