// A camera as the kernel presents it, made of memory: what the source asks of it, and what it makes of its answers.
#include "vision/v4l2/v4l2_source.h"

#include "tests/vision/support.h"
#include "tests/vision/v4l2/fake_camera.h"
#include "vision/v4l2/v4l2_device.h"

namespace skein::vision {
namespace {

TEST(V4l2, GivesTheNewestFrameWithTheDriversTime) {
  FakeCamera fake;
  fake.coming = {{{10, 1.25}}, {{20, 2.0}, {30, 2.1}, {40, 2.25}}};
  {
    auto camera = open_v4l2("/dev/fake", {}, fake);
    ASSERT_TRUE(camera) << camera.error();
    EXPECT_EQ((*camera)->describe(), "camera /dev/fake (640x480 GREY, 10 frames/s)");
    EXPECT_FALSE((*camera)->stills());
    EXPECT_TRUE(fake.streaming);
    EXPECT_EQ(fake.idle(), 4U);
    Frame frame;
    ASSERT_TRUE((*camera)->read(frame).value());
    EXPECT_EQ(frame.width, 640);
    EXPECT_EQ(frame.height, 480);
    EXPECT_EQ(frame.row(479)[639], 10);
    EXPECT_DOUBLE_EQ(frame.captured_at, 1.25);
    ASSERT_TRUE((*camera)->read(frame).value());
    EXPECT_EQ(frame.row(0)[0], 40) << "older ones are passed over";
    EXPECT_DOUBLE_EQ(frame.captured_at, 2.25);
    EXPECT_EQ(frame.index, 1);
    EXPECT_EQ(fake.idle(), 4U) << "every buffer is given back";
  }
  EXPECT_FALSE(fake.streaming);
  EXPECT_EQ(fake.opened, 0);
  EXPECT_EQ(fake.mapped, 0);
}

TEST(V4l2, TakesGreyOutOfColours) {
  FakeCamera fake;
  fake.formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV};
  fake.padding = 64;
  fake.coming = {{{77, 1.0}}};
  auto camera = open_v4l2("/dev/fake", {.width = 320, .height = 240}, fake);
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ(fake.pixelformat, V4L2_PIX_FMT_YUYV);
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(frame.width, 320);
  EXPECT_EQ(frame.grey, Frame::Grey(320 * 240, 77));
}

TEST(V4l2, TakesGreyOutOfFormatsThatAreSeldom) {
  // Every byte is 1, so that two of them are 257: of 10 bits the upper eight are 64, of 12 bits 16.
  for (const auto& [format, grey] :
       std::initializer_list<std::pair<std::uint32_t, std::uint8_t>>{{V4L2_PIX_FMT_NV12, 1},
                                                                     {V4L2_PIX_FMT_YUV420, 1},
                                                                     {V4L2_PIX_FMT_NV16, 1},
                                                                     {V4L2_PIX_FMT_YUV422P, 1},
                                                                     {V4L2_PIX_FMT_YVYU, 1},
                                                                     {V4L2_PIX_FMT_VYUY, 1},
                                                                     {V4L2_PIX_FMT_SGRBG10, 64},
                                                                     {V4L2_PIX_FMT_SBGGR12, 16}}) {
    FakeCamera fake;
    fake.formats = {format};
    fake.padding = 32;
    fake.coming = {{{1, 1.0}}};
    auto camera = open_v4l2("/dev/fake", {.width = 320, .height = 240}, fake);
    ASSERT_TRUE(camera) << camera.error();
    Frame frame;
    ASSERT_TRUE((*camera)->read(frame).value());
    EXPECT_EQ(frame.grey, Frame::Grey(320 * 240, grey)) << detail::four_letters(format);
  }
}

/// What was lost may have stood in the picture: then the rest of it has moved, however many bytes there are.
TEST(V4l2, LeavesOutAFrameThatLacksBytesAlsoWhereItsGreyWouldBeLongEnough) {
  for (const std::uint32_t format :
       {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_NV12, V4L2_PIX_FMT_YUV420, V4L2_PIX_FMT_NV16, V4L2_PIX_FMT_YUV422P}) {
    FakeCamera fake;
    fake.formats = {format};
    fake.padding = 32;
    fake.coming = {{{1, 1.0}}, {{2, 2.0, 0, 400}}, {{3, 3.0, 0, 32}}};
    auto camera = open_v4l2("/dev/fake", {.width = 320, .height = 240}, fake);
    ASSERT_TRUE(camera) << camera.error();
    Frame frame;
    for (const int grey : {1, 3}) {
      ASSERT_TRUE((*camera)->read(frame).value());
      EXPECT_EQ(frame.row(239)[319], grey) << detail::four_letters(format) << ": a last row may end without padding";
    }
    EXPECT_EQ((*camera)->status().damaged, 1) << detail::four_letters(format);
  }
}

TEST(V4l2, ChoosesTheFormatBySizeAndRate) {
  // A C920: raw frames of this size come at 10 frames/s, JPEGs at 30.
  FakeCamera fake;
  fake.formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG};
  fake.rates = {{V4L2_PIX_FMT_YUYV, {10, 5}}, {V4L2_PIX_FMT_MJPEG, {30, 15}}};
  {
    auto camera = open_v4l2("/dev/fake", {.width = 1280, .height = 960, .rate = 25.0}, fake);
    ASSERT_TRUE(camera) << camera.error();
    EXPECT_EQ(fake.pixelformat, V4L2_PIX_FMT_MJPEG);
    EXPECT_TRUE((*camera)->status().notices.empty());
  }
  {
    auto camera = open_v4l2("/dev/fake", {.width = 1280, .height = 960, .rate = 5.0}, fake);
    ASSERT_TRUE(camera) << camera.error();
    EXPECT_EQ(fake.pixelformat, V4L2_PIX_FMT_YUYV) << "cheaper, and fast enough";
  }
  {
    auto camera = open_v4l2("/dev/fake", {.width = 1280, .height = 960, .rate = 25.0, .format = "YUYV"}, fake);
    ASSERT_TRUE(camera) << camera.error();
    EXPECT_EQ(fake.pixelformat, V4L2_PIX_FMT_YUYV) << "as it was asked for";
    const auto notices = (*camera)->status().notices;
    ASSERT_EQ(notices.size(), 1U);
    EXPECT_EQ(notices[0], "/dev/fake: delivers 10 frames/s at 1280x960 YUYV, not 25");
  }
}

