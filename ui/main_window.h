#pragma once

#include <QDockWidget>
#include <QLabel>
#include <QMainWindow>
#include <QPointer>
#include <QToolBar>
#include <future>

#include "app/readiness.h"
#include "ui/live_session.h"
#include "ui/palette.h"

namespace skein::ui {

class AlertStrip;
class ArenaView;
class CheckList;
class EventPanel;
class GainsPanel;
class PlotsPanel;
class RobotButtons;
class RobotsPanel;
class RunBar;

/// The operator's window: arena, gains, plots, robots, log, and STOP. It wires the panels to the session; what is
/// shown is the panels' business, what is true the session's.
class MainWindow final : public QMainWindow {
  Q_OBJECT

 public:
  MainWindow();
  ~MainWindow() override;

  void open(const app::Experiment& experiment, bool start_at_once);
  /// Reads an experiment file and opens it, or says what is wrong with it.
  void open_file(const QString& file);
  void save_csv(const QString& file);
  void save_plot(const QString& file);
  void set_theme(Theme theme);  ///< and keep to it, instead of following the desktop

  const LiveSession& live() const { return live_; }

 public slots:
  void stop();
  void go();  ///< Start, Pause or Resume
  void new_run();

 signals:
  void saved(const QString& file, const QString& problem);  ///< no problem: empty

 protected:
  void closeEvent(QCloseEvent*) override;
  void changeEvent(QEvent*) override;

 private:
  // main_window.cpp: what the window is made of, and what comes from the session
  void build_panels();
  void connect_panels();
  void default_layout();
  QDockWidget* dock(QWidget* panel, const QString& title, const QString& name, Qt::DockWidgetArea area);
  void show_experiment();
  void on_opened();
  void on_open_failed(const QString& reason);
  void on_record(const app::TickRecord& record);
  void on_frame();
  void show_state();
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
  void start_if_ready(bool overrule);
  void mend(app::Check::What what);
  void bring_to_places();

  void reopen_with(const QString& set);

  // main_window_pairs.cpp: couplings, pair by pair
  void connect_pairs();
  void show_pairs();

  // main_window_actions.cpp: menus, dialogs, settings
  void build_menus(QMenuBar* menus);
  void build_arena_tools(QToolBar* tools);
  void dress_icons();
  void ask_open();
  void ask_save_csv();
  void ask_save_plot();
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

  struct Saving {
    QString file;
    std::future<QString> problem;
  };
  std::optional<Saving> saving_;
  bool may_close_ = false;                          // all robots are stopped and the session is gone
  const Theme desktop_at_start_ = desktop_theme();  // before any palette of ours
  bool theme_chosen_ = false;                       // else the desktop's
  bool teaches_ = false;                            // the hint stands until a robot was moved
  app::Phase shown_phase_ = app::Phase::ready;
  int frames_ = 0;
  std::uint64_t rows_missed_ = 0;  // by the window, of this session
};

}  // namespace skein::ui
