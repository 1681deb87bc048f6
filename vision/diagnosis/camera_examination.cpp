#include "vision/diagnosis/camera_examination.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>

#include "vision/diagnosis/diagnosis.h"
#include "vision/diagnosis/edge_widths.h"
#include "vision/diagnosis/light_limits.h"
#include "vision/diagnosis/module_grey.h"
#include "vision/tags/detection.h"

namespace skein::vision {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

constexpr int grid_step = 4;              // every fourth pixel of every fourth row is looked at in each frame
constexpr std::size_t most_bands = 96;    // of rows
constexpr std::size_t most_samples = 10;  // frames that are searched for tags
constexpr double between_samples = 1.0;   // [s]
constexpr std::int64_t few_frames = 5;    // of a film: the times of fewer say nothing of its rate

// What is still well, and from where on it is ill.
constexpr double enough_rate = 0.95;    // of what is needed
constexpr double some_jitter = 0.5e-3;  // at 0.13 m/s a millimetre is 8 ms [s]
constexpr double much_jitter = 2e-3;    // [s]
constexpr double some_missing = 0.01;   // of the frames
constexpr double some_flicker = 0.03;   // of the brightness
constexpr double much_flicker = 0.10;
constexpr double some_drift = 0.05;      // of the brightness
constexpr double some_saturated = 0.05;  // of the pixels
constexpr int dim_grey = 100;
constexpr double some_noise = 8.0;      // [grey levels]
constexpr double soft_edge = 3.2;       // [px]; a lens in focus gives 2 to 2.5
constexpr double some_contrast = 40.0;  // [grey levels]
constexpr double small_edge = 16.0;     // of a tag [px]
constexpr double late = 0.1;            // [s]

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return nan;
  const auto at = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Standard deviation of one pixel from the differences of two frames: each row's mean is taken out, which is the
/// light's, and what is far off, which moves.
double noise_between(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b, std::size_t columns) {
  if (columns == 0 || a.size() != b.size()) return nan;
  std::vector<double> off;
  off.reserve(a.size());
  for (std::size_t row = 0; row + columns <= a.size(); row += columns) {
    double mean = 0.0;
    for (std::size_t i = row; i < row + columns; ++i) mean += a[i] - b[i];
    mean /= static_cast<double>(columns);
    for (std::size_t i = row; i < row + columns; ++i) off.push_back(a[i] - b[i] - mean);
  }
  double limit = std::numeric_limits<double>::infinity(), sigma = 0.0;
  for (int pass = 0; pass < 3; ++pass) {
    double sum = 0.0;
    std::size_t count = 0;
    for (const double value : off)
      if (std::abs(value) < limit) {
        sum += value * value;
        ++count;
      }
    sigma = count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
    limit = std::max(3.5 * sigma, 1.0);
  }
  return sigma / std::sqrt(2.0);
}

double edge_of(const Corners& corners) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i)
    sum += std::hypot(corners[i][0] - corners[(i + 1) % 4][0], corners[i][1] - corners[(i + 1) % 4][1]);
  return sum / 4.0;
}

Window around(const Corners& corners) {
  double u = 0.0, v = 0.0;
  for (const auto& corner : corners) {
    u += 0.25 * corner[0];
    v += 0.25 * corner[1];
  }
  const double half = edge_of(corners);
  return {static_cast<int>(u - half), static_cast<int>(v - half), static_cast<int>(2.0 * half),
          static_cast<int>(2.0 * half)};
}

/// Between ink and paper: the border of the black square and the white one around it. [grey levels]
double contrast_of(const Frame& frame, const Corners& corners) {
  const auto grey = [&](double column, double row) { return detail::module_grey(frame, corners, column, row); };
  std::vector<double> ink, paper;
  for (int i = 0; i < 8; ++i)
    for (const double side : {0.0, 1.0}) {
      const double along = i + 0.5, inside = 0.5 + 7.0 * side, outside = -0.5 + 9.0 * side;
      ink.push_back(grey(along, inside));
      ink.push_back(grey(inside, along));
      paper.push_back(grey(along, outside));
      paper.push_back(grey(outside, along));
    }
  return quantile(paper, 0.5) - quantile(ink, 0.5);
}

/// Times of the frames: rate, gaps, jitter.
void measure_stamps(const std::vector<double>& stamps, CameraMeasurements& measured) {
  std::vector<double> apart;
  for (std::size_t k = 1; k < stamps.size(); ++k) {
    const double distance = stamps[k] - stamps[k - 1];
    if (distance > 0.0)
      apart.push_back(distance);
    else
      ++measured.backwards;
  }
  if (apart.empty()) return;
  const double usual = quantile(apart, 0.5);
  double sum = 0.0;
  for (const double distance : apart) {
    const double frames = std::max(1.0, std::round(distance / usual));
    measured.missing += static_cast<std::int64_t>(frames) - 1;
    sum += std::pow(distance - frames * usual, 2);
  }
  measured.stamp_jitter = std::sqrt(sum / static_cast<double>(apart.size()));
  measured.rate = static_cast<double>(measured.missing + static_cast<std::int64_t>(stamps.size()) - 1) /
                  (stamps.back() - stamps.front());
}

