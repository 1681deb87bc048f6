// Fonts of the desktop from small to three times as large, on the screen of this process: ctest runs it on several
// (CMakeLists.txt). STOP is whole, and the arena can be used.
#include <QAbstractButton>
#include <QAbstractSpinBox>
#include <QApplication>
#include <QDockWidget>
#include <QScreen>
#include <cmath>
#include <optional>

#include "operator.h"
#include "ui/base/dialogs.h"
#include "ui/base/settings.h"
#include "ui/plots/plot_view.h"

namespace skein::ui::test {
namespace {

/// Set before the program starts.
class DesktopFont : public ::testing::WithParamInterface<int> {
 protected:
  DesktopFont() {
    settings().remove(QStringLiteral("geometry"));
    QFont font = before_;
    font.setPointSize(GetParam());
    QApplication::setFont(font);
  }
  ~DesktopFont() override { QApplication::setFont(before_); }
  DesktopFont(const DesktopFont&) = delete;
  DesktopFont& operator=(const DesktopFont&) = delete;

 private:
  const QFont before_ = QApplication::font();
};

class LargeFont : public DesktopFont, public Operator {
 protected:
  /// The smallest screen that Skein is made for, at least.
  QSize screen() { return window.screen()->availableSize().expandedTo(QSize(1024, 768)); }
  void expect_all_well(const QSize& size) {
    window.resize(size);
    const auto* stop = find<QPushButton>("stop");
    EXPECT_TRUE(eventually([&] { return window.size() == size; }))
        << "it needs " << window.minimumSizeHint().width() << " x " << window.minimumSizeHint().height();
    lay_out();
    EXPECT_TRUE(QRect(QPoint(), size).contains({stop->mapTo(&window, QPoint()), stop->size()}));
    EXPECT_GE(stop->width(), stop->minimumSizeHint().width());
    EXPECT_GE(stop->height(), 56);
    for (const char* part : {"phase", "go", "step", "speed", "new_run", "record", "time_line", "time"})
      EXPECT_GE(find(part)->width(), find(part)->minimumSizeHint().width()) << part << " at " << size.width();
    EXPECT_GE(arena().width(), 300) << "at " << size.width();
    EXPECT_GE(arena().height(), 300) << "at " << size.height();
  }
};

TEST_P(LargeFont, LeavesStopWholeAndTheArenaItsRoom) {
  start();
  expect_all_well(screen());
  // Also with the longest that the run bar has to say.
  find<QLabel>("experiment_name")->setText(QString(60, QLatin1Char('n')));
  window.set_speed(10.0);
  ASSERT_TRUE(eventually([&] { return find<QLabel>("phase")->text().contains(QStringLiteral("at ")); }));
  expect_all_well(screen());
}

TEST_P(LargeFont, OpensInsideTheScreenWhatWasArrangedWithASmallOne) {
  const QFont large = QApplication::font();
  QFont small = large;
  small.setPointSize(8);
  QApplication::setFont(small);
  {
    MainWindow before;
    QDockWidget* left = before.findChild<QDockWidget*>(QStringLiteral("gains_dock"));
    for (const char* name : {"plots_dock", "robots_dock", "log_dock"}) {  // all in a row
      auto* dock = before.findChild<QDockWidget*>(QLatin1String(name));
      before.addDockWidget(Qt::LeftDockWidgetArea, dock);
      before.splitDockWidget(std::exchange(left, dock), dock, Qt::Horizontal);
    }
    before.show();
    before.close();
    ASSERT_TRUE(eventually([&] { return !before.isVisible(); }));
  }
  QApplication::setFont(large);
  MainWindow after;
  after.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&after));
  EXPECT_LE(after.width(), screen().width());
  const auto* stop = after.findChild<QPushButton*>(QStringLiteral("stop"));
  EXPECT_LE(stop->mapTo(&after, QPoint(stop->width(), 0)).x(), screen().width());
  after.close();
  EXPECT_TRUE(eventually([&] { return !after.isVisible(); }));
  settings().remove(QStringLiteral("geometry"));
}

TEST_P(LargeFont, ShowsWholeWhatSetsALawsParameters) {
  for (const char* law : {"leader_follower", "virtual_structure"}) {
    const auto experiment =
        app::parse_experiment(app::paper_experiment().source, "platoon.toml", {std::string("controller.kind=") + law});
    ASSERT_TRUE(experiment) << law;
    ASSERT_TRUE(eventually([&] { return !live().is_busy(); }));
    start(*experiment);
    window.resize(screen());
    find<QDockWidget>("gains_dock")->raise();
    const auto* panel = find<QWidget>("gains");
    const QWidget* room = panel->parentWidget();
    const auto sticks_out = [&] {  // what nobody could scroll to
      std::string names;
      for (const QWidget* part : panel->findChildren<QWidget*>()) {
        const QRect there(part->mapTo(room, QPoint()), part->size());
        const bool matters = qobject_cast<const QAbstractSpinBox*>(part) || qobject_cast<const QAbstractButton*>(part);
        if (part->isVisibleTo(panel) && matters && (there.left() < 0 || there.right() >= room->width()))
          names += " " + part->objectName().toStdString();
      }
      return names;
    };
    EXPECT_TRUE(eventually([&] { return sticks_out().empty(); })) << law << ":" << sticks_out();
    expect_all_well(screen());
  }
}

TEST_P(LargeFont, KeepsTheNumbersAtTheAxesOfPlotsApart) {
  const QFont of_desktop = QApplication::font();
  QFont small = of_desktop;
  small.setPointSize(10);
  QApplication::setFont(small);
  start();
  window.resize(screen());
  QApplication::setFont(of_desktop);  // the desktop's may change while the window is there
  const auto* plots = find<PlotView>("plot");
  const auto crowded = [&] {
    for (const QCPAxisRect* rect : plots->axisRects()) {
      const QCPAxis* value = rect->axis(QCPAxis::atLeft);
      const QFontMetrics letters(value->tickLabelFont());
      std::optional<double> before;
      for (const double tick : value->tickVector()) {
        if (!value->range().contains(tick)) continue;
        const double at = value->coordToPixel(tick);
        if (before && std::abs(at - *before) < letters.capHeight()) return true;
        before = at;
      }
    }
    return false;
  };
  const auto* first = plots->axisRects().first()->axis(QCPAxis::atLeft);
  EXPECT_TRUE(eventually([&] { return first->tickLabelFont().pointSize() == GetParam(); }));
  EXPECT_TRUE(eventually([&] { return !crowded(); })) << "numbers lie over one another";
}

INSTANTIATE_TEST_SUITE_P(Of, LargeFont, ::testing::Values(8, 10, 14, 20, 28),
                         [](const auto& points) { return std::to_string(points.param) + "pt"; });

}  // namespace
}  // namespace skein::ui::test
