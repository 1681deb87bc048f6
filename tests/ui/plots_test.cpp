// The plots: what they hold, how they draw much of it, and what they give away.
#include <QMenu>
#include <QRegularExpression>
#include <QToolButton>
#include <QToolTip>
#include <algorithm>
#include <array>
#include <clocale>
#include <cmath>
#include <functional>
#include <random>
#include <set>

#include "operator.h"
#include "tests/app/rows.h"
#include "ui/gains/gains_panel.h"
#include "ui/plots/curve_numbers.h"
#include "ui/plots/plot_history.h"
#include "ui/plots/plot_view.h"
#include "ui/plots/plots_panel.h"
#include "ui/plots/xy_plot.h"

namespace skein::ui::test {
namespace {

/// A curve with gaps and single peaks, and its history.
struct Curve {
  std::vector<double> t, value;
  PlotHistory history{1, std::size_t{1} << 17};

  explicit Curve(std::size_t samples, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (std::size_t k = 0; k < samples; ++k) {
      t.push_back(0.04 * static_cast<double>(k) + (k > samples / 2 ? 7.0 : 0.0));  // a jump in the middle
      const double u = unit(random);
      value.push_back(u < 0.02 ? std::nan("") : u > 0.999 ? 100.0 * unit(random) : std::sin(0.01 * t.back()) + 0.1 * u);
      history.add(t.back(), {value.back()});
    }
  }
};

TEST(PlotHistory, FindsTheSmallestAndTheLargestOfAnyStretch) {
  for (const std::size_t samples : {1U, 31U, 32U, 33U, 1024U, 5000U}) {
    const Curve curve(samples, 7);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> time(-1.0, curve.t.back() + 1.0);
    for (int trial = 0; trial < 200; ++trial) {
      const auto [from, to] = std::minmax({time(random), time(random)});
      double low = 1e300, high = -1e300;
      for (std::size_t k = 0; k < samples; ++k)
        if (curve.t[k] >= from && curve.t[k] <= to && !std::isnan(curve.value[k])) {
          low = std::min(low, curve.value[k]);
          high = std::max(high, curve.value[k]);
        }
      const PlotHistory::Range range = curve.history.range(0, from, to);
      if (low > high) {
        EXPECT_GT(range.low, range.high);
      } else {
        EXPECT_EQ(range.low, low);
        EXPECT_EQ(range.high, high);
      }
    }
  }
}

TEST(PlotHistory, DrawsFewPointsAndLeavesNoPeakOut) {
  const Curve curve(45000, 3);  // half an hour
  std::vector<PlotHistory::Point> points;
  for (const std::size_t columns : {100U, 400U, 1000U}) {
    curve.history.points(0, 0.0, curve.t.back(), columns, points);
    EXPECT_LE(points.size(), 4 * columns + 4);
    double low = 1e300, high = -1e300, last = -1.0;
    for (const PlotHistory::Point& point : points) {
      EXPECT_GE(point.t, last);
      last = point.t;
      if (std::isnan(point.value)) continue;
      low = std::min(low, point.value);
      high = std::max(high, point.value);
    }
    const PlotHistory::Range range = curve.history.range(0, 0.0, curve.t.back());
    EXPECT_EQ(low, range.low);
    EXPECT_EQ(high, range.high);
  }
  curve.history.points(0, 100.0, 101.0, 400, points);  // few: every one, and one beyond the end
  EXPECT_EQ(points.size(), 27u);
}

/// The height of a line through these points.
double height_at(const std::vector<PlotHistory::Point>& points, double t) {
  const auto after = std::find_if(points.begin(), points.end(), [t](const auto& point) { return point.t >= t; });
  if (after == points.begin() || after->t == t) return after->value;
  const auto before = std::prev(after);
  return before->value + (after->value - before->value) * (t - before->t) / (after->t - before->t);
}

TEST(PlotHistory, LevelStretchesAreDrawnByTheirEnds) {
  const double gap = std::numeric_limits<double>::quiet_NaN();
  std::vector<PlotHistory::Point> points{{0, 1}, {1, 1}, {2, 1.05}, {3, 1}, {4, gap}, {5, 7}, {6, 7}, {7, 9}, {8, 9}};
  drop_level_points(points, 0.1);
  std::vector<double> times(points.size());
  std::transform(points.begin(), points.end(), times.begin(), [](const auto& point) { return point.t; });
  EXPECT_EQ(times, (std::vector<double>{0, 3, 4, 5, 6, 7, 8}));

  std::mt19937 random(7);
  std::normal_distribution<double> step(0.0, 1.0);
  for (const double tolerance : {0.0, 0.5, 2.0, 20.0}) {
    std::vector<PlotHistory::Point> all(2000);
    double value = 0.0;
    for (std::size_t k = 0; k < all.size(); ++k) {
      value += k % 400 < 200 ? step(random) : 0.0;
      all[k] = {static_cast<double>(k), value};
    }
    std::vector<PlotHistory::Point> few = all;
    drop_level_points(few, tolerance);
    EXPECT_LT(few.size(), 1020u) << tolerance;
    EXPECT_EQ(few.front().t, all.front().t);
    EXPECT_EQ(few.back().t, all.back().t);
    for (const PlotHistory::Point& point : all)
      ASSERT_NEAR(height_at(few, point.t), point.value, 2 * tolerance) << tolerance << ", " << point.t;
  }
}

TEST(PlotHistory, ForgetsTheOldestAndStaysBounded) {
  PlotHistory history(2, 4096);
  for (int k = 0; k < 100000; ++k) history.add(k, {double(k), -double(k)});
  EXPECT_LE(history.size(), 5120u);
  EXPECT_GE(history.size(), 4096u - PlotHistory::block_size);
  EXPECT_EQ(history.last_time(), 99999.0);
  EXPECT_EQ(history.value(1, 99998.5), -99998.0);
  EXPECT_TRUE(std::isnan(history.value(0, 10.0)));
}

/// The plots of a crowd whose curves are waves about zero.
class Crowd : public ::testing::TestWithParam<std::size_t> {
 protected:
  static constexpr double end = 50.0;

