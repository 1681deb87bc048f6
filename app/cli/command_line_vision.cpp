#include "app/cli/command_line_vision.h"

#include <fmt/format.h>

#include <charconv>
#include <system_error>

#include "app/cli/shipped_file.h"
#include "app/experiment/experiment.h"
#include "app/manual/whole_number.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "vision/sources/open_source.h"
#include "vision/tags/tag_family.h"

namespace skein::app {

void add_camera_words(CLI::App& command, CameraWords& words, bool calibrated) {
  command
      .add_option("--set", words.settings,
                  "of a camera, repeatable: exposure=SECONDS (0: automatic), gain=, focus=, or a control of its own")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  if (!calibrated)
    command
        .add_option("--size", words.size, "of a camera's frames; default: the calibration's, or the present setting")
        ->type_name("WxH");
  command
      .add_option("--format", words.format, "of a camera's frames; default: the cheapest that supports size and rate")
      ->type_name("YUYV|MJPG|...");
  command.add_option("--rate", words.rate, "of a camera [frames/s]; default: the present setting")
      ->check(number_within(0.1, 10000.0));
  command
      .add_option("--trigger", words.trigger, "what triggers the frames of an aravis camera; default: its own clock")
      ->type_name("software|LINE");
}

void VisionCommands::BoardWords::add_to(CLI::App& command) {
  command.add_option("--board", kind, "charuco or chessboard")
      ->check(CLI::IsMember({"charuco", "chessboard"}))
      ->capture_default_str();
  command.add_option("--squares", squares, "squares of the board, black and white: columns x rows")
      ->type_name("CxR")
      ->capture_default_str();
  command.add_option("--square", square_mm, "edge of a square [mm]")
      ->type_name("MM")
      ->check(number_within(1.0, 1000.0))
      ->capture_default_str();
  command.add_option("--marker", marker_mm, "ChArUco: edge of a marker [mm]")
      ->type_name("MM")
      ->check(number_within(0.5, 1000.0))
      ->capture_default_str();
  command.add_option("--bits", bits, "ChArUco: bits per side of a marker, OpenCV's DICT_nXn_1000")
      ->check(whole_number(4, 7))
      ->capture_default_str();
}

bool VisionCommands::BoardWords::read(vision::Board& board) const {
  board.kind = kind == "charuco" ? vision::Board::Kind::charuco : vision::Board::Kind::chessboard;
  board.square = 1e-3 * square_mm;
  board.marker = 1e-3 * marker_mm;
  board.bits = bits;
  const char* const end = squares.data() + squares.size();
  const auto columns = std::from_chars(squares.data(), end, board.columns);
  if (columns.ec == std::errc() && columns.ptr != end && *columns.ptr == 'x') {
    const auto rows = std::from_chars(columns.ptr + 1, end, board.rows);
    if (rows.ec == std::errc() && rows.ptr == end) return true;
  }
  complain(fmt::format("--squares {}; allowed: columns x rows, such as 12x8", squares));
  return false;
}

void VisionCommands::add_to(CLI::App& program) {
  CLI::App& calibrate = *program.add_subcommand("calibrate", "Calibrates a camera: its lens and its pose");
  calibrate.require_subcommand(1);

  intrinsics_ = calibrate.add_subcommand(
      "intrinsics", "Focal length, centre and distortion of a camera, from pictures of a board (`skein tags board`)");
  intrinsics_->add_option("source", intrinsics_request_.source, vision::source_forms())->required();
  intrinsics_->add_option("--out", intrinsics_request_.out, "calibration to write")->type_name("CAL.TOML")->required();
  intrinsics_->add_option("--views", intrinsics_request_.views, "largest number of views from a film or camera")
      ->check(whole_number(3, 1000))
      ->capture_default_str();
  add_camera_words(*intrinsics_, intrinsics_request_.words, /*calibrated=*/false);
  intrinsics_->add_flag("--quiet", intrinsics_request_.quiet, "no progress, no summary");
  calibration_board_.add_to(*intrinsics_);

  const auto floor_words = [](CLI::App& command, FloorRequest& request) {
    command.add_option("source", request.source, vision::source_forms())->required();
    command.add_option("--camera", request.camera, "calibration file")->type_name("CAL.TOML")->required();
    command
        .add_option("--marks", request.marks,
                    "file of the marks on the floor (see docs/calibration.md); default: those that the calibration has")
        ->type_name("MARKS.TOML");
    command.add_option("--frames", request.frames, "number of frames to average")
        ->check(whole_number(1, 10000))
        ->capture_default_str();
    add_camera_words(command, request.words, /*calibrated=*/true);
    command.add_flag("--quiet", request.quiet, "no summary");
  };
  floor_ = calibrate.add_subcommand(
      "floor", "The world frame of a mounted camera, from tags or points at known positions on the floor");
  floor_words(*floor_, floor_request_);
  floor_->add_option("--out", floor_request_.out, "calibration to write; default: the input file")
      ->type_name("CAL.TOML");
  floor_->add_option("--tag-height", tag_height_mm_, "height of the robots' tags above the floor [mm]")
      ->type_name("MM")
      ->check(number_within(0.0, 10000.0));
  floor_->add_option("--tag-size", tag_size_mm_, "edge of the robots' tags [mm]")
      ->type_name("MM")
      ->check(number_within(5.0, 2000.0));
  floor_
      ->add_option("--measure-height", floor_request_.measure_height,
                   "estimate that height from the apparent size of this robot's tag")
      ->type_name("TAG")
      ->check(whole_number(0, vision::largest_tag));

  check_ = calibrate.add_subcommand("check", "The error of a calibration at each mark, in millimetres on the floor");
  floor_words(*check_, check_request_);
  check_->add_option("--limit", limit_mm_, "exit with status 1 if an error is larger [mm]")
      ->type_name("MM")
      ->check(number_within(0.001, 10000.0));

  joint_ = calibrate.add_subcommand("joint",
                                    "Makes the world frames of several cameras agree, from the films of a run in which "
                                    "robots drove where two of them "
                                    "look; prints by how much they differed");
  take_shipped_files(
      *joint_->add_option("experiment", joint_request_.experiment, "experiment file with its cameras ([[camera.also]])")
           ->required(),
      "experiments");
  joint_
      ->add_option("--video", joint_request_.film,
                   "film of a run of this experiment (`skein run --video`); the other cameras' films lie beside it")
      ->type_name("FILM.MKV")
      ->required();
  joint_->add_option("--reference", joint_request_.reference, "the camera whose calibration stays unchanged, from 1")
      ->check(whole_number(1, static_cast<std::int64_t>(most_cameras)))
      ->capture_default_str();
  CLI::Option* const out =
      joint_
          ->add_option("--out", joint_request_.out, "folder for the corrected calibrations, under their present names")
          ->type_name("FOLDER");
  joint_
      ->add_flag("--save", joint_request_.save, "write them over the experiment's calibrations; the old ones are kept")
      ->excludes(out);
  joint_->add_flag("--quiet", joint_request_.quiet, "no progress, no summary");

  tags_ = program.add_subcommand("tags", "Writes sheets to print: tags for robots, or a calibration board");
  tags_->require_subcommand(0, 1);
  tags_->add_option("ids", tags_request_.ids, "tags of the family 36h11, such as 1-4,7")->capture_default_str();
  tags_->add_option("--size", tags_request_.size_mm, "edge of the black square [mm]")
      ->type_name("MM")
      ->check(number_within(5.0, 2000.0))
      ->capture_default_str();
  tags_->add_option("--copies", tags_request_.copies, "of every tag")
      ->check(whole_number(1, 100))
      ->capture_default_str();
  board_ = tags_->add_subcommand("board", "A calibration board instead of tags");
  printed_board_.add_to(*board_);
  for (CLI::App* sheet : {tags_, board_}) {
    sheet->add_option("--paper", tags_request_.paper, "A4, A3, A2, A1, A0 or letter")->capture_default_str();
    sheet->add_option("--out", tags_request_.out, "a name that ends in .pdf or .svg")
        ->type_name("FILE")
        ->capture_default_str();
    sheet->add_flag("--force", tags_request_.force, "overwrite an existing file");
  }
}

std::optional<int> VisionCommands::run() {
  if (*intrinsics_)
    return calibration_board_.read(intrinsics_request_.board) ? calibrate_intrinsics(intrinsics_request_) : wrong_input;
  floor_request_.tag_height = tag_height_mm_ < 0.0 ? -1.0 : 1e-3 * tag_height_mm_;
  floor_request_.tag_size = 1e-3 * tag_size_mm_;
  check_request_.limit = 1e-3 * limit_mm_;
  if (*floor_) return calibrate_floor(floor_request_);
  if (*check_) return calibrate_check(check_request_);
  if (*joint_) return calibrate_joint(joint_request_);
  if (!*tags_) return {};
  tags_request_.is_board = static_cast<bool>(*board_);
  return printed_board_.read(tags_request_.board) ? print_tags(tags_request_) : wrong_input;
}

}  // namespace skein::app
