#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace skein::test {

/// One source file: its path from the project's root ("core/geometry/pose.h") and its text.
struct SourceFile {
  std::string path;
  std::string text;
};

/// The table of ARCHITECTURE.md: each folder, and the folders (or whole rooms) that its sources may include.
using Arrows = std::map<std::string, std::set<std::string, std::less<>>, std::less<>>;

/// Reads the block "```arrows" of a Markdown page, lines of the form "folder -> folder, folder". Throws
/// std::runtime_error where there is no such block, and on a line of another form.
Arrows arrows_of(std::string_view page);

/// Everything in `file` that the house rules of ARCHITECTURE.md forbid, one sentence each, with path and line.
std::vector<std::string> broken_rules(const SourceFile& file, const Arrows& arrows);

/// The cycles of includes among `files`, of units (a header with its source) and of folders, one sentence each.
std::vector<std::string> cycles_in(const std::vector<SourceFile>& files);

/// The places in `files` where `? :` chooses by one enumerator of an enumeration that they declare, one sentence each.
std::vector<std::string> choices_by_one_enumerator(const std::vector<SourceFile>& files);

/// The constants and functions at the left margin that two sources of one folder of `files` define alike, one sentence
/// each: a build that compiles both at once fails, and which does depends on the size of its batches.
std::vector<std::string> definitions_that_meet(const std::vector<SourceFile>& files);

/// The sources of one room, read from the disk.
std::vector<SourceFile> sources_of(const std::string& room);

/// The text of a file, its path relative to the project's root.
std::string text_of(const std::string& path);

}  // namespace skein::test
