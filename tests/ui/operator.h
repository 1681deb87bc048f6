#pragma once

#include <gtest/gtest.h>

#include <QAbstractItemView>
#include <QCoreApplication>
#include <QDialog>
#include <QElapsedTimer>
#include <QFile>
#include <QPushButton>
#include <QTemporaryDir>
#include <QTest>
#include <QWheelEvent>
#include <functional>
#include <optional>

#include "app/experiment/experiment_file.h"
#include "ui/arena/arena_view.h"
#include "ui/main/main_window.h"
#include "ui/status/event_log.h"

namespace skein::ui::test {

// Far more than anything takes, on a loaded machine too; a wait ends as soon as it may.
inline constexpr int deadline_ms = 60000;

/// A variable of the environment has another value; the tests that come after see it as it was.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const QByteArray& value) : name_(name), before_(qgetenv(name)) {
    qputenv(name, value);
  }
  ~EnvironmentVariable() { before_.isNull() ? qunsetenv(name_) : qputenv(name_, before_); }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  const char* name_;
  QByteArray before_;
};

inline bool eventually(const std::function<bool()>& holds) {
  return QTest::qWaitFor(holds, deadline_ms);
}

/// Lets layouts come to rest, on a busy machine too: a change of one causes that of another in a later turn of the
/// loop.
inline void lay_out() {
  for (int turn = 0; turn < 10; ++turn) QTest::qWait(5);
}

/// Gives a window the keyboard, as a window manager would. On an X server without one, the window below may come to the
/// front once more after it: until it stays there.
inline bool bring_to_front(QWidget& window) {
  constexpr int long_enough_ms = 50;
  QElapsedTimer in_front;
  return eventually([&] {
    if (!window.isActiveWindow()) {
      window.activateWindow();
      in_front.invalidate();
      return false;
    }
    if (!in_front.isValid()) in_front.start();
    return in_front.hasExpired(long_enough_ms);
  });
}

/// Somebody at the window: sees what is on it, and has a mouse and a keyboard.
class Operator : public ::testing::Test {
 protected:
  /// Whether the window is active then.
  bool show_and_open(const app::Experiment& experiment, bool start_at_once) {
    window.resize(1280, 800);
    window.show();
    window.activateWindow();  // on an X server without a window manager nobody else does
    window.open(experiment, start_at_once);
    return QTest::qWaitForWindowActive(&window);
  }
  /// The window with the paper's experiment on simulated robots, running.
  void start(const app::Experiment& experiment = app::paper_experiment()) {
    ASSERT_TRUE(show_and_open(experiment, true));
    ASSERT_TRUE(eventually([&] { return running() && record().t >= 0.2; }));
  }