  void SetUp() override {
    app::Experiment experiment = app::paper_experiment();
    experiment.robots.resize(GetParam(), experiment.robots.front());
    panel.resize(430, 600);
    panel.show_experiment(experiment);
    panel.show_plots({QStringLiteral("e_x"), QStringLiteral("e_y"), QStringLiteral("V")});
    panel.show();
    app::TickRecord record;
    record.phase = app::Phase::running;
    record.robots.resize(GetParam());
    for (record.t = 0.0; record.t < end; record.t += 0.04) {
      for (std::size_t i = 0; i < record.robots.size(); ++i) {
        const auto k = static_cast<double>(i + 1);
        record.robots[i].pose.x = 0.1 * std::sin(0.3 * record.t + k) * std::cos(k * k);
      }
      panel.show_record(record);
    }
  }
  /// The numbers of e_x in the newest picture.
  std::vector<CurveNumbers::Placed> numbers() {
    panel.view().draw_history(panel.history(), {});
    panel.view().replot(QCustomPlot::rpImmediateRefresh);
    return panel.view().numbers_of(0)->placed();
  }
  static std::size_t told_apart(const std::vector<CurveNumbers::Placed>& numbers, bool by_colour) {
    std::set<QString> all;
    for (const auto& one : numbers) all.insert(by_colour ? one.colour.name() : QString::number(one.number));
    return all.size();
  }
  PlotsPanel panel;
};

TEST_P(Crowd, HasItsNumbersOnItsCurves) {
  const std::vector<CurveNumbers::Placed> seen = numbers();
  const QCPAxis* time = panel.view().axisRect(0)->axis(QCPAxis::atBottom);
  const QCPAxis* value = panel.view().axisRect(0)->axis(QCPAxis::atLeft);
  for (const auto& one : seen) {
    const double t = time->pixelToCoord(one.place.center().x());
    EXPECT_NEAR(value->coordToPixel(panel.history().value(static_cast<std::size_t>(one.number - 1), t)),
                one.place.center().y(), 2.0)
        << one.number << " is not on its curve";
    for (const auto& other : seen) {
      EXPECT_TRUE(other.number == one.number || !other.place.intersects(one.place)) << one.number << other.number;
    }
  }
  EXPECT_EQ(told_apart(seen, false), seen.size());
  EXPECT_LE(told_apart(seen, true), 7U) << "by colours alone no more could be told apart";
  // In a panel this wide a third has no room at worst; all of 20 have.
  EXPECT_GE(3 * seen.size(), 2 * GetParam());
  EXPECT_GE(seen.size(), 20U);
  // The selected robot always has.
  for (const int robot : {0, 7, 13, static_cast<int>(GetParam()) - 1}) {
    panel.select(robot);
    EXPECT_EQ(numbers().front().number, robot + 1);
  }
}

TEST_P(Crowd, HasItsNumbersBehindShortCurves) {
  numbers();
  panel.view().set_time(0.9 * end, 2.0 * end);
  const std::vector<CurveNumbers::Placed> seen = numbers();
  EXPECT_GE(3 * seen.size(), 2 * GetParam());
  const QCPAxis* value = panel.view().axisRect(0)->axis(QCPAxis::atLeft);
  for (const auto& one : seen)
    EXPECT_NEAR(value->coordToPixel(panel.history().value(static_cast<std::size_t>(one.number - 1), end)),
                one.place.center().y(), 2.0);
  // Side by side from the curves' ends on: between an end and its number there are only other numbers.
  const double ends = panel.view().axisRect(0)->axis(QCPAxis::atBottom)->coordToPixel(end);
  for (const auto& one : seen) {
    double from = ends, to = one.place.left();
    for (const auto& other : seen)
      if (other.place.left() < to && other.place.top() < one.place.bottom() && other.place.bottom() > one.place.top())
        from = std::max(from, other.place.right());
    EXPECT_LE(to - from, 12.0) << one.number << " stands where no curve is";
  }
}

INSTANTIATE_TEST_SUITE_P(Of, Crowd, ::testing::Values(20U, 64U));

TEST(PlotBand, OfOneCentimetreIsSeenWhereExpectIsJudgedByItAndNowhereElse) {
  PlotsPanel panel;
  panel.show_experiment(app::paper_experiment());
  panel.resize(500, 700);
  panel.show_plots({"e_x", "e_y", "e_theta", "e", "delta", "V"});
  constexpr std::array judged{true, true, false, true, true, false};
  panel.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&panel));
  for (int plot = 0; plot < 6; ++plot) {
    const QCPAxisRect* rect = panel.view().axisRect(plot);
    QCPAxis* value = rect->axis(QCPAxis::atLeft);
    value->setRange(-0.03, 0.03);
    panel.view().replot(QCustomPlot::rpImmediateRefresh);
    const QImage picture = panel.view().grab().toImage();
    const auto ground = [&](double at) {  // beside the lines of the grid
      return picture.pixelColor(rect->left() + 3, static_cast<int>(std::lround(value->coordToPixel(at))));
    };
    const QColor bare = ground(0.017);
    const bool banded = judged[static_cast<std::size_t>(plot)];
    for (const double inside : {0.003, 0.008, -0.003, -0.008}) EXPECT_EQ(ground(inside) != bare, banded) << plot;
    for (const double outside : {0.012, -0.012, -0.017}) EXPECT_EQ(ground(outside), bare) << plot << ", " << outside;
  }
}

