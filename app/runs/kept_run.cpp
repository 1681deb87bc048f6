#include "app/runs/kept_run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/controllers/own_controller.h"
#include "app/embedded/embedded.h"
#include "app/experiment/experiment_keys.h"
#include "app/experiment/experiment_sets.h"
#include "app/experiment/file_change.h"
#include "app/experiment/text_file.h"
#include "app/record/report.h"
#include "app/run/version.h"
#include "app/runs/machine.h"
#include "app/runs/run_folder.h"
#include "app/runs/sha256.h"
#include "app/session/camera_film.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Done = tl::expected<void, std::string>;

/// Letters, digits, - and _ of a name, for that of a folder.
std::string slug(const std::string& name) {
  constexpr std::size_t longest = 40;
  std::string result;
  for (const char c : name.substr(0, longest)) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
    if (plain || !result.ends_with('-')) result += plain ? c : '-';
  }
  return result.empty() ? "run" : result;
}

/// std::filesystem's copy_file says of a full disk that it has an input/output error.
Done keep_copy(const fs::path& from, const fs::path& to) {
  if (auto is_file = check_is_file(from.string()); !is_file) return is_file;
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  const auto failed = [&] {
    const int why = errno;
    return tl::unexpected(
        fmt::format("{}: cannot be copied to {}: {}", from.string(), to.string(), std::strerror(why)));
  };
  const int in = ::open(from.c_str(), O_RDONLY | O_CLOEXEC);
  if (in < 0) return failed();
  const int out = ::open(to.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  Done done;
  std::vector<char> block(std::size_t{1} << 20);
  if (out < 0) done = failed();
  for (ssize_t size = 1; done && size > 0;) {
    size = ::read(in, block.data(), block.size());
    if (size < 0) done = failed();
    for (ssize_t written = 0; done && written < size;)
      if (const ssize_t more = ::write(out, block.data() + written, static_cast<std::size_t>(size - written)); more > 0)
        written += more;
      else
        done = failed();
  }
  if (out >= 0 && ::close(out) != 0 && done) done = failed();
  ::close(in);
  if (!done && out >= 0) fs::remove(to, error);  // half of it would fill a full disk for nothing
  return done;
}

/// A file that holds room for the results while the run goes on: its record, or its film, may fill the disk.
constexpr const char* reserve = ".room";

void hold_room(const fs::path& folder) {
  // run.json and summary.json, each beside its draft: of 64 robots, or, where there is too little for that, of a few.
  constexpr std::array<off_t, 2> rooms{256 << 10, 32 << 10};  // [bytes]
  const fs::path file = folder / reserve;
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) return;
  const bool held =
      std::any_of(rooms.begin(), rooms.end(), [&](off_t room) { return ::posix_fallocate(descriptor, 0, room) == 0; });
  ::close(descriptor);
  if (std::error_code ignored; !held) fs::remove(file, ignored);
}

/// A number as one, true and false as such, all else as a text.
Json value_of(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  if (text == "none") return nullptr;
  if (const auto number = number_of(text)) return std::visit([](const auto& value) { return Json(value); }, *number);
  return text;
}

Json json(const MachineDescription& machine) {
  return {{"host", machine.host},
          {"kernel", machine.kernel},
          {"architecture", machine.architecture},
          {"cpu", machine.cpu},
          {"cores", machine.cores},
          {"governor", machine.governor},
          {"realtime_kernel", machine.realtime_kernel},
          {"realtime_priority", machine.realtime_priority}};
}

/// The summary's lines, "key: value", as an object.
Json summary_object(const Statistics::Summary& summary) {
  Json result = Json::object();
  const std::string lines = as_lines(summary);
  for (std::size_t at = 0; at < lines.size();) {
    const std::size_t end = lines.find('\n', at), colon = lines.find(": ", at);
    if (colon < end) result[lines.substr(at, colon - at)] = value_of(lines.substr(colon + 2, end - colon - 2));
    at = end + 1;
  }
  return result;
}