/// Brightness of bands of rows, against the same band in other frames: what stands in the picture cancels.
void measure_light(const std::vector<std::vector<float>>& bands, const std::vector<double>& stamps,
                   CameraMeasurements& measured) {
  if (bands.empty()) return;
  const std::size_t count = bands.front().size();
  std::vector<double> usual(count, 0.0);
  for (const auto& frame : bands)
    for (std::size_t b = 0; b < count; ++b)
      usual[b] += static_cast<double>(frame[b]) / static_cast<double>(bands.size());
  constexpr double black = 20.0;  // a picture as dark as this says nothing about the light [grey levels]
  const auto off = [&](std::size_t k, std::size_t b) {
    return (static_cast<double>(bands[k][b]) - usual[b]) / std::max(black, usual[b]);
  };
  std::map<std::int64_t, std::pair<double, int>> seconds;  // sum of the brightness, number of frames
  std::vector<std::int64_t> second(bands.size());
  for (std::size_t k = 0; k < bands.size(); ++k) {
    second[k] = static_cast<std::int64_t>(std::floor(stamps[k] - stamps.front()));
    double mean = 0.0;
    for (std::size_t b = 0; b < count; ++b) mean += off(k, b) / static_cast<double>(count);
    auto& [sum, frames] = seconds[second[k]];
    sum += mean;
    ++frames;
  }
  const auto slow = [&](std::size_t k) {
    const auto& [sum, frames] = seconds[second[k]];
    return sum / frames;
  };
  double sum = 0.0, least = 0.0, most = 0.0;
  for (std::size_t k = 0; k < bands.size(); ++k) {
    const double mean = slow(k);
    if (seconds[second[k]].second >= 5) {  // a second that is cut short says little
      least = std::min(least, mean);
      most = std::max(most, mean);
    }
    for (std::size_t b = 0; b < count; ++b) sum += std::pow(off(k, b) - mean, 2);
  }
  measured.flicker = std::sqrt(2.0 * sum / static_cast<double>(bands.size() * count));  // amplitude of a sine
  measured.drift = most - least;
}

std::string milliseconds(double seconds) {
  return fmt::format("{:.2f} ms", 1e3 * seconds);
}

}  // namespace

void CameraExamination::add(const Frame& frame) {
  const bool other =
      !samples_.empty() && (frame.width != samples_.front().width || frame.height != samples_.front().height);
  if (other || frame.width < grid_step || frame.height < grid_step) {
    ++other_size_;
    return;
  }
  stamps_.push_back(frame.captured_at);
  if (frame.arrived_at > 0.0) latencies_.push_back(frame.arrived_at - frame.captured_at);
  grid_.swap(last_grid_);
  grid_.clear();
  grid_columns_ = static_cast<std::size_t>((frame.width + grid_step - 1) / grid_step);
  const auto rows = static_cast<std::size_t>((frame.height + grid_step - 1) / grid_step);
  const std::size_t count = std::min(rows, most_bands);
  std::vector<float> band(count, 0.0F);
  std::vector<int> pixels(count, 0);
  for (std::size_t r = 0; r < rows; ++r) {
    const std::uint8_t* row = frame.row(static_cast<int>(r) * grid_step);
    int sum = 0;
    for (int u = 0; u < frame.width; u += grid_step) {
      grid_.push_back(row[u]);
      sum += row[u];
    }
    const std::size_t b = r * count / rows;
    band[b] += static_cast<float>(sum);
    pixels[b] += static_cast<int>(grid_columns_);
  }
  for (std::size_t b = 0; b < count; ++b) band[b] /= static_cast<float>(std::max(1, pixels[b]));
  bands_.push_back(std::move(band));
  if (!last_grid_.empty()) noises_.push_back(noise_between(grid_, last_grid_, grid_columns_));
  const bool due = samples_.empty() || frame.captured_at >= samples_.back().captured_at + between_samples;
  if (due && samples_.size() < most_samples) samples_.push_back(frame);
}

