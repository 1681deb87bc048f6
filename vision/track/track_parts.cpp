#include "vision/track/track_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <ostream>

#include "vision/tags/tag_plane.h"

namespace skein::vision::detail {
namespace {

template <typename Number>
void append(std::string& line, Number value) {
  char digits[32];  // the shortest text that reads back to the same double has at most 24
  line.append(digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr);
}

}  // namespace

Table::Table(std::ostream* csv, const std::optional<Calibration>& calibration) : csv_(csv), calibration_(calibration) {
  if (csv_ == nullptr) return;
  *csv_ << "frame,source,t,tag,u1,v1,u2,v2,u3,v3,u4,v4," << (calibration_ ? "x,y,theta,sigma_xy,sigma_theta," : "")
        << "how\n";
}

void Table::add(const Frame& frame, const Detection& detection, How how) {
  if (csv_ == nullptr) return;
  double middle = 0.0;
  for (const auto& corner : detection.corners) middle += 0.25 * corner[1];
  begin(frame, frame.captured_at + (calibration_ ? calibration_->row_time * middle : 0.0), detection.tag,
        detection.corners);
  if (calibration_) {
    if (const auto place = place_on_plane(*calibration_, detection.corners)) {
      const PoseSigma sigma = pose_sigma(*place, corner_sigma_px);
      pose(place->pose, sigma.xy, sigma.theta);
    } else {
      for (int i = 0; i < 5; ++i) separate();
    }
  }
  end(how);
}

void Table::add(const Frame& frame, const TagPose& seen) {
  if (csv_ == nullptr) return;
  begin(frame, seen.captured_at, seen.tag, seen.corners);
  pose(seen.pose, seen.sigma_xy, seen.sigma_theta);
  end(seen.how);
}

bool Table::well() const {
  return csv_ == nullptr || static_cast<bool>(*csv_);
}

bool Table::finish() {
  return csv_ == nullptr || static_cast<bool>(csv_->flush());
}

void Table::begin(const Frame& frame, double t, int tag, const Corners& corners) {
  number(frame.index);
  text(frame.source);
  number(t);
  number(static_cast<std::int64_t>(tag));
  for (const auto& corner : corners) {
    number(corner[0]);
    number(corner[1]);
  }
}

void Table::pose(const core::Pose& pose, double sigma_xy, double sigma_theta) {
  for (const double value : {pose.x, pose.y, pose.theta, sigma_xy, sigma_theta}) number(value);
}

void Table::end(How how) {
  text(word(how));
  line_ += '\n';
  *csv_ << line_;
  line_.clear();
}

void Table::text(std::string_view value) {
  separate();
  if (value.find_first_of(",\"\n\r") == std::string_view::npos) {
    line_ += value;
    return;
  }
  line_ += '"';
  for (const char c : value) line_.append(c == '"' ? 2 : 1, c);
  line_ += '"';
}

void Table::number(double value) {
  separate();
  append(line_, value);
}

void Table::number(std::int64_t value) {
  separate();
  append(line_, value);
}

void Table::separate() {
  if (!line_.empty()) line_ += ',';
}

void insert(std::vector<int>& ascending, int id) {
  const auto place = std::lower_bound(ascending.begin(), ascending.end(), id);
  if (place == ascending.end() || *place != id) ascending.insert(place, id);
}

std::string wrong_size(const Frame& frame, const std::string& source, const std::optional<Calibration>& calibration) {
  if (!calibration || (frame.width == calibration->width && frame.height == calibration->height)) return {};
  return fmt::format("frame {} ({}) of {} is {}x{} px, but the calibration holds for {}x{}", frame.index, frame.source,
                     source, frame.width, frame.height, calibration->width, calibration->height);
}

tl::expected<std::unique_ptr<Recorder>, std::string> open_recorder(const std::string& film, FilmNotes notes,
                                                                   const std::string& source) {
  if (film.empty()) return nullptr;
  notes["SOURCE"] = source;
  return Recorder::open(film, notes);
}

std::string nothing_read(const FrameSource& source, std::int64_t frames) {
  if (frames > 0 || source.skipped().empty()) return {};
  return fmt::format("{}: none of its images can be read: {}", source.describe(), fmt::join(source.skipped(), "; "));
}

}  // namespace skein::vision::detail
