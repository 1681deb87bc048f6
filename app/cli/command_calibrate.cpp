#include "app/cli/command_calibrate.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "app/calibration/floor_marks_file.h"
#include "app/cli/same_file.h"
#include "app/experiment/text_file.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/tools/board_views.h"
#include "core/math/elementary.h"
#include "vision/calibrate/floor_calibration.h"
#include "vision/calibrate/intrinsics.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/sheets/sheet.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

int fail_with(const std::string& text, int status) {
  complain(text);
  return status;
}

bool at_terminal(bool quiet) {
  return !quiet && isatty(STDERR_FILENO) != 0;
}

/// A source, with the settings that a camera took instead of the requested ones. None: `status` says why.
std::unique_ptr<vision::FrameSource> open(const std::string& name, const CameraWords& words,
                                          const vision::Calibration* calibration, int& status) {
  auto options = words.read(name);
  if (const std::string wrong = wrong_source(name); !wrong.empty() || !options) {
    status = fail_with(wrong.empty() ? options.error() : wrong, wrong_input);
    return nullptr;
  }
  if (calibration != nullptr) options->width = calibration->width, options->height = calibration->height;
  auto source = vision::open_source(name, *options);
  if (!source) {
    status = fail_with(source.error(), device_failed);
    return nullptr;
  }
  const vision::SourceStatus status_now = (*source)->status();
  for (const std::string& notice : status_now.notices) complain(notice);
  for (const std::string& remark : status_now.remarks) complain(remark);
  return std::move(*source);
}

/// Why the calibration must not be written there: the source is read from it. Empty: it is not.
std::string over_source(const std::string& out, const std::string& source) {
  if (!belongs_to_source(out, source)) return {};
  return fmt::format("{}: belongs to {}, allowed: another name for the calibration", out, source);
}

void name_skipped(const vision::FrameSource& source) {
  for (const std::string& skipped : source.skipped()) complain(fmt::format("skipped {}", skipped));
}

/// Millimetres from metres, for people.
double mm(double metres) {
  return 1e3 * metres;
}

struct Looked {
  vision::Calibration calibration;
  std::vector<vision::FloorMark> marks;
  vision::FloorSight sight;
  tl::expected<vision::TrustedFloor, std::string> solved{};  // by these marks, one of which it may point at
};

/// The marks by which a camera was calibrated, to be seen again. A point has a pixel that held only then.
tl::expected<std::vector<vision::FloorMark>, std::string> marks_to_look_for(const vision::Calibration& calibration,
                                                                            const std::string& file) {
  std::vector<vision::FloorMark> marks;
  for (vision::FloorMark mark : calibration.marks) {
    if (mark.tag < 0) {
      complain(fmt::format("{} is left out: its pixel is of the last calibration", mark.name));
      continue;
    }
    mark.seen = false;
    marks.push_back(mark);
  }
  if (!marks.empty()) return marks;
  return tl::unexpected(
      fmt::format("{}: has no tags on the floor ([[mark]]), allowed: --marks, a file that lists them", file));
}

/// What calibrate floor and check begin with; `status` says why not.
std::optional<Looked> look(const FloorRequest& request, bool need_world, int& status) {
  Looked looked;
  auto calibration = load_calibration(request.camera);
  if (!calibration) {
    complain_lines(calibration.error());
    status = wrong_input;
    return {};
  }
  looked.calibration = *calibration;
  if (need_world && !looked.calibration.world_from_camera) {
    status = fail_with(request.camera + ": has no world frame yet: skein calibrate floor", wrong_input);
    return {};
  }
  auto marks =
      request.marks.empty() ? marks_to_look_for(looked.calibration, request.camera) : load_floor_marks(request.marks);
  if (!marks) {
    complain_lines(marks.error());
    status = wrong_input;
    return {};
  }
  looked.marks = std::move(*marks);
  const auto source = open(request.source, request.words, &looked.calibration, status);
  if (!source) return {};
  auto sight = vision::look_at_floor(*source, looked.calibration, request.frames, [](int) { return !interrupted(); });
  name_skipped(*source);
  if (!sight) {
    status = fail_with(sight.error(), device_failed);
    return {};
  }
  // Fewer frames than requested would do for a solution, but a user who presses Ctrl-C wants none.
  if (interrupted()) {
    status = fail_with("interrupted; nothing was written", device_failed);
    return {};
  }
  looked.sight = std::move(*sight);
  enter(looked.sight, looked.marks);
  looked.solved = vision::solve_trusted_floor(looked.calibration, looked.marks);
  // A file's own world frame may be that of a camera that has moved since.
  vision::Calibration floor = looked.calibration;
  if (looked.solved)
    floor = looked.solved->calibration;
  else if (!need_world)
    floor.world_from_camera.reset();
  for (const std::string& why : why_not_seen(looked.sight, looked.marks, floor)) complain(why);
  if (const std::string twice = doubled_tags(looked.sight); !twice.empty()) {
    status = fail_with(twice + (need_world ? "" : "; nothing was written"), device_failed);
    return {};
  }
  return looked;
}

