// A random operator at the window: clicks, keys, texts, drags and files in any order, while simulated robots drive.
// Whatever was done, the window comes back at once and without a warning, shows the state that the session has, and
// STOP is in sight and stops every robot.
// SKEIN_CHAOS_SEED sets the first seed, SKEIN_CHAOS_RUNS how many (default 2), SKEIN_CHAOS_ACTIONS how many actions
// each (default 45); SKEIN_CHAOS_TELL=1 prints each action.
#include <unistd.h>

#include <QElapsedTimer>
#include <QSettings>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "operator.h"
#include "random_operator.h"
#include "tests/from_environment.h"
#include "ui/base/settings.h"

namespace skein::ui::test {
namespace {

/// The last actions, to be read by whoever looks into a failure.
class Trail {
 public:
  void add(const QString& what) {
    const std::scoped_lock lock(mutex_);
    lines_.push_back(what.toStdString());
    if (lines_.size() > 25) lines_.pop_front();
    since_ = std::chrono::steady_clock::now();
    if (tells_) std::fprintf(stderr, "%s\n", lines_.back().c_str());
  }
  std::string text() const {
    const std::scoped_lock lock(mutex_);
    std::string text;
    for (const std::string& line : lines_) text += "\n  " + line;
    return text;
  }
  std::chrono::steady_clock::duration age() const {
    const std::scoped_lock lock(mutex_);
    return std::chrono::steady_clock::now() - since_;
  }

 private:
  const bool tells_ = skein::test::number_from_environment("SKEIN_CHAOS_TELL", 0.0) > 0.0;
  mutable std::mutex mutex_;
  std::deque<std::string> lines_;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
};

/// Ends the program where the window does not come back from an action.
class Watchdog {
  static constexpr std::chrono::seconds patience{90};

 public:
  explicit Watchdog(const Trail& trail)
      : thread_([&trail](const std::stop_token& over) {
          while (!over.stop_requested()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            if (trail.age() < patience) continue;
            std::fprintf(stderr, "the window does not come back:%s\n", trail.text().c_str());
            std::abort();
          }
        }) {}

 private:
  std::jthread thread_;
};

/// Collects what Qt and the window complain about.
class Complaints {
 public:
  Complaints() : before_(qInstallMessageHandler(take)) { list().clear(); }
  ~Complaints() { qInstallMessageHandler(before_); }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  static std::string text() {
    const std::scoped_lock lock(mutex());
    return list().join(QLatin1Char('\n')).toStdString();
  }

 private:
  static QStringList& list() {
    static QStringList all;
    return all;
  }
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
  static void take(QtMsgType type, const QMessageLogContext& /*context*/, const QString& text) {
    if (type == QtDebugMsg || type == QtInfoMsg) return;
    // The offscreen platform says so of every window; a hand has no such limits either.
    if (text.startsWith(QStringLiteral("This plugin does not support"))) return;
    const std::scoped_lock lock(mutex());
    list() << text;
  }
  QtMessageHandler before_;
};

/// The settings and the font of the other tests come back.
class OwnSettings {
 public:
  explicit OwnSettings(const QString& recordings) {
    QSettings stored = settings();
    for (const QString& key : stored.allKeys()) before_[key] = stored.value(key);
    stored.setValue(QStringLiteral("recordings"), recordings);
  }
  ~OwnSettings() {
    QSettings stored = settings();
    stored.clear();
    for (const auto& [key, value] : before_) stored.setValue(key, value);
    QApplication::setFont(font_);
  }
  OwnSettings(const OwnSettings&) = delete;
  OwnSettings& operator=(const OwnSettings&) = delete;