CameraMeasurements CameraExamination::measure() const {
  CameraMeasurements measured;
  measured.frames = static_cast<std::int64_t>(stamps_.size());
  measured.other_size = other_size_;
  measure_stamps(stamps_, measured);
  measured.latency = quantile(latencies_, 0.5);
  measured.latency_p99 = quantile(latencies_, 0.99);
  double off = 0.0;
  for (const double latency : latencies_) off += std::pow(latency - measured.latency, 2);
  measured.latency_jitter = latencies_.empty() ? nan : std::sqrt(off / static_cast<double>(latencies_.size()));
  measure_light(bands_, stamps_, measured);
  measured.noise = quantile(noises_, 0.5);
  measured.contrast = measured.tag_edge = nan;

  TagDetector detector({.min_white_black_diff = detail::faint});
  std::vector<double> widths_at_tags, widths;
  const double noise = std::isfinite(measured.noise) ? measured.noise : 0.0;
  for (const Frame& frame : samples_) {
    std::array<std::size_t, 256> histogram{};
    for (const std::uint8_t grey : frame.grey) ++histogram[grey];
    std::size_t above = 0;
    int brightest = 0;
    for (int grey = 255; grey >= 0; --grey) {
      above += histogram[static_cast<std::size_t>(grey)];
      if (grey == 250)
        measured.saturated =
            std::max(measured.saturated, static_cast<double>(above) / static_cast<double>(frame.grey.size()));
      if (brightest == 0 && above > frame.grey.size() / 100) brightest = grey;
    }
    measured.brightest = std::max(measured.brightest, brightest);
    const std::vector<Detection> found = detect_at_both(detector, frame);
    measured.tags = std::max(measured.tags, static_cast<int>(found.size()));
    for (const Detection& tag : found) {
      measured.contrast = std::fmin(measured.contrast, contrast_of(frame, tag.corners));
      measured.tag_edge = std::fmin(measured.tag_edge, edge_of(tag.corners));
      detail::edge_widths(frame, around(tag.corners), noise, widths_at_tags);
    }
    detail::edge_widths(frame, {0, 0, frame.width, frame.height}, noise, widths);
  }
  if (measured.tags == 0 && !samples_.empty()) measured.why_no_tag = why_no_tag(samples_.back());
  measured.edge_width = quantile(widths_at_tags.empty() ? widths : widths_at_tags, 0.5);
  return measured;
}

