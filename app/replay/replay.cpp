#include "app/replay/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>

#include "app/controllers/own_controller.h"
#include "app/experiment/text_file.h"
#include "app/record/csv_reader.h"
#include "app/record/disk_writer.h"
#include "app/replay/replay_film.h"
#include "app/tick/control_tick.h"
#include "app/tick/recorded_input.h"
#include "core/geometry/pose.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

bool same_bits(double a, double b) noexcept {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

struct Value {
  const char* name;
  double recorded, again;
};

/// Compares values of one robot at one tick, notes the first that differs; false: one did. `camera`: "c2_" or nothing.
template <std::size_t N>
bool same(const Value (&values)[N], const TickRecord& row, std::size_t robot, ReplayResult& result,
          const std::string& camera = {}) {
  for (const Value& value : values) {
    if (same_bits(value.recorded, value.again)) continue;
    if (result.first.empty())
      result.first = fmt::format("tick {} (t = {} s), r{}_{}{}: recorded {}, replayed {}", row.tick, row.t, robot + 1,
                                 camera, value.name, value.recorded, value.again);
    return false;
  }
  return true;
}

/// Of one camera: `prefix` is "c2_", or nothing where there is one.
void compare_poses(const TickRecord& row, std::span<const core::Measurement> recorded,
                   std::span<const core::Measurement> again, const std::string& prefix, ReplayResult& result) {
  for (std::size_t i = 0; i < again.size(); ++i) {
    const core::Measurement &a = recorded[i], &b = again[i];
    ++result.poses;
    if (!a.ever_seen() && !b.ever_seen()) continue;  // not yet
    ++result.poses_exact;
    const Value values[] = {{"x_meas", a.pose.x, b.pose.x},
                            {"y_meas", a.pose.y, b.pose.y},
                            {"theta_meas", a.pose.theta, b.pose.theta},
                            {"t_meas", a.captured_at, b.captured_at},
                            {"sigma_xy", a.sigma_xy, b.sigma_xy},
                            {"sigma_theta", a.sigma_theta, b.sigma_theta}};
    result.poses_different += same(values, row, i, result, prefix) ? 0 : 1;
  }
}

/// What the poses of a film that cannot give them to the bit differ by from the recorded ones.
class FilmLoss {
 public:
  void add(std::span<const core::Measurement> recorded, std::span<const core::Measurement> seen, ReplayResult& result) {
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const core::Measurement &a = recorded[i], &b = seen[i];
      if (!a.ever_seen()) continue;  // this camera had not seen it yet
      ++result.poses;
      ++result.poses_approximate;
      if (a.captured_at != b.captured_at) {
        ++result.poses_missing;
        continue;
      }
      ++compared_;
      const double distance = core::math::hypot(b.pose.x - a.pose.x, b.pose.y - a.pose.y);
      const double turn = core::wrap_angle(b.pose.theta - a.pose.theta);
      squares_ += distance * distance;
      turns_ += turn * turn;
      result.pose_error_max = std::max(result.pose_error_max, distance);
    }
  }
  void finish(ReplayResult& result) const {
    if (compared_ == 0) return;
    result.pose_error_rms = std::sqrt(squares_ / static_cast<double>(compared_));
    result.heading_error_rms = std::sqrt(turns_ / static_cast<double>(compared_));
  }

 private:
  double squares_ = 0.0, turns_ = 0.0;
  std::int64_t compared_ = 0;
};

void compare(const TickRecord& recorded, const TickRecord& again, ReplayResult& result) {
  for (std::size_t i = 0; i < recorded.robots.size(); ++i) {
    const RobotRecord& a = recorded.robots[i];
    const RobotRecord& b = again.robots[i];
    const Value values[] = {{"v", a.command.v, b.command.v},
                            {"omega", a.command.omega, b.command.omega},
                            {"wheel_left", a.wheels.left, b.wheels.left},
                            {"wheel_right", a.wheels.right, b.wheels.right}};
    ++result.commands;
    result.different += same(values, recorded, i, result) ? 0 : 1;
  }
}

/// Compares a controller's present commands with the recorded ones. A robot that is out is not compared.
void compare_answers(const TickRecord& recorded, const OwnController& again, ReplayResult& result) {
  if (again.state() != ControllerState::answered) {
    ++result.answers_late;
    return;
  }
  for (std::size_t i = 0; i < recorded.robots.size(); ++i) {
    const core::Twist &a = recorded.robots[i].law, &b = again.law()[i];
    const Value values[] = {{"v_law", a.v, b.v}, {"omega_law", a.omega, b.omega}};
    ++result.answers;
    ReplayResult one;
    if ((std::isnan(a.v) && !std::isfinite(b.v + b.omega)) || same(values, recorded, i, one)) continue;
    ++result.answers_different;
    if (result.first_answer.empty()) result.first_answer = one.first;
  }
}

