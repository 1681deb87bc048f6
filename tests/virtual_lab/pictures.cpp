// skein_lab_pictures EXPERIMENT DIRECTORY: a calibration file (camera.toml) and a picture of the experiment's robots,
// each a little beside its place at second 0, so that the law has something to do.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include "app/calibration/calibration_file.h"
#include "app/experiment/experiment_file.h"
#include "app/experiment/experiment_reference.h"
#include "vision/calibration/calibration.h"
#include "vision/synthetic/synthetic_camera.h"

namespace {

constexpr double behind = 0.02, beside = 0.005;  // [m]
constexpr double tag_size = 0.06;                // [m]
constexpr int shrink = 2;                        // of the pictures' sides: 640x480

}  // namespace

int main(int argc, char** argv) {
  using namespace skein;
  if (argc != 3) {
    fmt::print(stderr, "usage: {} EXPERIMENT DIRECTORY\n", argv[0]);
    return 2;
  }
  // Its camera's calibration does not exist yet; nobody opens it here.
  const auto experiment = app::load_experiment(argv[1]);
  if (!experiment) {
    for (const app::Problem& problem : experiment.error()) fmt::print(stderr, "{}\n", problem.message());
    return 2;
  }
  const std::filesystem::path directory = argv[2];
  vision::Calibration camera = vision::overhead_calibration(experiment->arena_width, experiment->arena_height);
  camera.width /= shrink;
  camera.height /= shrink;
  for (double* length : {&camera.fx, &camera.fy}) *length /= shrink;
  for (double* place : {&camera.cx, &camera.cy}) *place = (*place + 0.5) / shrink - 0.5;
  camera.tag_size = tag_size;
  if (const auto saved = app::save_calibration(camera, directory / "camera.toml"); !saved) {
    fmt::print(stderr, "{}\n", saved.error());
    return 3;
  }
  const auto reference = app::make_reference(*experiment);
  std::vector<vision::SyntheticTag> tags;
  for (std::size_t i = 0; i < experiment->robots.size(); ++i) {
    const core::Pose place = reference->at(i, 0.0).pose;
    const double c = std::cos(place.theta), s = std::sin(place.theta);
    const double side = i % 2 == 0 ? beside : -beside;
    const core::Pose pose{place.x - behind * c - side * s, place.y - behind * s + side * c, place.theta};
    tags.push_back({experiment->robots[i].tag, pose, tag_size});
  }
  vision::Frame frame;
  vision::SyntheticCamera(camera, {}, experiment->seed).render(tags, 0.0, frame);
  std::ofstream out(directory / "picture.pgm", std::ios::binary);
  out << "P5\n" << frame.width << ' ' << frame.height << "\n255\n";
  for (int v = 0; v < frame.height; ++v) out.write(reinterpret_cast<const char*>(frame.row(v)), frame.width);
  return out ? 0 : 3;
}
