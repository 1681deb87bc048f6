#include "ui/main/main_window.h"

#include <QAbstractItemView>
#include <QApplication>
#include <QCloseEvent>
#include <QCursor>
#include <QDragEnterEvent>
#include <QDropEvent>
#include <QFileInfo>
#include <QHelpEvent>
#include <QMenu>
#include <QMenuBar>
#include <QStatusBar>
#include <QTimer>
#include <QToolBar>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "app/experiment/hardware.h"
#include "app/run/interrupted.h"
#include "ui/arena/arena_view.h"
#include "ui/base/compared.h"
#include "ui/base/dialogs.h"
#include "ui/base/number_text.h"
#include "ui/base/settings.h"
#include "ui/base/timing_text.h"
#include "ui/gains/gains_panel.h"
#include "ui/main/arena_actions.h"
#include "ui/main/branch_controller.h"
#include "ui/main/calibration_controller.h"
#include "ui/main/camera_controller.h"
#include "ui/main/cell_plotter.h"
#include "ui/main/check_controller.h"
#include "ui/main/comparison_controller.h"
#include "ui/main/connect_controller.h"
#include "ui/main/dock_layout.h"
#include "ui/main/editor_controller.h"
#include "ui/main/file_controller.h"
#include "ui/main/help.h"
#include "ui/main/left_behind_bar.h"
#include "ui/main/pair_controller.h"
#include "ui/main/preview_controller.h"
#include "ui/main/recording_controller.h"
#include "ui/main/reopen_controller.h"
#include "ui/main/replay_controller.h"
#include "ui/main/result_controller.h"
#include "ui/main/robot_controller.h"
#include "ui/plots/plots_panel.h"
#include "ui/results/result_panel.h"
#include "ui/robots/robot_buttons.h"
#include "ui/robots/robots_panel.h"
#include "ui/status/alert_strip.h"
#include "ui/status/alert_voice.h"
#include "ui/status/check_list.h"
#include "ui/status/event_log.h"
#include "ui/status/run_bar.h"
#include "ui/status/stop_guard.h"