TEST(PlotBand, TheDistanceThatExpectAsksForIsALineBesideTheShields) {
  const auto lines = [](const char* set) {
    const auto experiment = app::parse_experiment(app::paper_experiment().source, "platoon.toml", {set});
    PlotsPanel panel;
    panel.show_experiment(*experiment);
    panel.show_plots({"min_distance"});
    std::vector<double> at;
    for (int k = 0; k < panel.view().itemCount(); ++k)
      if (const auto* line = qobject_cast<QCPItemStraightLine*>(panel.view().item(k));
          line && line->point1->typeY() == QCPItemPosition::ptPlotCoords && line->visible())
        at.push_back(line->point1->value());
    std::sort(at.begin(), at.end());
    return at;
  };
  const double shield = app::paper_experiment().shield.distance;
  EXPECT_EQ(lines("expect={min_distance=0.09}"), (std::vector{std::min(shield, 0.09), std::max(shield, 0.09)}));
  EXPECT_EQ(lines("expect={final_error=0.09}"), std::vector{shield});
}

TEST(Group, OfFourHasALegendAndNoNumbers) {
  PlotsPanel panel;
  panel.show_experiment(app::paper_experiment());
  EXPECT_EQ(panel.view().numbers_of(0), nullptr);
}

TEST(Group, ACurveThatStaysWhereItIsIsDrawnWithFewPointsAndAPeakInItIsSeen) {
  PlotsPanel panel;
  panel.resize(430, 600);
  panel.show_experiment(app::paper_experiment());
  panel.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&panel));
  app::TickRecord record;
  record.phase = app::Phase::running;
  record.robots.resize(4);
  constexpr double half_an_hour = 1800.0, peak_at = 900.0, peak = 0.015;
  for (int k = 0; record.t < half_an_hour; ++k) {
    record.t = 0.04 * k;
    record.robots[0].pose.x = k == static_cast<int>(peak_at / 0.04) ? peak : 0.0;  // for one tick
    record.robots[1].pose.x = 1e-7 * std::sin(record.t);                           // not seen
    panel.show_record(record);
  }
  panel.set_span(half_an_hour);
  panel.view().set_time(0.0, half_an_hour);
  panel.view().draw_history(panel.history(), {});
  const QCPGraph* with_peak = panel.view().graph(0);
  EXPECT_LE(with_peak->dataCount(), 8);
  EXPECT_LE(panel.view().graph(1)->dataCount(), 2);
  double lowest = 0.0;
  for (const QCPGraphData& point : *with_peak->data()) lowest = std::min(lowest, point.value);
  EXPECT_EQ(lowest, -peak);
}

class Plots : public Operator {
 protected:
  PlotsPanel& plots() { return *find<PlotsPanel>("plots"); }
  QStringList lines_of(const QString& file) {
    QFile in(file);
    EXPECT_TRUE(in.open(QIODevice::ReadOnly));
    return QString::fromUtf8(in.readAll()).split(QLatin1Char('\n'), Qt::SkipEmptyParts);
  }
  QTemporaryDir dir;
};

