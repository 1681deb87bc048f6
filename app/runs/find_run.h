#pragma once

#include <string>

#include <tl/expected.hpp>

namespace skein::app {

/// The folder of a run: `word` is a path, or the name of a run in `directory`, or the unique beginning of a name;
/// "last": the newest. The error names the candidates.
tl::expected<std::string, std::string> find_run(const std::string& word, const std::string& directory);

/// The record of a run that a command line names: a CSV, or a run as find_run finds it.
struct RunRecord {
  std::string csv;
  std::string folder;  ///< of a kept run; empty: it is a CSV
  std::string name;    ///< for files made from it: beside a CSV; for a kept run, in the current folder
};
tl::expected<RunRecord, std::string> record_of(const std::string& word, const std::string& asked_directory);

}  // namespace skein::app
