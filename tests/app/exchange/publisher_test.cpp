#include "app/exchange/publisher.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <semaphore>

#include "tests/app/exchange/recorded.h"

namespace skein::app {
namespace {

using test::Recorded;

/// A receiver on this machine.
class Receiver {
 public:
  Receiver() : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    const int room = 8 << 20;
    ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    EXPECT_EQ(::bind(descriptor_, reinterpret_cast<sockaddr*>(&address), size), 0);
    ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &size);
    where = "udp:127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  ~Receiver() { ::close(descriptor_); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;
  /// The next datagram that is there; empty: there is none.
  std::string next() const {
    std::string datagram(65536, '\0');
    const ssize_t size = ::recv(descriptor_, datagram.data(), datagram.size(), MSG_DONTWAIT);
    datagram.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
    return datagram;
  }
  std::string where;

 private:
  int descriptor_;
};

TEST(Publisher, EveryRowArrives) {
  const Recorded run({"duration=1"});
  const Receiver receiver;
  auto publisher = Publisher::open(receiver.where, run.experiment).value();
  for (const TickRecord& row : run.rows) publisher->record(row);
  const Publisher::Counts counts = publisher->finish();
  EXPECT_EQ(counts.sent, static_cast<std::int64_t>(run.rows.size()));
  EXPECT_EQ(counts.dropped, 0);
  std::set<double> times;
  for (std::string datagram = receiver.next(); !datagram.empty(); datagram = receiver.next())
    times.insert(nlohmann::json::parse(datagram).at("timestamp").get<double>());
  EXPECT_EQ(times.size(), run.rows.size());
}

TEST(Publisher, WhereNothingIsTakenTheOldestRowsAreDroppedAndCountedAndNobodyWaits) {
  const Recorded run({"duration=8"});
  ASSERT_GT(run.rows.size(), Publisher::capacity + 100);
  std::binary_semaphore stalled{0}, goes_on{0};
  bool first = true;
  std::vector<double> sent;
  Publisher publisher(run.experiment, [&](const std::vector<std::string>& datagrams) {
    if (std::exchange(first, false)) {
      stalled.release();
      goes_on.acquire();  // stalls while all the rest of the run comes
    }
    sent.push_back(nlohmann::json::parse(datagrams.front()).at("timestamp").get<double>());
    return true;
  });
  publisher.record(run.rows[0]);
  stalled.acquire();
  for (std::size_t k = 1; k < run.rows.size(); ++k) publisher.record(run.rows[k]);  // would hang if it waited
  const auto rest = static_cast<std::int64_t>(run.rows.size() - 1 - Publisher::capacity);
  EXPECT_EQ(publisher.counts().dropped, rest);
  goes_on.release();
  EXPECT_EQ(publisher.finish().dropped, rest);
  ASSERT_EQ(sent.size(), Publisher::capacity + 1);
  EXPECT_EQ(sent.back(), run.rows.back().now) << "the newest rows are kept";
  EXPECT_EQ(sent[1], run.rows[run.rows.size() - Publisher::capacity].now);
}

TEST(Publisher, NobodyNeedsToListen) {
  const Recorded run({"duration=1"});
  std::string where;
  {
    const Receiver gone;
    where = gone.where;
  }
  auto publisher = Publisher::open(where, run.experiment).value();
  for (const TickRecord& row : run.rows) publisher->record(row);
  publisher->finish();
}

TEST(Publisher, AnAddressSaysWhatIsWrongWithIt) {
  for (const char* const good : {"udp:localhost:9870", "udp:127.0.0.1:1", "udp:[::1]:65535"})
    EXPECT_TRUE(check_publish_address(good)) << good;
  for (const char* const bad : {"", "localhost:9870", "udp:localhost", "udp::9870", "udp:h:0", "udp:h:65536",
                                "udp:h:1x", "udp:::1:9870", "tcp:h:1"}) {
    const auto checked = check_publish_address(bad);
    ASSERT_FALSE(checked) << bad;
    EXPECT_NE(checked.error().find("udp:HOST:PORT"), std::string::npos);
  }
}

}  // namespace
}  // namespace skein::app