// CMakeLists.txt runs it once more as on a desktop that writes decimal commas.
TEST_F(Plots, HaveADecimalPointAsAllNumbersOfTheWindow) {
  start();
  EXPECT_EQ(plots().view().locale().decimalPoint(), QStringLiteral("."));
  EXPECT_STREQ(std::localeconv()->decimal_point, ".");
}

TEST_F(Plots, DrawNoWideLinesButTheSelectedRobots) {
  start();  // a line that is wider than a pixel costs several times as much
  const auto wide = [&] {
    int count = 0;
    for (int k = 0; k < plots().view().graphCount(); ++k) count += plots().view().graph(k)->pen().widthF() > 1.0;
    return count;
  };
  EXPECT_EQ(wide(), 0);
  arena().select(1);
  ASSERT_TRUE(eventually([&] { return wide() > 0; }));
  EXPECT_LT(wide(), plots().view().graphCount() / 2);
}

TEST_F(Plots, SavesWhatIsSeenAndEverything) {
  start();
  window.set_speed(50.0);
  ASSERT_TRUE(eventually([&] { return record().t > 30.0; }));
  plots().set_span(10.0);
  ASSERT_TRUE(eventually([&] { return plots().view().time().size() < 10.5; }));
  const QString seen = dir.filePath(QStringLiteral("seen.csv")), all = dir.filePath(QStringLiteral("all.csv"));
  window.save_plot(seen, false);
  window.save_plot(all, true);
  const QStringList few = lines_of(seen), many = lines_of(all);
  EXPECT_EQ(few.first(), many.first());
  EXPECT_TRUE(few.first().startsWith(QStringLiteral("t,e_x_1,e_x_2"))) << few.first().toStdString();
  EXPECT_NEAR(static_cast<double>(few.size()), 251.0, 3.0);
  EXPECT_GT(many.size(), 700);
  // As the run has it, to the last digit.
  const auto rows = live().history().rows();
  const QStringList cells = many[400].split(QLatin1Char(','));
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r->t == cells[0].toDouble(); });
  ASSERT_NE(row, rows.end());
  const app::RobotRecord& first = (*row)->robots[0];
  EXPECT_EQ(cells[1].toDouble(), first.nominal.pose.x - first.pose.x);
}

TEST_F(Plots, ShowsThePlotsAndRobotsThatWereChosen) {
  start();
  EXPECT_EQ(plots().shown().size(), 5);
  plots().show_all_plots();
  EXPECT_EQ(plots().shown().size(), static_cast<qsizetype>(plots().rows().size()));
  for (const char* name : {"v", "omega", "V_dot", "period", "compute_time", "latency"})
    EXPECT_TRUE(plots().shown().contains(QString::fromLatin1(name))) << name;
  ASSERT_TRUE(eventually([&] { return plots().view().axisRectCount() == static_cast<int>(plots().rows().size()); }));
  plots().show_plots({QStringLiteral("V"), QStringLiteral("v")});
  EXPECT_EQ(plots().view().axisRectCount(), 2);
  window.close();
  ASSERT_TRUE(eventually([&] { return !window.isVisible(); }));
  MainWindow again;
  again.open(app::paper_experiment(), false);
  EXPECT_EQ(again.findChild<PlotsPanel*>()->shown(), (QStringList{QStringLiteral("V"), QStringLiteral("v")}));
  again.findChild<PlotsPanel*>()->show_plots({});
  again.close();
  EXPECT_TRUE(eventually([&] { return !again.live().is_busy(); }));
}

TEST_F(Plots, StandStillToBeRead) {
  start();
  QTest::mouseClick(find<QToolButton>("freeze_plots"), Qt::LeftButton);
  EXPECT_FALSE(plots().is_live());
  const double t = record().t;
  const QCPRange before = plots().view().time();
  ASSERT_TRUE(eventually([&] { return record().t > t + 0.4; }));
  EXPECT_EQ(plots().view().time().lower, before.lower);
  EXPECT_GE(plots().history().last_time(), t + 0.4) << "what came meanwhile is lost";
}

