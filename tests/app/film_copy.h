#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "vision/recording/recorder.h"
#include "vision/sources/open_source.h"

namespace skein::test {

/// A copy of a film without some of its frames, as a recorder leaves it whose encoder or disk is too slow; taken
/// `later`. [s]
inline void copy_film(const std::string& from, const std::string& to, const std::vector<std::int64_t>& dropped,
                      double later = 0.0) {
  auto film = vision::open_source("video:" + from);
  ASSERT_TRUE(film) << film.error();
  auto copy = vision::Recorder::open(to, (*film)->notes());
  ASSERT_TRUE(copy) << copy.error();
  std::size_t lacking = 0;
  for (vision::Frame frame; (*film)->read(frame).value();) {
    frame.captured_at += later;
    if (std::find(dropped.begin(), dropped.end(), frame.index) == dropped.end())
      (*copy)->add(frame);
    else
      ++lacking;
  }
  EXPECT_EQ(lacking, dropped.size()) << "frames that the film does not have";
  EXPECT_EQ((*copy)->finish().problem, "");
}

/// How many frames a film has: fewer than its camera took where the machine was busy.
inline std::int64_t frames_of(const std::string& path) {
  auto film = vision::open_source("video:" + path);
  EXPECT_TRUE(film) << film.error();
  std::int64_t frames = 0;
  for (vision::Frame frame; film && (*film)->read(frame).value();) ++frames;
  return frames;
}

}  // namespace skein::test
