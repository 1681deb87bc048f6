#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

// OpenCV's ArUco markers and ChArUco boards. Their interface, and the module that they are in, changed with OpenCV 4.7.
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
#include <opencv2/objdetect/aruco_detector.hpp>
#include <opencv2/objdetect/charuco_detector.hpp>
#define SKEIN_OPENCV_MARKERS_IN_OBJDETECT 1
#else
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#define SKEIN_OPENCV_MARKERS_IN_OBJDETECT 0
#endif

namespace skein::vision {

// `dictionary`: one of OpenCV's, such as cv::aruco::DICT_4X4_50.

/// The markers in a picture: their corners [px], clockwise, and their numbers.
inline void find_markers(const cv::Mat& picture, int dictionary, const cv::aruco::DetectorParameters& parameters,
                         std::vector<std::vector<cv::Point2f>>& corners, std::vector<int>& ids) {
#if SKEIN_OPENCV_MARKERS_IN_OBJDETECT
  cv::aruco::ArucoDetector(cv::aruco::getPredefinedDictionary(dictionary), parameters)
      .detectMarkers(picture, corners, ids);
#else
  cv::aruco::detectMarkers(picture, cv::aruco::getPredefinedDictionary(dictionary), corners, ids,
                           cv::makePtr<cv::aruco::DetectorParameters>(parameters));
#endif
}

/// A marker's picture, a pixel for each of its cells, with one cell of border.
inline cv::Mat marker_picture(int dictionary, int id, int cells) {
  cv::Mat picture;
#if SKEIN_OPENCV_MARKERS_IN_OBJDETECT
  cv::aruco::getPredefinedDictionary(dictionary).generateImageMarker(id, cells, picture, 1);
#else
  cv::aruco::getPredefinedDictionary(dictionary)->drawMarker(id, cells, picture, 1);
#endif
  return picture;
}

/// The inner corners of a ChArUco board that a picture shows [px], their numbers, and where all of them are on the
/// board, in the unit of `square`.
struct CharucoCorners {
  std::vector<cv::Point2f> points;
  std::vector<int> numbers;
  std::vector<cv::Point3f> on_board;
};

/// Refines each corner once more, in a window that no marker reaches into. OpenCV refines them too, but versions from
/// 4.5.4 until 2026 then return them half a pixel too far to the right and too low (opencv/opencv issue 25539).
inline void refine(const cv::Mat& picture, const std::vector<std::vector<cv::Point2f>>& markers,
                   std::vector<cv::Point2f>& corners) {
  const cv::TermCriteria enough{cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 40, 1e-3};
  for (cv::Point2f& corner : corners) {
    double nearest = 1e9;
    for (const auto& marker : markers)
      for (const cv::Point2f& other : marker) nearest = std::min(nearest, cv::norm(other - corner));
    const int half = std::clamp(static_cast<int>(nearest) - 2, 1, 10);
    std::vector<cv::Point2f> one{corner - cv::Point2f(0.5F, 0.5F)};
    if (!cv::Rect2f(cv::Point2f(), picture.size()).contains(one.front())) continue;  // cornerSubPix throws
    cv::cornerSubPix(picture, one, {half, half}, {-1, -1}, enough);
    corner = one.front();
  }
}

inline CharucoCorners find_charuco_corners(const cv::Mat& picture, int dictionary, int columns, int rows, float square,
                                           float marker) {
  CharucoCorners found;
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
#if SKEIN_OPENCV_MARKERS_IN_OBJDETECT
  const cv::aruco::CharucoBoard board({columns, rows}, square, marker, cv::aruco::getPredefinedDictionary(dictionary));
  found.on_board = board.getChessboardCorners();
  cv::aruco::CharucoDetector(board).detectBoard(picture, found.points, found.numbers, markers, ids);
#else
  const auto board =
      cv::aruco::CharucoBoard::create(columns, rows, square, marker, cv::aruco::getPredefinedDictionary(dictionary));
  found.on_board = board->chessboardCorners;
  find_markers(picture, dictionary, cv::aruco::DetectorParameters(), markers, ids);
  if (!ids.empty()) cv::aruco::interpolateCornersCharuco(markers, ids, picture, board, found.points, found.numbers);
#endif
  refine(picture, markers, found.points);
  return found;
}

}  // namespace skein::vision
