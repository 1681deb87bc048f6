#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "app/cli/command_runs.h"
#include "app/experiment/text_file.h"
#include "app/page/report_page.h"
#include "app/record/disk_writer.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/runs/kept_run.h"
#include "app/runs/run_folder.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

/// What the story of a kept run says beside its record.
PageOrigin origin_of(const nlohmann::ordered_json& story) {
  PageOrigin origin;
  const auto text = [&](const char* table, const char* key) {
    return story.contains(table) && story[table].is_object() ? story[table].value(key, std::string()) : std::string();
  };
  const std::string commit = text("program", "commit");
  origin.sentence = fmt::format("Run {} of {}, on {} ({}), by skein {}{}.", story.value("id", std::string()),
                                story.value("began", std::string()), text("machine", "host"), text("machine", "cpu"),
                                text("program", "version"), commit.empty() ? "" : ", commit " + commit);
  if (story.contains("problems") && story["problems"].is_array())
    for (const auto& problem : story["problems"])
      if (problem.is_string()) origin.problems.push_back(problem.get<std::string>());
  return origin;
}

}  // namespace

int write_page(const PageRequest& request) {
  const auto refused = [](const std::string& sentence) {
    complain(sentence);
    return wrong_input;
  };
  const auto record = record_of(request.run, request.directory);
  if (!record) return refused(record.error());
  std::ifstream csv(record->csv, std::ios::binary);
  if (!csv) return refused(fmt::format("{}: cannot be opened: {}", record->csv, std::strerror(errno)));
  PageOrigin origin;
  if (!record->folder.empty())
    if (const auto story = read_story(record->folder)) origin = origin_of(*story);
  const auto page = report_page(csv, record->csv, origin);
  if (!page) return refused(page.error());
  for (const std::string& warning : page->warnings) complain(warning);

  const std::string out = request.out.empty() ? fs::path(record->name).replace_extension("html").string() : request.out;
  constexpr double patience = 60.0;  // [s]
  auto disk = DiskWriter::open(out, {.force = request.force});
  if (!disk) return refused(disk.error());
  if (!disk->write(page->html)) return refused(disk->failure());
  disk->publish();
  if (const auto written = disk->finish(patience); !written) return refused(written.error());
  print_out(fmt::format("file: {}\n", out));
  return done;
}

}  // namespace skein::app