void print_residuals(const vision::FloorCheck& check) {
  for (const vision::FloorResidual& r : check.residuals)
    fmt::print("{}: x {:.3f} y {:.3f} m, off by {:.2f} mm (x {:+.2f}, y {:+.2f}){}\n", shown(r.mark->name), r.mark->x,
               r.mark->y, mm(core::math::hypot(r.dx, r.dy)), mm(r.dx), mm(r.dy), r.left_out ? ", left out" : "");
  fmt::print("marks: {}\nrms_mm: {:.3f}\nworst_mm: {:.3f}\n", check.marks, mm(check.rms), mm(check.worst));
}

void print_shift(const vision::PoseShift& shift) {
  for (const vision::PoseShift::Place& place : shift.places)
    fmt::print("pose at x {:.3f} y {:.3f} m ({}): moves by {:.2f} mm (x {:+.2f}, y {:+.2f})\n", place.x, place.y,
               shown(place.name), mm(core::math::hypot(place.dx, place.dy)), mm(place.dx), mm(place.dy));
  fmt::print("poses_move_mm: {:.3f}\n", mm(shift.rms));
}

}  // namespace

int calibrate_intrinsics(const IntrinsicsRequest& request) {
  if (const std::string problem = vision::check(request.board); !problem.empty())
    return fail_with(problem, wrong_input);
  if (const auto possible = check_calibration_target(request.out); !possible)
    return fail_with(possible.error(), wrong_input);
  if (const std::string over = over_source(request.out, request.source); !over.empty())
    return fail_with(over, wrong_input);
  int status = done;
  const auto source = open(request.source, request.words, nullptr, status);
  if (!source) return status;
  const bool stills = source->stills();
  const bool live = vision::is_camera(request.source);
  BoardViews seen(request.board, *source, live);
  vision::Frame frame;
  // A camera is watched until it has seen enough; of a film, which is over when it is over, the best views are taken.
  const bool terminal = at_terminal(request.quiet);
  bool drawn = false;
  const auto show = [&] {
    const vision::Coverage& covered = *seen.coverage();
    // Of a camera at a terminal: in the same place again, a line more than the picture has rows.
    if (terminal && live && std::exchange(drawn, true))
      print_error_as_is(fmt::format("\033[{}A\033[J", vision::Coverage::rows + 1));
    print_error(fmt::format("{} views, {:.0f} % of the picture covered{}\n{}", seen.views().size(),
                            100.0 * covered.share(),
                            live ? fmt::format("; {} at most, Ctrl-C to finish", request.views) : "", covered.text()));
  };
  if (live && !request.quiet) print_error(fmt::format("{}: show the board\n", source->describe()));
  while (!interrupted() && (!live || static_cast<int>(seen.views().size()) < request.views)) {
    const auto more = source->read(frame);
    if (!more) return fail_with(more.error(), device_failed);
    if (!*more) break;
    const auto kind = seen.add(frame);
    if (!kind) return fail_with(kind.error(), device_failed);
    const vision::Coverage& first = *seen.coverage();
    switch (*kind) {
      case BoardViews::FrameKind::other_size:
        complain(fmt::format("skipped {}: {}x{} px, the first picture of the board has {}x{}", frame.source,
                             frame.width, frame.height, first.width, first.height));
        break;
      case BoardViews::FrameKind::no_board:
        if (stills) complain(fmt::format("{}: no board", frame.source));
        break;
      case BoardViews::FrameKind::view:
        if (terminal || (live && !request.quiet)) show();
        break;
      case BoardViews::FrameKind::known:
        if (stills) complain(fmt::format("{}: left out: the board is where it is in another picture", frame.source));
        break;
    }
  }
  const std::optional<vision::Coverage>& coverage = seen.coverage();
  std::vector<vision::BoardView> views = std::move(seen.views());
  name_skipped(*source);
  if (!coverage) return fail_with(source->describe() + ": no picture", device_failed);
  if (!stills) views = vision::most_different(std::move(views), static_cast<std::size_t>(request.views));
  const auto result = vision::solve_intrinsics(std::move(views), coverage->width, coverage->height);
  if (const std::string why = result ? vision::equal_tilts(*result) : result.error(); !why.empty())
    return fail_with(fmt::format("{}: {} (pictures looked at: {})", source->describe(), why, seen.frames()),
                     device_failed);
  const auto old = replace_calibration(result->calibration, request.out);
  if (!old) return fail_with(old.error(), wrong_input);
  if (!old->empty())
    complain(fmt::format("{} was overwritten; its previous contents are in {}", request.out, old->string()));
  if (request.quiet) return done;
  int rejected = 0;
  int outliers = 0;
  std::size_t corners = 0;
  for (const vision::BoardView& view : result->views) {
    fmt::print("view {}: {} corners, {:.3f} px{}{}\n", shown(view.source), view.corners.size(), view.rms,
               view.outliers > 0 ? fmt::format(", {} left out", view.outliers) : "",
               view.rejected ? ", view left out" : "");
    rejected += view.rejected ? 1 : 0;
    outliers += view.outliers;
    if (!view.rejected) corners += view.corners.size();
  }
  const vision::Calibration& c = result->calibration;
  fmt::print("coverage:\n{}", coverage->text());
  fmt::print(
      "frames: {}\nviews: {}\nviews_left_out: {}\ncorners: {}\ncorners_left_out: {}\ncoverage: {:.2f}\nrms_px: {:.4f}\n"
      "fx: {:.3f}\nfy: {:.3f}\nfocal_sigma: {:.3f}\ncx: {:.3f}\ncy: {:.3f}\ncentre_sigma: {:.3f}\n"
      "distortion: {:.5f}\ncalibration: {}\n",
      seen.frames(), result->views.size() - static_cast<std::size_t>(rejected), rejected, corners, outliers,
      coverage->share(), result->rms, c.fx, c.fy, result->focal_sigma, c.cx, c.cy, result->centre_sigma,
      fmt::join(c.distortion, " "), request.out);
  if (result->focal_sigma > 0.01 * c.fx)
    complain(fmt::format("the focal length is only known to {:.0f} px: show the board tilted, near and far",
                         result->focal_sigma));
  for (const std::string& why : {vision::uneven_focal_lengths(*result), vision::systematic_residuals(*result)})
    if (!why.empty()) complain(why);
  if (coverage->share() < 0.6)
    fmt::print(
        stderr,
        "skein: only {:.0f} % of the picture was covered: distortion is extrapolated elsewhere; show the board there\n",
        100.0 * coverage->share());
  return done;
}

