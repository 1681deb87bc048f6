#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "app/record/csv_writer.h"

namespace skein::app {

/// The rows of a run as JSON datagrams. Each is a whole object, fits into one Ethernet frame, and has the row's time:
///
///     {"timestamp":12.04,"t":12,"V":0.31,...}      {"timestamp":12.04,"r1":{"x":0.1,"y":0.2,...}}
///
/// A row takes as many datagrams as necessary. Keys are the CSV's columns, those of a robot below its name; a key
/// without a value is left out. `timestamp` is the column `now`. One thread.
class Datagrams {
 public:
  explicit Datagrams(const Experiment& experiment);

  /// The datagrams of one row. Valid until the next call.
  const std::vector<std::string>& of(const TickRecord& record);

  static constexpr std::size_t largest = 1400;  ///< [bytes] an Ethernet frame holds 1472 of UDP

 private:
  struct Key {
    std::string name;   // within its object
    std::size_t robot;  // from 1; 0: of the group
    bool words;
  };
  std::ostringstream text_;
  CsvWriter writer_;
  std::vector<Key> keys_;
  std::vector<std::string> datagrams_;
};

}  // namespace skein::app
