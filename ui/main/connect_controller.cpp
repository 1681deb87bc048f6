#include "ui/main/connect_controller.h"

#include <algorithm>
#include <utility>

#include "app/experiment/hardware.h"
#include "ui/base/number_text.h"
#include "ui/main/editor_controller.h"

namespace skein::ui {
namespace {

constexpr double patience = 10.0;  // an attempt to reach a robot may be under way [s]

using Kind = app::SetupTask::Kind;

bool needs_links(Kind kind) {
  switch (kind) {
    case Kind::scan:
    case Kind::pair:
      return false;
    case Kind::ping:
    case Kind::test:
      return true;
  }
  return true;
}

/// Whether the robot did well in what was done with it.
bool succeeded(Kind kind, const app::RobotSetup& robot) {
  switch (kind) {
    case Kind::scan:
      return false;  // counts the robots that it finds
    case Kind::pair:
      return robot.paired == true;
    case Kind::ping:
      return robot.answers;
    case Kind::test:
      return robot.test && robot.test_problem.empty() && robot.test->faults.empty();
  }
  return false;
}

/// Of the news while it works.
Severity severity_of(app::SetupTask::Kind kind) {
  switch (kind) {
    case app::SetupTask::Kind::test:  // robots drive
      return Severity::warning;
    case app::SetupTask::Kind::scan:
    case app::SetupTask::Kind::pair:
    case app::SetupTask::Kind::ping:
      break;
  }
  return Severity::notice;
}

}  // namespace

ConnectController::ConnectController(Runs& runs, EditorController& editor, const Messages& messages, QObject* parent)
    : QObject(parent), runs_(runs), live_(runs.live()), editor_(editor), messages_(messages) {
  connect(&runs_, &Runs::shown_changed, this, &ConnectController::show_experiment);
  connect(&live_, &LiveRun::starting, this, [this] {
    if (!is_working()) return;
    stop();
    say(tr("Ended: a run starts"), Severity::warning);
  });
}

ConnectController::~ConnectController() {
  stop();
  if (work_ && needs_links(kind_)) static_cast<void>(work_->wait(patience));
}

void ConnectController::show() {
  if (page_) {
    page_->raise();
    return page_->activateWindow();
  }
  page_ = new ConnectPage(messages_.window());
  connect(page_, &ConnectPage::scan_wanted, this, [this] { begin(Kind::scan); });
  connect(page_, &ConnectPage::pair_wanted, this, [this] { begin(Kind::pair); });
  connect(page_, &ConnectPage::ping_wanted, this, [this] { begin(Kind::ping); });
  connect(page_, &ConnectPage::test_wanted, this, [this] { begin(Kind::test); });
  connect(page_, &ConnectPage::stop_wanted, this, &ConnectController::stop);
  connect(page_, &ConnectPage::add_wanted, this, &ConnectController::add);
  connect(page_, &ConnectPage::save_wanted, this, &ConnectController::save);
  connect(page_, &QObject::destroyed, this, &ConnectController::stop);
  robots_ = app::setups_of(runs_.shown().experiment(), robots_);
  page_->set_working(is_working());
  show_robots();
  page_->say(tr("Choose robots in the table (Ctrl+A: all), then Ping. Scan finds robots by Bluetooth."),
             Severity::note);
  page_->show();
}

void ConnectController::show_experiment() {
  borrowed_ = false;
  if (is_working()) stop();
  robots_ = app::setups_of(runs_.shown().experiment(), robots_);
  show_robots();
}

void ConnectController::show_robots() {
  if (page_) page_->show_robots(robots_, runs_.shown().experiment().camera.kind() != app::CameraKind::absent);
}

void ConnectController::say(const QString& text, Severity severity) {
  if (page_) page_->say(text, severity);
}

std::vector<std::pair<std::size_t, app::RobotSetup>> ConnectController::chosen_for(Kind kind, QString& why) const {
  std::vector<std::pair<std::size_t, app::RobotSetup>> chosen;
  const std::vector<std::size_t> rows = page_->chosen();
  const bool pairs = kind == Kind::pair;
  for (const std::size_t row : rows)
    if (pairs ? robots_[row].is_bluetooth() : robots_[row].spec.has_link()) chosen.emplace_back(row, robots_[row]);
  if (rows.empty())
    why = tr("Choose robots in the table first (Ctrl+A: all of them)");
  else if (kind == Kind::pair)
    why = tr("None of the chosen robots is reached by Bluetooth: there is nothing to pair. Scan finds those that are");
  else
    why = tr("The chosen robots are simulated: they have no link, and nothing to test");
  return chosen;
}

void ConnectController::begin(Kind kind) {
  if (!page_ || is_working()) return;
  if (live_.is_under_way()) return say(tr("Not while a run is under way: stop it first"), Severity::warning);
  if (live_.is_busy())
    return say(tr("The experiment is still being opened or closed: try again in a moment"), Severity::warning);
  app::SetupTask task{kind, page_->adapter().toStdString(), runs_.shown().experiment(), {}};
  QString why;
  if (kind != Kind::scan) task.robots = chosen_for(kind, why);
  if (kind != Kind::scan && task.robots.empty()) return say(why, Severity::notice);
  asked_ = task.robots.size();
  good_ = 0;
  stopped_ = false;
  kind_ = kind;
  if (!needs_links(kind) || !live_.is_open() || !app::has_hardware(live_.experiment())) return start(std::move(task));
  messages_.note(tr("The experiment lets go of its robots: they are being set up"), Severity::notice);
  say(tr("The experiment lets go of its robots; it is opened again when this page is closed …"), Severity::notice);
  borrowed_ = true;
  waiting_ = std::move(task);
  page_->set_working(true);
  emit session_ends();
  live_.end();
}

void ConnectController::start(app::SetupTask task) {
  if (kind_ == Kind::test) messages_.note(tr("Robots are tested: they drive"), Severity::warning);
  work_ = std::make_unique<app::SetupWork>(std::move(task));
  if (page_) page_->set_working(true);
}

void ConnectController::stop() noexcept {
  if (work_) work_->stop();
  if (is_working()) stopped_ = true;
}

void ConnectController::end_then(std::function<void()> next) {
  if (!is_working()) return next();
  stop();
  next_ = std::move(next);
}

void ConnectController::close(std::function<void()> next) {
  borrowed_ = false;
  end_then(std::move(next));
}

void ConnectController::close_now() {
  stop();
  waiting_.reset();
  if (work_) static_cast<void>(work_->wait(patience));
}

void ConnectController::refresh() {
  if (waiting_ && !live_.is_busy()) {
    app::SetupTask task = std::move(*waiting_);
    waiting_.reset();
    if (!stopped_)
      start(std::move(task));
    else if (page_)
      page_->set_working(false);
  }
  if (work_) {
    const app::SetupNews news = work_->news();
    show_news(news);
    if (news.over) {
      work_.reset();
      if (page_) page_->set_working(false);
      tell_end(news);
    }
  }
  if (is_working()) return;
  if (next_) return std::exchange(next_, nullptr)();
  if (!page_) give_back();
}

/// The page is gone: the experiment has its robots again.
void ConnectController::give_back() {
  if (!std::exchange(borrowed_, false) || live_.is_open() || live_.is_busy()) return;
  emit experiment_wanted(app::Experiment(live_.experiment()));
}

void ConnectController::show_news(const app::SetupNews& news) {
  for (const auto& [row, robot] : news.robots) {
    // Another experiment may be shown by now.
    if (row >= robots_.size() || !app::is_same_robot(robots_[row].spec, robot.spec)) continue;
    robots_[row] = robot;
    const bool good = succeeded(kind_, robot);
    if (good) ++good_;
    if (kind_ == Kind::test && robot.test && robot.test_problem.empty())
      messages_.note(good ? tr("%1 passes its test").arg(QString::fromStdString(robot.name))
                          : tr("%1 does NOT pass its test: %2")
                                .arg(QString::fromStdString(robot.name),
                                     QString::fromStdString(app::verdict_on(robot, true).sentence)),
                     good ? Severity::good : Severity::alarm);
  }
  if (!news.found.empty()) app::add_found(robots_, news.found);
  if (!news.found.empty() || !news.robots.empty()) show_robots();
  if (kind_ == Kind::scan) good_ += news.found.size();
  for (const std::string& warning : news.warnings) messages_.note(QString::fromStdString(warning), Severity::alarm);
  if (!news.over && !news.doing.empty())
    say(stopped_ ? tr("Stopping …") : QString::fromStdString(news.doing), severity_of(kind_));
}

void ConnectController::tell_end(const app::SetupNews& news) {
  if (stopped_) return say(tr("Stopped. What was found out until then stands in the table"), Severity::notice);
  if (!news.problem.empty()) {
    const QString problem = QString::fromStdString(news.problem);
    messages_.note(problem, Severity::warning);
    return say(problem, Severity::alarm);
  }
  const bool all = good_ == asked_;
  const auto of = [&](const QString& text) { return text.arg(good_).arg(asked_); };
  switch (kind_) {
    case Kind::scan:
      return say(tr("%1 found").arg(counted(static_cast<qsizetype>(good_), "robot")), Severity::good);
    case Kind::pair:
      return say(of(tr("%1 of %2 robots are paired")), all ? Severity::good : Severity::warning);
    case Kind::ping:
      return say(of(tr("%1 of %2 robots answer")), all ? Severity::good : Severity::warning);
    case Kind::test:
      return say(of(tr("%1 of %2 robots pass their test")), all ? Severity::good : Severity::warning);
  }
}

void ConnectController::add() {
  QString tables;
  for (const std::size_t row : page_->chosen()) {
    const app::RobotSetup& robot = robots_[row];
    if (robot.number >= 0) continue;
    app::KnownRobot known{robot.spec, {}};
    if (robot.test && robot.test->tag >= 0) known.spec.tag = robot.test->tag;
    tables += (tables.isEmpty() ? QString() : QStringLiteral("\n")) + QString::fromStdString(app::as_toml(known));
  }
  if (tables.isEmpty())
    return say(tr("The chosen robots are in the experiment already: choose robots that a scan has found"),
               Severity::notice);
  editor_.edit_with_tables(tables);
  say(tr("The editor has the experiment with these robots: save and open it there"), Severity::good);
}

void ConnectController::save() {
  std::vector<app::RobotSetup> chosen;
  for (const std::size_t row : page_->chosen()) chosen.push_back(robots_[row]);
  const auto saved = app::save(chosen);
  if (!saved) return say(tr("Not saved: %1").arg(QString::fromStdString(saved.error())), Severity::warning);
  QString text =
      tr("Saved in %1, %2.")
          .arg(QString::fromStdString(saved->file), counted(static_cast<qsizetype>(saved->added), "new robot"));
  for (const std::string& problem : saved->problems) text += QLatin1Char(' ') + QString::fromStdString(problem) + '.';
  say(text, saved->problems.empty() ? Severity::good : Severity::warning);
}

}  // namespace skein::ui