TEST_F(Plots, TellValuesAndEventsAtTheMouse) {
  start();
  drag(robot(1), floor(0.2, 0.1));
  moved(1);
  ASSERT_TRUE(eventually([&] { return record().t > 1.5; }));
  QTest::mouseClick(find<QToolButton>("freeze_plots"), Qt::LeftButton);
  PlotView& view = plots().view();
  ASSERT_TRUE(eventually([&] { return view.axisRect(0)->graphs().last()->dataCount() > 10; }));
  const QRect first = view.axisRect(0)->rect();
  const auto read = [&](double t, const std::function<bool(const QString&)>& is_there) {
    // A pointer that the X server puts elsewhere meanwhile hides the tip: then the mouse comes back. The numbers beside
    // the axis may take more room in a next picture, which moves the time, and a tip from before may still be shown.
    static_cast<void>(eventually([&] {
      const int x = static_cast<int>(view.axisRect(0)->axis(QCPAxis::atBottom)->coordToPixel(t));
      QTest::mouseMove(&view, {x + 9, first.center().y()});
      QTest::mouseMove(&view, {x, first.center().y()});
      return !QToolTip::text().isEmpty() && is_there(QToolTip::text());
    }));
    return QToolTip::text();
  };
  const auto move = last<app::events::Move>(1);
  const auto rows = live().history().rows();
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [](const auto& r) { return r->events.template contains<app::events::Move>(1); });
  ASSERT_NE(row, rows.end());
  const QString text = read((*row)->t, [](const QString& tip) { return tip.contains(QStringLiteral("move r2")); });
  EXPECT_TRUE(text.contains(QStringLiteral("t = "))) << text.toStdString();
  EXPECT_TRUE(text.contains(QStringLiteral("Tracking error along x"))) << text.toStdString();
  EXPECT_TRUE(text.contains(QStringLiteral("4: "))) << "a value of each robot: " << text.toStdString();
  EXPECT_TRUE(text.contains(QStringLiteral("move r2"))) << "the event: " << text.toStdString();
  EXPECT_EQ(move.robot, 1u);
  // Without robot 4 its value is not read either.
  auto* robots = find<QToolButton>("choose_robots")->menu();
  emit robots->aboutToShow();
  robots->actions().at(3)->toggle();
  const QString without = read((*row)->t, [](const QString& tip) { return !tip.contains(QStringLiteral("4: ")); });
  EXPECT_TRUE(without.contains(QStringLiteral("3: "))) << without.toStdString();
  EXPECT_FALSE(without.contains(QStringLiteral("4: "))) << without.toStdString();
}

TEST_F(Plots, MeasureDifferencesFromAMark) {
  start();
  window.set_speed(20.0);
  ASSERT_TRUE(eventually([&] { return record().t > 20.0; }));
  QTest::mouseClick(find<QToolButton>("freeze_plots"), Qt::LeftButton);
  PlotView& view = plots().view();
  view.set_time(10.0, 20.0);
  ASSERT_TRUE(eventually([&] { return view.axisRect(0)->graphs().last()->dataCount() > 10; }));
  view.setFocus();
  const auto press = [&](Qt::Key key, Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    QTest::keyClick(&view, key, modifiers);
    return view.accessibleDescription();
  };
  EXPECT_FALSE(press(Qt::Key_Left).contains(QStringLiteral("Δ"))) << "there is no mark yet";
  EXPECT_TRUE(press(Qt::Key_D).contains(QStringLiteral("Δt = 0.00 s")));
  ASSERT_TRUE(plots().mark());
  const double from = *plots().mark();
  // 10 s / 60 a step
  QString text;
  for (int step = 0; step < 12; ++step) text = press(Qt::Key_Left);
  EXPECT_TRUE(text.contains(QStringLiteral("Δt = -2.00 s since the mark at %1 s").arg(from, 0, 'f', 2)))
      << text.toStdString();
  const double t = from - 2.0;
  const std::size_t e_x = 0;
  ASSERT_EQ(plots().rows()[e_x].name, QStringLiteral("e_x"));
  const double difference = plots().history().value(e_x, t) - plots().history().value(e_x, from);
  EXPECT_NE(difference, 0.0);
  EXPECT_TRUE(text.contains(QStringLiteral("Δ %1").arg(difference, 0, 'g', 4))) << text.toStdString();
  EXPECT_FALSE(press(Qt::Key_D, Qt::ShiftModifier).contains(QStringLiteral("Δ")));
  EXPECT_FALSE(plots().mark());
}

