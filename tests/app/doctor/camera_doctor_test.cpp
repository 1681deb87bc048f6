#include "app/doctor/camera_doctor.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "app/experiment/experiment_file.h"
#include "tests/app/folder.h"

namespace skein::app {
namespace {

using State = Finding::State;

/// What stands in a webcam's place: automatics on, MJPG where it is fast.
vision::CameraDescription webcam() {
  vision::CameraDescription camera;
  camera.formats = {{"YUYV", 1280, 960, {7.5, 5.0}}, {"MJPG", 1280, 960, {30.0, 15.0}}, {"YUYV", 640, 480, {30.0}}};
  camera.controls = {{.name = "auto_exposure", .id = V4L2_CID_EXPOSURE_AUTO, .value = V4L2_EXPOSURE_APERTURE_PRIORITY},
                     {.name = "exposure_time_absolute", .id = V4L2_CID_EXPOSURE_ABSOLUTE, .value = 312},
                     {.name = "gain", .id = V4L2_CID_GAIN, .value = 64},
                     {.name = "focus_automatic_continuous", .id = V4L2_CID_FOCUS_AUTO, .value = 1},
                     {.name = "focus_absolute", .id = V4L2_CID_FOCUS_ABSOLUTE, .value = 30}};
  return camera;
}

const Finding& named(const std::vector<Finding>& findings, const std::string& what) {
  const auto found = std::find_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.what == what; });
  if (found == findings.end()) throw std::runtime_error("no finding " + what);
  return *found;
}

/// The [camera] of an experiment file that begins with this table.
CameraSpec parsed(const std::string& table) {
  const auto experiment = parse_experiment(table + "\n[[robot]]\n", "pasted.toml");
  if (!experiment) throw std::runtime_error(messages(experiment.error()));
  return experiment->camera;
}

TEST(CameraDoctor, AutomaticsAreNamedWithWhatToSet) {
  const auto findings = driver_findings(webcam(), 1280, 960, 30.0, 25.0);
  EXPECT_EQ(named(findings, "automatic exposure").state, State::note);
  EXPECT_EQ(named(findings, "automatic exposure").remedy, "--set exposure=0.005, and exposure in [camera]");
  EXPECT_EQ(named(findings, "automatic focus").remedy, "--set focus=30, and focus in [camera]");
  EXPECT_EQ(named(findings, "formats").state, State::well);

  vision::CameraDescription still = webcam();
  still.controls[0].value = V4L2_EXPOSURE_MANUAL;
  still.controls[3].value = 0;
  for (const Finding& finding : driver_findings(still, 1280, 960, 30.0, 25.0))
    EXPECT_EQ(finding.state, State::well) << as_line(finding);
}

TEST(CameraDoctor, AFormatThatIsFastEnoughIsNamed) {
  const Finding slow = named(driver_findings(webcam(), 1280, 960, 7.5, 25.0), "formats");
  EXPECT_EQ(slow.found, "at 1280x960, up to [frames/s]: YUYV 7.5, MJPG 30");
  EXPECT_EQ(slow.remedy, "--rate 25 --format MJPG, and a shorter exposure");
  EXPECT_EQ(named(driver_findings(webcam(), 1280, 960, 7.5, 60.0), "formats").remedy,
            "none is fast enough at this size: --size");
}

TEST(CameraDoctor, TheTableIsTakenByTheExperimentParser) {
  CameraCase examined{.source = "v4l2:/dev/video0", .calibration_file = "a \"good\" one.toml"};
  const CameraSpec camera = parsed(camera_table(examined, webcam()));
  EXPECT_EQ(camera.source, "v4l2:/dev/video0");
  EXPECT_EQ(camera.calibration, "a \"good\" one.toml");
  EXPECT_DOUBLE_EQ(camera.exposure, 0.005) << "shorter than the automatic's 31 ms";
  EXPECT_DOUBLE_EQ(camera.gain, 64.0);
  EXPECT_DOUBLE_EQ(camera.focus, 30.0);

  examined.options.controls = {{"exposure", 0.002}, {"gain", 10.0}};
  EXPECT_DOUBLE_EQ(parsed(camera_table(examined, webcam())).exposure, 0.002) << "what was asked for";
  EXPECT_DOUBLE_EQ(parsed(camera_table(examined, webcam())).gain, 10.0);

  CameraCase aravis{.source = "aravis:Basler-1"};
  aravis.options.trigger = "Line1";
  EXPECT_EQ(parsed(camera_table(aravis, {})).trigger, "Line1");
  EXPECT_EQ(parsed(camera_table({.source = "synthetic"}, {})).source, "synthetic");
  EXPECT_EQ(parsed(camera_table({.source = "video:run.mkv"}, {})).source, "video:run.mkv");

  vision::CameraDescription unitless;
  unitless.controls = {{.name = "exposure", .id = V4L2_CID_EXPOSURE, .value = 156}};
  EXPECT_TRUE(std::isnan(parsed(camera_table({.source = "v4l2:/dev/video0"}, unitless)).exposure))
      << "[camera] counts in seconds";
}

