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

/// Publishes the rows of a run live, as JSON datagrams (datagrams.h). `record` never waits for the network or a
/// receiver: rows wait in a bounded queue for a separate thread, and if it is full the oldest is dropped and
/// counted.
class Publisher final : public RecordSink {
 public:
  static constexpr std::size_t capacity = 64;  ///< [rows]

  /// Sends datagrams to the network; false: they were not sent. Called by the publisher's thread.
  using Send = std::function<bool(const std::vector<std::string>&)>;

  /// `where`: "udp:HOST:PORT", "udp:[::1]:PORT". A name is resolved now. The error is a sentence.
  static tl::expected<std::unique_ptr<Publisher>, std::string> open(const std::string& where,
                                                                    const Experiment& experiment);
  Publisher(const Experiment& experiment, Send send);
  ~Publisher() override;

  /// One thread. Copies the row.
  void record(const TickRecord& record) override;

  struct Counts {
    std::int64_t sent = 0;     ///< rows that were sent completely
    std::int64_t dropped = 0;  ///< rows that were not sent: the queue was full, or sending failed
  };
  /// Sends the waiting rows, for a second at most, and ends the thread: no more rows.
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
  bool busy_ = false;                 // a row is being sent
  Counts counts_;
  std::jthread thread_;
};

/// Checks only the form of "udp:HOST:PORT". The error is a sentence.
tl::expected<void, std::string> check_publish_address(const std::string& where);

}  // namespace skein::app