int calibrate_floor(const FloorRequest& request) {
  const std::string out = request.out.empty() ? request.camera : request.out;
  if (const auto possible = check_calibration_target(out); !possible) return fail_with(possible.error(), wrong_input);
  if (same_file(out, request.marks))
    return fail_with(fmt::format("{}: is the file of the marks, allowed: another name for the calibration", out),
                     wrong_input);
  if (const std::string over = over_source(out, request.source); !over.empty()) return fail_with(over, wrong_input);
  int status = done;
  auto looked = look(request, /*need_world=*/false, status);
  if (!looked) return status;
  auto& solved = looked->solved;
  if (!solved) return fail_with(solved.error() + "; nothing was written", device_failed);
  vision::Calibration* const result = &solved->calibration;
  if (request.tag_size > 0.0) result->tag_size = request.tag_size;
  if (request.tag_height >= 0.0) result->tag_height = request.tag_height;
  result->marks = vision::kept_marks(*solved, looked->marks, looked->sight);
  if (const std::string wrong = vision::wrong_mark_size(result->marks); !wrong.empty())
    return fail_with(wrong + "; nothing was written", device_failed);
  if (const std::string wrong = vision::wrong_tag_height(*result); !wrong.empty()) return fail_with(wrong, wrong_input);
  if (request.measure_height >= 0) {
    const auto& ids = looked->sight.ids;
    const auto found = std::find(ids.begin(), ids.end(), request.measure_height);
    const auto height =
        found == ids.end()
            ? std::nullopt
            : vision::tag_height_of(*result, looked->sight.corners[static_cast<std::size_t>(found - ids.begin())]);
    if (found == ids.end()) {
      const std::array missing{vision::MissingTag{.tag = request.measure_height}};
      return fail_with(sentence(vision::diagnose(looked->sight.last, *result, missing).front(), *result),
                       device_failed);
    }
    if (!height)
      return fail_with(fmt::format("tag {}: no height explains its size: check --tag-size", request.measure_height),
                       device_failed);
    result->tag_height = *height;
  }
  const auto check = vision::check_floor(*result, looked->marks, solved->left_out);
  if (!check) return fail_with(check.error(), device_failed);
  const auto old = replace_calibration(*result, out, std::array{request.camera, request.marks});
  if (!old) return fail_with(old.error(), wrong_input);
  if (!old->empty()) complain(fmt::format("{} was overwritten; its previous contents are in {}", out, old->string()));
  if (!request.quiet) {
    print_residuals(*check);
    if (const auto shift = vision::pose_shift(looked->calibration, *result)) print_shift(*shift);
    const Eigen::Vector3d& p = result->world_from_camera->position;
    fmt::print("camera: {:.4f} {:.4f} {:.4f}\ntag_height: {:.4f}\ntag_size: {:.4f}\ncalibration: {}\n", p.x(), p.y(),
               p.z(), result->tag_height, result->tag_size, shown(out));
  }
  if (solved->left_out)
    complain(fmt::format("{} was rejected: it is {:.1f} mm from its place in {}, and the others agree without it",
                         solved->left_out->name, mm(solved->off),
                         request.marks.empty() ? request.camera : request.marks));
  else if (const double off = vision::single_error(*check); off > 5e-3)
    complain(
        fmt::format("the marks disagree by up to {:.1f} mm, as if one of the {} were off by {:.1f} mm: check "
                    "their positions and the camera's focus",
                    mm(check->worst), check->marks, mm(off)));
  return done;
}

