// The real protocol against Aravis's camera in software, through the source that a run uses.
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

#include "tests/seconds.h"
#include "tests/vision/aravis/fake_gige.h"
#include "tests/vision/support.h"
#include "vision/frames/receive_buffer.h"
#include "vision/modules/aravis.h"
#include "vision/modules/media_loader.h"
#include "vision/sources/open_source.h"

namespace skein::vision {
namespace {

constexpr const char* address = "aravis:127.0.0.1";

/// When the fake camera opened its shutter.
double exposed_at(const Frame& frame) {
  double time = 0.0;
  std::memcpy(&time, frame.grey.data(), sizeof time);
  return time;
}

/// How late captured_at is against the middle of the exposure: of some frames the median and the least [s].
struct Timing {
  double late = 0.0, least = 0.0;
};
Timing measure(FrameSource& camera, double exposure, int frames, int settling) {
  Frame frame;
  std::vector<double> late;
  for (int i = 0; i < settling + frames; ++i) {
    const auto read = camera.read(frame);
    EXPECT_TRUE(read && *read) << (read ? std::string("end") : read.error());
    if (!read || !*read) return {};
    if (i >= settling) late.push_back(frame.captured_at - exposed_at(frame) - 0.5 * exposure);
  }
  std::nth_element(late.begin(), late.begin() + frames / 2, late.end());
  return {late[static_cast<std::size_t>(frames / 2)], *std::min_element(late.begin(), late.end())};
}

TEST(Aravis, FindsCamerasAndSaysWhatTheyCanDo) {
  test::FakeGige fake({"--clock"});
  ASSERT_TRUE(fake.running());
  const auto module = aravis();
  ASSERT_TRUE(module) << module.error();
  const auto cameras = (*module)->discover();
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0].name, "Aravis-Fake-SKEIN1");
  EXPECT_EQ(cameras[0].model, "Aravis Fake");
  EXPECT_EQ(cameras[0].address, "127.0.0.1");
  EXPECT_EQ(cameras[0].protocol, "GigEVision");
  std::string error;
  const auto lines = (*module)->describe("Aravis-Fake-SKEIN1", error);
  const std::vector<std::string> expected{"Aravis Fake, serial number SKEIN1",
                                          "sensor: 2048x2048",
                                          "frames: 512x512 at (0, 0), Mono8",
                                          "formats: BayerBG8 BayerGB8 BayerGR8 BayerRG8 Mono8 RGB8 Mono16",
                                          "frames/s: 25 (0.1 to 1000)",
                                          "exposure: 0.01 s (1e-05 to 10)",
                                          "gain: 0 (0 to 10)",
                                          "triggers: Line0 Software",
                                          "clock: TimestampLatch"};
  EXPECT_EQ(lines, expected) << error;
}

TEST(Aravis, SeveralMayLookForCamerasAtOnce) {
  test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  const auto module = aravis();
  ASSERT_TRUE(module) << module.error();
  // Enough that one search begins while another one reads what it has found.
  constexpr int threads = 4;
  constexpr int searches = 3;
  std::atomic<int> found = 0;
  {
    std::vector<std::jthread> looking;
    for (int i = 0; i < threads; ++i)
      looking.emplace_back([&] {
        for (int k = 0; k < searches; ++k)
          for (const NetworkCamera& camera : (*module)->discover())
            found += camera.name == "Aravis-Fake-SKEIN1" ? 1 : 0;
      });
  }
  EXPECT_EQ(found, threads * searches);
}

TEST(Aravis, GivesFramesOfTheSizeThatWasAskedFor) {
  test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  auto camera = open_source("aravis:Aravis-Fake-SKEIN1",
                            {.width = 480, .height = 360, .rate = 50.0, .controls = {{"exposure", 0.002}}});
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ((*camera)->describe(), "camera aravis:Aravis-Fake-SKEIN1 (480x360 Mono8, 50 frames/s)");
  EXPECT_FALSE((*camera)->stills());
  Frame frame;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE((*camera)->read(frame).value());
    EXPECT_EQ(frame.index, i);
    EXPECT_EQ(frame.width, 480);
    EXPECT_EQ(frame.height, 360);
    for (const int u : {10, 100, 479}) EXPECT_EQ(frame.row(359)[u], test::fake_gige_grey(u));
  }
  EXPECT_EQ((*camera)->status().outages, 0);
}

