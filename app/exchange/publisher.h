#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <tl/expected.hpp>

#include "app/exchange/datagrams.h"

namespace skein::app {

/// Publishes the rows of a run while it goes on, as JSON datagrams (datagrams.h). Whoever calls `record` never waits
/// for the network or a receiver: rows wait in a queue of bounded size for a thread of their own, and where that is
/// full the oldest is dropped and counted.
class Publisher final : public RecordSink {
 public:
  static constexpr std::size_t capacity = 64;  ///< [rows]

  /// Hands datagrams to the network; false: they were not taken. Called by the publisher's thread.
  using Send = std::function<bool(const std::vector<std::string>&)>;

  /// `where`: "udp:HOST:PORT", "udp:[::1]:PORT". A name is looked up now. The error says what is wrong with it.
  static tl::expected<std::unique_ptr<Publisher>, std::string> open(const std::string& where,
                                                                    const Experiment& experiment);
  Publisher(const Experiment& experiment, Send send);
  ~Publisher() override;

  /// One thread. Copies the row.
  void record(const TickRecord& record) override;

  struct Counts {
    std::int64_t sent = 0;     ///< rows that were handed to the network whole
    std::int64_t dropped = 0;  ///< rows that were not: the queue was full, or the network did not take them
  };
  /// Sends what waits, for a second at most, and ends the thread: no more rows.
  Counts finish();
  Counts counts() const;

 private:
  void publish(const std::stop_token& token);

  Datagrams datagrams_;
  Send send_;
  mutable std::mutex mutex_;
  std::condition_variable_any filled_, emptied_;
  std::vector<TickRecord> ring_;
  std::size_t first_ = 0, size_ = 0;  // in the ring
  bool busy_ = false;                 // a row is on its way
  Counts counts_;
  std::jthread thread_;
};

/// Checks "udp:HOST:PORT" for its form alone. The error is a sentence.
tl::expected<void, std::string> check_publish_address(const std::string& where);

}  // namespace skein::app
