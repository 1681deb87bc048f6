#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::app {

/// The result of replaying a recorded run through the same tick.
struct ReplayResult {
  std::string experiment;  ///< its name
  std::int64_t ticks = 0;
  std::int64_t commands = 0;           ///< compared: one per robot and tick
  std::int64_t different = 0;          ///< that did not come out bit for bit
  bool filmed = false;                 ///< the poses came from a film
  std::int64_t frames = 0;             ///< processed frames of the film
  std::int64_t missing_frames = 0;     ///< dropped by its recorder
  std::int64_t poses = 0;              ///< compared: one per robot and tick
  std::int64_t poses_different = 0;    ///< that did not come out bit for bit
  std::int64_t poses_exact = 0;        ///< of poses: seen, and compared bit for bit
  bool lossless = true;                ///< the film
  std::int64_t poses_approximate = 0;  ///< of poses: not from a lossless film, or after a frame that it lacks
  std::int64_t poses_missing = 0;      ///< of poses_approximate: the film does not yield them for the same frame
  double pose_error_rms = 0.0;         ///< of the others of them: their distance from the recorded ones [m]
  double pose_error_max = 0.0;         ///< [m]
  double heading_error_rms = 0.0;      ///< [rad]
  bool asked = false;                  ///< the run's own controller was started again, with the same questions
  std::int64_t answers = 0;            ///< compared: one per robot and tick
  std::int64_t answers_different = 0;  ///< from v_law, omega_law, bit for bit
  std::int64_t answers_late = 0;       ///< ticks
  std::string first_answer;            ///< the first of them, and its place
  std::string first;                   ///< the first difference, and its place; empty: there is none
  std::vector<std::string> warnings;

  /// Whether its film shows none of the run's poses, or others, as that of another run does.
  bool other_film() const noexcept {
    constexpr double other_poses = 0.01;  // more than losses and missing frames do [m]
    const bool yields_none = poses_exact == 0 && poses_missing == poses_approximate;
    return poses_approximate > 0 && (yields_none || pose_error_rms > other_poses);
  }
};

/// Feeds the measurements, times and operator's commands of a run's CSV to a new tick and compares every command (v,
/// omega and both wheels) with the recorded one. `file` is the stream's name in messages. The error has the place of
/// invalid input.
/// With the film of the run (`skein run --video`; of several cameras the first one's, film_paths names the others), the
/// measurements come from it instead, through the same tracker, and are compared with the recorded ones too. From a
/// film that is not lossless, and after a frame that the recorder dropped, poses are only compared (`pose_error_rms`),
/// and commands come from the recorded ones. Empty: none.
/// The answers of the run's own controller are taken from the record. With `controller` that controller is also
/// started, in the current directory, asked again, and its answers are compared with the recorded ones.
tl::expected<ReplayResult, std::string> replay(std::istream& csv, const std::string& file, const std::string& film = {},
                                               bool controller = false);

/// Removes the torn last row of a run's CSV; the torn file stays as FILE.torn. The error: there is nothing to repair,
/// or it is not possible.
tl::expected<void, std::string> repair(const std::string& file);

/// A recorded run with everything that the window shows.
struct RecordedRun {
  std::string file;
  Experiment experiment;         ///< as the file embeds it
  std::vector<TickRecord> rows;  ///< as recorded; phase, margins and tracking gains, which no file has, as replayed
  ReplayResult check;
};

/// Reads a run and replays it. The error names invalid input and its place.
tl::expected<RecordedRun, std::string> load_run(const std::string& file);

}  // namespace skein::app
