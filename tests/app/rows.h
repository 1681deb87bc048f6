#pragma once

#include <string>
#include <vector>

#include "app/run/tick_record.h"

namespace skein::test {

/// Keeps every row of a run.
class Rows final : public app::RecordSink {
 public:
  void record(const app::TickRecord& record) override { rows.push_back(record); }

  /// How often an event of this kind happened.
  template <typename Kind>
  int count() const {
    int n = 0;
    for (const app::TickRecord& row : rows)
      for (const app::Event& event : row.events) n += app::is<Kind>(event) ? 1 : 0;
    return n;
  }
  template <typename Kind>
  bool has() const {
    return count<Kind>() > 0;
  }
  std::vector<const app::TickRecord*> all() const {
    std::vector<const app::TickRecord*> result;
    result.reserve(rows.size());
    for (const app::TickRecord& row : rows) result.push_back(&row);
    return result;
  }
  /// What the operator did, "TICK words" each.
  std::vector<std::string> actions() const {
    std::vector<std::string> result;
    for (const app::TickRecord& row : rows)
      for (const app::Event& event : row.events)
        if (app::is_action(event)) result.push_back(std::to_string(row.tick) + " " + app::describe(event));
    return result;
  }

  std::vector<app::TickRecord> rows;
};

}  // namespace skein::test