/// The file's size and hash, into run.json's `files`.
Done note_file(Json& files, const fs::path& folder, const std::string& name) {
  const auto hash = sha256_of_file((folder / name).string());
  if (!hash) return tl::unexpected(hash.error());
  files[name] = {{"bytes", fs::file_size(folder / name)}, {"sha256", *hash}};
  return {};
}

/// A new folder, which no other run uses.
tl::expected<std::string, std::string> new_folder(const std::string& directory, const std::string& name) {
  if (auto refused = folder_of_a_run(directory)) return tl::unexpected(*std::move(refused));
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) {
    std::error_code no_link;
    const fs::path target = fs::read_symlink(directory, no_link);  // of one that leads nowhere EEXIST tells nothing
    return tl::unexpected(
        fmt::format("{}: cannot be made: {}", directory,
                    no_link ? error.message() : "it is a link to " + target.string() + ", which is no folder"));
  }
  for (int number = 1;; ++number) {
    const std::string folder =
        (fs::path(directory) / (number == 1 ? name : fmt::format("{}-{}", name, number))).string();
    if (::mkdir(folder.c_str(), 0777) == 0) return folder;
    if (errno != EEXIST) return tl::unexpected(fmt::format("{}: cannot be made: {}", folder, std::strerror(errno)));
  }
}

/// Files that the experiment file names: where they are, and their names in the run's folder.
std::vector<std::pair<fs::path, std::string>> inputs(const std::string& text, const std::vector<std::string>& sets,
                                                     const Experiment& experiment) {
  std::vector<std::pair<fs::path, std::string>> files;
  const auto take = [&](const std::string& name, std::string as) {
    if (!name.empty()) files.emplace_back(fs::path(experiment.directory) / name, std::move(as));
  };
  for (std::size_t k = 0; k < experiment.cameras(); ++k)
    take(experiment.camera_at(k).calibration, calibration_in_folder(experiment.camera_at(k).calibration, k));
  try {
    toml::table document = toml::parse(text);
    std::vector<Problem> refused_before;
    apply_sets(document, sets, refused_before);
    take(document["robots_file"].value_or<std::string>(""), run_files::robots);
    if (const toml::array* const robots = document["robot"].as_array())
      for (std::size_t i = 0; i < robots->size(); ++i)
        if (const toml::table* const robot = robots->get(i)->as_table())
          take((*robot)["trajectory"]["csv"].value_or<std::string>(""), fmt::format("trajectory-{}.csv", i + 1));
  } catch (const toml::parse_error&) {
    // it has been read before: a file that has changed meanwhile is kept as it is
  }
  // A controller's own files: its library, and those that its command names in the experiment's folder.
  std::vector<std::string> words{experiment.controller.law.library};
  if (auto of_command = words_of(experiment.controller.law.command))
    words.insert(words.end(), of_command->begin(), of_command->end());
  for (const std::string& word : words) {
    const fs::path name = fs::path(word).lexically_normal();
    const bool here = calibration_in_folder(word, 0) == name;  // not one of another folder, or of the run's own names
    if (std::error_code ignored; here && fs::is_regular_file(fs::path(experiment.directory) / name, ignored))
      take(name.string(), name.string());
  }
  return files;
}

bool is_inside(const std::string& folder, const std::string& file) {
  std::error_code not_there;
  return !folder.empty() && fs::equivalent(fs::absolute(file, not_there).parent_path(), folder, not_there);
}

}  // namespace

std::vector<std::string> files_named_by(const std::string& text, const std::vector<std::string>& sets,
                                        const Experiment& experiment) {
  std::vector<std::string> files;
  for (const auto& [from, as] : inputs(text, sets, experiment)) files.push_back(from.string());
  return files;
}

