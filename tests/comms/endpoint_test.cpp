#include "comms/emulator/endpoint.h"

#include "comms/emulator/emulate.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

TEST(ListenAddress, IsAnAdapterAndAChannel) {
  EXPECT_EQ(parse_listen_address("rfcomm:hci4/1"), (ListenAddress{LinkKind::rfcomm, "hci4", 1}));
  EXPECT_EQ(parse_listen_address("rfcomm:00:AA:01:04:00:04/30"),
            (ListenAddress{LinkKind::rfcomm, "00:AA:01:04:00:04", 30}));
  EXPECT_EQ(parse_listen_address("tcp:127.0.0.1:1000"), (ListenAddress{LinkKind::tcp, "127.0.0.1", 1000}));
}

TEST(ListenAddress, RefusalsNameWhatWasFoundAndWhatIsAllowed) {
  const auto refused = [](const char* text, const char* what) {
    const auto address = parse_listen_address(text);
    ASSERT_FALSE(address) << text;
    for (const char* part : {text, what, "rfcomm:hci4/1"})
      EXPECT_NE(address.error().find(part), std::string::npos) << address.error();
  };
  refused("hci4/1", "begins with neither");
  refused("rfcomm:hci4", "no channel");
  refused("rfcomm:/1", "no adapter");
  refused("rfcomm:eth0/1", "eth0");
  refused("rfcomm:hci4/31", "1 to 30");
  refused("rfcomm:hci4/x", "1 to 30");
  refused("tcp:999.1.1.1:80", "is not an IPv4 address");
  refused("tcp:localhost:80", "is not an IPv4 address");
}

TEST(Emulate, RefusesToListenWhereNobodyCan) {
  EXPECT_EQ(emulate({.listen = {"rfcomm:hci4"}}), 2);
}

}  // namespace
}  // namespace skein::comms
