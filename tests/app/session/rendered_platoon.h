#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/rows.h"

namespace skein::test {

/// A run of the paper's platoon in rendered pictures, without disturbances, and what the operator is told in it.
struct RenderedPlatoon {
  explicit RenderedPlatoon(double duration, std::vector<std::string> sets = {}) {
    sets.push_back("duration=" + std::to_string(duration));
    for (const char* set : {"camera.source=synthetic", "perturb=[]", "expect={}"}) sets.emplace_back(set);
    auto session = app::Session::open(app::good(app::paper_experiment().source, sets), app::Session::Clock::virtual_,
                                      {false, {&sink}});
    EXPECT_TRUE(session) << session.error();
    const auto listen = [&] {
      for (std::string& sentence : (*session)->alarms()) told.push_back(std::move(sentence));
      down = down || !(*session)->camera_status().down.empty();
      return true;
    };
    end = (*session)->run(listen);
    listen();
    outages = (*session)->camera().outages;
    (*session)->close();
    failure = (*session)->failure().value_or("");
  }
  Rows sink;
  app::Phase end = app::Phase::ready;
  std::vector<std::string> told;
  bool down = false;  // the camera, at any time
  std::int64_t outages = 0;
  std::string failure;
};

}  // namespace skein::test
