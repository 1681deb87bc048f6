#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "app/run/status.h"

namespace skein::app {

/// The camera with the settings of the experiments: a calibration holds for one size and focus.
struct CalibratedCamera {
  std::string source;                   ///< v4l2:DEVICE, aravis:CAMERA, images:DIR, video:FILE
  std::string size{};                   ///< "1280x960"; empty: as the camera is set
  std::vector<std::string> settings{};  ///< of a camera: "focus=30"
};

/// The board that is shown to the camera, as it was printed by `skein tags board`.
struct CalibrationBoard {
  bool chessboard = false;     ///< else ChArUco, whose markers have 5 x 5 bits
  int columns = 12, rows = 8;  ///< of squares
  double square = 0.020;       ///< edge [m]
  double marker = 0.015;       ///< ChArUco: edge of a marker [m]
};

/// The progress of a camera's calibration.
struct CalibrationProgress {
  static constexpr int columns = 10, rows = 8;  ///< parts of the picture whose coverage is counted
  struct View {
    std::string name;
    int corners = 0, outliers = 0;
    double rms = none;      ///< reprojection error of its corners; none: not solved since it was added [px]
    bool left_out = false;  ///< fits three times worse than the others
  };
  struct Result {
    double rms = 0.0;                               ///< [px]
    double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< [px]
    double focal_sigma = 0.0, centre_sigma = 0.0;   ///< [px]
  };
  int width = 0, height = 0;  ///< [px]; 0 before the first picture
  std::int64_t frames = 0;
  std::vector<std::array<double, 2>> corners;  ///< in the newest image; empty: no board in it [px]
  std::array<int, columns * rows> coverage{};  ///< corners seen in each part, row by row
  int seen(int row, int column) const {
    return coverage[static_cast<std::size_t>(row) * columns + static_cast<std::size_t>(column)];
  }
  double covered = 0.0;  ///< share of the parts with any corners
  std::vector<View> views;
  std::optional<Result> result;
  std::string unsolved;  ///< why there is none
  std::string problem;   ///< of the camera, which is then closed
  bool over = false;     ///< there are no more images
};

/// Calibrates a camera's lens (intrinsics) while a board is shown to it: processes its images on a separate
/// thread, keeps the views that add information, and solves again after each new one. All calls from one
/// thread.
class CameraCalibration {
 public:
  CameraCalibration(const CalibratedCamera& camera, const CalibrationBoard& board);
  ~CameraCalibration();

  void end();  ///< closes the camera, which takes a frame or two; the views are kept
  CalibrationProgress progress() const;
  /// The newest image, if it is newer than the last one returned.
  bool picture(Picture& out);
  /// Removes a view, from 0.
  void forget(std::size_t view);
  /// Writes the calibration file with the present result; its floor has to be calibrated again.
  tl::expected<void, std::string> save(const std::string& path) const;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace skein::app