TEST_F(Plots, KeepAHeightUntilTheyAreToFollowTheirCurves) {
  start();
  window.set_speed(20.0);
  ASSERT_TRUE(eventually([&] { return record().t > 20.0; }));
  PlotView& view = plots().view();
  const QCPRange fitted = view.height_of(0);
  const QPoint middle = view.axisRect(0)->rect().center();
  const double value = view.value_at(0, middle);
  QWheelEvent wheel(middle, view.mapToGlobal(QPointF(middle)), {}, {0, 120}, Qt::NoButton, Qt::ControlModifier,
                    Qt::NoScrollPhase, false);
  QApplication::sendEvent(&view, &wheel);
  EXPECT_NEAR(view.height_of(0).size(), fitted.size() / PlotsPanel::zoom_step, 1e-9);
  EXPECT_NEAR(view.value_at(0, middle), value, 1e-9) << "what is under the mouse stays there";
  EXPECT_TRUE(plots().is_live()) << "the time runs on";
  const QCPRange other = view.height_of(1);
  const double t = record().t;
  ASSERT_TRUE(eventually([&] { return record().t > t + 5.0; }));
  EXPECT_NEAR(view.height_of(0).size(), fitted.size() / PlotsPanel::zoom_step, 1e-9);
  EXPECT_GT(other.size(), 0.0);
  // By keys, in the row of the cursor; a plot that is not drawn keeps nothing.
  view.setFocus();
  QTest::keyClick(&view, Qt::Key_Left);
  QTest::keyClick(&view, Qt::Key_Y, Qt::ShiftModifier);
  EXPECT_NEAR(view.height_of(0).size(), fitted.size(), 1e-9);
  QTest::keyClick(&view, Qt::Key_A);
  EXPECT_FALSE(view.holds_heights());
  // Without end it ends: a height is never empty.
  for (int k = 0; k < 4000; ++k) view.zoom_height(0, PlotsPanel::zoom_step);
  EXPECT_GT(view.height_of(0).size(), 0.0);
}

TEST_F(Plots, AreSavedAsPictures) {
  start();
  plots().show_all_plots();
  ASSERT_TRUE(eventually([&] { return record().t > 1.0; }));
  for (const char* name : {"plots.pdf", "plots.png"}) {
    const QString file = dir.filePath(QString::fromLatin1(name));
    window.save_plot(file, true);
    QFile in(file);
    ASSERT_TRUE(in.open(QIODevice::ReadOnly)) << name;
    EXPECT_GT(in.size(), 10000) << name;
    EXPECT_TRUE(in.peek(4) == "%PDF" || in.peek(4) == "\x89PNG") << name;
  }
  // All plots are on it, those that are scrolled out of sight as well.
  const QImage picture(dir.filePath(QStringLiteral("plots.png")));
  EXPECT_EQ(picture.height(), 2 * plots().view().height());
  const QRgb paper = picture.pixel(3, picture.height() - 3);
  int inked = 0;
  for (int x = 0; x < picture.width(); ++x)
    for (int y = picture.height() - 200; y < picture.height() - 100; ++y) inked += picture.pixel(x, y) != paper;
  EXPECT_GT(inked, 500) << "the last plot is empty";
}

TEST_F(Plots, ShowGainsPairByPair) {
  window.set_speed(10.0);
  start();
  emit find<GainsPanel>("gains")->couple_wanted(0, 2, false);
  ASSERT_TRUE(eventually([&] { return record().pair_gain(core::GainName::k_xx, 0, 2) == 0.0; }));
  const auto& rows = plots().rows();
  const auto row = std::find_if(rows.begin(), rows.end(), [](const PlotRow& r) { return r.name == "k_xx"; });
  ASSERT_NE(row, rows.end());
  ASSERT_EQ(row->curves.size(), 6u);
  EXPECT_EQ(row->curves[1], QStringLiteral("1,3"));
  const double t = plots().history().last_time();
  EXPECT_EQ(plots().history().value(row->first + 1, t), 0.0);
  EXPECT_EQ(plots().history().value(row->first + 0, t), 0.008);
}

TEST_F(Plots, LeaveOutTheWayToTheStarts) {
  const auto experiment = app::parse_experiment(app::paper_experiment().source, "platoon.toml",
                                                {"duration=4", "robot.2.start=[0.5, 0.3, 2.0]", "perturb=[]"});
  ASSERT_TRUE(experiment.has_value());
  skein::test::Rows run;
  (*app::Session::open(*experiment, app::Session::Clock::virtual_, {false, {&run}}))->run();
  ASSERT_EQ(run.rows.front().phase, app::Phase::staging);
  start(*experiment);
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  plots().show_experiment(*experiment);
  for (const app::TickRecord& row : run.rows) plots().show_record(row);
  plots().set_span(0.0);
  EXPECT_EQ(plots().history().size(), 100u);
  EXPECT_LT(std::abs(plots().history().value(1, 0.0)), 0.02) << "e_x of robot 2 at its start";
  plots().compare({PlotsPanel::Compared{&run.rows}});
}

