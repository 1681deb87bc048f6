// Robots that POV-Ray has drawn, a program that knows nothing of Skein: rendered_robots.pov says what they do.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "tests/vision/support.h"
#include "vision/bench/bench_score.h"
#include "vision/sources/open_source.h"
#include "vision/synthetic/random.h"
#include "vision/tracker/tracker.h"

namespace skein::vision::detail {
namespace {

constexpr double degree = core::pi / 180.0;

struct Circle {
  int tag;
  double x, y, radius;  // [m]
  double from, speed;   // [degrees], [degrees/s]
};
constexpr std::array<Circle, 6> robots{{{1, -0.34, 0.20, 0.09, 20, 80},
                                        {2, 0.02, 0.21, 0.10, 100, -70},
                                        {3, 0.37, 0.18, 0.11, 200, 65},
                                        {4, -0.33, -0.23, 0.10, -60, -75},
                                        {20, 0.00, -0.22, 0.08, 10, 90},
                                        {21, 0.36, -0.24, 0.09, 140, -85}}};

/// By the numbers of the tags.
BenchMoment truth_at(double t) {
  BenchMoment truth;
  truth.tags.resize(22);
  truth.in_sight.resize(22);
  for (const Circle& circle : robots) {
    const auto tag = static_cast<std::size_t>(circle.tag);
    const double angle = (circle.from + circle.speed * t) * degree;
    truth.tags[tag].pose = {circle.x + circle.radius * std::cos(angle), circle.y + circle.radius * std::sin(angle),
                            core::wrap_angle(angle + (circle.speed > 0.0 ? 0.5 : -0.5) * core::pi)};
    truth.in_sight[tag] = true;
  }
  return truth;
}

Calibration camera() {
  Calibration camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 690.0;
  camera.cx = 319.5, camera.cy = 239.5;
  CameraPose& pose = camera.world_from_camera.emplace();
  const Eigen::Matrix3d tilt = (Eigen::AngleAxisd(1.0 * degree, Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(3.0 * degree, Eigen::Vector3d::UnitX()))
                                   .toRotationMatrix();
  pose.rotation = tilt * Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  pose.position = {0.02, -0.03, 1.2};
  return camera;
}

std::vector<Frame> pictures() {
  const auto source = open_source("images:" + test::in_source("tests/vision/tracker/rendered"));
  if (!source) throw std::runtime_error(source.error());
  std::vector<Frame> frames(4);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto more = (*source)->read(frames[k]);
    if (!more || !*more) throw std::runtime_error(more ? "a picture is missing" : more.error());
    frames[k].captured_at = 0.04 * static_cast<double>(k);
  }
  return frames;
}

struct Sensor {
  const char* name;
  double exposure;  // of the pictures' grey levels
  double noise;     // [grey levels]
  double gamma;     // most webcams have 2.2
};

/// As the sensor sees the picture.
Frame seen_by(const Sensor& sensor, const Frame& picture, Random& random) {
  Frame seen = picture;
  for (auto& grey : seen.grey) {
    const double normal = std::sqrt(-2.0 * std::log(1.0 - random.unit())) * std::cos(2.0 * core::pi * random.unit());
    const double light = std::clamp((sensor.exposure * grey + sensor.noise * normal) / 255.0, 0.0, 1.0);
    grey = static_cast<std::uint8_t>(std::lround(255.0 * std::pow(light, 1.0 / sensor.gamma)));
  }
  return seen;
}

TEST(RenderedRobots, AreWhereTheTrackerSaysAsExactlyAsItSays) {
  const std::vector<Frame> frames = pictures();
  std::vector<int> tags;
  for (const Circle& circle : robots) tags.push_back(circle.tag);
  // The control, a fit without a tone: squared errors of 0.60, 0.74, 0.07, 0.12 and 0.19 times the claimed variance.
  for (const Sensor& sensor : {Sensor{"linear", 1.2, 2.0, 1.0},
                               {"noisy", 1.2, 5.0, 1.0},
                               {"gamma", 1.2, 2.0, 2.2},
                               {"gamma, noisy", 1.2, 5.0, 2.2},
                               {"overexposed", 1.8, 2.0, 1.0}}) {
    Random random(3);
    Score score;
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    constexpr int films = 8;
    for (int film = 0; film < films; ++film) {
      TagTracker tracker(camera(), {.tags = tags});
      for (const Frame& picture : frames) {
        const BenchMoment truth = truth_at(picture.captured_at);
        const std::vector<TagPose>& poses = tracker.process(seen_by(sensor, picture, random));
        score.add(truth, poses);
        for (const TagPose& pose : poses) {
          const core::Pose& is = truth.tags[static_cast<std::size_t>(pose.tag)].pose;
          shift +=
              Eigen::Vector3d(pose.pose.x - is.x, pose.pose.y - is.y, core::wrap_angle(pose.pose.theta - is.theta));
        }
      }
    }
    shift /= static_cast<double>(score.right);
    fmt::print(
        "{:13} recall {:.0f} %, rms {:.4f} mm and {:.3f} degrees, mean {:.4f} {:.4f} mm {:.3f} degrees, nees {:.2f}\n",
        sensor.name, score.recall(), 1e3 * score.rms_xy(), score.rms_theta() / degree, 1e3 * shift.x(), 1e3 * shift.y(),
        shift.z() / degree, score.mean_nees());
    EXPECT_EQ(score.recall(), 100.0) << sensor.name;
    EXPECT_EQ(score.wrong_poses + score.wrong_ids, 0) << sensor.name;
    EXPECT_GT(score.mean_nees(), 0.5) << sensor.name;
    EXPECT_LT(score.mean_nees(), 1.5) << sensor.name;
    EXPECT_LT(score.rms_xy(), 0.05e-3) << sensor.name;
    EXPECT_LT(shift.head<2>().norm(), 0.01e-3) << sensor.name;  // a sixtieth of a pixel
    EXPECT_LT(std::abs(shift.z()), 0.04 * degree) << sensor.name;
  }
}

}  // namespace
}  // namespace skein::vision::detail
