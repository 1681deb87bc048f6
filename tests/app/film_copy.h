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
  for (vision::Frame frame; (*film)->read(frame).value();) {
    frame.captured_at += later;
    if (std::find(dropped.begin(), dropped.end(), frame.index) == dropped.end()) (*copy)->add(frame);
  }
  EXPECT_EQ((*copy)->finish().problem, "");
}

}  // namespace skein::test