TEST(V4l2, TellsWhatTheCameraSetsByItselfUntilItIsSwitchedOff) {
  FakeCamera fake;
  fake.controls[V4L2_CID_EXPOSURE_AUTO] = {"Auto Exposure", V4L2_CTRL_TYPE_MENU, 0, 3, V4L2_EXPOSURE_APERTURE_PRIORITY};
  fake.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {"Exposure Time", V4L2_CTRL_TYPE_INTEGER, 1, 5000, 100};
  fake.controls[V4L2_CID_FOCUS_AUTO] = {"Focus, Automatic", V4L2_CTRL_TYPE_BOOLEAN, 0, 1, 1};
  fake.coming.assign(60, {{77, 1.0}});
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ((*camera)->status().automatics, (std::vector<std::string>{"exposure", "focus"}));
  ASSERT_EQ((*camera)->status().notices.size(), 1U);
  EXPECT_EQ((*camera)->status().notices[0],
            "/dev/fake: its exposure and focus are automatic, and the picture changes by itself");
  // The window sets controls beside the run that reads the camera.
  fake.controls[V4L2_CID_FOCUS_AUTO].value = 0;
  fake.controls[V4L2_CID_EXPOSURE_AUTO].value = V4L2_EXPOSURE_MANUAL;
  Frame frame;
  for (int i = 0; i < 50; ++i) ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_TRUE((*camera)->status().automatics.empty());
  EXPECT_NEAR(frame.captured_at, 1.0 + 0.5 * 0.01, 1e-9) << "half of the exposure that holds now";
  // Whoever asks for an automatic exposure knows that it is one.
  fake.controls[V4L2_CID_EXPOSURE_AUTO].value = V4L2_EXPOSURE_MANUAL;
  camera->reset();
  camera = open_v4l2("/dev/fake", {.controls = {{"exposure", 0.0}}}, fake);
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ(fake.controls[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_TRUE((*camera)->status().automatics.empty());
}

TEST(V4l2, SaysWhenRowsAreNotOfOneMoment) {
  for (const auto& [field, name] :
       std::initializer_list<std::pair<std::uint32_t, const char*>>{{V4L2_FIELD_NONE, nullptr},
                                                                    {V4L2_FIELD_ANY, nullptr},
                                                                    {V4L2_FIELD_INTERLACED, "INTERLACED"},
                                                                    {V4L2_FIELD_INTERLACED_TB, "INTERLACED"},
                                                                    {V4L2_FIELD_INTERLACED_BT, "INTERLACED"},
                                                                    {V4L2_FIELD_SEQ_TB, "SEQUENTIAL"},
                                                                    {V4L2_FIELD_SEQ_BT, "SEQUENTIAL"},
                                                                    {V4L2_FIELD_ALTERNATE, "ALTERNATE"},
                                                                    {V4L2_FIELD_TOP, "TOP"},
                                                                    {V4L2_FIELD_BOTTOM, "BOTTOM"}}) {
    FakeCamera fake;
    fake.field = field;
    const auto camera = open_v4l2("/dev/fake", {}, fake);
    ASSERT_TRUE(camera) << camera.error();
    const auto notices = (*camera)->status().notices;
    ASSERT_EQ(notices.size(), name ? 1U : 0U) << field;
    if (name) {
      EXPECT_NE(notices[0].find(name), std::string::npos) << notices[0];
    }
  }
}

TEST(V4l2, TakesTheFastestFormatWhereNoneGivesTheRate) {
  FakeCamera fake;
  fake.formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_UYVY};
  fake.rates = {{V4L2_PIX_FMT_YUYV, {5}}, {V4L2_PIX_FMT_UYVY, {15}}};
  auto camera = open_v4l2("/dev/fake", {.width = 1280, .height = 960, .rate = 25.0}, fake);
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ(fake.pixelformat, V4L2_PIX_FMT_UYVY);
  ASSERT_EQ((*camera)->status().notices.size(), 1U);
}

TEST(V4l2, StampsFramesItselfWhenTheDriversClockIsAnother) {
  FakeCamera fake;
  fake.timestamp = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  fake.coming = {{{1, 5e8}}};
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  timespec before{};
  clock_gettime(CLOCK_MONOTONIC, &before);
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_NEAR(frame.captured_at, static_cast<double>(before.tv_sec), 10.0);
  ASSERT_EQ((*camera)->status().notices.size(), 1U);
  EXPECT_NE((*camera)->status().notices[0].find("does not report capture times"), std::string::npos);
}

TEST(V4l2, SaysWhenStampsAreNotTheStartOfExposure) {
  for (const std::uint32_t source : {V4L2_BUF_FLAG_TSTAMP_SRC_SOE, V4L2_BUF_FLAG_TSTAMP_SRC_EOF}) {
    FakeCamera fake;
    fake.timestamp = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | source;
    fake.coming = {{{1, 5.0}}, {{1, 5.04}}};
    auto camera = open_v4l2("/dev/fake", {}, fake);
    ASSERT_TRUE(camera) << camera.error();
    Frame frame;
    for (const double at : {5.0, 5.04}) {
      ASSERT_TRUE((*camera)->read(frame).value());
      EXPECT_NEAR(frame.captured_at, at, 1e-6);
    }
    const auto notices = (*camera)->status().notices;
    ASSERT_EQ(notices.size(), source == V4L2_BUF_FLAG_TSTAMP_SRC_SOE ? 0U : 1U) << "once";
    if (!notices.empty()) {
      EXPECT_NE(notices[0].find("stamps the end of a frame"), std::string::npos) << notices[0];
    }
  }
}

/// The middle of the exposure, from what each driver stamps.
TEST(V4l2, TakesTheMiddleOfAKnownExposureForTheTimeOfCapture) {
  constexpr double exposure = 0.01, readout = 0.02, stamp = 5.0;
  constexpr std::uint32_t start = V4L2_BUF_FLAG_TSTAMP_SRC_SOE, end = V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  struct Case {
    std::uint32_t source;
    const char *driver, *hwtimestamps;
    int automatic;
    double captured_at;
  };
  for (const Case& c : {Case{start, "vivid", "", V4L2_EXPOSURE_MANUAL, stamp + 0.5 * exposure},
                        Case{start, "uvcvideo", "1", V4L2_EXPOSURE_MANUAL, stamp + 0.5 * exposure},
                        Case{start, "uvcvideo", "Y", V4L2_EXPOSURE_MANUAL, stamp + 0.5 * exposure},
                        Case{start, "uvcvideo", "0", V4L2_EXPOSURE_MANUAL, stamp - 0.5 * exposure},
                        Case{start, "uvcvideo", "0", V4L2_EXPOSURE_APERTURE_PRIORITY, stamp},
                        Case{end, "vivid", "", V4L2_EXPOSURE_MANUAL, stamp - readout - 0.5 * exposure},
                        Case{end, "vivid", "", V4L2_EXPOSURE_APERTURE_PRIORITY, stamp - readout}}) {
    FakeCamera fake;
    fake.driver = c.driver;
    fake.hwtimestamps = c.hwtimestamps;
    fake.timestamp = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | c.source;
    fake.controls[V4L2_CID_EXPOSURE_AUTO] = {"Auto Exposure", V4L2_CTRL_TYPE_MENU, 0, 3, c.automatic};
    fake.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {.name = "Exposure (Absolute)", .most = 10000, .value = 100};
    fake.coming = {{{1, stamp}}};
    SourceOptions options;
    options.readout = readout;
    auto camera = open_v4l2("/dev/fake", options, fake);
    ASSERT_TRUE(camera) << camera.error();
    Frame frame;
    ASSERT_TRUE((*camera)->read(frame).value());
    EXPECT_NEAR(frame.captured_at, c.captured_at, 1e-6) << c.driver << " " << c.hwtimestamps << " " << c.automatic;
  }
}

TEST(V4l2, DoesNotBelieveThatUvcvideoStampsTheExposure) {
  FakeCamera fake;
  fake.driver = "uvcvideo";
  fake.coming = {{{1, 5.0}}};
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ((*camera)->stamps(), TimeStamps::first_packet);
  ASSERT_EQ((*camera)->status().notices.size(), 1U);
  EXPECT_NE((*camera)->status().notices[0].find("stamps the first packet"), std::string::npos);
}

TEST(V4l2, PassesDamagedFramesOver) {
  FakeCamera fake;
  fake.coming = {{{1, 1.0, V4L2_BUF_FLAG_ERROR}}, {{2, 1.1, 0, 1000}}, {{3, 1.2}}};
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(frame.row(0)[0], 3);
  EXPECT_EQ(frame.index, 0);
  for (int i = 0; i < 100; ++i) fake.coming.push_back({{1, 2.0, V4L2_BUF_FLAG_ERROR}});
  const auto read = (*camera)->read(frame);
  ASSERT_FALSE(read);
  EXPECT_EQ(
      read.error(),
      "/dev/fake: sends only damaged frames; use another cable, a port of its own without a hub, a smaller size, a "
      "lower rate or another format (skein track --format)");
}

TEST(V4l2, ACameraThatStallsIsOpenedAgain) {
  FakeCamera fake;
  fake.coming = {{{1, 1.0}}, {{2, 1.1}}, {{3, 1.2}}};
  fake.controls[V4L2_CID_GAIN] = {.name = "Gain", .value = 10};
  SourceOptions options;
  options.controls = {{"gain", 40.0}};
  auto camera = open_v4l2("/dev/fake", options, fake);
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(fake.last_wait_ms, 5000) << "the first frame may take its time";
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(fake.last_wait_ms, 300) << "three frame times";
  EXPECT_EQ((*camera)->status().outages, 0);
  fake.stalls = 1;
  fake.controls[V4L2_CID_GAIN].value = 0;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(frame.row(0)[0], 3);
  EXPECT_EQ(frame.index, 2) << "it goes on counting";
  EXPECT_EQ(fake.opens, 2);
  EXPECT_EQ(fake.controls[V4L2_CID_GAIN].value, 40) << "set again";
  const SourceStatus status = (*camera)->status();
  EXPECT_TRUE(status.up);
  EXPECT_EQ(status.outages, 1);
  EXPECT_EQ(status.reason, "/dev/fake: no frame for 0.3 s (unplugged, or the bus is full?)");
}

TEST(V4l2, ACameraThatWasUnpluggedComesBack) {
  FakeCamera fake;
  fake.coming = {{{1, 1.0}}, {{2, 7.0}}};
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  fake.unplugged = true;
  fake.gone_for_ms = 6000;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(frame.row(0)[0], 2);
  EXPECT_EQ((*camera)->status().outages, 1);
  EXPECT_EQ((*camera)->status().reason, "/dev/fake: stopped delivering frames (unplugged?)");
}

TEST(V4l2, ACameraThatStaysAwayIsAnError) {
  for (const bool gone : {true, false}) {
    FakeCamera fake;
    fake.coming = {{{1, 1.0}}};
    auto camera = open_v4l2("/dev/fake", {}, fake);
    ASSERT_TRUE(camera) << camera.error();
    Frame frame;
    ASSERT_TRUE((*camera)->read(frame).value());
    fake.unplugged = gone;
    fake.gone_for_ms = gone ? 1000000 : 0;
    const auto read = (*camera)->read(frame);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error(), gone ? "/dev/fake: stopped delivering frames (unplugged?)"
                                 : "/dev/fake: no frame for 5 s (unplugged, or the bus is full?)");
    EXPECT_FALSE((*camera)->status().up);
    EXPECT_EQ((*camera)->status().outages, 1);
    const int tried_ms = gone ? 1000000 - fake.gone_for_ms : 10000;
    EXPECT_NEAR(tried_ms, 10000, 100);
  }
}

