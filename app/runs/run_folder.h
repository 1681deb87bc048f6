#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>
#include <tl/expected.hpp>

namespace skein::app {

/// The file names in a run's folder; docs/runs.md describes the files.
namespace run_files {
inline constexpr const char* story = "run.json";
inline constexpr const char* record = "run.csv";
inline constexpr const char* as_written = "experiment-as-written.toml";
inline constexpr const char* as_run = "experiment.toml";
inline constexpr const char* summary = "summary.json";
inline constexpr const char* film = "film.mkv";
inline constexpr const char* robots = "robots.toml";
}  // namespace run_files
/// The name of a camera's calibration, from 0, that was not beside the experiment: calibration.toml,
/// calibration-2.toml.
std::string kept_calibration(std::size_t camera);

/// The folder of kept runs: `asked`, else $SKEIN_RUNS, else $XDG_DATA_HOME/skein/runs, else ~/.local/share/skein/runs.
/// The error: none of these is there, since the user has no home.
tl::expected<std::string, std::string> runs_directory(const std::string& asked);

/// A sentence if the directory is the folder of a single run, to which other runs and an index would not belong.
std::optional<std::string> folder_of_a_run(const std::string& directory);

/// A sentence if less than `least` bytes are free for runs kept in this directory, which need not exist yet.
std::optional<std::string> little_room(const std::string& directory, std::uintmax_t least = 1'000'000'000);

/// The files below a run's folder, by their names there, sorted.
std::vector<std::string> files_of_run(const std::string& folder);

/// The room that the files of a run's folder take [bytes].
std::uintmax_t bytes_of_run(const std::string& folder);

/// The room that a run took when its run.json, of `story_bytes`, was written [bytes]; none: it does not say.
std::optional<std::uintmax_t> bytes_when_written(const nlohmann::ordered_json& story, std::uintmax_t story_bytes);

/// The run.json of a folder. The error is a sentence.
tl::expected<nlohmann::ordered_json, std::string> read_story(const std::string& folder);

/// The newest format of run.json, its key "format".
inline constexpr int story_format = 1;

/// The key of a run.json that says that the run's figures are being drawn: where it stays, the program was killed
/// meanwhile.
inline constexpr const char* figures_to_come = "figures_to_come";

/// The text of a run.json whose last value is a hash of all the others.
std::string sealed(nlohmann::ordered_json story);
/// Whether it is as sealed() wrote it, apart from blanks; none: it has no such hash.
std::optional<bool> seal_holds(nlohmann::ordered_json story);

/// The instant at which a run began, from its run.json, whatever the time zone [ns since 1970]. Empty: it does not say.
std::optional<std::int64_t> began_at(const nlohmann::ordered_json& story);

/// A number or a text of a run. A whole number that no double holds, such as a large seed, keeps its digits.
using RunValue = std::variant<double, std::int64_t, std::string>;

/// The text as a number if all of it is one; none: it is not.
std::optional<RunValue> number_of(std::string_view text);

/// The text that a run.json has at a key, or at a key of a table; empty: none, or something else than a text.
std::string text_at(const nlohmann::ordered_json& story, const char* key);
std::string text_at(const nlohmann::ordered_json& story, const char* table, const char* key);

/// The name of an experiment's calibration in the run's folder: its own, so that the experiment finds it there as it
/// did beside the file; kept_calibration() where that leads elsewhere or is the name of another file of the folder.
std::string calibration_in_folder(const std::string& name, std::size_t camera);

/// The searchable values of a run.json, as a flat list of keys; those below "experiment" and "summary" without that
/// prefix.
std::map<std::string, RunValue> run_facts(const nlohmann::ordered_json& story);

}  // namespace skein::app
