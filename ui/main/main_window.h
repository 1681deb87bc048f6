#pragma once

#include <QLabel>
#include <QMainWindow>

#include "app/session/readiness.h"
#include "ui/base/compositor.h"
#include "ui/base/palette.h"
#include "ui/base/throttle.h"
#include "ui/main/messages.h"
#include "ui/run/runs.h"

class QDockWidget;
class QMenu;
class QMenuBar;

namespace skein::ui {

class AlertStrip;
class AlertVoice;
class ArenaActions;
class ArenaView;
class BranchController;
class CalibrationController;
class CameraController;
class CheckController;
class CheckList;
class ComparisonController;
class ConnectController;
class DockLayout;
class EditorController;
class EventPanel;
class FileController;
class GainsPanel;
class LeftBehindBar;
class PairController;
class PlotsPanel;
class PreviewController;
class RecordingController;
class ReopenController;
class ReplayController;
class ResultController;
class ResultPanel;
class RobotButtons;
class RobotController;
class RobotsPanel;
class RunBar;

/// The operator's window: arena, gains, plots, robots, log, and STOP. A shell: it lays out the panels, and wires them
/// to the run that is shown and to the controllers, which do the work.
class MainWindow final : public QMainWindow {
  Q_OBJECT

 public:
  MainWindow();
  ~MainWindow() override;

  void open(const app::Experiment& experiment, bool start_at_once);
  /// Reads an experiment file and opens it, or shows its problems; replays a recorded run (.csv).
  void open_file(const QString& file);
  /// Where the open experiment comes from, for the editor and the list of recent files; empty: not known.
  void set_experiment_file(const QString& file);
  void save_csv(const QString& file);
  void save_plot(const QString& file, bool everything = false);
  /// Records this run to the file live, including its beginning, and later runs to files beside it.
  void record_to(const QString& file);
  void set_theme(Theme theme);  ///< and keep to it, instead of following the desktop

  /// Reads a recorded run and plays it in place of the experiment, which ends.
  void open_recording(const QString& file);
  /// Draws a recorded run pale behind the one that is shown.
  void compare_with(const QString& file);

  /// Without a display: stops all robots, waits for their answers, completes the recording; reports the result.
  QString close_session();

  const LiveRun& live() const { return runs_.live(); }
  const ReplayRun& replay() const { return runs_.replay(); }

 public slots:
  void stop();
  void go();    ///< the action of the first button: start, pause, resume, play
  void step();  ///< a simulation or a replay, one tick on
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
  void build_panels();
  void build_controllers();
  void lay_out();
  void connect_panels();
  void connect_session();
  void build_menus(QMenuBar* menus);
  void build_run_menu(QMenu* run);
  void build_files_of_run(QMenu* run);
  void build_view_menu(QMenu* view);
  /// Brings a panel to the front, and the keyboard to its first control, if it has one.
  void go_to(QDockWidget* dock, QWidget* first);
  /// The tip that a mouse would find over the control with the focus.
  void show_tip_of_focus();

  void show_run();    // another run, or another experiment
  void show_state();  // five times a second, however many frames there are, and when something changes
  void show_timing();
  void show_numbers();
  void on_opened();
  void on_open_failed(const QString& reason);
  void on_frame(double now);
  void select_robot(int robot);
  void seek(double t);
  void mend(app::Check::What what);
  void let_go_of_session();
  /// STOP by a key. Returns whether anything could have been moving: then the key press is consumed.
  bool stop_by_key();
  void on_space();
  void ask_save_plot(bool everything);
  void draw_icons();
  void restore_settings();
  void store_settings();

  Runs runs_;
  RunBar* run_bar_;
  ArenaView* arena_;
  GainsPanel* gains_;
  PlotsPanel* plots_;
  RobotsPanel* robots_;
  RobotButtons* robot_buttons_;
  EventPanel* log_;
  ResultPanel* results_;
  AlertStrip* alert_;
  CheckList* check_list_;
  LeftBehindBar* left_behind_;
  QLabel* pace_;
  DockLayout* docks_;
  AlertVoice* voice_;
  QAction *dark_, *voice_action_, *go_action_, *new_run_action_, *save_csv_action_;

  std::unique_ptr<Messages> messages_;
  ArenaActions* arena_actions_;
  BranchController* branch_;
  CheckController* checks_;
  FileController* files_;
  EditorController* editor_;
  RecordingController* recording_;
  ReplayController* replay_;
  ComparisonController* comparison_;
  PairController* pairs_;
  ReopenController* reopen_;
  PreviewController* preview_;
  ResultController* result_;
  RobotController* robot_;
  CalibrationController* calibration_;
  CameraController* camera_;
  ConnectController* connect_;

  bool may_close_ = false;                          // all robots are stopped and the session is gone
  const Theme desktop_at_start_ = desktop_theme();  // before Skein sets a palette
  bool theme_chosen_ = false;                       // otherwise the desktop's
  bool teaches_ = false;                            // the hint stays until a robot was moved
  app::Phase shown_phase_ = app::Phase::ready;
  Throttle texts_{0.19};     // numbers that change five times a second can be read
  Throttle questions_{0.5};  // to the display
  Compositor compositor_;
};

}  // namespace skein::ui