std::map<std::string, std::string> experiment_facts(const Experiment& experiment) {
  std::map<std::string, std::string> facts;
  for (const ExperimentKey& key : experiment_keys())
    if (std::string value = shown_value(key, experiment); !value.empty())
      facts[*key.table ? key.name() : "experiment." + key.name()] = std::move(value);
  for (const core::GainName gain : core::gain_names)
    facts[fmt::format("controller.gains.{}", word(gain))] =
        fmt::format("{}", core::table(experiment.controller.gains, gain).largest());
  facts["experiment.robots"] = fmt::format("{}", experiment.robots.size());
  facts["experiment.obstacles"] = fmt::format("{}", experiment.obstacles.size());
  return facts;
}

std::optional<std::string> wrong_clock() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  constexpr int first = 2020, end = 2262;
  if (::gmtime_r(&now, &utc) != nullptr && utc.tm_year + 1900 >= first && utc.tm_year + 1900 < end) return {};
  return fmt::format("says that it is the year {}", utc.tm_year + 1900);
}

tl::expected<KeptRun, std::string> KeptRun::begin(const KeepRequest& request, const Experiment& experiment) {
  const auto now = request.clock ? request.clock() : std::chrono::system_clock::now();
  std::string text = request.text.empty() ? std::string(embedded::platoon_toml) : request.text;
  if (!request.experiment.empty()) {
    auto read = read_text(request.experiment);
    if (!read) return tl::unexpected(read.error().front().message());
    text = std::move(*read);
  }
  const auto made = new_folder(request.directory, time_for_name(now) + '_' + slug(experiment.name));
  if (!made) return tl::unexpected(made.error());
  const fs::path folder = *made;

  Json inputs_used = Json::object();
  Done written = write_file(folder / run_files::as_written, text);
  if (written) written = write_file(folder / run_files::as_run, experiment.source);
  for (const auto& [from, as] : inputs(text, {}, experiment)) {
    if (written) written = keep_copy(from, folder / as);
    inputs_used[as] = from.lexically_normal().string();
  }

  Json facts = Json::object();
  for (const auto& [key, value] : experiment_facts(experiment)) facts[key] = value_of(value);
  const Json head{{"format", story_format},
                  {"id", folder.filename().string()},
                  {"name", experiment.name},
                  {"state", "begun"},
                  {"began", local_time(now)},
                  {"program", {{"version", SKEIN_VERSION}, {"commit", commit()}, {"words", request.words}}},
                  {"machine", json(describe_machine())},
                  {"clock", request.real_time ? "wall" : "virtual"},
                  {"sets", request.sets},
                  {"inputs", inputs_used},
                  {"experiment", facts}};
  std::string begun = sealed(head);
  if (written) written = write_file(folder / run_files::story, begun);
  if (!written) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);  // nothing began
    return tl::unexpected(written.error());
  }
  hold_room(folder);
  return KeptRun(folder.string(), experiment, std::move(begun), now);
}

