// Why a robot's tag is not seen, asked of a camera that runs, and calibrations that are missing.
#include "app/session/camera_rig.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

/// A folder with a calibration for 60 mm tags and a film, as pictures, of one tag of 40 mm.
struct Lab {
  fs::path folder = fs::temp_directory_path() / ("skein_camera_rig_" + std::to_string(::getpid()));

  Lab() {
    fs::create_directories(folder / "film");
    vision::Calibration calibration = vision::overhead_calibration(2.0, 1.5);
    calibration.tag_size = 0.06;
    EXPECT_TRUE(vision::save_calibration(calibration, folder / "cal.toml"));
    vision::Frame frame;
    vision::SyntheticCamera(calibration)
        .render(std::vector<vision::SyntheticTag>{{1, {0.3, -0.2, 0.4}, 0.04}}, 0.0, frame);
    {
      std::ofstream picture(folder / "film" / "0.pgm", std::ios::binary);
      picture << "P5\n" << frame.width << " " << frame.height << "\n255\n";
      picture.write(reinterpret_cast<const char*>(frame.grey.data()), static_cast<std::streamsize>(frame.grey.size()));
    }
    for (int k = 1; k < 500; ++k)  // 20 s
      fs::create_hard_link(folder / "film" / "0.pgm", folder / "film" / (std::to_string(k) + ".pgm"));
  }
  ~Lab() { fs::remove_all(folder); }

  Experiment experiment(const std::string& calibration) const {
    auto e = parse_experiment(paper_experiment().source, "platoon.toml",
                              std::vector<std::string>{"camera.source=images:" + (folder / "film").string(),
                                                       "camera.calibration=" + (folder / calibration).string()});
    EXPECT_TRUE(e) << (e ? "" : e.error().front().message());
    return *e;
  }
};

TEST(CameraRig, SaysWhyATagIsNotSeen) {
  const Lab lab;
  const Experiment experiment = lab.experiment("cal.toml");
  SessionClock clock(true);
  SimulatedWorld world(experiment);
  auto rig = CameraRig::open(experiment, clock, world, false, wanted_tags(experiment));
  ASSERT_TRUE(rig) << rig.error();
  (*rig)->start();
  const std::vector<std::string> why = (*rig)->why_not_seen();
  (*rig)->end();
  ASSERT_EQ(why.size(), 4U) << "one sentence a robot";
  EXPECT_TRUE(why[0].starts_with("tag 1 is there, but its edge is 40 mm, 33 % smaller than [tags] size 60 mm"))
      << why[0];
  EXPECT_EQ(why[1], "no tag 2 is in the picture");
}

TEST(CameraRig, NamesAMissingCalibration) {
  const Lab lab;
  const auto missing = camera_calibration(lab.experiment("none.toml"));
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().find("none.toml"), std::string::npos) << missing.error();
  EXPECT_TRUE(camera_calibration(lab.experiment("cal.toml")));
}

}  // namespace
}  // namespace skein::app
