#include "ui/main/main_window.h"

#include <QCloseEvent>
#include <QCursor>
#include <QHeaderView>
#include <QMenuBar>
#include <QStatusBar>
#include <QVBoxLayout>
#include <chrono>
#include <cmath>
#include <utility>

#include "app/run/interrupted.h"
#include "ui/arena/arena_view.h"
#include "ui/calibration/calibration_dialog.h"
#include "ui/gains/gains_panel.h"
#include "ui/plots/plots_panel.h"
#include "ui/robots/robot_buttons.h"
#include "ui/robots/robots_panel.h"
#include "ui/run/alert_strip.h"
#include "ui/run/check_list.h"
#include "ui/run/event_log.h"
#include "ui/run/run_bar.h"
#include "ui/run/stop_guard.h"

namespace skein::ui {
namespace {

constexpr int frames_per_text = 6;       // numbers that change five times a second can be read
constexpr int frames_per_question = 15;  // to the display

}  // namespace

MainWindow::MainWindow() {
  setObjectName(QStringLiteral("main_window"));
  setWindowTitle(tr("Skein"));
  setAcceptDrops(true);
  setContextMenuPolicy(Qt::NoContextMenu);  // Qt's own would offer to hide things
  build_panels();
  connect_panels();
  new StopGuard([this] { return stop_by_key(); }, run_bar_->stop_button(), this);
  default_layout();
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
  alert_ = new AlertStrip;
  checks_ = new CheckList;
  checks_->hide();
  pace_ = new QLabel;
  pace_->setObjectName(QStringLiteral("pace"));
  pace_->setToolTip(tr("Pace of the control loop, and what a tick takes of it"));
  pace_->setContentsMargins(8, 0, 8, 0);

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
  build_arena_tools(tools);
  middle_layout->addWidget(tools);
  middle_layout->addWidget(checks_);
  middle_layout->addWidget(arena_, 1);
  setCentralWidget(middle);

  gains_dock_ = dock(gains_, tr("Coupling gains"), QStringLiteral("gains_dock"), Qt::LeftDockWidgetArea);
  plots_dock_ = dock(plots_, tr("Plots"), QStringLiteral("plots_dock"), Qt::RightDockWidgetArea);
  auto* robots_box = new QWidget;
  auto* robots_layout = new QVBoxLayout(robots_box);
  robots_layout->setContentsMargins(0, 0, 0, 0);
  robots_layout->setSpacing(0);
  robots_layout->addWidget(robots_, 1);
  robots_layout->addWidget(robot_buttons_);
  robots_dock_ = dock(robots_box, tr("Robots"), QStringLiteral("robots_dock"), Qt::BottomDockWidgetArea);
  log_dock_ = dock(log_, tr("Events"), QStringLiteral("log_dock"), Qt::BottomDockWidgetArea);

  statusBar()->setSizeGripEnabled(false);
  statusBar()->addWidget(alert_, 1);
  statusBar()->addPermanentWidget(pace_);
}

QDockWidget* MainWindow::dock(QWidget* panel, const QString& title, const QString& name, Qt::DockWidgetArea area) {
  auto* dock = new QDockWidget(title, this);
  dock->setObjectName(name);
  dock->setWidget(panel);
  dock->setFeatures(QDockWidget::DockWidgetMovable | QDockWidget::DockWidgetClosable);
  addDockWidget(area, dock);
  return dock;
}

void MainWindow::default_layout() {
  for (QDockWidget* dock : {gains_dock_, plots_dock_, robots_dock_, log_dock_}) {
    dock->setFloating(false);
    dock->show();
  }
  setCorner(Qt::BottomLeftCorner, Qt::BottomDockWidgetArea);
  setCorner(Qt::BottomRightCorner, Qt::RightDockWidgetArea);
  addDockWidget(Qt::LeftDockWidgetArea, gains_dock_);
  addDockWidget(Qt::RightDockWidgetArea, plots_dock_);
  addDockWidget(Qt::BottomDockWidgetArea, robots_dock_);
  splitDockWidget(robots_dock_, log_dock_, Qt::Horizontal);
  resize(1280, 800);
  resizeDocks({gains_dock_, plots_dock_}, {250, 400}, Qt::Horizontal);
  resizeDocks({robots_dock_, log_dock_}, {600, 280}, Qt::Horizontal);
  resizeDocks({robots_dock_}, {176}, Qt::Vertical);
}

void MainWindow::connect_panels() {
  connect_run();
  connect_replay();
  connect(arena_, &ArenaView::move_wanted, this,
          [this](int robot, const core::Pose& pose) { tell(live_.move_robot(static_cast<std::size_t>(robot), pose)); });
  connect(arena_, &ArenaView::kick_wanted, this, [this](int robot, QPointF velocity) {
    tell(live_.kick_robot(static_cast<std::size_t>(robot), velocity.x(), velocity.y()));
  });
  connect(arena_, &ArenaView::obstacle_wanted, this,
          [this](int number, const core::Obstacle& obstacle) { tell(live_.put_obstacle(number, obstacle)); });
  connect(arena_, &ArenaView::selected, this, &MainWindow::select_robot);
  connect(arena_, &ArenaView::refused, this, [this](const QString& why) { alert_->say(why, Severity::notice); });
  connect_robots();
  connect(gains_, &GainsPanel::wanted, this,
          [this](core::GainName gain, double value) { live_.set_gain(gain, value, gains_->ramp()); });
  connect(&live_, &LiveSession::refused, this, [this](const QString& why) { note(why, Severity::warning); });
  connect_pairs();
  connect(gains_, &GainsPanel::experiment_wanted, this, &MainWindow::reopen_with);
  connect(plots_, &PlotsPanel::save_wanted, this, &MainWindow::ask_save_plot);
  connect(checks_, &CheckList::mend, this, &MainWindow::mend);
  connect(checks_, &CheckList::start_anyway, this, [this] { start_if_ready(true); });
  connect(&live_, &LiveSession::opened, this, &MainWindow::on_opened);
  connect(&live_, &LiveSession::open_failed, this, &MainWindow::on_open_failed);
  connect(&live_, &LiveSession::record_taken, this, &MainWindow::on_record);
  connect(&live_, &LiveSession::frame, this, &MainWindow::on_frame);
  connect(&live_, &LiveSession::closed, this, [this] {
    may_close_ = true;
    close();
  });
}

void MainWindow::open(const app::Experiment& experiment, bool start_at_once) {
  if (live_.is_busy()) return;
  leave_replay();
  teaches_ = start_at_once;
  const bool films = records_ && experiment.camera.kind() != app::CameraKind::absent;
  live_.open(experiment, start_at_once, films ? recording_path(experiment, QStringLiteral(".mkv")) : QString());
  show_experiment();
}

void MainWindow::show_experiment() {
  show_experiment_of(live_.experiment());
  begin_checks();
  show_state();
}

void MainWindow::show_experiment_of(const app::Experiment& experiment) {
  setWindowTitle(tr("%1 – Skein").arg(QString::fromStdString(experiment.name)));
  run_bar_->show_experiment(experiment);
  arena_->show_experiment(experiment);
  gains_->show_experiment(experiment, [this](core::GainName gain) { return live_.gain_border(gain); });
  plots_->show_experiment(experiment);
  robots_->robots().show_experiment(experiment);
  robot_buttons_->show_experiment(experiment);
  rows_missed_ = 0;
  log_->clear();
  alert_->clear_alert();
  picture_->setEnabled(experiment.camera.kind() != app::CameraKind::absent);
  regions_->setEnabled(experiment.avoidance.enabled || experiment.shield.enabled);
  const bool comparable = other_ && other_->experiment.robots.size() == experiment.robots.size();
  compare(comparable ? other_ : nullptr);
}

void MainWindow::on_opened() {
  const auto border = [this](core::GainName gain) { return live_.gain_border(gain); };
  gains_->show_experiment(live_.experiment(), border);
  warn_unguarded();
  if (live_.has_camera())
    arena_->set_camera([this](QPointF floor) {
      const auto [u, v] = live_.pixel(floor.x(), floor.y());
      return QPointF(u, v);
    });
  show_state();
}

void MainWindow::on_open_failed(const QString& reason) {
  log_->note(0.0, reason, Severity::alarm);
  alert_->hold(reason, Severity::alarm);
  show_problem(tr("The experiment could not be opened"), reason);
}

void MainWindow::on_record(const app::TickRecord& record) {
  arena_->take(record);
  run_bar_->take(record);
  gains_->take(record);
  robot_buttons_->take(record);
  plots_->take(record);
  log_->take(record);
  alert_->take(record);
  for (const app::Event& event : record.events)
    if (app::is<app::events::Move, app::events::Kick>(event)) teaches_ = false;
}

void MainWindow::on_frame() {
  if (app::interrupted() && !may_close_) close();
  if (calibrating_ && !live_.is_busy()) std::exchange(calibrating_, nullptr)->look();
  for (const QString& sentence : live_.alarms()) log_->note(0.0, sentence, Severity::alarm);
  app::Picture picture;
  if (arena_->shows_picture() && live_.picture(picture)) arena_->take(picture);
  arena_->refresh();
  alert_->refresh();
  const Colours c = colours(palette());
  // Where the eye is; what the banner says already needs no second line.
  const bool said = shown_phase_ == app::Phase::stopped || shown_phase_ == app::Phase::finished ||
                    (shown_phase_ == app::Phase::ready && !alert_->lost_robots().isEmpty());
  arena_->set_alert(said ? QString() : alert_->loud(),
                    alert_->severity() == Severity::alarm ? c.alarm_fill : c.warning);
  take_loaded();
  if (live_.latest()) show_other(live_.latest()->t);
  if (saving_ && saving_->problem.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const QString file = saving_->file, problem = saving_->problem.get();
    saving_.reset();
    if (!problem.isEmpty())
      show_problem(tr("The run was not saved"), problem);
    else if (const auto gone = live_.history().dropped())
      alert_->say(tr("Saved %1 without its first %2 rows: the run was too long to keep them").arg(file).arg(gone),
                  Severity::warning);
    else
      alert_->say(tr("Saved %1").arg(file), Severity::good);
    emit saved(file, problem);
  }
  // A question to the display, which waits for the answer: one that has stalled holds this thread up as well, and who
  // cannot see the robots cannot stop them. The session takes care of that (3 s).
  if (frames_ % frames_per_question == 0) static_cast<void>(QCursor::pos());
  if (++frames_ % frames_per_text == 0 || live_.phase() != shown_phase_) show_state();
}

void MainWindow::show_state() {
  if (player_.is_loaded()) return show_replay();
  const app::TickRecord* record = live_.latest();
  const app::Phase phase = shown_phase_ = live_.phase();
  const bool opening = live_.is_open() ? record == nullptr : live_.is_busy();
  const bool failed = !live_.is_open() && !live_.is_busy();
  run_bar_->show_state(run_state());
  const bool over = phase == app::Phase::stopped || phase == app::Phase::finished;
  go_action_->setEnabled(live_.is_open() && !opening && !over);
  show_checks();
  new_run_action_->setEnabled(!live_.is_busy());
  save_csv_action_->setEnabled(live_.history().size() > 0 && !saving_);

  QString banner;
  if (opening)
    banner = tr("Opening …");
  else if (failed)
    banner = live_.failure() ? tr("The experiment could not be opened") : tr("No experiment is open");
  else if (phase == app::Phase::ready && !alert_->lost_robots().isEmpty())
    banner = tr("Waiting: no tag seen of robot %1").arg(alert_->lost_robots());
  else if (phase == app::Phase::ready)
    banner = tr("Ready – start with F5");
  else if (phase == app::Phase::paused)
    banner = tr("Paused – reference and robots stand");
  else if (phase == app::Phase::stopped)
    banner = stopped_text();
  else if (phase == app::Phase::finished)
    banner = tr("Finished – new run: Ctrl+N");
  arena_->set_banner(banner, failed || phase == app::Phase::stopped);
  if (phase == app::Phase::stopped) alert_->hold(stopped_text() + acknowledgements(), Severity::alarm);
  const bool can_drag = live_.is_open() && teaches_ && !over;
  arena_->set_hint(can_drag ? tr("Drag a robot out of the formation; turn it with the mouse wheel; Shift+drag kicks it")
                            : QString());

  if (failed) gains_->setEnabled(false);  // until an experiment is shown again
  robot_buttons_->show_state(live_.robots(), phase, live_.is_open(), live_.is_busy());
  if (!record) return;
  robots_->robots().take(*record, live_.robots(), live_.stop_asked(), robot_buttons_->held());
  if (const std::uint64_t missed = live_.undrained_rows(); missed > rows_missed_) {
    const QString text = tr("The window hung: it has missed %n row(s). The record has them.", nullptr,
                            static_cast<int>(missed - rows_missed_));
    rows_missed_ = missed;
    log_->note(record->t, text, Severity::warning);
    alert_->say(text, Severity::warning);
  }
  gains_->set_borders([this](core::GainName gain) { return live_.gain_border(gain); },
                      [this](core::GainName gain) { return live_.gain_border_now(gain); });
  gains_->set_before_start(live_.is_open() && phase == app::Phase::ready);
  show_pairs();
  show_numbers(*record);
}

void MainWindow::show_numbers(const app::TickRecord& record) {
  const QString closest = std::isfinite(record.min_distance)
                              ? tr("closest pair %1 cm").arg(record.min_distance * 100, 0, 'f', 1)
                              : QString();
  const QString tick =
      std::isfinite(record.compute_time) ? tr("tick %1 µs").arg(record.compute_time * 1e6, 0, 'f', 0) : QString();
  const QString rate = tr("%1 Hz").arg(1.0 / record.period, 0, 'f', 1);
  QStringList known{closest, rate, tick};
  known.removeAll(QString());
  pace_->setText(known.join(QStringLiteral("   ·   ")));
}

QString MainWindow::stopped_text() const {
  const auto failure = live_.failure();
  return failure ? tr("STOPPED: %1").arg(*failure) : tr("STOPPED by operator – new run: Ctrl+N");
}

QString MainWindow::acknowledgements() const {
  QStringList missing;
  bool any_link = false;
  const auto& specs = live_.experiment().robots;
  for (std::size_t i = 0; i < specs.size() && i < live_.robots().size(); ++i) {
    if (specs[i].link == app::RobotSpec::Link::sim) continue;
    any_link = true;
    if (!live_.robots()[i].stop_acknowledged) missing << QString::number(i + 1);
  }
  if (!any_link) return {};
  if (missing.isEmpty()) return tr(". All robots have acknowledged.");
  const QString robots = missing.join(QStringLiteral(", "));
  return live_.stop_is_due() ? tr(". NOT acknowledged by robot %1!").arg(robots)
                             : tr(". Waiting for robot %1 to acknowledge.").arg(robots);
}

void MainWindow::tell(const tl::expected<void, std::string>& done) {
  if (!done) alert_->say(QString::fromStdString(done.error()), Severity::warning);
}

void MainWindow::select_robot(int robot) {
  plots_->select(robot);
  robots_->select_robot(robot);
  robot_buttons_->select_robot(robot);
}

void MainWindow::stop() {
  live_.stop();  // before anything else
  show_state();
}

bool MainWindow::stop_by_key() {
  const bool could_move = (live_.is_open() || live_.is_busy()) && !live_.stop_asked() &&
                          live_.phase() != app::Phase::stopped && live_.phase() != app::Phase::finished;
  stop();
  return could_move;
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (may_close_) {
    store_settings();
    event->accept();
    return;
  }
  // The robots first; the window goes when they stand, or have not answered for a second.
  event->ignore();
  arena_->set_camera(nullptr);  // it goes with the session
  live_.close();
  setEnabled(false);
  alert_->hold(tr("Stopping all robots …"), Severity::warning);
}

void MainWindow::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) dress_icons();
  QMainWindow::changeEvent(event);
}

}  // namespace skein::ui