TEST(Aravis, TellsTheSameGreyInEveryFormat) {
  test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  for (const char* format : {"Mono8", "Mono16", "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8", "RGB8"}) {
    auto camera = open_source(
        address, {.width = 320, .height = 240, .rate = 50.0, .format = format, .controls = {{"exposure", 0.001}}});
    ASSERT_TRUE(camera) << camera.error();
    Frame frame;
    ASSERT_TRUE((*camera)->read(frame).value()) << format;
    for (int u = 16; u < 304; ++u) ASSERT_NEAR(frame.row(120)[u], test::fake_gige_grey(u), 1) << format << " " << u;
  }
}

TEST(Aravis, AFrameThatTheKernelCannotHoldIsNamed) {
  test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  long limit = 0;
  std::ifstream(receive_buffer_setting) >> limit;
  ASSERT_GT(limit, 0);
  const struct {
    int width, height;
    const char* format;
    long bytes;
  } cases[] = {{320, 240, "Mono8", 76'800}, {2048, 2048, "RGB8", 12'582'912}};
  for (const auto& each : cases) {
    auto camera =
        open_source(address, {.width = each.width, .height = each.height, .rate = 10.0, .format = each.format});
    ASSERT_TRUE(camera) << camera.error();
    const auto notices = (*camera)->status().notices;
    const bool named = std::any_of(notices.begin(), notices.end(), [&](const std::string& notice) {
      return notice.find(std::to_string(each.bytes) + " bytes") != std::string::npos &&
             notice.find("net.core.rmem_max=33554432") != std::string::npos;
    });
    EXPECT_EQ(named, each.bytes > limit) << each.bytes << " of " << limit;
  }
}

TEST(Aravis, StampsAreTheMiddleOfTheExposureWhereTheClockCanBeRead) {
  // Its clock runs 50 ppm too fast, and a frame leaves it 1 to 3 ms after an exposure of 8 ms: what arrives is 9 to 11
  // ms later than the exposure began.
  test::FakeGige fake({"--clock"});
  ASSERT_TRUE(fake.running());
  constexpr double exposure = 0.008;
  auto camera = open_source(address, {.width = 320, .height = 240, .rate = 50.0, .controls = {{"exposure", exposure}}});
  ASSERT_TRUE(camera) << camera.error();
  const Timing timing = measure(**camera, exposure, 40, 5);
  EXPECT_NEAR(timing.late, 0.0, 0.005) << "half an exposure and 2 ms earlier than the arrival";
  EXPECT_EQ((*camera)->stamps(), TimeStamps::exposure_start);
  const auto status = (*camera)->status();  // a busy machine may lose packets, which is the only thing told then
  EXPECT_EQ(status.notices.size(), status.damaged > 0 ? 1U : 0U) << (status.notices.empty() ? "" : status.notices[0]);
}

TEST(Aravis, StampsOfTheEndOfAnExposureAreKnownByFramesThatFollowSoon) {
  test::FakeGige fake({"--clock", "--stamp-end"});
  ASSERT_TRUE(fake.running());
  constexpr double exposure = 0.012, rate = 50.0;
  auto camera = open_source(address, {.width = 320, .height = 240, .rate = rate, .controls = {{"exposure", exposure}}});
  ASSERT_TRUE(camera) << camera.error();
  constexpr int learnt = static_cast<int>(1.5 * rate);  // a second, and what a busy machine leaves out
  EXPECT_NEAR(measure(**camera, exposure, 40, learnt).late, 0.0, 0.005) << "not an exposure later";
}

TEST(Aravis, AClockThatCannotBeReadIsReported) {
  test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  constexpr double exposure = 0.008;
  auto camera = open_source(address, {.width = 320, .height = 240, .rate = 50.0, .controls = {{"exposure", exposure}}});
  ASSERT_TRUE(camera) << camera.error();
  ASSERT_EQ((*camera)->status().notices.size(), 1U);
  EXPECT_NE((*camera)->status().notices[0].find("its clock cannot be read"), std::string::npos);
  const Timing timing = measure(**camera, exposure, 40, 30);
  EXPECT_EQ((*camera)->stamps(), TimeStamps::frame_end);
  EXPECT_GT(timing.least, 0.0005) << "1 ms until the first packet is the least";
  EXPECT_LT(timing.least, 0.02) << "of the frame that a busy machine let wait the least";
}

TEST(Aravis, SoftwareTriggerGivesAFrameWhenItIsTime) {
  test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  constexpr double exposure = 0.004;
  auto camera = open_source(
      address,
      {.width = 320, .height = 240, .rate = 20.0, .trigger = "software", .controls = {{"exposure", exposure}}});
  ASSERT_TRUE(camera) << camera.error();
  const Timing timing = measure(**camera, exposure, 20, 3);
  EXPECT_EQ((*camera)->stamps(), TimeStamps::exposure_start);
  EXPECT_NEAR(timing.late, 0.0, 0.02);
}

TEST(Aravis, AFrameThatDoesNotComeIsAskedForAgain) {
  test::FakeGige fake({"--lose-frames", "2"});
  ASSERT_TRUE(fake.running());
  auto camera = open_source(
      address, {.width = 320, .height = 240, .rate = 20.0, .trigger = "software", .controls = {{"exposure", 0.004}}});
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  const auto read = (*camera)->read(frame);
  ASSERT_TRUE(read && *read) << (read ? std::string("end") : read.error());
  EXPECT_NE((*camera)->stamps(), TimeStamps::exposure_start) << "nobody knows by which trigger it came";
  EXPECT_EQ((*camera)->status().outages, 0);
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ((*camera)->stamps(), TimeStamps::exposure_start);
}

TEST(Aravis, HardwareTriggerGivesAFrameForEachPulse) {
  test::FakeGige fake({"--clock", "--line", "40"});
  ASSERT_TRUE(fake.running());
  constexpr double exposure = 0.004;
  auto camera = open_source(
      address, {.width = 320, .height = 240, .rate = 40.0, .trigger = "Line0", .controls = {{"exposure", exposure}}});
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ((*camera)->describe(), "camera aravis:127.0.0.1 (320x240 Mono8, 40 frames/s, trigger Line0)");
  const Timing timing = measure(**camera, exposure, 30, 3);
  EXPECT_NEAR(timing.late, 0.0, 0.05);
}

TEST(Aravis, RefusesWhatTheCameraCannotDo) {
  test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  const struct {
    SourceOptions options;
    std::string message;
  } cases[] = {
      {{.format = "MJPG"},
       "aravis:127.0.0.1: offers BayerBG8, BayerGB8, BayerGR8, BayerRG8, Mono8, RGB8, Mono16; needed: MJPG"},
      {{.width = 4096, .height = 3000}, "aravis:127.0.0.1: cannot give 4096x3000; its sensor has 2048x2048"},
      {{.trigger = "Line7"}, "aravis:127.0.0.1: trigger \"Line7\"; allowed: software, Line0, Software"},
      {{.controls = {{"exposure", 60.0}}}, "aravis:127.0.0.1: exposure = 60; allowed: 1e-05 to 10"},
      {{.controls = {{"gain", 99.0}}}, "aravis:127.0.0.1: gain = 99; allowed: 0 to 10"},
      {{.controls = {{"focus", 3.0}}}, "aravis:127.0.0.1: has no control focus"},
  };
  for (const auto& [options, message] : cases) {
    const auto camera = open_source(address, options);
    ASSERT_FALSE(camera) << message;
    EXPECT_EQ(camera.error().substr(0, message.size()), message);
  }
}

TEST(Aravis, ACameraThatIsNotThereIsNamed) {
  const test::PortLock nobody_is_there;
  const auto camera = open_source(address);
  ASSERT_FALSE(camera);
  EXPECT_TRUE(camera.error().starts_with("aravis:127.0.0.1: cannot be opened (")) << camera.error();
}

TEST(Aravis, FramesWithMissingPacketsArePassedOverAndSaid) {
  test::FakeGige fake({"--lost", "20"});
  ASSERT_TRUE(fake.running());
  auto camera = open_source(address, {.width = 128, .height = 96, .rate = 50.0, .controls = {{"exposure", 0.001}}});
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE((*camera)->read(frame).value());
    for (const int u : {10, 60, 127}) ASSERT_EQ(frame.row(95)[u], test::fake_gige_grey(u)) << "a whole frame";
  }
  const SourceStatus status = (*camera)->status();
  EXPECT_GT(status.damaged, 0);
  ASSERT_FALSE(status.notices.empty());
  EXPECT_NE(status.notices.back().find("a frame was not whole"), std::string::npos) << status.notices.back();
}

TEST(Aravis, ALostCameraIsAnErrorAfterItsTime) {
  test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  auto camera = open_source(address, {.width = 320, .height = 240, .rate = 25.0, .reopen_for = 2.0});
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  for (int i = 0; i < 5; ++i) ASSERT_TRUE((*camera)->read(frame).value());
  fake.kill();
  const test::PortLock nobody_comes_back;
  const double killed = test::seconds();
  auto read = (*camera)->read(frame);
  while (read && *read) read = (*camera)->read(frame);  // what was on its way
  ASSERT_FALSE(read);
  // A quarter of a second, or three frames of a camera that is slower, as this one is on a starved machine.
  EXPECT_THAT(read.error(),
              testing::ContainsRegex(R"(no frame for 0\.[0-9]+ s \(unplugged, or the network is full\?\))"));
  const SourceStatus status = (*camera)->status();
  EXPECT_FALSE(status.up);
  EXPECT_EQ(status.outages, 1);
  EXPECT_EQ(status.reason, read.error());
  EXPECT_LT(test::seconds() - killed, 7.0);
}

TEST(Aravis, ACameraThatComesBackIsOpenedAgainWithItsSettings) {
  auto fake = std::make_unique<test::FakeGige>();
  ASSERT_TRUE(fake->running());
  auto camera = open_source(
      address, {.width = 320, .height = 240, .rate = 50.0, .controls = {{"exposure", 0.002}}, .reopen_for = 30.0});
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  for (int i = 0; i < 5; ++i) ASSERT_TRUE((*camera)->read(frame).value());
  fake->kill();
  std::jthread again([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    fake = std::make_unique<test::FakeGige>();
  });
  const std::int64_t before = frame.index;
  const double last = frame.captured_at;
  bool back = false;
  for (int i = 0; i < 10 && !back; ++i) {
    ASSERT_TRUE((*camera)->read(frame).value());
    back = frame.captured_at > last + 0.4;
  }
  ASSERT_TRUE(back);
  EXPECT_GT(frame.index, before);
  EXPECT_EQ(frame.width, 320);
  EXPECT_EQ((*camera)->status().outages, 1);
  EXPECT_TRUE((*camera)->status().up);
  measure(**camera, 0.002, 10, 1);
}

TEST(Aravis, NobodyWaitsForACameraThatWasLost) {
  test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  std::atomic<bool> waits{true};
  auto camera = open_source(address, {.width = 320, .height = 240, .keep_waiting = [&] { return waits.load(); }});
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  fake.kill();
  waits = false;
  const double asked = test::seconds();
  auto read = (*camera)->read(frame);
  while (read && *read) read = (*camera)->read(frame);
  ASSERT_TRUE(read) << read.error();
  EXPECT_LT(test::seconds() - asked, 0.5);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  camera->reset();
  EXPECT_LT(test::seconds() - asked, 2.0) << "nobody waits for its goodbye either";
}

}  // namespace
}  // namespace skein::vision