/// What a row needs to be shown and no file has.
void complete(TickRecord& row, const TickRecord& again) {
  row.phase = again.phase;
  row.staging_paused = again.staging_paused;
  row.pair_gains = again.pair_gains;  // older files have none
  for (std::size_t i = 0; i < row.robots.size(); ++i) {
    row.robots[i].k_x = again.robots[i].k_x;
    row.robots[i].k_theta = again.robots[i].k_theta;
    row.robots[i].margins = again.robots[i].margins;
  }
}

/// But for empty lines at their ends.
bool same_text(std::string_view a, std::string_view b) {
  const auto trimmed = [](std::string_view text) { return text.substr(0, text.find_last_not_of(" \n\r") + 1); };
  return trimmed(a) == trimmed(b);
}

/// `run`, if there is one, gets experiment and rows.
tl::expected<ReplayResult, std::string> replay_into(std::istream& csv, const std::string& file, const std::string& film,
                                                    bool controller, RecordedRun* run) {
  auto reader = CsvReader::open(csv, file);
  if (!reader) return tl::unexpected(reader.error());
  const std::string& version = reader->head().version;
  const auto unreadable = [&](std::string why) {  // a newer version may write what this one does not know
    if (!version.empty() && version != SKEIN_VERSION)
      why += fmt::format("; recorded by skein {}, read by " SKEIN_VERSION, version);
    return tl::unexpected(std::move(why));
  };
  const auto experiment = reader->experiment();
  if (!experiment) return unreadable(experiment.error());
  ReplayResult result;
  result.experiment = reader->head().name;
  if (!reader->head().intact)
    result.warnings.push_back("the experiment in the file has been changed since it was recorded");
  if (version != SKEIN_VERSION)
    result.warnings.push_back(fmt::format("recorded by skein {}, replayed by " SKEIN_VERSION, version));

  if (run) run->experiment = *experiment;
  const std::vector<std::string> paths = film_paths(*experiment, film);
  std::vector<ReplayFilm> films;  // of each camera
  for (std::size_t k = 0; !film.empty() && k < paths.size(); ++k) {
    auto opened = ReplayFilm::open(paths[k], *experiment);
    if (!opened) return tl::unexpected(camera_prefix(*experiment, k) + opened.error());
    films.push_back(std::move(*opened));
    if (const std::string of = films.back().experiment(); !of.empty() && !same_text(of, experiment->source))
      result.warnings.push_back(
          fmt::format("{} was recorded with another experiment than {}: it is the film of another "
                      "run",
                      paths[k], file));
    result.filmed = true;
    result.lossless = result.lossless && films.back().lossless();
  }

  std::unique_ptr<OwnController> asked;
  if (controller) {
    if (!experiment->controller.law.own())
      return tl::unexpected(file + ": --controller: the run had no controller of its own");
    Experiment here = *experiment;
    here.directory.clear();
    auto started = OwnController::start(here, /*waits=*/true);
    if (!started) return tl::unexpected(started.error());
    asked = std::move(*started);
    result.asked = true;
  }
  ControlTick tick(*experiment);
  FilmLoss loss;
  RecordedInput recorded(*experiment);
  const std::size_t robots = experiment->robots.size();
  std::vector<core::Measurement> filmed(films.size() * robots), inputs(filmed.size());
  TickRecord row;
  while (true) {
    const auto more = reader->next(row);
    if (!more) return unreadable(more.error());
    if (!*more) break;
    TickInput input = recorded.of(row);
    for (std::size_t k = 0; k < films.size(); ++k) {
      const auto measured = input.measurements.subspan(k * robots, robots);
      const auto seen = std::span(filmed).subspan(k * robots, robots),
                 used = std::span(inputs).subspan(k * robots, robots);
      if (const auto read = films[k].advance(measured, seen); !read)
        return tl::unexpected(camera_prefix(*experiment, k) + read.error());
      if (films[k].exact()) {
        compare_poses(row, measured, seen, films.size() > 1 ? fmt::format("c{}_", k + 1) : std::string(), result);
        std::copy(seen.begin(), seen.end(), used.begin());
      } else {
        loss.add(measured, seen, result);
        std::copy(measured.begin(), measured.end(), used.begin());
      }
    }
    if (!films.empty()) input.measurements = inputs;
    tick.see(input);
    if (asked) asked->heed(tick.record().events);
    if (const core::ControllerInput* const question = tick.ask(); asked && question) {
      asked->ask(*question);
      compare_answers(row, *asked, result);
    }
    const TickRecord& again = tick.decide(input);
    compare(row, again, result);
    if (run) {
      run->rows.push_back(row);
      complete(run->rows.back(), again);
    }
    ++result.ticks;
  }
  if (result.ticks == 0) return tl::unexpected(fmt::format("{}: it has no rows", file));  // of nothing nothing differs
  if (reader->torn()) result.warnings.push_back(*reader->torn());
  loss.finish(result);
  for (std::size_t k = 0; k < films.size(); ++k) {
    constexpr double unusual = 0.1;  // more than a frame's read-out [s]
    result.frames += films[k].frames();
    result.missing_frames += films[k].missing();
    if (films[k].missing() > 0)
      result.warnings.push_back(fmt::format("{} lacks {} frames that its recorder dropped",
                                            films.size() > 1 ? paths[k] : "the film", films[k].missing()));
    if (films[k].short_by() > unusual)
      result.warnings.push_back(fmt::format("{} ends {:.1f} s before the poses of its camera do",
                                            films.size() > 1 ? paths[k] : "the film", films[k].short_by()));
  }
  return result;
}

}  // namespace

