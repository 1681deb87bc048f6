// What the figures show of a run: all of a short one, and of a long one as much as can be seen.
#include "app/record/figure_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/experiment_file.h"

namespace skein::app {
namespace {

using testing::HasSubstr;
using testing::Not;

Experiment robots(int n) {
  std::string text = "controller.gains = { k_xx = 0, k_tt = 0, k_yy = 0 }\n";
  for (int i = 0; i < n; ++i) text += "[[robot]]\n";
  return parse_experiment(text, "e.toml").value();
}

/// A row of a run whose robots go round and round, a lap in 80 s, seen with an error of about a millimetre.
TickRecord row(std::int64_t tick, std::size_t n) {
  TickRecord row;
  row.t = 0.04 * static_cast<double>(tick);
  row.delta.assign(n - 1, 1e-3);
  row.robots.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = row.t * 6.283185307 / 80.0 + static_cast<double>(i);
    const double off = 1e-3 * std::sin(static_cast<double>(tick * tick % 1009));
    row.robots[i].nominal.pose = {0.6 * std::cos(angle), 0.6 * std::sin(angle), 0.0};
    row.robots[i].pose = {(0.6 + off) * std::cos(angle), (0.6 + off) * std::sin(angle), 0.0};
    row.robots[i].mode = tracking;
  }
  return row;
}

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(FigureData, HasAllOfAShortRun) {
  constexpr std::int64_t ticks = 3000;
  FigureData figures(robots(2));
  for (std::int64_t tick = 0; tick < ticks; ++tick) figures.record(row(tick, 2));
  // Each block has a line before it and one behind it.
  EXPECT_EQ(lines(figures.paths()), 2u * (ticks + 2) + 2u * (ticks + 2) + 2u * (1 + 2) + 2u * (2 + 2));
  const std::string errors = figures.errors();
  EXPECT_EQ(lines(errors.substr(0, errors.find("$peaks_1"))), (2u * 3u + 1u) * (ticks + 2));
  EXPECT_EQ(figures.extents().t.high, row(ticks - 1, 2).t);
}

TEST(FigureData, DoesNotGrowWithTheRun) {
  constexpr std::size_t n = 4;
  const auto bytes_after = [](std::int64_t ticks) {
    FigureData figures(robots(n));
    for (std::int64_t tick = 0; tick < ticks; ++tick) figures.record(row(tick, n));
    return figures.paths().size() + figures.errors().size();
  };
  const std::size_t of_an_hour = bytes_after(90'000);
  EXPECT_LT(of_an_hour, 5u << 20);
  EXPECT_LT(bytes_after(360'000), of_an_hour * 6 / 5) << "4 hours";
}

TEST(FigureData, KeepsWhatSticksOutForOneTick) {
  FigureData figures(robots(1));
  for (std::int64_t tick = 0; tick < 100'000; ++tick) {
    TickRecord one = row(tick, 1);
    one.robots[0].pose = one.robots[0].nominal.pose;
    if (tick == 77'777) one.robots[0].pose.x -= 0.0173;
    if (tick == 77'779) one.robots[0].pose.x += 0.0171;
    figures.record(one);
  }
  EXPECT_THAT(figures.errors(), HasSubstr("\n3111.08 0.0173\n"));
  EXPECT_THAT(figures.errors(), HasSubstr("\n3111.16 -0.0171\n"));
  EXPECT_NEAR(figures.extents().e_xy.high, 0.0173, 1e-9);
}

TEST(FigureData, AThinnedPathIsNowhereFarFromTheRobots) {
  FigureData figures(robots(1));
  FloorLine line(500, 2.0);
  for (std::int64_t tick = 0; tick < 50'000; ++tick) {
    const TickRecord one = row(tick, 1);
    line.add(one.robots[0].pose.x, one.robots[0].pose.y, true);
  }
  std::istringstream text(line.text());
  std::vector<std::pair<double, double>> points;
  for (double x = 0.0, y = 0.0; text >> x >> y;) points.emplace_back(x, y);
  EXPECT_LE(points.size(), 500u);
  for (const auto& [x, y] : points) EXPECT_NEAR(std::hypot(x, y), 0.6, 0.0015);
  for (int degree = 0; degree < 360; ++degree) {  // none of the lap is left out
    const double a = degree * 3.14159265 / 180.0;
    const bool near = std::any_of(points.begin(), points.end(), [&](const auto& p) {
      return std::hypot(p.first - 0.6 * std::cos(a), p.second - 0.6 * std::sin(a)) < 0.05;
    });
    EXPECT_TRUE(near) << degree;
  }
}

TEST(FigureData, BreaksAPathWhereARobotWasPutElsewhereOrNotSeen) {
  FigureData figures(robots(1));
  const auto at = [&](double x, double y) {
    TickRecord one = row(0, 1);
    one.robots[0].pose = {x, y, 0.0};
    figures.record(one);
  };
  at(0.0, 0.0), at(0.01, 0.0), at(0.2, 0.1), at(0.21, 0.1), at(none, none), at(0.22, 0.1), at(0.23, 0.1);
  EXPECT_THAT(figures.paths(),
              HasSubstr("$path_1 << end\n0 0\n0.01 0\n\n0.2 0.1\n0.21 0.1\n\n0.22 0.1\n0.23 0.1\nend\n"));
  EXPECT_THAT(figures.paths(), HasSubstr("$moves_1 << end\n0.01 0 0.19 0.1\nend\n"));
  EXPECT_THAT(figures.paths(), HasSubstr("$ends_1 << end\n0 0\n0.23 0.1\nend\n"));
}

TEST(FigureData, APathBeginsWhereItsRobotWasSeenFirst) {
  FigureData figures(robots(1));
  for (const double x : {none, none, 0.1, 0.11}) {
    TickRecord one = row(0, 1);
    one.robots[0].pose = {x, std::isnan(x) ? none : 0.2, 0.0};
    figures.record(one);
  }
  EXPECT_THAT(figures.paths(), HasSubstr("$ends_1 << end\n0.1 0.2\n0.11 0.2\nend\n"));
}

TEST(FigureData, APathOfNothingButJumpsEndsToo) {
  FloorLine line(100, 2.0);
  for (int k = 0; k < 10'000; ++k) line.add(k % 2 == 0 ? 0.1 * (k % 17) : 1e200, 0.05 * (k % 13), k % 3 != 0);
  EXPECT_LE(lines(line.text()), 200u);
}

TEST(FigureData, ARobotThatWasNeverSeenHasEmptyBlocks) {
  FigureData figures(robots(2));
  TickRecord one = row(0, 2);
  one.robots[1].pose = {none, none, none};
  figures.record(one);
  EXPECT_THAT(figures.errors(), HasSubstr("$x_2 << end\nNaN NaN NaN NaN\nend\n"));
  EXPECT_THAT(figures.errors(), Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace skein::app
