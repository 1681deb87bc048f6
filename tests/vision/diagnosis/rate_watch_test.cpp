// A camera that delivers fewer frames than it was asked for.
#include "vision/diagnosis/rate_watch.h"

#include <gmock/gmock.h>

#include <vector>

namespace skein::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A camera of so many frames/s that was asked for 25.
struct Camera {
  RateWatch watch{25.0};
  double t = 0.0;
  std::vector<std::string> told{};

  void deliver(double seconds, double rate) {
    for (const double end = t + seconds; t < end; t += 1.0 / rate)
      if (std::string sentence = watch.update(t); !sentence.empty()) told.push_back(std::move(sentence));
  }
};

TEST(RateWatch, TellsOnceOfACameraThatSlowsDownInTheDark) {
  Camera camera;
  camera.deliver(5.0, 25.0);
  camera.deliver(10.0, 12.5);
  EXPECT_THAT(camera.told, ElementsAre(HasSubstr("12.5 frames/s come, not 25")));
  camera.deliver(5.0, 25.0);
  camera.deliver(10.0, 15.0);
  EXPECT_THAT(camera.told, ElementsAre(HasSubstr("12.5"), HasSubstr("15 frames/s")));
}

TEST(RateWatch, SaysNothingOfACameraThatIsFastEnoughNorOfAnOutage) {
  Camera camera;
  camera.deliver(10.0, 30.0);
  camera.deliver(10.0, 24.9);
  camera.t += 5.0;
  camera.deliver(10.0, 25.0);
  camera.deliver(0.5, 10.0);
  camera.deliver(10.0, 25.0);
  EXPECT_THAT(camera.told, IsEmpty());
}

}  // namespace
}  // namespace skein::vision