TEST(V4l2, WhoeverWaitsMayGiveUp) {
  FakeCamera fake;
  fake.coming = {{{1, 1.0}}};
  int asked = 0;
  SourceOptions options;
  options.keep_waiting = [&] { return ++asked < 4; };
  auto camera = open_v4l2("/dev/fake", options, fake);
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  fake.unplugged = true;
  fake.gone_for_ms = 1000000;
  const auto more = (*camera)->read(frame);
  ASSERT_TRUE(more) << more.error();
  EXPECT_FALSE(*more) << "the end of the stream, and no fault of the camera";
  EXPECT_EQ(asked, 4);
}

TEST(V4l2, ACameraThatGetsSlowerInTheDarkIsNotStuck) {
  FakeCamera fake;
  fake.coming = {{{1, 1.0}}, {{2, 1.1}}, {{3, 1.35}}, {{4, 1.6}}};
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  for (int i = 0; i < 4; ++i) ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(fake.last_wait_ms, 750) << "three times the last frame time";
}

TEST(V4l2, SignalsDoNotDisturb) {
  FakeCamera fake;
  fake.interruptions = 3;
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  fake.interruptions = 3;
  fake.coming = {{{9, 1.0}}};
  Frame frame;
  EXPECT_TRUE((*camera)->read(frame).value());
}

