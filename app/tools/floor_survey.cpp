#include "app/tools/floor_survey.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "app/calibration/calibration_file.h"
#include "app/tools/camera_words.h"
#include "vision/calibrate/floor_calibration.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

constexpr int frames = 25;  // looked at, and averaged

}  // namespace

std::optional<KnownFloor> known_floor(const std::string& calibration) {
  const auto file = load_calibration(calibration);
  if (!file) return {};
  KnownFloor floor{{}, file->tag_size, file->tag_height};
  for (const vision::FloorMark& mark : file->marks)
    if (mark.tag >= 0) floor.tags.push_back({.id = mark.tag, .x = mark.x, .y = mark.y, .z = mark.z});
  return floor.tags.empty() ? std::nullopt : std::optional(floor);
}

tl::expected<FloorSurvey, std::string> survey_floor(const FloorQuestion& question, const std::atomic<bool>& ends) {
  const auto goes_on = [&ends] { return !ends.load(); };
  const auto lens = load_calibration(question.calibration);
  if (!lens) return tl::unexpected(lens.error());
  if (const std::string wrong = wrong_source(question.source); !wrong.empty()) return tl::unexpected(wrong);
  auto options = CameraWords{.settings = question.settings}.read(question.source);
  if (!options) return tl::unexpected(options.error());
  options->width = lens->width;
  options->height = lens->height;
  options->keep_waiting = goes_on;
  auto source = vision::open_source(question.source, *options);
  if (!source) return tl::unexpected(source.error());
  const auto sight = vision::look_at_floor(**source, *lens, frames, [&](int) { return goes_on(); });
  if (!sight) return tl::unexpected(sight.error());
  std::vector<vision::FloorMark> marks;
  marks.reserve(question.tags.size());
  for (const FloorTag& tag : question.tags)
    marks.push_back({.name = fmt::format("tag {}", tag.id), .tag = tag.id, .x = tag.x, .y = tag.y, .z = tag.z});
  vision::enter(*sight, marks);
  auto solved = vision::solve_trusted_floor(*lens, marks);
  vision::Calibration floor = solved ? solved->calibration : *lens;
  if (!solved) floor.world_from_camera.reset();  // that of a camera that may have moved
  const std::vector<std::string> unseen = vision::why_not_seen(*sight, marks, floor);
  const std::string twice = vision::doubled_tags(*sight);
  if (!solved || !twice.empty())
    return tl::unexpected(fmt::format("{}{}{}", twice.empty() ? solved.error() : twice, unseen.empty() ? "" : "; ",
                                      fmt::join(unseen, "; ")));
  vision::Calibration* const result = &solved->calibration;
  result->tag_size = question.tag_size;
  result->tag_height = question.tag_height;
  result->marks = vision::kept_marks(*solved, marks, *sight);
  if (const std::string wrong = vision::wrong_mark_size(result->marks); !wrong.empty()) return tl::unexpected(wrong);
  if (const std::string wrong = vision::wrong_tag_height(*result); !wrong.empty()) return tl::unexpected(wrong);
  const auto check = vision::check_floor(*result, marks, solved->left_out);
  if (!check) return tl::unexpected(check.error());
  if (!goes_on()) return tl::unexpected(std::string("ended"));
  if (const auto old = replace_calibration(*result, question.calibration); !old) return tl::unexpected(old.error());
  FloorSurvey survey{question.tags, check->rms, check->worst};
  for (const vision::FloorResidual& residual : check->residuals) {
    FloorTag& tag = survey.tags[static_cast<std::size_t>(residual.mark - marks.data())];
    tag.off_x = residual.dx;
    tag.off_y = residual.dy;
  }
  const Eigen::Vector3d& place = result->world_from_camera->position;
  survey.camera = {place.x(), place.y(), place.z()};
  if (const auto shift = vision::pose_shift(*lens, *result)) survey.poses_move = shift->rms;
  survey.unseen = unseen;
  if (solved->left_out) survey.suspect = solved->left_out->name;
  return survey;
}

}  // namespace skein::app
