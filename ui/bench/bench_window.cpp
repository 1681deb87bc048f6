// skein-bench ui: what the window costs, and what it costs the control thread.
#include "ui/bench/bench_window.h"

#include <sys/resource.h>
#include <time.h>

#include <QApplication>
#include <QElapsedTimer>
#include <QEvent>
#include <QEventLoop>
#include <QSettings>
#include <QTemporaryDir>
#include <QThread>
#include <QTimer>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "app/experiment/experiment_file.h"
#include "app/session/session.h"
#include "ui/arena/arena_view.h"
#include "ui/base/settings.h"
#include "ui/bench/bench_display.h"
#include "ui/main/main_window.h"
#include "ui/plots/plots_panel.h"
#include "ui/status/run_bar.h"
#include "ui/window.h"

namespace skein::ui {
namespace {

constexpr double half_an_hour = 1800.0, four_hours = 14400.0;  // what the plots hold before anything is measured [s]
constexpr int status_expectation_failed = 1, status_device_failed = 3;

double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Since this process was started; the kernel keeps it to a hundredth of a second.
double process_age() {
  std::ifstream stat("/proc/self/stat");
  std::string text;
  std::getline(stat, text);
  std::istringstream fields(text.substr(text.rfind(')') + 2));
  std::string field;
  for (int k = 3; k <= 22; ++k) fields >> field;
  return seconds(CLOCK_BOOTTIME) - std::stod(field) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

double process_cpu() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return of(usage.ru_utime) + of(usage.ru_stime);
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void wait(double how_long) {
  QEventLoop loop;
  QTimer::singleShot(static_cast<int>(1e3 * how_long), &loop, &QEventLoop::quit);
  loop.exec();
}

void report(const char* what, double value, const char* unit, const char* target = "") {
  std::printf("%-62s %9.2f %-5s %s\n", what, value, unit, target);
  std::fflush(stdout);
}

/// The paper's experiment for any number of robots; the couplings shrink with the group, as (18f, g) ask, and a path on
/// which not all of them have room grows with its arena.
app::Experiment group_of(std::size_t robots, double duration) {
  const app::Experiment paper = app::paper_experiment();
  const auto number = static_cast<double>(robots);
  constexpr double most_on_its_path = 28.0;  // robots, 12 cm apart
  const double larger = std::max(1.0, number / most_on_its_path), share = 3.0 / (number - 1.0);
  std::vector<std::string> sets{
      "perturb=[]",
      fmt::format("duration={}", duration),
      fmt::format("arena.width={}", larger * paper.arena_width),
      fmt::format("arena.height={}", larger * paper.arena_height),
      fmt::format("reference.path.width={}", larger * paper.reference.path.width),
      fmt::format("reference.path.height={}", larger * paper.reference.path.height),
  };
  if (robots != paper.robots.size()) {
    std::string list;
    for (std::size_t i = 1; i <= robots; ++i) list += fmt::format("{{tag={}}},", i);
    const core::CouplingGains& gains = paper.controller.gains;
    sets.push_back(fmt::format("robot=[{}]", list));
    sets.push_back(fmt::format("controller.gains.k_xx={}", share * gains.k_xx.largest()));
    sets.push_back(fmt::format("controller.gains.k_tt={}", share * gains.k_tt.largest()));
    sets.push_back(fmt::format("controller.gains.k_yy={}", share * gains.k_yy.largest()));
  }
  return app::parse_experiment(paper.source, "platoon.toml", sets).value();
}

/// What this process has in memory now. [MB]
double resident() {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024.0;
  return 0.0;
}

/// A run that ends where the one that is measured begins.
class PastRun final : public app::RecordSink {
 public:
  PastRun(PlotsPanel& plots, double duration) : plots_(plots), duration_(duration) {}
  void record(const app::TickRecord& record) override {
    row_ = record;
    row_.t -= duration_;
    plots_.show_record(row_);
  }

 private:
  PlotsPanel& plots_;
  double duration_;
  app::TickRecord row_;
};

/// Adds the ticks of a run without a window, on the clock that the window's runs have.
void run_headless(const app::Experiment& experiment, double how_long, app::Histogram& lateness) {
  auto session = app::Session::open(experiment, app::Session::Clock::wall, {.paced = true});
  if (!(*session)->start()) return;
  std::this_thread::sleep_for(std::chrono::duration<double>(how_long));
  if (const auto timing = (*session)->timing_so_far()) lateness += timing->tick;
  (*session)->close();
}

/// Knows how long its thread was busy with events; those of other threads do not count.
class TimedApplication final : public QApplication {
 public:
  using QApplication::QApplication;
  bool notify(QObject* receiver, QEvent* event) override {
    if (QThread::currentThread() != thread()) return QApplication::notify(receiver, event);
    if (depth_++ == 0) since_ = seconds(CLOCK_MONOTONIC);
    const bool done = QApplication::notify(receiver, event);
    if (--depth_ == 0) busy_ += seconds(CLOCK_MONOTONIC) - since_;
    return done;
  }
  /// [s] since the last call, up to now, from within an event or not.
  double take_busy() {
    if (depth_ > 0) busy_ += seconds(CLOCK_MONOTONIC) - std::exchange(since_, seconds(CLOCK_MONOTONIC));
    return std::exchange(busy_, 0.0);
  }

 private:
  int depth_ = 0;
  double since_ = 0.0, busy_ = 0.0;
};

/// The window with everything open and so much behind it.
class Stage {
 public:
  Stage(const app::Experiment& experiment, double history) : experiment_(experiment) {
    window_.resize(1280, 800);
    window_.show();
    window_.open(experiment, true);
    fill(history);
    QObject::connect(&window_.live(), &LiveRun::frame, &window_, [this] { end_of_frame(); });
  }
  ~Stage() {
    window_.close();
    for (int k = 0; k < 100 && window_.isVisible(); ++k) wait(0.05);
  }

  void measure(double how_long, bool resized) {
    wait(2.0);  // the first frames lay everything out
    const app::Histogram ticks_before = ticks();
    frames_ms_.clear();
    frames_cpu_ms_.clear();
    const double cpu = process_cpu(), began = seconds(CLOCK_MONOTONIC);
    QTimer resizing;
    int k = 0;
    QObject::connect(&resizing, &QTimer::timeout, &window_, [&] {
      ++k;
      window_.resize(1280 + 10 * (k % 16), 800 + 8 * (k % 16));
    });
    if (resized) resizing.start(100);
    wait(how_long);
    resizing.stop();
    elapsed_ = seconds(CLOCK_MONOTONIC) - began;
    cpu_share_ = (process_cpu() - cpu) / elapsed_;
    late_ = ticks().since(ticks_before);
  }

  double frames_per_second() const { return static_cast<double>(frames_ms_.size()) / elapsed_; }
  double cpu_share() const { return cpu_share_; }
  double frame_ms(double share) const { return percentile(frames_ms_, share); }
  double frame_cpu_ms(double share) const { return percentile(frames_cpu_ms_, share); }
  const app::Histogram& late() const { return late_; }

 private:
  void fill(double history) {
    app::Experiment before = experiment_;
    before.duration = history;
    auto* plots = window_.findChild<PlotsPanel*>();
    plots->show_all_plots();
    PastRun past(*plots, history);
    auto session = app::Session::open(before, app::Session::Clock::virtual_, {false, {&past}});
    (*session)->run();
    plots->set_span(history > half_an_hour ? 0.0 : half_an_hour);  // 0: all there is
  }

  app::Histogram ticks() const {
    const auto timing = window_.live().timing();
    return timing ? timing->tick : app::Histogram{};
  }

  /// All that the window's thread did since the last one: reading records, painting, the plots' own timer.
  void end_of_frame() {
    const double cpu = seconds(CLOCK_THREAD_CPUTIME_ID);
    frames_ms_.push_back(1e3 * static_cast<TimedApplication*>(qApp)->take_busy());
    frames_cpu_ms_.push_back(1e3 * (cpu - std::exchange(cpu_before_, cpu)));
  }

  app::Experiment experiment_;
  MainWindow window_;
  app::Histogram late_;  // of the last measurement
  std::vector<double> frames_ms_, frames_cpu_ms_;
  double cpu_before_ = 0.0;
  double elapsed_ = 1.0, cpu_share_ = 0.0;
};

/// The time at which a widget was painted first.
class FirstPaint final : public QObject {
 public:
  using QObject::QObject;
  double age = 0.0;

 protected:
  bool eventFilter(QObject*, QEvent* event) override {
    if (age == 0.0 && event->type() == QEvent::Paint) age = process_age();
    return false;
  }
};

double first_frame() {
  MainWindow window;
  FirstPaint paint;
  window.findChild<ArenaView*>()->installEventFilter(&paint);
  window.resize(1280, 800);
  window.show();
  window.open(app::paper_experiment(), true);
  while (paint.age == 0.0) wait(0.005);
  window.close();
  for (int k = 0; k < 100 && window.isVisible(); ++k) wait(0.05);
  return paint.age;
}

/// A whole run in the window, with all plots and a kick a minute, as fast as a simulation may go.
int measure_memory(double hours) {
  constexpr double limit = 200.0;  // [MB]
  app::Experiment experiment = group_of(4, 3600.0 * hours);
  constexpr double minute = 60.0;  // [s]
  for (int k = 1; k * minute < experiment.duration; ++k)
    experiment.perturbations.push_back({.t = k * minute, .robot = 1, .dy = 0.05});
  MainWindow window;
  window.resize(1280, 800);
  window.show();
  window.open(experiment, true);
  window.findChild<PlotsPanel*>()->show_all_plots();
  const LiveRun& live = window.live();
  double largest = 0.0, next = std::min(1.0, 0.125 * hours);
  bool fast = false;
  report("resident at the start", resident(), "MB");
  const auto over = [&live] { return live.phase() == app::Phase::finished || live.phase() == app::Phase::stopped; };
  while (!over()) {
    wait(0.1);
    if (!fast && live.phase() == app::Phase::running) {
      fast = true;
      emit window.findChild<RunBar*>()->speed_wanted(50.0);
    }
    largest = std::max(largest, resident());
    if (live.t() < 3600.0 * next && !over()) continue;
    std::printf("after %5.2f h:", live.t() / 3600.0);
    report("resident", resident(), "MB");
    next += std::min(1.0, 0.125 * hours);
  }
  report("largest", largest, "MB", "<= 200");
  const bool whole = live.phase() == app::Phase::finished;
  window.close();
  for (int k = 0; k < 100 && window.isVisible(); ++k) wait(0.05);
  return whole && largest <= limit ? 0 : status_expectation_failed;
}

}  // namespace

int bench_window(int& argc, char** argv, double how_long, double hours) {
  const BenchDisplay display;
  TimedApplication application(argc, argv);
  const QTemporaryDir own;  // the user's settings stay as they are
  if (!own.isValid()) return status_device_failed;
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, own.path());
  settings().setValue(QStringLiteral("keep_runs"), false);
  prepare(application);
  if (hours > 0.0) return measure_memory(hours);

