#include "app/cli/command_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "app/experiment/experiment_sets.h"
#include "app/experiment/text_file.h"
#include "app/run/event.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/run/utf8.h"
#include "app/runs/find_run.h"
#include "app/runs/kept_run.h"
#include "app/runs/run_folder.h"
#include "app/runs/run_index.h"
#include "app/runs/run_removal.h"
#include "app/runs/verify.h"

namespace skein::app {
namespace {

using Json = nlohmann::ordered_json;
using Facts = std::map<std::string, RunIndex::Value>;

int refused(const std::string& sentence) {
  complain(sentence);
  return wrong_input;
}

std::string text(const RunIndex::Value& value) {
  return std::visit(Overloaded{[](double number) { return fmt::format("{}", number); },
                               [](std::int64_t whole) { return fmt::format("{}", whole); },
                               [](const std::string& words) { return words; }},
                    value);
}

Json json(const RunIndex::Value& value) {
  return std::visit([](const auto& v) { return Json(v); }, value);
}

std::string text(const Facts& facts, const std::string& key) {
  const auto found = facts.find(key);
  return found == facts.end() ? "" : text(found->second);
}

/// A value that may be as long as a trajectory, from its letter `from` on.
std::string in_brief(const std::string& value, std::size_t from) {
  constexpr std::size_t longest = 60;
  const std::string_view rest = std::string_view(value).substr(std::min(from, value.size()));
  const std::string_view shown = first_letters(rest, longest);
  return fmt::format("{}{}{}", from > 0 ? "..." : "", shown, shown.size() < rest.size() ? "..." : "");
}

/// From where on two values are to be shown, so that their difference is seen.
std::size_t before_difference(const std::string& a, const std::string& b) {
  constexpr std::size_t seen = 40, before = 20;  // bytes that are the same
  const auto same = static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
  return same <= seen ? 0 : first_letters(a, same - before).size();
}

/// Runs as a table, a line each.
void print_table(const std::vector<RunIndex::Run>& runs, const std::vector<std::string>& keys, bool as_json) {
  if (as_json) {
    Json all = Json::array();
    for (const RunIndex::Run& run : runs) {
      Json one{{"id", run.id}};
      for (const auto& [key, value] : run.facts) one[key] = json(value);
      all.push_back(std::move(one));
    }
    print_out(all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n", reader_patience);
    return;
  }
  std::vector<std::vector<std::string>> rows{{"run"}};
  rows[0].insert(rows[0].end(), keys.begin(), keys.end());
  for (const RunIndex::Run& run : runs) {
    std::vector<std::string>& row = rows.emplace_back(1, run.id);
    for (const std::string& key : keys) row.push_back(text(run.facts, key));
  }
  print_out(table(std::move(rows)), reader_patience);
}

const std::vector<std::string> usual_keys{"state",        "experiment.seed", "collisions",
                                          "min_distance", "final_error",     "megabytes"};

tl::expected<RunIndex, std::string> open_index(const RunsRequest& request) {
  auto index = runs_directory(request.directory).and_then([](const std::string& directory) {
    return RunIndex::open(directory);
  });
  if (index)
    for (const std::string& problem : index->problems()) complain(problem);
  return index;
}

tl::expected<std::string, std::string> folder_of(const std::string& run, const RunsRequest& request) {
  return runs_directory(request.directory).and_then([&](const std::string& directory) {
    return find_run(run, directory);
  });
}

/// A folder by the one name that it has, whichever way it was named.
std::string plain_path(const std::string& folder) {
  std::error_code error;
  const std::filesystem::path plain = std::filesystem::canonical(folder, error);
  return error ? folder : plain.string();
}

/// The same of a run, which among the kept runs may be a link to a run elsewhere: that has a name of its own.
std::string plain_run(const std::string& folder) {
  std::filesystem::path run(folder);
  if (!run.has_filename()) run = run.parent_path();
  if (std::error_code error; !std::filesystem::is_symlink(run, error)) return plain_path(folder);
  const std::string parent = run.parent_path().string();
  return (std::filesystem::path(plain_path(parent.empty() ? "." : parent)) / run.filename()).string();
}

/// All that a run's story says, flat, without its files. Its id is the folder's name, as in the index: a folder may
/// have been given another one.
Facts facts_of(const nlohmann::ordered_json& story, const std::string& folder) {
  Facts facts = run_facts(story);
  facts["id"] = std::filesystem::path(plain_run(folder)).filename().string();
  return facts;
}

tl::expected<Facts, std::string> facts_of(const std::string& run, const RunsRequest& request) {
  const auto folder = folder_of(run, request);
  if (!folder) return tl::unexpected(folder.error());
  const auto story = read_story(*folder);
  if (!story) return tl::unexpected(story.error());
  return facts_of(*story, *folder);
}

/// Adds what the experiments of two runs say otherwise, also where it is no fact of a run: kicks, paths, robots.
tl::expected<void, std::string> add_differences(const std::string& run_a, Facts& a, const std::string& run_b, Facts& b,
                                                const RunsRequest& request) {
  std::array<std::string, 2> texts;
  for (const auto& [run, text] : {std::pair(&run_a, &texts[0]), std::pair(&run_b, &texts[1])}) {
    const auto folder = folder_of(*run, request);
    if (!folder) return tl::unexpected(folder.error());
    auto read = read_text((std::filesystem::path(*folder) / run_files::as_run).string());
    if (!read) return tl::unexpected(read.error().front().message());
    *text = std::move(*read);
  }
  const auto add = [&](Facts& facts, const std::string& from, const std::string& to) {
    for (const std::string& set : sets_between(from, to)) {
      const std::string key = set.substr(0, set.find('=')), value = set.substr(key.size() + 1);
      if (value != "{}" && !facts.contains("experiment." + key)) facts.emplace(key, number_of(value).value_or(value));
    }
  };
  add(a, texts[1], texts[0]);
  add(b, texts[0], texts[1]);
  return {};
}

void keep_newest(std::vector<RunIndex::Run>& runs, std::size_t newest) {
  if (newest > 0 && runs.size() > newest) runs.erase(runs.begin(), runs.end() - static_cast<std::ptrdiff_t>(newest));
}

}  // namespace

int list_runs(const RunsRequest& request) {
  auto index = open_index(request);
  if (!index) return refused(index.error());
  if (const auto known = index->knows(request.show); !known) return refused(known.error());
  const std::vector<std::string>& keys = request.show.empty() ? usual_keys : request.show;
  std::vector<RunIndex::Run> runs = index->all(keys);
  keep_newest(runs, request.newest);
  print_table(runs, keys, request.json);
  return done;
}

int find_runs(const RunsRequest& request) {
  auto index = open_index(request);
  if (!index) return refused(index.error());
  if (request.keys) {
    std::string names;
    for (const std::string& key : index->keys()) names += key + "\n";
    print_out(names, reader_patience);
    return done;
  }
  const auto query = parse_query(request.query);
  if (!query) return refused(query.error());
  if (const auto known = index->knows(request.show); !known) return refused(known.error());
  const std::vector<std::string>& keys = request.show.empty() ? usual_keys : request.show;
  auto runs = index->find(*query, keys);
  if (!runs) return refused(runs.error());
  keep_newest(*runs, request.newest);
  print_table(*runs, keys, request.json);
  return runs->empty() ? expectation_failed : done;
}

int show_run(const RunsRequest& request) {
  const auto folder = folder_of(request.run, request);
  if (!folder) return refused(folder.error());
  const auto story = read_story(*folder);
  if (!story) return refused(story.error());
  if (request.json) {
    print_out(story->dump(2, ' ', false, Json::error_handler_t::replace) + "\n", reader_patience);
    return done;
  }
  std::string out = fmt::format("folder: {}\n", shown(*folder));
  for (const auto& [key, value] : facts_of(*story, *folder))
    out += fmt::format("{}: {}\n", shown(key), shown(text(value)));
  if (const auto sets = story->find("sets"); sets != story->end() && sets->is_array())
    for (const auto& set : *sets)
      if (set.is_string()) out += fmt::format("set: {}\n", shown(set.get<std::string>()));
  for (const std::string& name : files_of_run(*folder)) out += fmt::format("file: {}\n", shown(name));
  print_out(out, reader_patience);
  return done;
}

int compare_runs(const RunsRequest& request) {
  auto a = facts_of(request.run, request), b = facts_of(request.other, request);
  if (!a || !b) return refused(!a ? a.error() : b.error());
  if (const auto added = add_differences(request.run, *a, request.other, *b, request); !added)
    complain(fmt::format("{}; only values of run.json are compared", added.error()));
  std::set<std::string> keys;
  for (const Facts* const facts : {&*a, &*b})
    for (const auto& [key, value] : *facts) keys.insert(key);
  std::vector<std::vector<std::string>> rows{{"", text(*a, "id"), text(*b, "id")}};
  Json all = Json::object();
  std::size_t same = 0;
  for (const std::string& key : keys) {
    const std::string left = text(*a, key), right = text(*b, key);
    if (key == "id") continue;
    if (left == right) {
      ++same;
      continue;
    }
    const std::size_t from = before_difference(left, right);
    rows.push_back({key, in_brief(left, from), in_brief(right, from)});
    all[key] = {a->contains(key) ? json(a->at(key)) : Json(), b->contains(key) ? json(b->at(key)) : Json()};
  }
  if (request.json) {
    print_out(all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n", reader_patience);
    return done;
  }
  print_out(table(std::move(rows)) + fmt::format("{} other values are the same\n", same), reader_patience);
  return done;
}

int verify_runs(const RunsRequest& request) {
  const auto folder = folder_of(request.run, request);
  if (!folder) return refused(folder.error());
  const auto found = verify_run(*folder);
  if (!found) return refused(found.error());
  std::string out;
  for (const Verification::Step& step : found->steps)
    out += fmt::format("{}: {}, {}\n", step.what, step.holds ? "holds" : "FAILS", shown(step.finding));
  print_out(out, reader_patience);
  for (const std::string& note : found->notes) complain(note);
  return found->holds() ? done : expectation_failed;
}

int remove_runs(const RunsRequest& request) {
  if (request.runs.empty() && request.query.empty())
    return refused("no run is named, allowed: names of runs (`skein runs list`), or --where with a condition");
  std::vector<std::string> folders;
  for (const std::string& run : request.runs) {
    const auto folder = folder_of(run, request);
    if (!folder) return refused(folder.error());
    folders.push_back(*folder);
  }
  for (std::string& folder : folders) folder = plain_run(folder);
  if (!request.query.empty()) {
    auto index = open_index(request);
    if (!index) return refused(index.error());
    const auto query = parse_query(request.query);
    if (!query) return refused(query.error());
    const auto runs = index->find(*query, {});
    if (!runs) return refused(runs.error());
    const std::filesystem::path place = plain_path(*runs_directory(request.directory));
    for (const std::string& folder : folders)
      if (std::filesystem::path(folder).parent_path() != place)
        return refused(fmt::format("{}: is not in {}, allowed with --where: runs in there", folder, place.string()));
    std::vector<std::string> fitting;
    for (const RunIndex::Run& run : *runs) fitting.push_back((place / run.id).string());
    // With names: those of them for which the condition holds.
    if (!request.runs.empty())
      std::erase_if(fitting, [&](const std::string& folder) {
        return std::find(folders.begin(), folders.end(), folder) == folders.end();
      });
    folders = std::move(fitting);
  }
  std::sort(folders.begin(), folders.end());
  folders.erase(std::unique(folders.begin(), folders.end()), folders.end());

  std::string out;
  std::uintmax_t bytes = 0;
  std::size_t runs = 0;
  int status = done;
  for (const std::string& folder : folders) {
    std::error_code ignored;
    const bool is_link = std::filesystem::is_symlink(folder, ignored);
    const std::uintmax_t room = is_link ? 0 : bytes_of_run(folder);
    const std::string stays = is_link ? fmt::format(", a link; {} stays", shown(plain_path(folder))) : std::string();
    if (request.yes)
      if (const auto removed = remove_run(folder); !removed) {
        complain(removed.error());
        status = device_failed;
        continue;
      }
    out += fmt::format("{}: {:.1f} MB{}\n", shown(folder), static_cast<double>(room) / 1e6, stays);
    bytes += room, ++runs;
  }
  const std::string all =
      fmt::format("{} run{}, {:.1f} MB", runs, runs == 1 ? "" : "s", static_cast<double>(bytes) / 1e6);
  print_out(out + all +
                (request.yes ? " removed\n"
                 : runs > 0  ? "; --yes removes them\n"
                             : ": there is none to remove\n"),
            reader_patience);
  return status;
}

}  // namespace skein::app
