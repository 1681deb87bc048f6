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

/// The camera, as an experiment will use it: with another size or focus its lens is another one.
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

/// How far the calibration of a camera has come.
struct CalibrationProgress {
  static constexpr int columns = 10, rows = 8;  ///< parts of the picture whose coverage is counted
  struct View {
    std::string name;
    int corners = 0, outliers = 0;
    double rms = none;      ///< of its corners from where the result puts them; none: not solved since it came [px]
    bool left_out = false;  ///< fits three times worse than the others
  };
  struct Result {
    double rms = 0.0;                               ///< [px]
    double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< [px]
    double focal_sigma = 0.0, centre_sigma = 0.0;   ///< [px]
  };
  int width = 0, height = 0;  ///< [px]; 0 before the first picture
  std::int64_t frames = 0;
  std::vector<std::array<double, 2>> corners;  ///< that the newest picture shows; empty: no board in it [px]
  std::array<int, columns * rows> coverage{};  ///< corners seen in each part, row by row
  double covered = 0.0;                        ///< share of the parts that had any
  std::vector<View> views;
  std::optional<Result> result;
  std::string unsolved;  ///< why there is none
  std::string problem;   ///< of the camera; it is looked at no more
  bool over = false;     ///< the pictures are at their end
};

/// Finds out what a camera's lens does (intrinsics), while somebody shows it a board: looks at its pictures on a thread
/// of its own, keeps the views that show something new, and solves again whenever there are more. All calls from one
/// thread.
class CameraCalibration {
 public:
  CameraCalibration(const CalibratedCamera& camera, const CalibrationBoard& board);
  ~CameraCalibration();

  void end();  ///< lets the camera go, which takes a frame or two; the views stay
  CalibrationProgress progress() const;
  /// The newest picture, if there is a newer one than the last that was handed over.
  bool picture(Picture& out);
  /// Takes a view out, from 0.
  void forget(std::size_t view);
  /// Writes the calibration file, as it is solved now; its floor has to be calibrated anew.
  tl::expected<void, std::string> save(const std::string& path) const;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace skein::app
