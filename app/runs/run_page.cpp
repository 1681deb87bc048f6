#include "app/runs/run_page.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "app/runs/run_folder.h"

namespace skein::app {
namespace {

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

tl::expected<Page, std::string> page_of_run(const std::string& csv, const std::string& folder) {
  std::ifstream in(csv, std::ios::binary);
  if (!in) return tl::unexpected(fmt::format("{}: cannot be opened: {}", csv, std::strerror(errno)));
  PageOrigin origin;
  if (!folder.empty())
    if (const auto story = read_story(folder)) origin = origin_of(*story);
  return report_page(in, csv, origin);
}

}  // namespace skein::app
