#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "tests/places.h"

namespace skein::app {

using Sets = std::vector<std::string>;

inline const std::string experiments = test::in_source("resources/experiments/");

/// What is said of a text that is no experiment.
inline std::vector<std::string> messages(const std::string& text, const Sets& sets = {}) {
  std::vector<std::string> result;
  if (const auto e = parse_experiment(text, "e.toml", sets); !e)
    for (const Problem& problem : e.error()) result.push_back(problem.message());
  return result;
}

/// The experiment of a text that is one.
inline Experiment good(const std::string& text, const Sets& sets = {}) {
  const auto e = parse_experiment(text, "e.toml", sets);
  if (e) return *e;
  ADD_FAILURE() << text << "\n" << e.error().front().message();
  return paper_experiment();
}

}  // namespace skein::app