 private:
  std::map<QString, QVariant> before_;
  const QFont font_ = QApplication::font();
};

class WindowChaos : public ::testing::Test {
 protected:
  void run(std::uint64_t seed, int actions) {
    QDir(home_.path()).mkpath(QStringLiteral("files"));
    window_ = std::make_unique<MainWindow>();
    RandomOperator hand(*window_, home_.filePath(QStringLiteral("files")), seed);
    hand.on_action = [this](const QString& what) {
      trail_.add(QStringLiteral("%1 %2 s: %3").arg(live().state().words).arg(live().t(), 0, 'f', 2).arg(what));
    };
    trail_.add(QStringLiteral("seed %1").arg(seed));
    window_->resize(1280, 800);
    window_->show();
    window_->activateWindow();
    window_->open(random_experiment(hand.random()), true);
    ASSERT_TRUE(QTest::qWaitForWindowExposed(window_.get()));
    for (int k = 0; k < actions; ++k) {
      QElapsedTimer took;
      took.start();
      hand.act();
      if (took.elapsed() > slowest_) slowest_ = took.elapsed(), slowest_action_ = trail_.text();
      QTest::qWait(live().is_busy() || hand.likely(0.2) ? hand.below(150) : hand.below(10));
      expect_stop_in_sight();
      expect_status();
      if (hand.likely(0.05)) stop(hand);
      ASSERT_EQ(Complaints::text(), "") << trail_.text();
      if (HasFailure()) return;
      ASSERT_TRUE(window_->isVisible()) << trail_.text();
    }
    end_everything();
  }

  const LiveRun& live() { return window_->live(); }
  QPushButton& stop_button() { return *window_->findChild<QPushButton*>(QStringLiteral("stop")); }

  void expect_stop_in_sight() {
    QPushButton& stop = stop_button();
    ASSERT_TRUE(eventually([&] {  // layouts come to rest in later turns of the loop
      const QRect there(stop.mapTo(window_.get(), QPoint()), stop.size());
      return stop.isVisible() && window_->rect().contains(there) && stop.width() >= stop.minimumSizeHint().width() &&
             stop.height() >= stop.minimumSizeHint().height() && window_->childAt(there.center()) == &stop;
    })) << "STOP is cut or covered: "
        << stop.geometry().width() << " x " << stop.geometry().height() << " in a window of " << window_->width()
        << " x " << window_->height() << trail_.text();
    EXPECT_TRUE(stop.isEnabled()) << trail_.text();
    EXPECT_FALSE(stop.isDown()) << "nobody presses it" << trail_.text();
  }

  /// The window and the run say the same.
  void expect_status() {
    const auto* phase = window_->findChild<QLabel*>(QStringLiteral("phase"));
    const auto* go = window_->findChild<QPushButton*>(QStringLiteral("go"));
    const auto words = [&] {
      const bool replays = window_->replay().is_loaded() &&
                           window_->windowTitle() == window_->replay().title() + QStringLiteral(" – Skein");
      const RunSource& run =
          replays ? static_cast<const RunSource&>(window_->replay()) : static_cast<const RunSource&>(live());
      return run.state();
    };
    EXPECT_TRUE(eventually([&] {
      const RunState state = words();
      const QString said = phase->text();
      const bool unready = said == QStringLiteral("● Not ready") && live().is_before_start();
      return (unready || said.startsWith(QStringLiteral("● ") + state.words)) && go->isEnabled() == state.may_go;
    })) << "shown: "
        << phase->text().toStdString() << ", the run: " << words().words.toStdString() << trail_.text();
  }

