#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/pgm.h"
#include "tests/places.h"
#include "vision/frames/frame.h"

namespace skein::test {

using vision::Frame;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitized = true;  // 5 to 15 times slower: slow tests take fewer frames
#else
inline constexpr bool sanitized = false;
#endif

/// Where real pictures are, if there are any (see real_data_test).
inline std::string real_data() {
  const char* named = std::getenv("SKEIN_REAL_DATA");
  return named != nullptr ? named : test::in_source("../shared/data");
}

/// A folder of its own for a test, gone when the test is over.
class Folder {
 public:
  Folder() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            (std::string("skein_") + test->test_suite_name() + "_" + test->name() + "_" + std::to_string(getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string path() const { return path_.string(); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

inline void write_file(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

inline Frame uniform_frame(int width, int height, std::uint8_t grey) {
  Frame frame;
  frame.resize(width, height);
  std::fill(frame.grey.begin(), frame.grey.end(), grey);
  return frame;
}

/// A table as `skein track` writes it (without quoted cells): one map from column to text a row.
inline std::vector<std::map<std::string, std::string>> read_csv(const std::string& text) {
  const auto split = [](const std::string& line) {
    std::vector<std::string> cells(1);
    for (const char c : line) {
      if (c == ',') {
        cells.emplace_back();
      } else {
        cells.back() += c;
      }
    }
    return cells;
  };
  std::istringstream in(text);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> header = split(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = split(line);
    EXPECT_EQ(cells.size(), header.size()) << line;
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(cells.size(), header.size()); ++i) row[header[i]] = cells[i];
  }
  return rows;
}

}  // namespace skein::test