TEST_F(Plots, AreDrawnOverEachOther) {
  start();
  ASSERT_TRUE(eventually([&] { return record().t > 1.0; }));
  EXPECT_FALSE(plots().over().isVisible());
  EXPECT_FALSE(plots().show_over(QStringLiteral("V"), QStringLiteral("e_x"))) << "one curve, and four";
  EXPECT_FALSE(plots().show_over(QStringLiteral("e_y"), QStringLiteral("nothing")));
  ASSERT_TRUE(plots().show_over(QStringLiteral("e_y"), QStringLiteral("e_x")));
  drag(robot(1), robot(1) + QPoint(30, 20));
  moved(1);
  const auto curve = [&](int robot) { return qobject_cast<QCPCurve*>(plots().over().plottable(2 * robot)); };
  ASSERT_TRUE(eventually([&] {
    bool found = false;
    return curve(1) && curve(1)->data()->size() > 20 && curve(1)->getKeyRange(found).size() > 0.02;
  }));
  EXPECT_TRUE(plots().over().isVisible());
  const auto& rows = plots().rows();
  const auto first = [&](const char* name) {
    return std::find_if(rows.begin(), rows.end(), [&](const PlotRow& r) { return r.name == QLatin1String(name); })
        ->first;
  };
  for (auto point = curve(1)->data()->constBegin(); point != curve(1)->data()->constEnd(); ++point) {
    EXPECT_EQ(point->key, plots().history().value(first("e_x") + 1, point->t));
    EXPECT_EQ(point->value, plots().history().value(first("e_y") + 1, point->t));
  }
  EXPECT_TRUE(plots().show_over(QStringLiteral("omega"), QStringLiteral("v")));
  plots().show_over({}, {});
  EXPECT_FALSE(plots().over().isVisible());
}

TEST_F(Plots, AreSavedWithTheOneOverAnother) {
  start();
  plots().show_plots({QStringLiteral("e_x")});
  ASSERT_TRUE(eventually([&] { return record().t > 1.0; }));
  const auto saved = [&](const char* name) {
    QString file = dir.filePath(QString::fromLatin1(name));
    window.save_plot(file, true);
    return file;
  };
  const int alone = QImage(saved("alone.png")).height();
  EXPECT_EQ(alone, 2 * plots().view().height());
  EXPECT_FALSE(lines_of(saved("alone.csv")).first().contains(QStringLiteral("omega_1")));

  ASSERT_TRUE(plots().show_over(QStringLiteral("omega"), QStringLiteral("v")));
  ASSERT_TRUE(eventually([&] { return plots().over().isVisible() && plots().over().height() > 100; }));
  const QImage both(saved("both.png"));
  EXPECT_EQ(both.height(), 2 * (plots().view().height() + plots().over().height()));
  // The curve of robot 4 is below the plots, in its colour.
  const Colours light = colours(palette(Theme::light));
  int inked = 0;
  for (int x = 0; x < both.width(); ++x)
    for (int y = 2 * plots().view().height(); y < both.height(); ++y)
      inked += QColor(both.pixel(x, y)) == light.robot(3);
  EXPECT_GT(inked, 20);
  QFile pdf(saved("both.pdf"));
  ASSERT_TRUE(pdf.open(QIODevice::ReadOnly));
  const QRegularExpressionMatch box = QRegularExpression(QStringLiteral("/MediaBox \\[0 0 ([0-9.]+) ([0-9.]+)\\]"))
                                          .match(QString::fromLatin1(pdf.readAll()));
  ASSERT_TRUE(box.hasMatch());
  EXPECT_NEAR(box.captured(2).toDouble(), plots().view().height() + plots().over().height(), 1.0);
  const QString head = lines_of(saved("both.csv")).first();
  for (const char* column : {"e_x_1", "omega_4", "v_1"})
    EXPECT_TRUE(head.contains(QString::fromLatin1(column))) << head.toStdString();
  EXPECT_TRUE(plots().over().isVisible()) << "it stays on the screen";
  plots().show_over({}, {});
  plots().show_plots({});
}