  /// STOP by a way that the hand chooses: what had been driving stands, and is commanded to.
  void stop(RandomOperator& hand) {
    if (!live().is_under_way() || live().stop_asked()) return;
    const int way = hand.below(3);
    trail_.add(QStringLiteral("STOP, way %1").arg(way));
    if (way == 0) {
      while (QWidget* popup = QApplication::activePopupWidget()) popup->close();
      const QPoint at = stop_button().mapTo(window_.get(), stop_button().rect().center());
      if (QApplication::activeModalWidget()) return;
      // A platform without a window manager may leave its window smaller than what it shows.
      if (QRect({}, window_->windowHandle()->size()).contains(at))
        QTest::mouseClick(window_->windowHandle(), Qt::LeftButton, {}, at);
      else
        QTest::mouseClick(&stop_button(), Qt::LeftButton);
    } else {
      const std::vector<QWidget*> all = hand.windows();
      QWidget* in = any_of_these(all, hand.random());
      if (!in->windowHandle()) in = window_.get();
      QTest::keyClick(in->windowHandle(), way == 1 ? Qt::Key_Space : Qt::Key_Escape);
    }
    // A file that was being read may have been opened since, and waits for its start.
    ASSERT_TRUE(eventually([&] { return !live().is_under_way(); })) << "STOP does not stop" << trail_.text();
    EXPECT_TRUE(eventually([&] {
      if (!live().latest()) return true;
      for (const app::RobotRecord& robot : live().latest()->robots)
        if (robot.wheels != core::WheelSpeeds{}) return false;
      return true;
    })) << "robots are still told to drive"
        << trail_.text();
    for (const auto& row : live().history().rows())
      if (row->phase == app::Phase::stopped) {
        for (const app::RobotRecord& robot : row->robots)
          EXPECT_EQ(robot.wheels, core::WheelSpeeds{}) << "after STOP" << trail_.text();
      }
  }

  /// By closing the window, whatever is open: what it asks about changes is answered by dropping them.
  void end_everything() {
    trail_.add(QStringLiteral("the end"));
    while (QWidget* popup = QApplication::activePopupWidget()) popup->close();
    while (auto* dialog = window_->findChild<QDialog*>()) delete dialog;
    window_->close();
    ASSERT_TRUE(eventually([&] { return !window_->isVisible(); })) << "the window does not close" << trail_.text();
    EXPECT_FALSE(live().is_open() || live().is_busy()) << trail_.text();
    window_.reset();
    EXPECT_TRUE(eventually([&] { return children() == 0; })) << "processes are left" << trail_.text();
    EXPECT_EQ(Complaints::text(), "") << trail_.text();
  }
  static std::ptrdiff_t children() {
    std::ptrdiff_t count = 0;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
      std::ifstream file(task.path() / "children");
      count += std::distance(std::istream_iterator<int>(file), {});
    }
    return count;
  }

  QTemporaryDir home_;
  EnvironmentVariable data_{"XDG_DATA_HOME", home_.path().toUtf8()}, state_{"XDG_STATE_HOME", home_.path().toUtf8()},
      config_{"XDG_CONFIG_HOME", home_.path().toUtf8()}, bus_{"DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nowhere"};
  OwnSettings settings_{home_.filePath(QStringLiteral("recordings"))};
  Complaints complaints_;
  Trail trail_;
  Watchdog watchdog_{trail_};
  std::unique_ptr<MainWindow> window_;
  qint64 slowest_ = 0;
  std::string slowest_action_;
};

TEST_F(WindowChaos, WhateverIsDoneStopIsInSightAndStops) {
  const int first = static_cast<int>(skein::test::number_from_environment("SKEIN_CHAOS_SEED", 1.0));
  const int runs = static_cast<int>(skein::test::number_from_environment("SKEIN_CHAOS_RUNS", 2.0));
  const int actions = static_cast<int>(skein::test::number_from_environment("SKEIN_CHAOS_ACTIONS", 45.0));
  for (int seed = first; seed < first + runs && !HasFailure(); ++seed) {
    SCOPED_TRACE("SKEIN_CHAOS_SEED=" + std::to_string(seed));
    run(static_cast<std::uint64_t>(seed), actions);
  }
  if (skein::test::number_from_environment("SKEIN_CHAOS_TELL", 0.0) > 0.0)
    std::fprintf(stderr, "the slowest action took %lld ms:%s\n", static_cast<long long>(slowest_),
                 slowest_action_.c_str());
}

}  // namespace
}  // namespace skein::ui::test