  /// The window with an experiment that is ready to be started.
  void open_and_wait(const app::Experiment& experiment = app::paper_experiment()) {
    ASSERT_TRUE(show_and_open(experiment, false));
    ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }))
        << live().failure().value_or(QString()).toStdString();
  }

  void TearDown() override {
    // An editor would ask about its changes. Deleting a dialog deletes those that it has opened.
    while (auto* dialog = window.findChild<QDialog*>()) delete dialog;
    window.close();
    EXPECT_TRUE(eventually([&] { return !window.isVisible(); })) << "the window did not close";
  }

  template <typename Widget = QWidget>
  Widget* find(const char* name) {
    auto* widget = window.findChild<Widget*>(QString::fromLatin1(name));
    if (widget == nullptr) ADD_FAILURE() << "there is no " << name;
    return widget;
  }

  const LiveRun& live() { return window.live(); }
  const app::TickRecord& record() { return *live().latest(); }
  bool running() { return live().latest() != nullptr && live().phase() == app::Phase::running; }
  bool stopped() { return live().latest() != nullptr && live().phase() == app::Phase::stopped; }

  ArenaView& arena() { return *find<ArenaView>("arena"); }
  /// Where robot i (from 0) is on the screen now.
  QPoint robot(std::size_t i) {
    const core::Pose pose = *arena().scene().pose(i);
    return arena().map().to_screen({pose.x, pose.y}).toPoint();
  }
  QPoint floor(double x, double y) { return arena().map().to_screen({x, y}).toPoint(); }

  void drag(QPoint from, QPoint to, Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    QTest::mousePress(&arena(), Qt::LeftButton, modifiers, from);
    for (int k = 1; k <= 5; ++k) QTest::mouseMove(&arena(), from + (to - from) * k / 5);
    QTest::mouseRelease(&arena(), Qt::LeftButton, modifiers, to);
  }

  void wheel(QPoint at, int notches, Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    QWheelEvent event(at, arena().mapToGlobal(at), {}, {0, 120 * notches}, Qt::NoButton, modifiers, Qt::NoScrollPhase,
                      false);
    QCoreApplication::sendEvent(&arena(), &event);
  }

  /// A key as the keyboard sends it: to the window that has the focus, and on from there.
  void key(Qt::Key key, QWidget* in = nullptr, Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    QTest::keyClick((in ? in : &window)->window()->windowHandle(), key, modifiers);
  }

  /// Where the operator put robot i last, once the run has a row of it.
  core::Pose moved(std::size_t i) { return last<app::events::Move>(i).pose; }
  /// The last event of this kind with this robot (or obstacle), once the run has a row of it.
  template <typename Kind>
  Kind last(std::size_t number) {
    std::optional<Kind> found;
    EXPECT_TRUE(eventually([&] {
      for (const auto& row : live().history().rows())
        for (const app::Event& event : row->events)
          if (const auto* const one = std::get_if<Kind>(&event); one && number_of(*one) == number) found = *one;
      return found.has_value();
    })) << "there was no "
        << Kind::word << " of " << number + 1;
    return found.value_or(Kind{});
  }
  static std::size_t number_of(const app::events::PutObstacle& put) { return put.number; }
  static std::size_t number_of(const auto& of_robot) { return of_robot.robot; }

  /// The events of the run's CSV, as the file has them.
  QStringList saved_events() {
    const QTemporaryDir dir;
    const QString file = dir.filePath(QStringLiteral("run.csv"));
    bool done = false;
    const auto connection =
        QObject::connect(&window, &MainWindow::saved, &window, [&](const QString&, const QString& problem) {
          done = true;
          EXPECT_EQ(problem.toStdString(), "");
        });
    window.save_csv(file);
    EXPECT_TRUE(eventually([&] { return done; }));
    QObject::disconnect(connection);
    QFile csv(file);
    EXPECT_TRUE(csv.open(QIODevice::ReadOnly));
    QStringList events;
    qsizetype column = -1;
    for (const QString& line : QString::fromUtf8(csv.readAll()).split(QLatin1Char('\n'), Qt::SkipEmptyParts)) {
      if (line.startsWith(QLatin1Char('#'))) continue;
      const QStringList cells = line.split(QLatin1Char(','));
      if (column < 0)
        column = cells.indexOf(QStringLiteral("event"));
      else if (!cells.value(column).isEmpty())
        events << cells.value(column).split(QStringLiteral("; "));
    }
    EXPECT_GE(column, 0) << "no column of events";
    return events;
  }

  /// The event log, a line each, in full.
  QString logged() {
    auto* log = find<QAbstractItemView>("event_log");
    QStringList lines;
    for (int row = 0; row < log->model()->rowCount(); ++row)
      lines << log->model()->index(row, EventModel::event).data(Qt::ToolTipRole).toString();
    return lines.join(QLatin1Char('\n'));
  }

  /// How many events begin like this.
  static qsizetype count(const QStringList& events, const char* beginning) {
    return std::count_if(events.begin(), events.end(),
                         [&](const QString& event) { return event.startsWith(QLatin1String(beginning)); });
  }

  MainWindow window;
};

}  // namespace skein::ui::test