TEST_F(Plots, TakeASignalThatIsDraggedOntoThem) {
  start();
  plots().show_plots({QStringLiteral("e_x"), QStringLiteral("e_y"), QStringLiteral("V")});
  PlotView& view = plots().view();
  const auto row = [&](const char* name) {
    const auto& rows = plots().rows();
    return static_cast<std::size_t>(
        std::find_if(rows.begin(), rows.end(), [&](const PlotRow& r) { return r.name == QLatin1String(name); }) -
        rows.begin());
  };
  ASSERT_TRUE(eventually([&] { return view.head_of(row("V")).width() > 100 && record().t > 1.0; }));
  const auto drag_onto = [&](const char* signal, int plot) {
    const QPoint from = view.head_of(row(signal)).center(), to = view.axisRect(plot)->rect().center();
    QTest::mousePress(&view, Qt::LeftButton, {}, from);
    for (int k = 1; k <= 4; ++k) QTest::mouseMove(&view, from + (to - from) * k / 4);
    QTest::mouseRelease(&view, Qt::LeftButton, {}, to);
  };
  const QStringList before = plots().shown();
  drag_onto("e_y", 1);  // its own
  EXPECT_EQ(plots().shown(), before);
  drag_onto("e_y", 0);
  EXPECT_EQ(plots().shown(), (QStringList{QStringLiteral("e_x+e_y"), QStringLiteral("e_y"), QStringLiteral("V")}));
  EXPECT_TRUE(plots().is_live()) << "the time is not dragged with it";
  const auto added = [&] { return view.axisRect(0)->graphs().at(1); };  // the second of four, before the plot's own
  ASSERT_TRUE(eventually([&] { return view.axisRect(0)->graphs().size() == 8 && added()->dataCount() > 10; }));
  EXPECT_EQ(added()->pen().style(), Qt::DashLine);
  EXPECT_EQ(view.axisRect(0)->graphs().at(5)->pen().style(), Qt::SolidLine);
  EXPECT_EQ(added()->pen().color(), view.axisRect(0)->graphs().at(5)->pen().color());
  for (auto point = added()->data()->constBegin(); point != added()->data()->constEnd(); ++point)
    EXPECT_EQ(point->value, plots().history().value(plots().rows()[row("e_y")].first + 1, point->key));
  EXPECT_FALSE(view.axisRect(0)->axis(QCPAxis::atRight)->visible()) << "it has the same unit";

  // Another unit has an axis of its own; a third one has none.
  ASSERT_TRUE(eventually([&] { return view.head_of(row("V")).width() > 100; }));
  drag_onto("V", 0);
  EXPECT_EQ(plots().shown().first(), QStringLiteral("e_x+e_y+V"));
  EXPECT_TRUE(view.axisRect(0)->axis(QCPAxis::atRight)->visible());
  EXPECT_TRUE(plots().add_signal(QStringLiteral("omega"), QStringLiteral("e_x")).contains(QStringLiteral("two units")));
  EXPECT_FALSE(plots().add_signal(QStringLiteral("e_y"), QStringLiteral("e_x")).isEmpty()) << "once is enough";

  // As by keys: from the menu of the plots, and out again; what is added is saved, and kept in a layout.
  plots().show_plots({QStringLiteral("e_x")});
  QMenu* menu = find<QToolButton>("choose_plots")->menu();
  const auto toggle = [&](const QString& begin) {
    emit menu->aboutToShow();
    for (QMenu* add : menu->findChildren<QMenu*>(QStringLiteral("add_signal")))
      for (QAction* action : add->actions())
        if (action->text().startsWith(begin)) return action->trigger();
    ADD_FAILURE() << begin.toStdString();
  };
  toggle(QStringLiteral("ω"));
  EXPECT_EQ(plots().shown(), QStringList{QStringLiteral("e_x+omega")});
  const QString file = dir.filePath(QStringLiteral("added.csv"));
  window.save_plot(file, true);
  EXPECT_TRUE(lines_of(file).first().contains(QStringLiteral("omega_4")));
  const PlotLayout layout = plots().layout_now(QStringLiteral("two"));
  toggle(QStringLiteral("ω"));
  EXPECT_EQ(plots().shown(), QStringList{QStringLiteral("e_x")});
  plots().use(layout);
  EXPECT_EQ(plots().shown(), QStringList{QStringLiteral("e_x+omega")});

  // A key on the way is not lost.
  ASSERT_TRUE(eventually([&] { return view.head_of(row("e_x")).width() > 100; }));
  QTest::mousePress(&view, Qt::LeftButton, {}, view.head_of(row("e_x")).center());
  key(Qt::Key_Space);
  EXPECT_TRUE(eventually([&] { return stopped(); }));
  QTest::mouseRelease(&view, Qt::LeftButton, {}, view.head_of(row("e_x")).center());
  plots().show_plots({});
}

TEST_F(Plots, AreKeptAsLayouts) {
  start();
  plots().show_plots({QStringLiteral("V"), QStringLiteral("e_x"), QStringLiteral("e_y")});
  plots().set_span(300.0);
  plots().show_over(QStringLiteral("e_y"), QStringLiteral("e_x"));
  keep_plot_layout(plots().layout_now(QStringLiteral("errors / 1")));
  plots().show_plots({QStringLiteral("v")});
  plots().set_span(10.0);
  plots().show_over({}, {});

  QMenu* menu = find<QToolButton>("choose_plots")->menu();
  emit menu->aboutToShow();
  QAction* found = nullptr;
  for (QAction* action : menu->findChildren<QAction*>())
    if (action->text() == QStringLiteral("errors - 1")) found = found ? found : action;
  ASSERT_NE(found, nullptr);
  found->trigger();
  EXPECT_EQ(plots().shown(), (QStringList{QStringLiteral("e_x"), QStringLiteral("e_y"), QStringLiteral("V")}));
  EXPECT_EQ(plots().span(), 300.0);
  EXPECT_TRUE(plots().over().isVisible());
  forget_plot_layout(QStringLiteral("errors - 1"));
  EXPECT_TRUE(plot_layouts().empty());
  plots().show_plots({});
}

}  // namespace
}  // namespace skein::ui::test
