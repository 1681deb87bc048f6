#include "vision/modules/boards.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/boards/markers.h"
#include "vision/boards/sheets.h"

namespace skein::vision {
namespace {

cv::Mat as_mat(const Frame& frame) {
  return {frame.height, frame.width, CV_8UC1, const_cast<std::uint8_t*>(frame.grey.data())};
}

int dictionary_of(int bits) {
  constexpr int per_size = cv::aruco::DICT_5X5_1000 - cv::aruco::DICT_4X4_1000;
  return cv::aruco::DICT_4X4_1000 + per_size * (bits - 4);
}

void detect_markers(const Frame& frame, int dictionary, const cv::aruco::DetectorParameters& parameters,
                    std::vector<Detection>& found) {
  cv::setNumThreads(1);
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  find_markers(as_mat(frame), dictionary, parameters, corners, ids);
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

void detect(const Frame& frame, std::vector<Detection>& found) {
  static const auto parameters = [] {
    cv::aruco::DetectorParameters p;
    p.cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
    p.cornerRefinementWinSize = 3;
    return p;
  }();
  detect_markers(frame, cv::aruco::DICT_APRILTAG_36h11, parameters, found);
}

void detect_aruco(const Frame& frame, int bits, std::vector<Detection>& found) {
  cv::aruco::DetectorParameters parameters;
  parameters.errorCorrectionRate = 0.0;
  parameters.maxErroneousBitsInBorderRate = 0.0;
  parameters.minMarkerDistanceRate = 0.01;  // else the edge of narrow paper is taken in place of the marker's
  try {
    detect_markers(frame, dictionary_of(bits), parameters, found);
  } catch (const cv::Exception&) {
    found.clear();  // a picture that is too small or odd in some other way shows no marker
  }
}

/// A ChArUco board, in whatever dictionary.
bool shows_markers(const Frame& frame) {
  constexpr std::size_t no_chance = 4;
  std::vector<Detection> markers;
  for (int bits = 4; bits <= 7; ++bits) {
    detect_aruco(frame, bits, markers);
    if (markers.size() >= no_chance) return true;
  }
  return false;
}

void find_chessboard(const cv::Mat& picture, const Board& board, std::vector<BoardCorner>& corners) {
  const cv::Size inner(board.columns - 1, board.rows - 1);
  std::vector<cv::Point2f> points;
  const int flags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  if (!cv::findChessboardCorners(picture, inner, points, flags)) return;
  // The window of the refinement must hold one corner alone: a third of the way to the next one.
  double nearest = 1e9;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (i % static_cast<std::size_t>(inner.width) != 0)
      nearest = std::min(nearest, cv::norm(points[i] - points[i - 1]));
  const int half = std::clamp(static_cast<int>(nearest / 3.0), 2, 11);
  cv::cornerSubPix(picture, points, {half, half}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 40, 1e-3});
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int row = static_cast<int>(i) / inner.width;
    const int column = static_cast<int>(i) % inner.width;
    corners.push_back({static_cast<int>(i), (column + 1) * board.square, (row + 1) * board.square,
                       static_cast<double>(points[i].x), static_cast<double>(points[i].y)});
  }
}

void find_charuco(const cv::Mat& picture, const Board& board, std::vector<BoardCorner>& corners) {
  const CharucoCorners found = find_charuco_corners(picture, dictionary_of(board.bits), board.columns, board.rows,
                                                    static_cast<float>(board.square), static_cast<float>(board.marker));
  for (std::size_t i = 0; i < found.numbers.size(); ++i) {
    const cv::Point3f& on_board = found.on_board[static_cast<std::size_t>(found.numbers[i])];
    corners.push_back({found.numbers[i], static_cast<double>(on_board.x), static_cast<double>(on_board.y),
                       static_cast<double>(found.points[i].x), static_cast<double>(found.points[i].y)});
  }
}

void find(const Frame& frame, const Board& board, std::vector<BoardCorner>& corners) {
  corners.clear();
  try {
    const cv::Mat picture = as_mat(frame);
    switch (board.kind) {
      case Board::Kind::charuco:
        find_charuco(picture, board, corners);
        break;
      case Board::Kind::chessboard:
        // Among markers OpenCV either takes their squares for the board's, or goes on searching for minutes.
        if (!shows_markers(frame)) find_chessboard(picture, board, corners);
        break;
    }
  } catch (const cv::Exception&) {
    corners.clear();  // a picture that is too small or odd in some other way shows no board
  }
}

std::string calibrate(const std::vector<BoardView*>& views, int width, int height, Intrinsics& result,
                      std::vector<std::vector<double>>& residuals) {
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::vector<cv::Point2f>> seen;
  for (const BoardView* view : views) {
    auto& points = on_board.emplace_back();
    auto& pixels = seen.emplace_back();
    for (const BoardCorner& corner : view->corners) {
      points.emplace_back(static_cast<float>(corner.x), static_cast<float>(corner.y), 0.0F);
      pixels.emplace_back(static_cast<float>(corner.u), static_cast<float>(corner.v));
    }
  }
  try {
    cv::Mat camera, distortion, sigmas, of_views, rms_of_views;
    std::vector<cv::Mat> rotations, translations;
    cv::calibrateCamera(on_board, seen, {width, height}, camera, distortion, rotations, translations, sigmas, of_views,
                        rms_of_views);
    Calibration& c = result.calibration;
    c.width = width;
    c.height = height;
    c.fx = camera.at<double>(0, 0);
    c.fy = camera.at<double>(1, 1);
    c.cx = camera.at<double>(0, 2);
    c.cy = camera.at<double>(1, 2);
    for (int i = 0; i < 5; ++i) c.distortion[static_cast<std::size_t>(i)] = distortion.at<double>(i);
    result.focal_sigma = std::max(sigmas.at<double>(0), sigmas.at<double>(1));
    result.centre_sigma = std::max(sigmas.at<double>(2), sigmas.at<double>(3));
    residuals.clear();
    result.tilt = result.spread = 0.0;
    std::vector<cv::Vec3d> normals;
    double differences = 0.0;
    std::size_t neighbours = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      cv::Matx33d rotation;
      cv::Rodrigues(rotations[i], rotation);
      result.tilt = std::max(result.tilt, std::acos(std::min(1.0, std::abs(rotation(2, 2)))));
      normals.emplace_back(rotation(0, 2), rotation(1, 2), rotation(2, 2));
      for (const cv::Vec3d& other : normals)
        result.spread = std::max(result.spread, std::acos(std::min(1.0, std::abs(normals.back().dot(other)))));
      std::vector<cv::Point2f> expected;
      cv::projectPoints(on_board[i], rotations[i], translations[i], camera, distortion, expected);
      auto& distances = residuals.emplace_back();
      for (std::size_t k = 0; k < expected.size(); ++k) distances.push_back(cv::norm(expected[k] - seen[i][k]));
      for (std::size_t k = 1; k < expected.size(); ++k) {
        if (views[i]->corners[k].id != views[i]->corners[k - 1].id + 1) continue;
        const cv::Point2f apart = (expected[k] - seen[i][k]) - (expected[k - 1] - seen[i][k - 1]);
        differences += 0.5 * static_cast<double>(apart.dot(apart));
        ++neighbours;
      }
    }
    result.scatter = neighbours > 0 ? std::sqrt(differences / static_cast<double>(neighbours)) : 0.0;
  } catch (const cv::Exception& problem) {
    return "the views do not determine the camera: " + problem.err;
  }
  return {};
}