namespace skein::ui {
namespace {

QAction* add(QMenu* menu, const QString& text, const QString& name, const QKeySequence& keys,
             const std::function<void()>& slot) {
  QAction* made = menu->addAction(text, menu, slot);
  made->setObjectName(name);
  made->setShortcut(keys);
  return made;
}

QAction* add_toggle(QMenu* menu, const QString& text, const QString& name, const std::function<void(bool)>& slot) {
  QAction* made = menu->addAction(text);
  made->setObjectName(name);
  made->setCheckable(true);
  QObject::connect(made, &QAction::toggled, menu, slot);
  return made;
}

/// As the menu key does, which many keyboards lack.
void show_menu_of_focus() {
  QWidget* focus = QApplication::focusWidget();
  if (!focus) return;
  const QPoint where = focus->inputMethodQuery(Qt::ImCursorRectangle).toRect().center();
  QContextMenuEvent asked(QContextMenuEvent::Keyboard, where, focus->mapToGlobal(where));
  QApplication::sendEvent(focus, &asked);
}

/// What the action does, and to which change, if there is one.
void name_change(QAction* action, const QString& what, QUndoStack& changes, void (QUndoStack::*told)(const QString&)) {
  action->setText(what);
  QObject::connect(&changes, told, action, [action, what](const QString& change) {
    action->setText(change.isEmpty() ? what : QStringLiteral("%1: %2").arg(what, change));
  });
}

}  // namespace

MainWindow::MainWindow() {
  setObjectName(QStringLiteral("main_window"));
  setWindowTitle(tr("Skein"));
  setAcceptDrops(true);
  setContextMenuPolicy(Qt::NoContextMenu);  // Qt's own would offer to hide things
  build_panels();
  build_controllers();
  lay_out();
  for (QAction* action : findChildren<QAction*>())  // for messages, which are windows of their own
    if (!action->shortcut().isEmpty()) addAction(action);
  connect_panels();
  connect_session();
  new StopGuard({[this] { return stop_by_key(); },
                 [this] { return runs_.live().all_stand() && !connect_->is_working() && !branch_->is_busy(); },
                 [this] { on_space(); }},
                run_bar_->stop_button(), this);
  docks_->set_usual();
  restore_settings();
}

MainWindow::~MainWindow() = default;

void MainWindow::build_panels() {
  run_bar_ = new RunBar;
  arena_ = new ArenaView;
  gains_ = new GainsPanel;
  plots_ = new PlotsPanel;
  robots_ = new RobotsPanel;
  robot_buttons_ = new RobotButtons;
  log_ = new EventPanel;
  results_ = new ResultPanel;
  alert_ = new AlertStrip;
  voice_ = new AlertVoice(this);
  connect(alert_, &AlertStrip::alarmed, voice_, &AlertVoice::say);
  check_list_ = new CheckList;
  check_list_->hide();
  left_behind_ = new LeftBehindBar;
  pace_ = new QLabel;
  pace_->setObjectName(QStringLiteral("pace"));
  pace_->setContentsMargins(8, 0, 8, 0);
}

void MainWindow::build_controllers() {
  LiveRun& live = runs_.live();
  messages_ = std::make_unique<Messages>(runs_, alert_, log_, this);
  arena_actions_ = new ArenaActions(arena_, this);
  branch_ = new BranchController(runs_, *messages_, this);
  checks_ = new CheckController(runs_, *messages_, check_list_, gains_, this);
  files_ = new FileController(live, *messages_, this);
  editor_ = new EditorController(runs_, *files_, *messages_, this);
  recording_ = new RecordingController(live, *messages_, this);
  replay_ = new ReplayController(runs_, *files_, *messages_, this);
  comparison_ = new ComparisonController(runs_, *messages_, arena_, plots_, this);
  pairs_ = new PairController(runs_, *messages_, gains_, arena_, this);
  reopen_ = new ReopenController(live, *messages_, this);
  preview_ = new PreviewController(runs_, gains_, arena_, plots_, this);
  result_ = new ResultController(runs_, *messages_, results_, this);
  robot_ = new RobotController(runs_, *messages_, robot_buttons_, this);
  calibration_ = new CalibrationController(live, *messages_, this);
  camera_ = new CameraController(runs_, *editor_, *messages_, this);
  connect_ = new ConnectController(runs_, *editor_, *messages_, this);
}

void MainWindow::lay_out() {
  // Above everything, and not a tool bar: STOP can be neither moved nor hidden.
  auto* top = new QWidget;
  auto* top_layout = new QVBoxLayout(top);
  top_layout->setContentsMargins(0, 0, 0, 0);
  top_layout->setSpacing(0);
  auto* menus = new QMenuBar;
  top_layout->addWidget(menus);
  top_layout->addWidget(run_bar_);
  setMenuWidget(top);

  auto* middle = new QWidget;
  auto* middle_layout = new QVBoxLayout(middle);
  middle_layout->setContentsMargins(0, 0, 0, 0);
  middle_layout->setSpacing(0);
  auto* tools = new QToolBar;
  build_menus(menus);
  arena_actions_->build_tool_bar(tools);
  draw_icons();
  connect(left_behind_, &LeftBehindBar::stopped, this,
          [this] { messages_->note(tr("The robots of the earlier run stand"), Severity::good); });
  middle_layout->addWidget(left_behind_);
  middle_layout->addWidget(tools);
  middle_layout->addWidget(check_list_);
  middle_layout->addWidget(arena_, 1);
  setCentralWidget(middle);

  auto* robots_box = new QWidget;
  auto* robots_layout = new QVBoxLayout(robots_box);
  robots_layout->setContentsMargins(0, 0, 0, 0);
  robots_layout->setSpacing(0);
  robots_layout->addWidget(robots_, 1);
  robots_layout->addWidget(robot_buttons_);
  docks_ = new DockLayout({gains_, plots_, robots_box, log_, results_}, this);

  statusBar()->setSizeGripEnabled(false);
  statusBar()->addWidget(alert_, 1);
  statusBar()->addPermanentWidget(pace_);
}

void MainWindow::go_to(QDockWidget* dock, QWidget* first) {
  bring_forward(dock);
  if (!first) return;
  first->setFocus(Qt::ShortcutFocusReason);
  // A table without a current cell shows nobody where the keys go.
  auto* table = qobject_cast<QAbstractItemView*>(first);
  if (table && !table->currentIndex().isValid() && table->model()->rowCount() > 0)
    table->setCurrentIndex(table->model()->index(0, 0));
}

void MainWindow::show_tip_of_focus() {
  QWidget* focus = QApplication::focusWidget();
  if (!focus) return;
  QWidget* of = focus;
  QPoint where = focus->rect().center();
  if (auto* table = qobject_cast<QAbstractItemView*>(focus)) {
    of = table->viewport();
    if (table->currentIndex().isValid()) where = table->visualRect(table->currentIndex()).center();
  } else if (focus == arena_) {
    where = arena_->place_of_keys();
  }
  QHelpEvent tip(QEvent::ToolTip, where, of->mapToGlobal(where));
  QApplication::sendEvent(of, &tip);
}

void MainWindow::build_menus(QMenuBar* menus) {
  QMenu* file = menus->addMenu(tr("&File"));
  files_->build_menu(file);
  editor_->build_menu(file);
  file->addSeparator();
  replay_->build_menu(file);
  comparison_->build_menu(file);
  file->addSeparator();
  save_csv_action_ =
      add(file, tr("&Save CSV …"), QStringLiteral("save_csv"), QKeySequence::Save, [this] { recording_->ask_save(); });
  add(file, tr("Save &plot …"), QStringLiteral("save_plot"), QKeySequence(tr("Ctrl+P")),
      [this] { ask_save_plot(false); });
  file->addSeparator();
  add(file, tr("&Quit"), QStringLiteral("quit"), QKeySequence(tr("Ctrl+Q")), [this] {
    close();
  })->setShortcutContext(Qt::ApplicationShortcut);  // in every dialog as well

  build_run_menu(menus->addMenu(tr("&Run")));
  QMenu* robots = menus->addMenu(tr("Ro&bots"));
  robots->setToolTipsVisible(true);
  add(robots, tr("&Connect robots …"), QStringLiteral("connect_robots_page"), {}, [this] {
    connect_->show();
  })->setToolTip(tr("Finds, pairs, pings and tests the robots, and says of each what is next"));
  robots->addSeparator();
  robots->addActions(robot_buttons_->actions());
  build_view_menu(menus->addMenu(tr("&View")));
  arena_actions_->build_tool_menu(menus->addMenu(tr("&Arena")));

  QMenu* help = menus->addMenu(tr("&Help"));
  add(help, tr("&Shortcuts"), QStringLiteral("shortcuts"), QKeySequence(tr("F1")), [this] {
    show_beside(new MessageDialog(QStringLiteral("shortcuts_dialog"), tr("Shortcuts"), shortcuts_text(), this));
  });
  add(help, tr("&Tip of what has the focus"), QStringLiteral("focus_tip"), QKeySequence(tr("Shift+F1")),
      [this] { show_tip_of_focus(); });
  add(help, tr("&Menu of what has the focus"), QStringLiteral("focus_menu"), QKeySequence(tr("Shift+F10")),
      [] { show_menu_of_focus(); });
  add(help, tr("&About Skein"), QStringLiteral("about"), {}, [this] {
    show_beside(new MessageDialog(QStringLiteral("about_dialog"), tr("About Skein"), about_text(), this));
  });
}

void MainWindow::build_run_menu(QMenu* run) {
  run->setToolTipsVisible(true);
  go_action_ =
      add(run, tr("Start / &pause / resume"), QStringLiteral("go_action"), QKeySequence(tr("F5")), [this] { go(); });
  go_action_->setToolTip(tr("Starts the run; later pauses and resumes it: the robots stand, and its clock too"));
  add(run, tr("One &tick on"), QStringLiteral("step_action"), QKeySequence(tr("F6")), [this] {
    step();
  })->setToolTip(tr("One period of the control loop, then a pause. Simulations and replays only"));
  add(run, tr("&Faster"), QStringLiteral("faster"), QKeySequence(tr("Ctrl+Up")), [this] {
    run_bar_->pick_speed(1);
  })->setToolTip(tr("The next higher speed of a simulation or a replay, up to 50 times real time"));
  add(run, tr("Sl&ower"), QStringLiteral("slower"), QKeySequence(tr("Ctrl+Down")), [this] {
    run_bar_->pick_speed(-1);
  })->setToolTip(tr("The next lower speed of a simulation or a replay, down to a tenth of real time"));
  new_run_action_ =
      add(run, tr("&New run"), QStringLiteral("new_run_action"), QKeySequence::New, [this] { new_run(); });
  new_run_action_->setToolTip(tr("Ends this run, and sets the same experiment up again; it waits for its start"));
  branch_->build_menu(run);
  QAction* rehearse =
      add(run, tr("Re&hearse without hardware"), QStringLiteral("rehearse"), {}, [this] { files_->rehearse(); });
  rehearse->setToolTip(tr("The same experiment with emulated robots and rendered pictures in place of the real ones"));
  run->addSeparator();
  build_files_of_run(run);
  run->addSeparator();
  // The keys stand in the text only: StopGuard takes them before any shortcut could.
  add(run, tr("STOP\tSpace, Esc"), QStringLiteral("stop_action"), {}, [this] {
    stop();
  })->setToolTip(tr("Stops every robot at once, and ends the run"));
  run->addSeparator();
  QUndoStack& changes = gains_->undo_stack();
  QAction* undo = changes.createUndoAction(this);
  name_change(undo, tr("&Undo gain"), changes, &QUndoStack::undoTextChanged);
  undo->setShortcut(QKeySequence::Undo);
  undo->setToolTip(tr("Takes the last change of a gain, a coupling or a parameter back"));
  QAction* redo = changes.createRedoAction(this);
  name_change(redo, tr("Re&do gain"), changes, &QUndoStack::redoTextChanged);
  redo->setShortcut(QKeySequence(tr("Ctrl+Shift+Z")));
  redo->setToolTip(tr("Makes the change again that was taken back last"));
  run->addActions({undo, redo});
  run->addSeparator();
  QAction* checks =
      add_toggle(run, tr("&Check list"), QStringLiteral("view_checks"), [this](bool on) { checks_->set_wanted(on); });
  checks->setShortcut(QKeySequence(tr("Ctrl+L")));
  checks->setToolTip(tr("What has to hold before a start, and what does not yet"));
  add(run, tr("C&amera …"), QStringLiteral("camera"), {}, [this] {
    camera_->show();
  })->setToolTip(tr("Looks through a camera: which tags it sees, how large, and how fast"));
  add(run, tr("Calibrate ca&mera …"), QStringLiteral("calibrate_camera"), {}, [this] {
    calibration_->calibrate();
  })->setToolTip(tr("Measures the lens with a board that you show, then the floor with tags that lie on it"));
}

/// What of a run becomes files.
void MainWindow::build_files_of_run(QMenu* run) {
  add(run, tr("&Record as CSV"), QStringLiteral("record_action"), QKeySequence(tr("Ctrl+R")),
      [this] { record(!recording_->records()); })
      ->setToolTip(tr("Writes this run and later ones to CSV files in %1, later ones with their film")
                       .arg(RecordingController::directory()));
  QAction* keep =
      add_toggle(run, tr("&Keep runs"), QStringLiteral("keep_runs"), [this](bool on) { recording_->keep(on); });
  keep->setChecked(recording_->keeps());
  keep->setToolTip(
      tr("Every run that begins from now on has a folder of its own, with everything that it needs to be "
         "repeated: `skein runs list` finds it"));
  QAction* films = add_toggle(run, tr("Keep the f&ilm of each run"), QStringLiteral("keep_films"),
                              [this](bool on) { recording_->keep_films(on); });
  films->setChecked(recording_->keeps_films());
  films->setEnabled(recording_->keeps());
  films->setToolTip(
      tr("With a camera, the folder of a kept run has every frame, so that `skein runs verify` measures every pose "
         "again.\nAbout 1 GB a minute at 1280x960 and 25 Hz; camera.film = \"small\" in the experiment takes a tenth. "
         "From the next New run on"));
  connect(keep, &QAction::toggled, films, &QAction::setEnabled);
}

void MainWindow::build_view_menu(QMenu* view) {
  arena_actions_->build_view_menu(view);
  view->addSeparator();
  dark_ = add_toggle(view, tr("Dar&k palette"), QStringLiteral("view_dark"),
                     [this](bool on) { set_theme(on ? Theme::dark : Theme::light); });
  add(view, tr("&Like the desktop"), QStringLiteral("view_as_desktop"), {}, [this] {
    set_theme(desktop_at_start_);
    theme_chosen_ = false;
  });
  add_toggle(view, tr("&Full screen"), QStringLiteral("view_full_screen"), [this](bool on) {
    on ? showFullScreen() : showNormal();
  })->setShortcut(QKeySequence(tr("F11")));
  voice_action_ =
      add_toggle(view, tr("&Speak alarms"), QStringLiteral("view_voice"), [this](bool on) { voice_->set_on(on); });
  voice_action_->setToolTip(
      AlertVoice::can_speak() ? tr("Says stops, lost tags and links and low batteries aloud")
                              : tr("Beeps at stops, lost tags and links and low batteries: this machine has no speech "
                                   "engine (Debian: qt6-speech-speechd-plugin and speech-dispatcher)"));
  QMenu* go = view->addMenu(tr("Go t&o"));
  const auto place = [&](const QString& text, const char* name, int number, const std::function<void()>& slot) {
    add(go, text, QLatin1String(name), QKeySequence(QStringLiteral("Ctrl+%1").arg(number)), slot);
  };
  place(tr("&Arena"), "go_to_arena", 1, [this] { arena_->setFocus(Qt::ShortcutFocusReason); });
  place(tr("&Gains"), "go_to_gains", 2, [this] { go_to(docks_->gains(), gains_->first_control()); });
  place(tr("&Plots"), "go_to_plots", 3,
        [this] { go_to(docks_->plots(), plots_->findChild<QWidget*>(QStringLiteral("plot"))); });
  place(tr("&Robots"), "go_to_robots", 4, [this] { go_to(docks_->robots(), robots_); });
  place(tr("&Events"), "go_to_events", 5,
        [this] { go_to(docks_->events(), log_->findChild<QWidget*>(QStringLiteral("event_log"))); });
  place(tr("Re&sults"), "go_to_results", 6,
        [this] { go_to(docks_->results(), results_->findChild<QWidget*>(QStringLiteral("result_table"))); });
  place(tr("&Time line"), "go_to_time", 7, [this] { run_bar_->time_line()->setFocus(Qt::ShortcutFocusReason); });
  QMenu* panels = view->addMenu(tr("&Panels"));
  connect(panels, &QMenu::aboutToShow, this, [this, panels] {  // the docks come after the menus
    panels->clear();
    docks_->fill_menu(panels);
  });
}

void MainWindow::connect_panels() {
  connect(run_bar_, &RunBar::go, this, &MainWindow::go);
  connect(run_bar_, &RunBar::step, this, &MainWindow::step);
  connect(run_bar_, &RunBar::new_run, this, &MainWindow::new_run);
  connect(run_bar_, &RunBar::stop, this, &MainWindow::stop);
  connect(run_bar_, &RunBar::speed_wanted, this, &MainWindow::set_speed);
  connect(run_bar_, &RunBar::record_wanted, this, &MainWindow::record);
  connect(run_bar_->time_line(), &TimeLine::time_wanted, this, &MainWindow::seek);
  connect(plots_, &PlotsPanel::time_wanted, this, &MainWindow::seek);
  connect(plots_, &PlotsPanel::save_wanted, this, &MainWindow::ask_save_plot);
  connect(log_, &EventPanel::time_picked, this, &MainWindow::seek);

  connect(arena_, &ArenaView::move_wanted, robot_, &RobotController::move);
  connect(arena_, &ArenaView::kick_wanted, robot_, &RobotController::kick);
  connect(arena_, &ArenaView::obstacle_wanted, robot_, &RobotController::put_obstacle);
  connect(arena_, &ArenaView::selected, this, &MainWindow::select_robot);
  connect(arena_, &ArenaView::refused, this, [this](const QString& why) { messages_->say(why, Severity::notice); });
  robots_->addActions(robot_buttons_->actions());
  auto* plotter = new CellPlotter(
      plots_, [this] { bring_forward(docks_->plots()); }, this);
  plotter->serve(robots_);
  plotter->serve(gains_->pair_cells());
  connect(robots_, &RobotsPanel::picked, arena_, &ArenaView::select);
  connect(robot_buttons_, &RobotButtons::connect_again, this, &MainWindow::new_run);
  connect(robot_, &RobotController::testing, checks_, &CheckController::set_testing);
  connect(gains_, &GainsPanel::experiment_wanted, reopen_, &ReopenController::reopen_with);
  connect(reopen_, &ReopenController::experiment_wanted, this,
          [this](const app::Experiment& experiment) { open(experiment, false); });
  connect(reopen_, &ReopenController::refused, this, [this] {
    show_run();
    on_opened();
  });
  connect(check_list_, &CheckList::mend, this, &MainWindow::mend);
  connect(check_list_, &CheckList::tag_size_wanted, editor_, [this](double size) {
    editor_->save_with({{QStringLiteral("tags.size"), QString::number(size)}});
  });
  connect(files_, &FileController::experiment_wanted, this,
          [this](const app::Experiment& experiment) { open(experiment, false); });
  comparison_->set_kicks([this] {
    const RunResults* results = results_->results();
    return results ? results->kicks() : std::vector<RunResults::Kick>();
  });
  connect(comparison_, &ComparisonController::compared, this, [this] {
    std::vector<RunBeside> others;
    for (std::size_t k = 0; k < comparison_->runs().size(); ++k) {
      const ComparisonController::Run& run = comparison_->runs()[k];
      if (run.shown) others.push_back({compared_letter(k), run.name, run.results});
    }
    results_->compare(std::move(others));
  });
  connect(branch_, &BranchController::experiment_wanted, this, [this](const app::Experiment& experiment) {
    comparison_->compare_with_now();
    const QString file = runs_.shown().file();  // a recording has none, whatever was open before it
    open(experiment, true);
    set_experiment_file(file);
  });
  connect(recording_, &RecordingController::saved, this, &MainWindow::saved);
  connect(recording_, &RecordingController::keeping, results_, &ResultPanel::show_kept);
  connect(calibration_, &CalibrationController::session_ends, this, &MainWindow::let_go_of_session);
  connect(connect_, &ConnectController::session_ends, this, &MainWindow::let_go_of_session);
  connect(connect_, &ConnectController::experiment_wanted, this,
          [this](const app::Experiment& experiment) { open(experiment, false); });
}

void MainWindow::connect_session() {
  connect(&runs_, &Runs::shown_changed, this, &MainWindow::show_run);
  connect(&runs_, &Runs::session_ends, this, &MainWindow::let_go_of_session);
  connect(&runs_, &Runs::changed, this, &MainWindow::show_state);
  connect(&runs_, &Runs::row_added, plots_, &PlotsPanel::show_record);
  connect(&runs_, &Runs::row_added, log_,
          [this](const app::TickRecord& record) { log_->show_record(record, runs_.shown().robots()); });
  connect(&runs_, &Runs::row_added, results_, &ResultPanel::show_record);
  connect(&runs_, &Runs::record_shown, this, [this](const app::TickRecord& record) {
    arena_->show_record(record);
    run_bar_->show_record(record);
    gains_->show_record(record);
    alert_->show_record(record, runs_.shown().robots());
    pairs_->explain(record);
  });

  connect(&runs_.replay(), &ReplayRun::jumped, arena_, &ArenaView::set_circumstances);
  const LiveRun* live = &runs_.live();
  connect(live, &LiveRun::opened, this, &MainWindow::on_opened);
  connect(live, &LiveRun::open_failed, this, &MainWindow::on_open_failed);
  connect(live, &LiveRun::frame, this, &MainWindow::on_frame);
  connect(live, &LiveRun::record_shown, this, [this](const app::TickRecord& record) {
    for (const app::Event& event : record.events)
      if (app::is<app::events::Move, app::events::Kick>(event)) teaches_ = false;
  });
  connect(live, &LiveRun::refused, this, [this](const QString& why) { messages_->note(why, Severity::warning); });
  connect(live, &LiveRun::was_away, this, [this](double seconds) {
    messages_->note(tr("The window stalled for %1 s; the control loop did not").arg(seconds, 0, 'f', 1),
                    Severity::warning);
  });
  connect(live, &LiveRun::rows_missed, this, [this](int rows) {
    messages_->note(tr("The window hung: it has missed %1; the recording has them.").arg(counted(rows, "row")),
                    Severity::warning);
  });
  connect(live, &LiveRun::closed, this, [this] {
    connect_->close([this] {
      may_close_ = true;
      close();
    });
  });
}

void MainWindow::open(const app::Experiment& experiment, bool start_at_once) {
  if (runs_.live().is_busy()) return;
  if (connect_->is_working()) {  // a robot has one master
    messages_->say(tr("Robots are being set up: that is ended first"), Severity::notice);
    return connect_->end_then([this, experiment, start_at_once] { open(experiment, start_at_once); });
  }
  branch_->drop();
  teaches_ = start_at_once;
  camera_->let_go();
  runs_.live().open(experiment, start_at_once, recording_->film(experiment));
  runs_.show_live();
  checks_->begin();
  show_state();
}

void MainWindow::open_file(const QString& file) {
  files_->open(file);
}

void MainWindow::set_experiment_file(const QString& file) {
  files_->set_experiment_file(file);
}

void MainWindow::open_recording(const QString& file) {
  files_->open_recording(file);
}

void MainWindow::compare_with(const QString& file) {
  comparison_->load(file);
}

void MainWindow::save_csv(const QString& file) {
  recording_->save(file);
}

void MainWindow::record_to(const QString& file) {
  recording_->record_to(file);
}

void MainWindow::show_run() {
  const RunSource& run = runs_.shown();
  const app::Experiment& experiment = run.experiment();
  setWindowTitle(tr("%1 – Skein").arg(run.title()));
  run_bar_->show_experiment(experiment);
  run_bar_->time_line()->set_scrubbable(run.is_complete(), run.rows());
  arena_->show_experiment(experiment);
  gains_->show_experiment(experiment, [&run](core::GainName gain) { return run.gain_limit(gain); });
  docks_->gains()->setWindowTitle(!GainsPanel::has_anything_to_set(experiment) ? tr("Gains: one robot has none")
                                  : experiment.controller.law.uses_gains()     ? tr("Coupling gains")
                                                                               : tr("Parameters of the law"));
  plots_->show_experiment(experiment);
  if (run.is_complete()) plots_->set_span(0.0);
  results_->show_experiment(experiment);
  robots_->robots().show_experiment(experiment);
  robot_buttons_->show_experiment(experiment);
  log_->clear();
  alert_->clear_alert();
  for (const Notice& found : run.findings()) log_->note(run.t(), found.text, found.severity);
  arena_actions_->show_experiment(experiment);
  comparison_->show_experiment();
}

void MainWindow::on_opened() {
  const LiveRun& live = runs_.live();
  gains_->show_experiment(live.experiment(), [&live](core::GainName gain) { return live.gain_limit(gain); });
  if (const auto why = live.unguarded()) {  // nothing would stop the robots should this program be killed
    const QString text = tr("NO GUARD: if this program is killed, nothing stops the robots (%1)").arg(*why);
    log_->note(0.0, text, Severity::warning);
    alert_->warn_unguarded(text);
  }
  if (live.has_camera())
    arena_->set_camera([&live](QPointF floor) {
      const auto [u, v] = live.pixel(floor.x(), floor.y());
      return QPointF(u, v);
    });
  show_state();
}

void MainWindow::on_open_failed(const QString& reason) {
  log_->note(0.0, reason, Severity::alarm);
  alert_->hold(reason, Severity::alarm);
  QString text = reason;
  if (app::has_hardware(runs_.live().experiment()))
    text += QStringLiteral("\n\n") + tr("Run | Rehearse without hardware opens it with emulated robots.");
  messages_->show_problem(tr("The experiment could not be opened"), text);  // the banner says it as well
}

void MainWindow::on_frame(double now) {
  if (app::interrupted() && !may_close_) close();
  for (const QString& sentence : runs_.live().alarms()) log_->note(0.0, sentence, Severity::alarm);
  calibration_->refresh();
  connect_->refresh();
  app::Picture picture;
  if ((arena_->shows_picture() || camera_->wants_picture()) && runs_.live().picture(picture)) {
    camera_->show_picture(picture);
    if (arena_->shows_picture()) arena_->set_picture(picture);
  }
  arena_->refresh();
  alert_->refresh();
  const Colours c = colours(palette());
  const app::Phase phase = runs_.shown().phase();
  // Where the eye is; what the banner says already needs no second line.
  const bool over = phase == app::Phase::stopped || phase == app::Phase::finished;
  const bool alarm = alert_->severity() == Severity::alarm;
  arena_->set_alert(over ? QString() : alert_->loud_beside_banner(), alarm ? c.alarm_fill : c.warning);
  files_->refresh();
  branch_->refresh();
  reopen_->refresh();
  replay_->refresh();
  comparison_->refresh();
  preview_->refresh();
  result_->refresh();
  recording_->refresh();
  // A question to the display, which waits for the answer: one that has stalled holds this thread up as well, and who
  // cannot see the robots cannot stop them. The session takes care of that (3 s).
  if (questions_.due(now)) {
    static_cast<void>(QCursor::pos());
    compositor_.ask();
  }
  if (texts_.due(now) || phase != shown_phase_) show_state();
}

void MainWindow::show_state() {
  const RunSource& run = runs_.shown();
  RunState state = run.state();
  const app::Phase phase = shown_phase_ = run.phase();
  go_action_->setEnabled(state.may_go);
  new_run_action_->setEnabled(state.new_run.possible);
  save_csv_action_->setEnabled(state.may_save && !recording_->is_saving());
  checks_->refresh();

  const bool may_be_ready = run.is_open() && run.latest() && run.is_before_start();
  const QString file = files_->reading() + replay_->reading();  // one of them at most
  const QString preparing = reopen_->is_busy() ? tr("Preparing the changed experiment …") : branch_->doing();
  const QString reading = file.isEmpty() ? preparing : reading_text(file);
  const bool nothing_else = !reading.isEmpty() && !run.is_open() && !run.is_busy() && !run.is_complete();
  const Notice banner = nothing_else ? Notice{reading} : may_be_ready ? checks_->banner() : run.banner();
  const bool unready = may_be_ready && phase == app::Phase::ready && !checks_->all_hold();
  const bool there = run.is_open() || run.is_complete();
  if (unready) state.words = tr("Not ready");
  if (unready) state.tone = Severity::warning;
  run_bar_->show_state(state);
  const QString left_behind = left_behind_->brief(), well = left_behind.isEmpty() ? tr("All well") : left_behind;
  alert_->rest_on(!reading.isEmpty() ? reading : unready || !there ? banner.text : well);
  const bool listed = unready && check_list_->isVisible();  // right above the arena, with the reason
  arena_->set_banner(listed ? QString() : banner.text, banner.severity == Severity::alarm);
  if (const Notice lasting = run.lasting_alert(); !lasting.text.isEmpty()) alert_->hold(lasting.text, lasting.severity);
  const bool over = phase == app::Phase::stopped || phase == app::Phase::finished;
  const QString preview = preview_->hint();
  arena_->set_hint(!preview.isEmpty() ? preview
                   : run.is_open() && teaches_ && !over
                       ? tr("Drag a robot out of the formation; turn it with the mouse wheel; Shift+drag kicks it")
                       : QString(),
                   preview.isEmpty());

  const QString fixed = run.why_fixed();
  gains_->setEnabled((there || run.is_busy()) && GainsPanel::has_anything_to_set(run.experiment()));
  gains_->set_fixed(fixed);
  arena_->set_fixed(fixed);
  gains_->set_before_start(run.is_open() && phase == app::Phase::ready);
  robot_buttons_->setEnabled(!run.is_complete());
  robot_buttons_->show_state({run.robots(), run.circumstances().held, phase, run.is_open(), run.is_busy()});
  plots_->set_playhead(run.is_complete() ? std::optional(run.t()) : std::nullopt);
  show_timing();
  results_->refresh();
  show_numbers();
  if (!run.latest()) return;
  arena_->set_may_be_driving(run.may_be_driving());
  const LiveRun& live = runs_.live();
  arena_->set_unseen(&run == &live ? live.camera().why_lost : std::vector<app::UnseenTag>());
  robots_->robots().show_record(
      *run.latest(), {run.robots(), run.stop_asked(), run.circumstances(), run.may_be_driving(), run.is_complete()});
  QStringList low;
  const auto& robots = run.robots();
  for (std::size_t i = 0; i < robots.size(); ++i)
    if (robots[i].battery_low) low << QString::number(i + 1);
  alert_->warn_batteries(over ? QStringList() : low);
  pairs_->refresh();
}

void MainWindow::show_timing() {
  const auto timing = runs_.shown().timing();
  const QString text = timing ? timing_text(*timing) : QString();
  const QString what = tr("Period of the control loop, and the duration of a tick");
  pace_->setToolTip(text.isEmpty() ? what : what + QLatin1Char('\n') + text);
  results_->show_timing(text);
}

void MainWindow::show_numbers() {
  const app::TickRecord* record = runs_.shown().latest();
  if (!record) return pace_->clear();
  QStringList known;
  const auto lost = [](const app::RobotRecord& robot) { return robot.is(app::lost); };
  const bool anybody = !std::all_of(record->robots.begin(), record->robots.end(), lost);
  if (anybody && std::isfinite(record->min_distance))
    known << tr("closest pair %1 cm").arg(record->min_distance * 100, 0, 'f', 1);
  if (record->period > 0.0) known << tr("%1 Hz").arg(1.0 / record->period, 0, 'f', 1);  // the first tick has none
  if (std::isfinite(record->compute_time)) known << tr("tick %1 µs").arg(record->compute_time * 1e6, 0, 'f', 0);
  pace_->setText(known.join(QStringLiteral("   ·   ")));
}

void MainWindow::select_robot(int robot) {
  plots_->select(robot);
  robots_->select_robot(robot);
  robot_buttons_->select_robot(robot);
}

void MainWindow::stop() {
  runs_.live().stop();  // before anything else
  connect_->stop();
  branch_->drop();  // nothing starts by itself after a STOP
  show_state();
}

bool MainWindow::stop_by_key() {
  const LiveRun& live = runs_.live();
  const bool could_move = (live.is_open() || live.is_busy()) && !live.stop_asked() &&
                          live.phase() != app::Phase::stopped && live.phase() != app::Phase::finished;
  const bool was_working = connect_->is_working() || branch_->is_busy();
  stop();
  return could_move || was_working;
}

/// Where nothing can be stopped, Space pauses what plays.
void MainWindow::on_space() {
  if (runs_.shown().is_complete()) messages_->tell(runs_.shown().go());
}

void MainWindow::go() {
  RunSource& run = runs_.shown();
  switch (run.state().go) {
    case RunState::Go::start:
      // With which of the two, nobody could say.
      if (reopen_->is_busy())
        return messages_->say(tr("Not started: the changed experiment is still being prepared"), Severity::warning);
      return checks_->start(false);
    case RunState::Go::again:
      return new_run();
    case RunState::Go::pause:
    case RunState::Go::resume:
    case RunState::Go::play:
      return messages_->tell(run.go());
  }
}

void MainWindow::step() {
  messages_->tell(runs_.shown().step());
}

void MainWindow::set_speed(double speed) {
  messages_->tell(runs_.shown().set_speed(speed));
  show_state();
}

void MainWindow::seek(double t) {
  if (!runs_.shown().seek(t)) plots_->show_time(t);
}

void MainWindow::record(bool on) {
  if (runs_.shown().state().record.possible) recording_->record(on);
  show_state();
}

void MainWindow::new_run() {
  const bool teaches = teaches_;
  // A replay that the window began with has no live experiment behind it: then its own is set up.
  const app::Experiment& before = runs_.live().experiment();
  app::Experiment again(before.robots.empty() ? runs_.shown().experiment() : before);
  if (again.robots.empty()) return messages_->say(tr("No experiment is open: open a file first"), Severity::notice);
  branch_->forget_pause(again);
  open(again, false);
  teaches_ = teaches;
}

void MainWindow::mend(app::Check::What what) {
  using What = app::Check::What;
  switch (what) {
    case What::camera:
      return calibration_->calibrate(runs_.live().camera().marks.moved.has_value());
    case What::settings:
      return camera_->show();
    case What::tags:
      return arena_actions_->show_picture();
    case What::links:
      return new_run();
    case What::gains:
      return bring_forward(docks_->gains());
    case What::batteries: {
      bring_forward(docks_->robots());
      const auto& robots = runs_.live().robots();
      for (std::size_t i = 0; i < robots.size(); ++i)
        if (robots[i].battery_low) return arena_->select(static_cast<int>(i));
      return;
    }
    case What::reference:
      return editor_->edit_experiment();
    case What::places:
      return robot_->bring_to_places();
  }
}

void MainWindow::let_go_of_session() {
  branch_->drop();
  arena_->set_camera(nullptr);  // it goes with the session
}

QString MainWindow::close_session() {
  LiveRun& live = runs_.live();
  connect_->stop();
  QString problem = live.close_now();
  connect_->close_now();
  if (!problem.isEmpty()) return problem;
  QStringList missing;
  for (std::size_t i = 0; i < live.robots().size(); ++i)
    if (!live.robots()[i].stop_acknowledged) missing << QString::number(i + 1);
  if (missing.isEmpty()) return tr("all robots have stopped");
  return tr("robot %1 has NOT acknowledged its stop and may still be driving: switch it off by hand")
      .arg(missing.join(QStringLiteral(", ")));
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (may_close_) {
    store_settings();
    event->accept();
    return;
  }
  event->ignore();
  if (!app::interrupted() && isEnabled() && editor_->ask_about_changes()) return;
  // The robots first; the window goes when they stand, or have not answered for a second.
  let_go_of_session();
  files_->drop();
  branch_->drop();
  reopen_->drop();
  connect_->stop();
  runs_.live().close();
  setEnabled(false);
  alert_->hold(tr("Stopping all robots …"), Severity::warning);
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (!FileController::dragged(event->mimeData()).isEmpty()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  const QString file = FileController::dragged(event->mimeData());
  if (file.isEmpty()) return;
  event->acceptProposedAction();
  // Once the drop is over: whoever drags waits for it.
  QMetaObject::invokeMethod(
      this, [this, file] { open_file(file); }, Qt::QueuedConnection);
}

void MainWindow::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) draw_icons();
  QMainWindow::changeEvent(event);
}