tl::expected<ReplayResult, std::string> replay(std::istream& csv, const std::string& file, const std::string& film,
                                               bool controller) {
  return replay_into(csv, file, film, controller, nullptr);
}

namespace {

/// Whether a file has all bytes of another one at its beginning.
bool begins_with(const std::string& file, const std::string& beginning) {
  std::ifstream all(file, std::ios::binary), part(beginning, std::ios::binary);
  using Bytes = std::istreambuf_iterator<char>;
  return all && part && std::mismatch(Bytes(part), Bytes(), Bytes(all), Bytes()).first == Bytes();
}

}  // namespace

tl::expected<void, std::string> repair(const std::string& file) {
  if (const auto ours = check_is_file(file); !ours) return tl::unexpected(ours.error());
  std::ifstream in(file, std::ios::binary);
  if (!in) return tl::unexpected(fmt::format("{}: cannot be opened: {}", file, std::strerror(errno)));
  auto reader = CsvReader::open(in, file);
  if (!reader) return tl::unexpected(reader.error());
  TickRecord row;
  tl::expected<bool, std::string> more = true;
  while (more && *more) more = reader->next(row);
  if (!more) return tl::unexpected(more.error());
  if (!reader->torn()) return tl::unexpected(file + ": is complete, there is nothing to repair");
  const std::string torn = file + ".torn";
  std::error_code error;
  // A repair that was killed leaves another name of the file, or part of a copy: nothing that the file lacks.
  const bool left_over = std::filesystem::exists(torn, error);
  if (left_over && !begins_with(file, torn))
    return tl::unexpected(
        fmt::format("{}: already exists, and {} does not begin with what is in it: move it away, so that the original "
                    "can be kept under this name",
                    torn, file));
  auto whole = DiskWriter::open(file, {.force = true, .whole = true});
  if (!whole) return tl::unexpected(whole.error());
  in.clear();
  in.seekg(0);
  std::string block;
  for (std::uint64_t left = reader->whole_bytes(); left > 0; left -= block.size()) {
    block.resize(static_cast<std::size_t>(std::min<std::uint64_t>(left, 1 << 16)));
    if (!in.read(block.data(), static_cast<std::streamsize>(block.size())))
      return tl::unexpected(fmt::format("{}: reading failed: {}", file, std::strerror(errno)));
    if (!whole->write(block)) return tl::unexpected(whole->failure());
  }
  constexpr double patience = 60.0;  // [s]
  if (auto written = whole->flush(patience); !written) return written;
  // The torn file keeps a name: nothing is lost for good by a repair.
  if (left_over) std::filesystem::remove(torn, error);
  std::filesystem::create_hard_link(file, torn, error);
  if (error) std::filesystem::copy_file(file, torn, error);
  if (error) return tl::unexpected(fmt::format("{}: cannot be written: {}", torn, error.message()));
  whole->publish();
  return whole->finish(patience);
}

tl::expected<RecordedRun, std::string> load_run(const std::string& file) {
  if (const auto ours = check_is_file(file); !ours) return tl::unexpected(ours.error());
  std::ifstream in(file, std::ios::binary);
  if (!in) return tl::unexpected(fmt::format("{}: cannot be opened: {}", file, std::strerror(errno)));
  RecordedRun run;
  run.file = file;
  auto check = replay_into(in, file, {}, false, &run);
  if (!check) return tl::unexpected(check.error());
  run.check = std::move(*check);
  return run;
}

}  // namespace skein::app
