// What a camera says it can do, and how it is set.
#include "vision/v4l2/camera_controls.h"

#include "tests/vision/support.h"
#include "tests/vision/v4l2/fake_camera.h"
#include "vision/v4l2/v4l2_source.h"

namespace skein::vision {
namespace {

FakeCamera webcam() {
  FakeCamera fake;
  fake.controls[V4L2_CID_BRIGHTNESS] = {.name = "Brightness", .least = -64, .most = 64, .value = 2};
  fake.controls[V4L2_CID_GAIN] = {.name = "Gain", .value = 10};
  fake.controls[V4L2_CID_EXPOSURE_AUTO] = {
      .name = "Exposure, Auto", .type = V4L2_CTRL_TYPE_MENU, .most = 3, .value = V4L2_EXPOSURE_APERTURE_PRIORITY};
  fake.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {
      .name = "Exposure Time, Absolute", .least = 2, .most = 5000, .value = 300, .flags = V4L2_CTRL_FLAG_INACTIVE};
  fake.controls[V4L2_CID_FOCUS_AUTO] = {.name = "Focus, Auto", .type = V4L2_CTRL_TYPE_BOOLEAN, .most = 1, .value = 1};
  fake.controls[V4L2_CID_FOCUS_ABSOLUTE] = {.name = "Focus (absolute)"};
  return fake;
}

std::string problem(FakeCamera& fake, const ControlSettings& settings) {
  SourceOptions options;
  options.controls = settings;
  const auto camera = open_v4l2("/dev/fake", options, fake);
  return camera ? "" : camera.error();
}

TEST(CameraControls, AreListed) {
  FakeCamera fake = webcam();
  const auto camera = describe_camera("/dev/fake", fake);
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ(fake.opened, 0) << "closed again";
  std::vector<std::string> names;
  for (const CameraControl& control : camera->controls) names.push_back(control.name);
  EXPECT_EQ(names, (std::vector<std::string>{"brightness", "gain", "exposure_auto", "exposure_time_absolute",
                                             "focus_absolute", "focus_auto"}));
  EXPECT_EQ(camera->controls[0].least, -64);
  EXPECT_EQ(camera->controls[0].value, 2);
  EXPECT_TRUE(camera->controls[0].settable);
  EXPECT_FALSE(camera->controls[3].settable) << "the automatic does it";
  using Choices = std::vector<std::pair<std::int64_t, std::string>>;
  EXPECT_EQ(camera->controls[2].choices, (Choices{{0, "auto_mode"}, {1, "manual_mode"}, {3, "auto_mode"}}));
  ASSERT_EQ(camera->formats.size(), 4U);
  EXPECT_EQ(camera->formats[1].format, "YUYV");
  EXPECT_EQ(camera->formats[1].width, 1280);
  EXPECT_EQ(camera->formats[1].rates, (std::vector{30.0, 15.0}));
  EXPECT_EQ(camera->formats[2].format, "GREY");
}

TEST(CameraControls, AreSetAndReadBack) {
  FakeCamera fake = webcam();
  SourceOptions options;
  options.controls = {{"exposure", 0.004}, {"focus", 7.0}, {"brightness", -6.0}};
  const auto camera = open_v4l2("/dev/fake", options, fake);
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ(fake.controls[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_MANUAL) << "the automatic is off";
  EXPECT_EQ(fake.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value, 40);
  EXPECT_EQ(fake.controls[V4L2_CID_FOCUS_AUTO].value, 0);
  EXPECT_EQ(fake.controls[V4L2_CID_BRIGHTNESS].value, -6);
  EXPECT_EQ((*camera)->status().notices, std::vector<std::string>{"/dev/fake: focus is 6, not 7"});
}

TEST(CameraControls, AreReadBackInTheirUnits) {
  FakeCamera fake = webcam();
  const auto before = v4l2_settings("/dev/fake", {}, fake);
  ASSERT_TRUE(before) << before.error();
  ASSERT_EQ(before->all.size(), 3U);
  EXPECT_EQ(before->all[0].name, "exposure");
  EXPECT_DOUBLE_EQ(before->all[0].value, 0.03);
  EXPECT_DOUBLE_EQ(before->all[0].least, 0.0002);
  EXPECT_DOUBLE_EQ(before->all[0].most, 0.5);
  EXPECT_DOUBLE_EQ(before->all[0].step, 1e-4);
  EXPECT_TRUE(before->all[0].automatic);
  EXPECT_FALSE(before->all[1].automatic) << "a gain without an automatic";

  const auto after = v4l2_settings("/dev/fake", {{"exposure", 0.004}, {"focus", 7.0}}, fake);
  ASSERT_TRUE(after) << after.error();
  EXPECT_DOUBLE_EQ(after->all[0].value, 0.004);
  EXPECT_FALSE(after->all[0].automatic);
  EXPECT_EQ(after->all[2].value, 6.0) << "as the camera has it, not as it was asked";
  EXPECT_EQ(after->notices, std::vector<std::string>{"/dev/fake: focus is 6, not 7"});
  EXPECT_EQ(fake.opened, 0) << "closed again";

  const auto refused = v4l2_settings("/dev/fake", {{"exposure", 9.0}}, fake);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().find("allowed: 0.0002 to 0.5"), std::string::npos) << refused.error();
}

TEST(CameraControls, ExposureUnderItsOtherName) {
  // A PS3 Eye: V4L2_CID_EXPOSURE, whose unit the driver does not say.
  FakeCamera fake = webcam();
  fake.controls.erase(V4L2_CID_EXPOSURE_ABSOLUTE);
  fake.controls[V4L2_CID_EXPOSURE] = {.name = "Exposure", .most = 255, .value = 120};
  EXPECT_EQ(problem(fake, {{"exposure", 40.0}}), "");
  EXPECT_EQ(fake.controls[V4L2_CID_EXPOSURE].value, 40);
  EXPECT_EQ(fake.controls[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(problem(fake, {{"exposure", 0.004}}),
            "/dev/fake: exposure = 0.004; allowed: a whole number from 0 to 255, since the driver does not say how "
            "many seconds one is");
}

TEST(CameraControls, AreRefusedWithWhatIsAllowed) {
  FakeCamera fake = webcam();
  EXPECT_EQ(problem(fake, {{"zoom", 1.0}}),
            "/dev/fake: has no control zoom; it has: brightness, gain, exposure_auto, exposure_time_absolute, "
            "focus_absolute, focus_auto");
  EXPECT_EQ(problem(fake, {{"gain", 256.0}}), "/dev/fake: gain = 256; allowed: 0 to 255");
  EXPECT_EQ(problem(fake, {{"exposure", 1.0}}), "/dev/fake: exposure = 1; allowed: 0.0002 to 0.5");
  EXPECT_EQ(fake.opened, 0);
  FakeCamera plain;
  EXPECT_EQ(problem(plain, {{"exposure", 0.01}}), "/dev/fake: has no control exposure; it has: none");
}

TEST(CameraControls, SettingsAreNamesAndNumbers) {
  EXPECT_EQ(parse_setting("exposure=0.005").value(), (std::pair<std::string, double>("exposure", 0.005)));
  for (const char* text : {"", "exposure", "=1", "gain=", "gain=high", "gain=1x", "gain=nan"})
    EXPECT_FALSE(parse_setting(text)) << text;
}

}  // namespace
}  // namespace skein::vision
