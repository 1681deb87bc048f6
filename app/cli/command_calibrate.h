#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/tools/camera_words.h"
#include "vision/calibration/board.h"

namespace skein::app {

/// The bodies of `skein calibrate` and `skein tags`; each returns an ExitStatus and reports errors on stderr.

struct IntrinsicsRequest {
  std::string source;
  CameraWords words;
  vision::Board board;
  std::string out;  ///< the calibration that is written
  int views = 60;   ///< largest number, from a film or a camera
  bool quiet = false;
};
int calibrate_intrinsics(const IntrinsicsRequest& request);

struct FloorRequest {
  std::string source;
  CameraWords words;
  std::string camera;                         ///< calibration file
  std::string marks;                          ///< file of the marks on the floor; empty: those of `camera`
  std::string out;                            ///< floor: the calibration that is written; empty: `camera`
  int frames = 25;                            ///< averaged
  double tag_height = -1.0, tag_size = -1.0;  ///< of the robots' tags [m]; negative: as the calibration has it
  int measure_height = -1;                    ///< tag whose height is measured from its apparent size
  double limit = 0.0;                         ///< check: the largest residual allowed [m]; 0: any
  bool quiet = false;
};
int calibrate_floor(const FloorRequest& request);
int calibrate_check(const FloorRequest& request);

struct JointRequest {
  std::string experiment;     ///< its file
  std::string film;           ///< camera 1's film of a run of it; those of the other cameras are beside it
  std::string out;            ///< folder for the corrected calibrations; empty: none are written
  std::size_t reference = 1;  ///< the camera whose calibration stays unchanged, from 1
  bool save = false;          ///< overwrite the experiment's own calibrations instead
  bool quiet = false;
};
int calibrate_joint(const JointRequest& request);

struct TagsRequest {
  std::string out = "tags.pdf";  ///< .pdf or .svg
  std::string ids = "1-4";       ///< "1-4,7"
  double size_mm = 40.0;
  int copies = 1;
  std::string paper = "A4";
  bool force = false;     ///< an existing file may be overwritten
  bool is_board = false;  ///< a calibration board instead of tags
  vision::Board board;
};
int print_tags(const TagsRequest& request);

/// "1-4,7" as numbers; none for any other text.
std::vector<int> parse_ids(const std::string& text);

}  // namespace skein::app
