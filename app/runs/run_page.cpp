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
  const std::string commit = text_at(story, "program", "commit");
  origin.sentence =
      fmt::format("Run {} of {}, on {} ({}), by skein {}{}.", text_at(story, "id"), text_at(story, "began"),
                  text_at(story, "machine", "host"), text_at(story, "machine", "cpu"),
                  text_at(story, "program", "version"), commit.empty() ? "" : ", commit " + commit);
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
