#include "vision/bench/bench_methods.h"

#include "vision/calibration/calibration.h"
#include "vision/detector/detector.h"
#include "vision/modules/media_loader.h"
#include "vision/tags/detection.h"
#include "vision/tags/tag_plane.h"
#include "vision/tracker/tracker.h"

namespace skein::vision::detail {
namespace {

/// Methods that give corners: their poses are put on the plane in the same way for all.
class FromCorners : public BenchMethod {
 public:
  explicit FromCorners(const Calibration& calibration) : calibration_(calibration) {}
  const std::vector<TagPose>& detect(const Frame& frame) final {
    poses_.clear();
    for (const Detection& detection : corners(frame)) {
      const auto place = place_on_plane(calibration_, detection.corners);
      if (place) poses_.push_back({.tag = detection.tag, .pose = place->pose, .corners = detection.corners});
    }
    return poses_;
  }

 protected:
  virtual const std::vector<Detection>& corners(const Frame& frame) = 0;

 private:
  Calibration calibration_;
  std::vector<TagPose> poses_;
};

class AprilTag final : public FromCorners {
 public:
  AprilTag(const Calibration& calibration, const char* title, int min_white_black_diff)
      : FromCorners(calibration),
        detector_({.decimate = 2.0, .min_white_black_diff = min_white_black_diff, .least_likeness = -1.0}) {
    name = title;
  }

 private:
  const std::vector<Detection>& corners(const Frame& frame) override { return detector_.detect(frame); }
  TagDetector detector_;
};

class ArucoMarkers final : public FromCorners {
 public:
  ArucoMarkers(const Calibration& calibration, const Boards& boards) : FromCorners(calibration), boards_(boards) {
    name = "OpenCV ArUco";
  }

 private:
  const std::vector<Detection>& corners(const Frame& frame) override {
    boards_.detect(frame, found_);
    return found_;
  }
  const Boards& boards_;
  std::vector<Detection> found_;
};

class Skein final : public BenchMethod {
 public:
  explicit Skein(const BenchScene& scene) : calibration_(scene.calibration) {
    name = "Skein";
    for (int i = 0; i < scene.tags; ++i) options_.tags.push_back(i);
    restart();
  }
  void restart() override { tracker_ = std::make_unique<TagTracker>(calibration_, options_); }
  const std::vector<TagPose>& detect(const Frame& frame) override { return tracker_->process(frame); }

 private:
  Calibration calibration_;
  TrackerOptions options_;
  std::unique_ptr<TagTracker> tracker_;
};

}  // namespace

std::vector<std::unique_ptr<BenchMethod>> bench_methods(const BenchScene& scene) {
  std::vector<std::unique_ptr<BenchMethod>> methods;
  // Its defaults: edges at half the resolution, 5 grey levels between ink and paper.
  methods.push_back(std::make_unique<AprilTag>(scene.calibration, "AprilTag", 5));
  methods.push_back(std::make_unique<AprilTag>(scene.calibration, "AprilTag tuned", 40));
  if (const auto module = boards()) methods.push_back(std::make_unique<ArucoMarkers>(scene.calibration, **module));
  methods.push_back(std::make_unique<Skein>(scene));
  return methods;
}

}  // namespace skein::vision::detail