Done KeptRun::end(const Statistics::Summary& summary, const End& how) {
  const fs::path folder(folder_);
  Done complete;
  const auto note = [&](Done done) {
    if (!done && complete) complete = std::move(done);
  };
  std::error_code none_held;
  fs::remove(folder / reserve, none_held);
  note(write_file(folder / run_files::summary, as_json(summary) + '\n'));
  if (!how.film.empty()) {
    const std::vector<std::string> films = film_paths(experiment_, how.film);
    const std::vector<std::string> names = film_paths(experiment_, folder / run_files::film);
    for (std::size_t k = 0; k < films.size(); ++k) {
      std::error_code error;
      const fs::path film = fs::canonical(films[k], error);     // a second name of a link would lead nowhere
      if (!error) fs::create_hard_link(film, names[k], error);  // of the same bytes, where that can be
      if (error) note(keep_copy(films[k], names[k]));
    }
  }

  Json story = Json::parse(head_);
  story["state"] = !summary.failure.empty() ? "failed" : summary.stopped ? "stopped" : "finished";
  const auto lasted = std::chrono::steady_clock::now() - since_;
  story["ended"] = local_time(began_ + std::chrono::duration_cast<std::chrono::system_clock::duration>(lasted));
  story["exit_status"] = how.exit_status;
  story["problems"] = how.problems;
  for (const std::string& set : how.sets) story["sets"].push_back(set);
  for (const TagCrop& crop : how.crops)
    story["not_seen"].push_back({{"robot", crop.robot + 1}, {"sentence", crop.sentence}, {"file", crop.file}});
  story["summary"] = summary_object(summary);
  const auto write_story = [&](Json files) {
    for (const std::string& name : files_of_run(folder_))
      if (name != run_files::story && !files.contains(name)) note(note_file(files, folder, name));
    story["files"] = std::move(files);
    return write_file(folder / run_files::story, sealed(story));
  };
  // Drawing comes last: it takes a while, in which the program may be killed, and figures may fill the disk.
  Done possible = check_report(folder_);
  std::error_code none_yet;
  const bool recorded = fs::exists(folder / run_files::record, none_yet);  // a run that never began has no figures
  if (possible && recorded) story[figures_to_come] = true;
  Done written = write_story(Json::object());
  complete_ = written.has_value();
  note(std::move(written));
  const Json without_figures = story["files"];
  if (!possible || !recorded || !complete_)
    note(std::move(possible));
  else {
    story.erase(figures_to_come);
    note(write_report(folder_, experiment_, summary));
    if (Done with_figures = write_story(without_figures); !with_figures) {
      note(std::move(with_figures));
      for (const std::string& name : files_of_run(folder_))  // else they would not belong to the run
        if (std::error_code ignored; name != run_files::story && !without_figures.contains(name))
          fs::remove(folder / name, ignored);
      note(write_story(without_figures));  // the one that is there promises figures
    }
  }
  return complete;
}

void remove_film(const Experiment& experiment, const std::string& film) {
  for (const std::string& path : film_paths(experiment, film)) {
    std::error_code gone_already;
    fs::remove(path, gone_already);
  }
}

Done add_to_kept_run(const std::string& folder, const std::vector<std::string>& files) {
  if (const auto is_run = read_story(folder); !is_run) return tl::unexpected(is_run.error());
  auto change = FileChange::begin(fs::path(folder) / run_files::story);  // another program may be adding files as well
  if (!change) return tl::unexpected(change.error());
  auto story = read_story(folder);
  if (!story) return tl::unexpected(story.error());
  if (!story->contains("files") || !(*story)["files"].is_object())
    return tl::unexpected(fmt::format("{}: its run did not end, allowed: the folder of a run that did", folder));
  if (seal_holds(*story) == false)  // a new seal would hide it
    return tl::unexpected(fmt::format("{}/{}: was changed after the run: nothing is added", folder, run_files::story));
  for (const std::string& name : files) {
    if (Done noted = note_file((*story)["files"], folder, name); !noted) return noted;
    (*story)["files"][name]["added"] = true;
  }
  return change->save(sealed(std::move(*story)));
}

Done add_if_inside(const std::string& folder, const std::string& file) {
  if (!is_inside(folder, file)) return {};
  const auto story = read_story(folder);
  if (!story || !story->contains("files") || seal_holds(*story) == false) return {};  // whatever is added, it fails
  return add_to_kept_run(folder, {fs::path(file).filename().string()});
}

bool is_of_run(const std::string& folder, const std::string& file) {
  if (!is_inside(folder, file)) return false;
  const std::string name = fs::path(file).filename().string();
  if (name == run_files::story) return true;
  const auto story = read_story(folder);
  const Json files = story ? story->value("files", Json()) : Json();
  return files.is_object() && files.contains(name) && !(files[name].is_object() && files[name].contains("added"));
}

}  // namespace skein::app
