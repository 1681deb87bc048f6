#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "app/cli/command_calibrate.h"

namespace skein::app {

/// The options for a camera's settings. `calibrated`: the frames' size is the calibration's, without an option.
void add_camera_words(CLI::App& command, CameraWords& words, bool calibrated);

/// The options of `skein calibrate` and `skein tags`.
class VisionCommands {
 public:
  void add_to(CLI::App& program);
  /// Executes the given command and returns its ExitStatus; none: another command was given.
  std::optional<int> run();

 private:
  /// A board as on the command line: lengths in millimetres.
  struct BoardWords {
    std::string kind = "charuco";
    std::string squares = "12x8";
    double square_mm = 20.0, marker_mm = 15.0;
    int bits = 5;
    void add_to(CLI::App& command);
    bool read(vision::Board& board) const;
  };
  CLI::App *intrinsics_ = nullptr, *floor_ = nullptr, *check_ = nullptr, *joint_ = nullptr, *tags_ = nullptr,
           *board_ = nullptr;
  IntrinsicsRequest intrinsics_request_;
  FloorRequest floor_request_, check_request_;
  JointRequest joint_request_;
  TagsRequest tags_request_;
  BoardWords calibration_board_, printed_board_;
  double tag_height_mm_ = -1.0, tag_size_mm_ = -1.0, limit_mm_ = 0.0;
};

}  // namespace skein::app
