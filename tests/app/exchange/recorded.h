#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/session/session.h"
#include "tests/app/folder.h"
#include "tests/app/rows.h"

namespace skein::test {

/// A run of the paper's platoon, shortened, with its CSV.
struct Recorded {
  app::Experiment experiment;
  std::vector<app::TickRecord> rows;
  std::string csv;

  explicit Recorded(const std::vector<std::string>& sets = {"duration=2", "simulation.dropout=0.2"}) {
    experiment = app::parse_experiment(app::paper_experiment().source, "platoon.toml", sets).value();
    std::ostringstream text;
    Rows kept;
    app::CsvWriter writer(text, experiment);
    auto session = app::Session::open(experiment, app::Session::Clock::virtual_, {false, {&writer, &kept}});
    (*session)->run();
    (*session)->close();
    rows = std::move(kept.rows);
    csv = text.str();
  }
};

}  // namespace skein::test