TEST(V4l2, RefusesWhatDoesNotFit) {
  const auto error_of = [](FakeCamera& fake, const SourceOptions& options = {}) {
    const auto camera = open_v4l2("/dev/fake", options, fake);
    EXPECT_EQ(fake.opened + (camera ? 1 : 0), camera ? 2 : 0) << "closed again";
    return camera ? std::string() : camera.error();
  };
  FakeCamera metadata;
  metadata.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  EXPECT_EQ(error_of(metadata), "/dev/fake: does not capture video (a camera often has a second device that does)");
  FakeCamera h264;
  h264.formats = {V4L2_PIX_FMT_H264};
  EXPECT_EQ(
      error_of(h264),
      "/dev/fake: offers H264; needed: GREY, NV12, NV21, YU12, YV12, NV16, NV61, 422P, YUYV, YVYU, UYVY, VYUY, Y10 , "
      "Y12 , Y16 , RGGB, GRBG, GBRG, BA81, RG10, BA10, GB10, BG10, RG12, BA12, GB12, BG12, MJPG, JPEG");
  FakeCamera small;
  small.fixed_size = true;
  EXPECT_EQ(error_of(small, {.width = 1280, .height = 960}), "/dev/fake: cannot give 1280x960 in GREY, only 640x480");
  FakeCamera busy;
  busy.busy = true;
  EXPECT_EQ(error_of(busy), "/dev/fake: is in use by another program (Device or resource busy)");
}

}  // namespace
}  // namespace skein::vision