int calibrate_check(const FloorRequest& request) {
  int status = done;
  const auto looked = look(request, /*need_world=*/true, status);
  if (!looked) return status;
  const auto check = vision::check_floor(looked->calibration, looked->marks);
  if (!check) return fail_with(check.error(), device_failed);
  if (!request.quiet) print_residuals(*check);
  if (request.limit > 0.0 && check->worst > request.limit)
    return fail_with(fmt::format("a mark is off by {:.2f} mm; allowed: {:.2f} mm", mm(check->worst), mm(request.limit)),
                     expectation_failed);
  return done;
}

std::vector<int> parse_ids(const std::string& text) {
  std::vector<int> ids;
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto number = [&](int& value) {
    const auto [behind, error] = std::from_chars(at, end, value);
    at = behind;
    return error == std::errc{} && value >= 0 && value < 10000;
  };
  while (at != end) {
    int first = 0;
    if (!number(first)) return {};
    int last = first;
    if (at != end && *at == '-' && (++at, !number(last) || last < first)) return {};
    for (int id = first; id <= last; ++id) ids.push_back(id);
    if (at == end) return ids;
    if (*at++ != ',') return {};
  }
  return {};
}

int print_tags(const TagsRequest& request) {
  end_by_interrupts();
  tl::expected<std::vector<vision::Page>, std::string> pages;
  if (request.is_board) {
    pages = vision::board_sheet(request.board, request.paper);
  } else {
    const std::vector<int> ids = parse_ids(request.ids);
    if (ids.empty()) return fail_with(fmt::format("ids \"{}\"; allowed: such as 1-4,7", request.ids), wrong_input);
    pages = vision::tag_sheet({ids, 1e-3 * request.size_mm, request.paper, request.copies});
  }
  if (!pages) return fail_with(pages.error(), wrong_input);
  const auto files = vision::sheet_files(*pages, request.out);
  if (!files) return fail_with(files.error(), wrong_input);
  std::error_code ignored;
  for (const vision::SheetFile& file : *files)
    if (const auto there = std::filesystem::status(file.name, ignored); std::filesystem::exists(there)) {
      if (!std::filesystem::is_regular_file(there))
        return fail_with(fmt::format("{}: is a folder, a device or a FIFO, allowed: the name of a file", file.name),
                         wrong_input);
      if (!request.force)
        return fail_with(fmt::format("{}: already exists, allowed: another name, or --force", file.name), wrong_input);
    }
  for (const vision::SheetFile& file : *files) {
    if (const auto written = write_file(file.name, file.contents); !written)
      return fail_with(written.error(), wrong_input);
    fmt::print("{}\n", shown(file.name));
  }
  return done;
}

}  // namespace skein::app