TEST(CameraDoctor, TheBusIsNamedWhereItIsTooNarrow) {
  test::Folder folder;
  const std::filesystem::path root = std::filesystem::path(folder / "sys");
  const auto plug = [&](const std::string& video, const std::string& port, const char* speed) {
    const auto device = root / "devices/usb1" / port, of_video = device / (port + ":1.0");
    std::filesystem::create_directories(of_video);
    std::ofstream(device / "speed") << speed << "\n";
    std::ofstream(device / "busnum") << "1\n";
    std::filesystem::create_directories(root / "class/video4linux" / video);
    std::filesystem::create_directory_symlink(of_video, root / "class/video4linux" / video / "device");
  };
  EXPECT_TRUE(usb_findings(root, "/dev/video7", 640, 480, 25.0).empty()) << "not on a USB";
  plug("video7", "1-1", "480");
  EXPECT_EQ(usb_findings(root, "/dev/video7", 640, 480, 25.0).at(0).state, State::well);
  const Finding narrow = usb_findings(root, "/dev/video7", 1280, 960, 25.0).at(0);
  EXPECT_EQ(narrow.state, State::note);
  EXPECT_EQ(narrow.found, "480 Mbit/s; two bytes a pixel take 492 at this size and rate");
  plug("video9", "1-2", "480");
  plug("video8", "1-2", "480");  // the same camera's second device
  EXPECT_EQ(usb_findings(root, "/dev/video7", 1280, 720, 20.0).at(0).found,
            "480 Mbit/s; two bytes a pixel take 295 at this size and rate; 1 other camera on the same bus");
  EXPECT_EQ(usb_findings(root, "/dev/video7", 1280, 720, 20.0).at(0).state, State::note);
}

/// It said of twelve of them only that no frame came, and nothing of one among others.
TEST(CameraDoctor, PicturesThatCannotBeReadAreNamed) {
  const test::Folder folder;
  const std::string junk = folder / "a.png";
  const std::string why = ": is of a format that cannot be read, allowed: png, jpg, pgm, ppm, bmp, tif, webp";
  std::ofstream(junk) << "no picture";
  const auto none = examine_camera({.source = "images:" + folder.path});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().find(": no frame came (skipped " + junk + why + ")"), std::string::npos) << none.error();
  for (const char* name : {"b.pgm", "c.pgm", "d.pgm"})
    std::ofstream(folder / name, std::ios::binary) << "P5\n64 48\n255\n" << std::string(64 * 48, 'x');
  const auto some = examine_camera({.source = "images:" + folder.path});
  ASSERT_TRUE(some) << some.error();
  EXPECT_EQ(named(some->findings, "damaged frames").state, State::ill);
  EXPECT_EQ(named(some->findings, "damaged frames").found, "1 (" + junk + why + ")");
}

TEST(CameraDoctor, TheSyntheticCameraIsWell) {
  const auto report = examine_camera({.source = "synthetic", .seconds = 1.0});
  ASSERT_TRUE(report) << report.error();
  for (const Finding& finding : report->findings) EXPECT_EQ(finding.state, State::well) << as_line(finding);
  EXPECT_GE(report->findings.size(), 10U);
  EXPECT_EQ(parsed(report->table).source, "synthetic");
  EXPECT_FALSE(examine_camera({.source = "v4l2:/dev/nowhere"}));
}

}  // namespace
}  // namespace skein::app
