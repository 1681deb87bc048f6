#pragma once

#include <string>
#include <string_view>

#include <tl/expected.hpp>

namespace skein::app {

/// A change of a text file that several programs may change, robots.toml or an experiment: begin, read, save. Another
/// program's change waits until this one ends and then reads its result, so no change is lost.
class FileChange {
 public:
  /// Waits for other changes to end; creates the file's directory. The error is a sentence.
  static tl::expected<FileChange, std::string> begin(const std::string& path);
  FileChange(FileChange&& other) noexcept;
  FileChange& operator=(FileChange&&) = delete;
  ~FileChange();  ///< without save(): the file stays as it is

  /// Writes the file atomically: a power cut leaves the old one or the new one. Once.
  tl::expected<void, std::string> save(std::string_view text);

 private:
  FileChange(std::string path, std::string target, int draft);
  std::string draft_path() const;

  std::string path_;    // as it was given
  std::string target_;  // the file itself, where the path is a link
  int draft_;           // locked; -1: saved or moved from
};

}  // namespace skein::app