std::string locate(const std::vector<Landmark>& landmarks, Calibration& calibration) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const Landmark& landmark : landmarks) {
    points.emplace_back(landmark.x, landmark.y, landmark.z);
    pixels.emplace_back(landmark.u, landmark.v);
  }
  const Calibration& c = calibration;
  const cv::Matx33d camera(c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0);
  const std::vector<double> distortion(c.distortion.begin(), c.distortion.end());
  try {
    cv::Mat rotation_vector, translation, rotation;
    if (!cv::solvePnP(points, pixels, camera, distortion, rotation_vector, translation, false, cv::SOLVEPNP_SQPNP))
      return "the points do not determine where the camera is";
    cv::solvePnPRefineLM(points, pixels, camera, distortion, rotation_vector, translation);
    cv::Rodrigues(rotation_vector, rotation);
    CameraPose pose;  // p_camera = rotation * p_world + translation, turned round
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) pose.rotation(i, j) = rotation.at<double>(j, i);
    const Eigen::Vector3d shift(translation.at<double>(0), translation.at<double>(1), translation.at<double>(2));
    pose.position = -(pose.rotation * shift);
    if (!pose.position.allFinite() || !pose.rotation.allFinite())
      return "the points do not determine where the camera is";
    calibration.world_from_camera = pose;
  } catch (const cv::Exception& problem) {
    return "the points do not determine where the camera is: " + problem.err;
  }
  return {};
}

std::vector<bool> marker(int bits, int id) {
  const int cells = bits + 2;
  const cv::Mat picture = marker_picture(dictionary_of(bits), id, cells);
  std::vector<bool> ink;
  for (int v = 0; v < cells; ++v)
    for (int u = 0; u < cells; ++u) ink.push_back(picture.at<std::uint8_t>(v, u) == 0);
  return ink;
}

}  // namespace
}  // namespace skein::vision

extern "C" __attribute__((visibility("default")))
const skein::vision::Boards skein_boards_6 = {.detect = skein::vision::detect,
                                              .detect_aruco = skein::vision::detect_aruco,
                                              .find = skein::vision::find,
                                              .calibrate = skein::vision::calibrate,
                                              .locate = skein::vision::locate,
                                              .marker = skein::vision::marker,
                                              .draw = skein::vision::draw_sheet,
                                              .rasterise = skein::vision::rasterise_sheet};
