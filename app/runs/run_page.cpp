#include "app/runs/run_page.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "app/runs/run_folder.h"

namespace skein::app {
namespace {

/// A file that lies in this folder itself; empty: there is none of this name.
std::string bytes_in(const std::filesystem::path& folder, const std::filesystem::path& name) {
  // Whatever run.json says: no file outside the folder gets into the page.
  std::error_code ignored;
  if (name.has_parent_path() || !std::filesystem::is_regular_file(folder / name, ignored)) return {};
  std::ifstream file(folder / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::vector<PageCrop> crops_of(const nlohmann::ordered_json& story, const std::string& folder) {
  std::vector<PageCrop> crops;
  const auto found = story.find("not_seen");
  if (found == story.end() || !found->is_array()) return crops;
  for (const auto& tag : *found) {
    const auto robot = tag.is_object() ? tag.find("robot") : tag.end();
    if (robot == tag.end() || !robot->is_number_unsigned() || robot->get<std::size_t>() == 0) continue;
    crops.push_back({robot->get<std::size_t>() - 1, text_at(tag, "sentence"), bytes_in(folder, text_at(tag, "file"))});
  }
  return crops;
}

/// What the story of a kept run says beside its record.
PageOrigin origin_of(const nlohmann::ordered_json& story, const std::string& folder) {
  PageOrigin origin;
  const std::string commit = text_at(story, "program", "commit");
  origin.sentence =
      fmt::format("Run {} of {}, on {} ({}), by skein {}{}.", text_at(story, "id"), text_at(story, "began"),
                  text_at(story, "machine", "host"), text_at(story, "machine", "cpu"),
                  text_at(story, "program", "version"), commit.empty() ? "" : ", commit " + commit);
  if (story.contains("problems") && story["problems"].is_array())
    for (const auto& problem : story["problems"])
      if (problem.is_string()) origin.problems.push_back(problem.get<std::string>());
  origin.crops = crops_of(story, folder);
  return origin;
}

}  // namespace

tl::expected<Page, std::string> page_of_run(const std::string& csv, const std::string& folder,
                                            const std::vector<TagCrop>& crops) {
  std::ifstream in(csv, std::ios::binary);
  if (!in) return tl::unexpected(fmt::format("{}: cannot be opened: {}", csv, std::strerror(errno)));
  PageOrigin origin;
  std::vector<std::string> warnings;
  if (!folder.empty()) {
    if (const auto story = read_story(folder))
      origin = origin_of(*story, folder);
    else
      warnings.push_back(story.error() + "; the page says nothing of it");
  }
  for (const TagCrop& crop : crops)
    origin.crops.push_back({crop.robot, crop.sentence, bytes_in(std::filesystem::path(csv).parent_path(), crop.file)});
  auto page = report_page(in, csv, origin);
  if (page) page->warnings.insert(page->warnings.begin(), warnings.begin(), warnings.end());
  return page;
}

}  // namespace skein::app