void MainWindow::draw_icons() {
  arena_actions_->draw_icons(colours(palette()).text);
}

void MainWindow::set_theme(Theme theme) {
  theme_chosen_ = true;
  apply(theme);
  const QSignalBlocker quiet(dark_);
  dark_->setChecked(theme == Theme::dark);
}

void MainWindow::ask_save_plot(bool everything) {
  QFileDialog* dialog =
      file_dialog(this, {tr("Save plot"),
                         QStringLiteral("save_plot_dialog"),
                         tr("PDF (*.pdf);;PNG (*.png);;CSV (*.csv)"),
                         {},
                         QString::fromStdString(runs_.shown().experiment().name) + QStringLiteral("-errors.pdf")});
  connect(dialog, &QFileDialog::filterSelected, dialog,
          [dialog](const QString& filter) { dialog->setDefaultSuffix(filter.left(3).toLower()); });
  connect(dialog, &QFileDialog::fileSelected, this,
          [this, everything](const QString& file) { save_plot(file, everything); });
  dialog->show();
}

void MainWindow::save_plot(const QString& file, bool everything) {
  const QString problem = plots_->save(file, everything);
  if (problem.isEmpty())
    messages_->say(tr("Saved %1").arg(file), Severity::good);
  else
    messages_->problem(tr("The plot was not saved"), problem);
}

void MainWindow::restore_settings() {
  const QSettings stored = settings();
  const QString theme = stored.value(QStringLiteral("theme")).toString();
  set_theme(theme.isEmpty() ? desktop_at_start_ : theme == QStringLiteral("dark") ? Theme::dark : Theme::light);
  theme_chosen_ = !theme.isEmpty();
  docks_->restore(stored);
  plots_->show_plots(stored.value(QStringLiteral("plots")).toStringList());
  arena_actions_->restore(stored);
  voice_action_->setChecked(stored.value(QStringLiteral("speak_alarms")).toBool());
}

void MainWindow::store_settings() {
  QSettings stored = settings();
  if (theme_chosen_)
    stored.setValue(QStringLiteral("theme"), dark_->isChecked() ? QStringLiteral("dark") : QStringLiteral("light"));
  else
    stored.remove(QStringLiteral("theme"));
  docks_->store(stored);
  stored.setValue(QStringLiteral("plots"), plots_->shown());
  arena_actions_->store(stored);
  stored.setValue(QStringLiteral("speak_alarms"), voice_->is_on());
}

}  // namespace skein::ui