std::vector<CameraFinding> CameraExamination::judge(const CameraMeasurements& m) const {
  using State = CameraFinding::State;
  std::vector<CameraFinding> findings;
  const auto say = [&](State state, const char* what, std::string found, std::string remedy) {
    if (state == State::well) remedy.clear();
    findings.push_back({state, what, std::move(found), std::move(remedy)});
  };
  const auto graded = [](double value, double some, double much) {
    return value >= much ? State::ill : value >= some ? State::note : State::well;
  };
  const bool timed = facts_.stamps != TimeStamps::nominal, film = facts_.stamps == TimeStamps::film;
  if (m.other_size > 0)
    say(State::ill, "size",
        samples_.empty() ? fmt::format("the frames have fewer than {} pixels from edge to edge", grid_step)
                         : fmt::format("{} of {} frames have another size than the first one's {}x{} px", m.other_size,
                                       m.frames + m.other_size, samples_.front().width, samples_.front().height),
        "one size for all: a calibration holds for no other");
  if (m.frames == 0 && m.other_size > 0) return findings;
  // Of a film that is over, or of pictures: what one frame shows is judged, and no rate made of the times of two.
  const bool enough = m.frames >= (film ? few_frames : 2);
  if (m.frames == 0 || (!enough && timed && !film)) {
    say(State::ill, "frames", fmt::format("{} came", m.frames), "look at the cable and at other programs that use it");
    return findings;
  }
  if (!enough)
    say(State::note, "frames",
        fmt::format("{} came, too few to judge {}how light and noise change", m.frames,
                    film ? "rate and regularity, or " : ""),
        film ? "a film of some seconds" : "more pictures, of a camera that hangs still");
  if (timed && enough) {
    say(m.rate < enough_rate * facts_.needed_rate ? State::ill : State::well, "frame rate",
        fmt::format("{:.2f} frames/s of {} frames, {:g} wanted", m.rate, m.frames, facts_.needed_rate),
        "a shorter exposure, another format or a smaller picture (--rate, --format, --size); skein camera list");
    const double missing = static_cast<double>(m.missing) / static_cast<double>(m.frames + m.missing);
    say(missing > some_missing ? State::ill : State::well, "gaps", fmt::format("{} frames are missing", m.missing),
        "a port of its own on the computer, no hub; close other programs");
    if (m.backwards > 0)
      say(State::ill, "regularity", fmt::format("{} stamps are not later than the previous one", m.backwards),
          "the driver's stamps cannot be used: update it, or use another camera");
    else if (m.stamp_jitter >= some_jitter && m.latency_jitter < 0.5 * m.stamp_jitter)
      say(State::note, "regularity",
          fmt::format("frames come {} (rms) off their beat, and their stamps say so", milliseconds(m.stamp_jitter)),
          "switch automatic exposure off: poses are right, but ticks wait for such frames");
    else
      say(graded(m.stamp_jitter, some_jitter, much_jitter), "regularity",
          fmt::format("stamps come {} (rms) off their beat", milliseconds(m.stamp_jitter)),
          "switch automatic exposure off; a robot at 0.13 m/s is measured 0.13 mm off for each ms");
  }
  constexpr const char* measured_later =
      "a robot is predicted its speed times the delay off: skein camera latency measures it";
  switch (facts_.stamps) {
    case TimeStamps::exposure_start:
      say(State::well, "stamps", "tell when the exposure began", {});
      break;
    case TimeStamps::first_packet:
      say(State::note, "stamps", "tell when the first packet of a frame came, later than its exposure", measured_later);
      break;
    case TimeStamps::frame_end:
      say(State::note, "stamps", "tell when a frame was complete, later than its exposure", measured_later);
      break;
    case TimeStamps::arrival:
      say(State::note, "stamps", "are the program's own: the driver tells none, or none that goes with time",
          "expect errors of some ms of driving; another camera or driver stamps by itself");
      break;
    case TimeStamps::film:
      say(State::well, "stamps", "are the film's", {});
      break;
    case TimeStamps::nominal:
      say(State::note, "stamps", "pictures have none: rate, gaps and latency cannot be judged",
          "examine the camera itself");
      break;
  }
  if (std::isfinite(m.latency)) {
    const std::string found = fmt::format("{} from capture to arrival (median), {} (99 %)", milliseconds(m.latency),
                                          milliseconds(m.latency_p99));
    if (m.latency < 0.0)
      say(State::ill, "latency", found + ": stamps from the future", "the driver's stamps cannot be used");
    else
      say(m.latency_p99 > late ? State::note : State::well, "latency", found,
          "the camera or a hub keeps frames back: a port of its own, a cheaper format");
  }
  if (facts_.row_time > 0.0)
    say(State::well, "row time", fmt::format("{:.3g} us a row, of the calibration", 1e6 * facts_.row_time), {});
  if (enough) {
    say(graded(m.flicker, some_flicker, much_flicker), "flicker",
        fmt::format("the light changes by {:.1f} % from frame to frame and row to row", 100.0 * m.flicker),
        "an exposure of 10 ms or a multiple (8.33 ms at 60 Hz mains), or lamps with a direct current");
    // Flicker and the frames beat: seconds differ by as much.
    say(m.drift - m.flicker >= some_drift ? State::note : State::well, "brightness",
        fmt::format("changes by {:.1f} % from second to second", 100.0 * m.drift),
        "set exposure and gain: --set exposure=0.005 --set gain=...; keep daylight out");
  }
  const std::string light =
      fmt::format("the brightest hundredth is at {} of 255, {:.1f} % are white", m.brightest, 100.0 * m.saturated);
  if (m.saturated >= some_saturated)
    say(graded(m.saturated, some_saturated, detail::saturated_share), "exposure", light,
        "a shorter exposure, or less gain");
  else
    say(m.brightest < detail::dark_grey ? State::ill
        : m.brightest < dim_grey        ? State::note
                                        : State::well,
        "exposure", light, "more light, then a longer exposure (5 ms keep a driving tag sharp), then gain");
  if (enough && std::isfinite(m.noise))
    say(m.noise >= some_noise ? State::note : State::well, "noise", fmt::format("{:.1f} grey levels", m.noise),
        "less gain and more light");
  if (std::isfinite(m.edge_width))
    say(graded(m.edge_width, soft_edge, detail::blurred_edge), "sharpness",
        fmt::format("an edge is {:.1f} px wide", m.edge_width), "turn the lens's focus, and fix it; clean the lens");
  else
    say(State::note, "sharpness", "no clear edge in the picture", "put a tag or a printed page under the camera");
  if (m.tags == 0) {
    if (m.why_no_tag.empty())
      say(State::note, "tags", "none of the family 36h11 is in the picture",
          "put printed tags under the camera: skein tags 1-4");
    else
      say(State::ill, "tags", "none of the family 36h11 can be read", m.why_no_tag);
    return findings;
  }
  say(m.contrast < detail::least_contrast ? State::ill
      : m.contrast < some_contrast        ? State::note
                                          : State::well,
      "contrast", fmt::format("{} tags, {:.0f} grey levels between ink and paper of the faintest", m.tags, m.contrast),
      "more light on the tags, matt paper, a darker print");
  say(m.tag_edge < small_edge ? State::note : State::well, "size of tags",
      fmt::format("{:.0f} px of the smallest", m.tag_edge), "larger tags, more pixels, or a lower camera");
  return findings;
}

}  // namespace skein::vision
