#include "app/bench/bench_joint.h"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "core/geometry/pose.h"
#include "core/math/elementary.h"
#include "vision/calibrate/joint_calibration.h"

namespace skein::app {
namespace {

using vision::Calibration;

/// What is wrong with the second camera's calibration, and how far its poses may be off after the correction.
struct Fault {
  const char* name;
  std::function<void(Calibration&)> make;
  double goal;  // [m]; 0: none, since a pose of the camera cannot mend it
};

void move(Calibration& calibration, double degrees, double x, double y) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(degrees / 180.0 * core::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  vision::CameraPose& pose = *calibration.world_from_camera;
  pose.rotation = turn * pose.rotation;
  pose.position = turn * pose.position + Eigen::Vector3d(x, y, 0.0);
}

/// What a calibration makes of a robot that the camera sees, with noise; none: outside its picture.
class Eye {
 public:
  Eye(Calibration truth, Calibration believed, std::mt19937_64& random)
      : truth_(std::move(truth)), believed_(std::move(believed)), random_(random) {}

  std::optional<core::Pose> see(const core::Pose& pose) {
    constexpr double margin = 30.0, sigma_px = 0.03, sigma_theta = 5e-4, ahead = 0.01;  // [px, px, rad, m]
    const Eigen::Vector2d noise(sigma_px * normal_(random_), sigma_px * normal_(random_));
    const auto place = [&](double way) -> std::optional<Eigen::Vector2d> {
      const auto pixel = pixel_from_world(truth_, {pose.x + way * core::math::cos(pose.theta),
                                                   pose.y + way * core::math::sin(pose.theta), truth_.tag_height});
      if (!pixel || pixel->x() < margin || pixel->y() < margin || pixel->x() > truth_.width - margin ||
          pixel->y() > truth_.height - margin)
        return {};
      return world_from_pixel(believed_, *pixel + noise, believed_.tag_height);
    };
    const auto at = place(0.0), front = place(ahead);
    if (!at || !front) return {};
    return core::Pose{at->x(), at->y(),
                      core::math::atan2(front->y() - at->y(), front->x() - at->x()) + sigma_theta * normal_(random_)};
  }

 private:
  const Calibration truth_, believed_;
  std::mt19937_64& random_;
  std::normal_distribution<double> normal_;
};

/// How far poses are off, rms over all that the camera sees. [m]
double error_of(const Calibration& truth, const Calibration& believed) {
  constexpr double step = 40.0;  // [px]
  double squares = 0.0;
  int n = 0;
  for (double u = step; u < truth.width; u += step)
    for (double v = step; v < truth.height; v += step) {
      const auto is = world_from_pixel(truth, {u, v}, truth.tag_height);
      const auto said = world_from_pixel(believed, {u, v}, believed.tag_height);
      if (!is || !said) continue;
      squares += (*is - *said).squaredNorm();
      ++n;
    }
  return std::sqrt(squares / n);
}

/// Three robots at 0.13 m/s on circles around points of the seam, for 30 s; the cameras see 10 cm beyond it, at 25 Hz
/// and out of step.
std::vector<std::vector<vision::TagPose>> film(const std::vector<Calibration>& truth,
                                               const std::vector<Calibration>& believed) {
  constexpr double radius = 0.2, speed = 0.13;
  std::mt19937_64 random(1);
  std::vector<std::vector<vision::TagPose>> sights(truth.size());
  for (std::size_t camera = 0; camera < truth.size(); ++camera) {
    Eye eye(truth[camera], believed[camera], random);
    for (int k = 0; k < 750; ++k)
      for (int robot = 0; robot < 3; ++robot) {
        const double t = 0.04 * k + 0.017 * static_cast<double>(camera), angle = speed / radius * t + robot;
        const auto pose = eye.see({radius * core::math::cos(angle), 0.4 * (robot - 1) + radius * core::math::sin(angle),
                                   angle + 0.5 * core::pi});
        if (pose) sights[camera].push_back({.tag = robot + 1, .pose = *pose, .captured_at = t});
      }
  }
  return sights;
}

}  // namespace

int bench_joint() {
  const std::vector<Fault> faults{
      {"right", [](Calibration&) {}, 0.5e-3},
      {"turned by 1 degree, 15 mm off", [](Calibration& c) { move(c, 1.0, 0.012, -0.009); }, 0.5e-3},
      {"50 mm off", [](Calibration& c) { move(c, 0.0, 0.05, 0.0); }, 0.5e-3},
      {"turned round, 0.5 m off", [](Calibration& c) { move(c, 180.0, 0.4, 0.3); }, 0.5e-3},
      {"tilted by 0.2 degrees", [](Calibration& c) { c = vision::tilted(c, 0.2); }, 1e-3},
      {"tilted by 1 degree", [](Calibration& c) { c = vision::tilted(c, 1.0); }, 3e-3},
      {"5 mm too high", [](Calibration& c) { c.world_from_camera->position.z() += 5e-3; }, 2e-3},
      {"focal length 0.3 % too large", [](Calibration& c) { c.fx *= 1.003, c.fy *= 1.003; }, 0.0},
  };
  print_out(
      fmt::format("calibrate joint: two cameras beside each other, the second one's calibration is wrong [mm]\n"
                  "{:<32}{:>8}{:>10}{:>10}{:>22}{:>10}{:>10}\n",
                  "", "places", "apart", "after", "its error (control)", "after", "known"));
  int status = done;
  for (const Fault& fault : faults) {
    const std::vector<Calibration> truth{vision::overhead_calibration(1.2, 1.5, {-0.5, 0.0}),
                                         vision::overhead_calibration(1.2, 1.5, {0.5, 0.0})};
    std::vector<Calibration> believed = truth;
    fault.make(believed[1]);
    const auto joint = vision::solve_joint(believed, film(truth, believed));
    if (!joint) {
      print_out(fmt::format("{:<32}{}\n", fault.name, joint.error()));
      status = expectation_failed;
      continue;
    }
    const vision::JointPair& pair = joint->pairs.front();
    const double after = error_of(truth[1], joint->cameras[1].calibration);
    print_out(fmt::format("{:<32}{:>8}{:>10.2f}{:>10.2f}{:>22.2f}{:>10.2f}{:>10.2f}\n", fault.name, pair.places,
                          1e3 * pair.before.rms, 1e3 * pair.after.rms, 1e3 * error_of(truth[1], believed[1]),
                          1e3 * after, 1e3 * joint->cameras[1].known));
    if (fault.goal > 0.0 && after > fault.goal) status = expectation_failed;
  }
  return status;
}

}  // namespace skein::app
