// Time stamps that make every pose too old to drive by.
#include "vision/diagnosis/stamp_watch.h"

#include <gmock/gmock.h>

namespace skein::vision {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

/// Frames that arrive every 40 ms, 10 ms after their capture.
struct StampedCamera {
  StampWatch watch{0.2};
  double t = 10.0;
  int changes = 0;

  void frames(int count, double set_back = 0.0) {
    for (int k = 0; k < count; ++k) {
      t += 0.04;
      changes += watch.update(t - 0.01 - set_back, t) ? 1 : 0;
    }
  }
};

TEST(StampWatch, SaysNothingOfFramesThatAreInTime) {
  StampedCamera camera;
  camera.frames(100);
  EXPECT_EQ(camera.changes, 0);
  EXPECT_THAT(camera.watch.fault(), IsEmpty());
}

TEST(StampWatch, KnowsStampsThatStandStill) {
  StampedCamera camera;
  camera.frames(10);
  const double stamp = camera.t - 0.01;
  for (int k = 0; k < 6; ++k) camera.watch.update(stamp, camera.t += 0.04);
  EXPECT_THAT(camera.watch.fault(), IsEmpty()) << "for a moment";
  camera.watch.update(stamp, camera.t += 0.04);
  EXPECT_THAT(camera.watch.fault(), HasSubstr("do not advance"));
  camera.frames(1);
  EXPECT_THAT(camera.watch.fault(), IsEmpty());
}

TEST(StampWatch, KnowsStampsThatWereSetBack) {
  StampedCamera camera;
  camera.frames(10);
  camera.frames(100, 1.0);
  EXPECT_THAT(camera.watch.fault(), HasSubstr("set back"));
  EXPECT_EQ(camera.changes, 1) << "once";
  camera.frames(10);
  EXPECT_EQ(camera.changes, 2);
  EXPECT_THAT(camera.watch.fault(), IsEmpty());
}

TEST(StampWatch, KnowsFramesThatComeTooLateFromTheFirstOn) {
  StampedCamera camera;
  camera.frames(20, 0.3);
  EXPECT_THAT(camera.watch.fault(), HasSubstr("0.31 s old when they arrive"));
  EXPECT_THAT(camera.watch.fault(), HasSubstr("estimation.bridge is 0.2 s"));
}

TEST(StampWatch, TellsOnceOfStampsThatAreAheadOfTheArrival) {
  StampWatch watch(0.2);
  std::string told;
  for (int k = 0; k < 200; ++k) told += watch.update_ahead(0.012, 0.04 * k);
  EXPECT_THAT(told, StartsWith("its time stamps are 12 ms later than the arrival of their frames"));
  EXPECT_EQ(told.find("its time stamps", 1), std::string::npos) << "once";
}

TEST(StampWatch, ASingleStampThatIsAheadIsNoMatterNorAreMicroseconds) {
  StampWatch watch(0.2);
  for (int k = 0; k < 200; ++k) EXPECT_THAT(watch.update_ahead(k % 25 == 0 ? 0.1 : 2e-4, 0.04 * k), IsEmpty());
}

TEST(StampWatch, SingleLateFramesAreNoMatter) {
  StampedCamera camera;
  for (int k = 0; k < 20; ++k) {
    camera.frames(3, 0.3);
    camera.frames(1);
  }
  EXPECT_EQ(camera.changes, 0);
}

/// A machine that stood still for a moment finds what the camera's buffers kept from before.
TEST(StampWatch, AnOldFrameAfterAPauseIsNoMatter) {
  StampedCamera camera;
  for (int k = 0; k < 20; ++k) {
    camera.frames(5);
    camera.t += 0.5;
    camera.frames(1, 0.35);
  }
  EXPECT_EQ(camera.changes, 0) << camera.watch.fault();
}

/// It is no pause if the next one is as old.
TEST(StampWatch, KnowsOldFramesOfASlowCamera) {
  StampedCamera camera;
  camera.frames(5);
  for (int k = 0; k < 2; ++k) {
    EXPECT_THAT(camera.watch.fault(), IsEmpty());
    camera.t += 0.5;
    camera.frames(1, 0.35);
  }
  EXPECT_THAT(camera.watch.fault(), HasSubstr("0.36 s old when they arrive"));
}

}  // namespace
}  // namespace skein::vision