  report("start to first frame", first_frame(), "s", "<= 1");
  std::printf("platform: %s, each measurement %g s\n", qPrintable(QApplication::platformName()), how_long);
  const app::Experiment four = group_of(4, 36000.0);
  app::Histogram without;
  run_headless(four, how_long, without);
  {
    Stage stage(four, half_an_hour);
    stage.measure(how_long, false);
    report("4 robots, all plots, 30 min: frame in the UI thread, p99", stage.frame_ms(0.99), "ms", "<= 16");
    report("  median", stage.frame_ms(0.5), "ms");
    report("  of it the thread's own CPU time, median", stage.frame_cpu_ms(0.5), "ms");
    report("    p99", stage.frame_cpu_ms(0.99), "ms");
    report("  frames a second", stage.frames_per_second(), "1/s", ">= 30");
    report("  CPU of the whole program", 100.0 * stage.cpu_share(), "%", "<= 50 of one core");
    stage.measure(how_long, true);
    report("being resized ten times a second: frame, p99", stage.frame_ms(0.99), "ms");
    run_headless(four, how_long, without);
    const double headless = 1e3 * without.quantile(0.99), in_the_window = 1e3 * stage.late().quantile(0.99);
    report("control thread's lateness, headless, p99", headless, "ms");
    report("  with the window open and being resized, p99", in_the_window, "ms");
    report("  difference", in_the_window - headless, "ms", "< 0.2");
  }
  const auto measure_history = [how_long](const char* title, const app::Experiment& experiment, double history) {
    Stage stage(experiment, history);
    stage.measure(how_long, false);
    std::printf("%s\n", title);
    report("  frames a second", stage.frames_per_second(), "1/s", ">= 30");
    report("  frame in the UI thread, p99", stage.frame_ms(0.99), "ms", experiment.robots.size() == 4 ? "<= 16" : "");
    report("  of it the thread's own CPU time, median", stage.frame_cpu_ms(0.5), "ms");
    report("    p99", stage.frame_cpu_ms(0.99), "ms");
    report("  CPU of the whole program", 100.0 * stage.cpu_share(), "%");
  };
  measure_history("4 robots, all plots, 4 h of history", four, four_hours);
  measure_history("20 robots, all plots, 30 min of history", group_of(20, 3600.0), half_an_hour);
  constexpr double three_minutes = 180.0;
  measure_history("64 robots, all plots, 3 min of history", group_of(64, 3600.0), three_minutes);
  return 0;
}

}  // namespace skein::ui
