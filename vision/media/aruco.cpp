#include "vision/media/aruco.h"

#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>

namespace skein::vision {
namespace {

void detect(const Frame& frame, std::vector<Detection>& found) {
  static const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
  static const auto parameters = [] {
    cv::setNumThreads(1);
    auto p = cv::aruco::DetectorParameters::create();
    p->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
    p->cornerRefinementWinSize = 3;
    return p;
  }();
  const cv::Mat picture(frame.height, frame.width, CV_8UC1, const_cast<std::uint8_t*>(frame.grey.data()));
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(picture, dictionary, corners, ids, parameters);
  found.clear();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Detection& detection = found.emplace_back();
    detection.tag = ids[i];
    // Clockwise from the corner that AprilTag counts as its second one.
    for (std::size_t k = 0; k < 4; ++k) {
      const cv::Point2f& p = corners[i][(5 - k) % 4];
      detection.corners[k] = {static_cast<double>(p.x), static_cast<double>(p.y)};
    }
  }
}

}  // namespace
}  // namespace skein::vision

extern "C" __attribute__((visibility("default"))) const skein::vision::Aruco skein_aruco_1 = {
    .detect = skein::vision::detect};
