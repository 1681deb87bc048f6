#include "comms/link_address.h"

#include "tests/property.h"

namespace skein::comms {
namespace {

TEST(LinkAddress, ReadsSerialLines) {
  EXPECT_EQ(parse_link_address("serial:/dev/ttyACM0").value(), (LinkAddress{LinkKind::serial, "/dev/ttyACM0", 0, ""}));
}

TEST(LinkAddress, ReadsBluetoothWithAndWithoutChannel) {
  EXPECT_EQ(parse_link_address("rfcomm:10:00:E8:AA:BB:CC/2").value(),
            (LinkAddress{LinkKind::rfcomm, "10:00:E8:AA:BB:CC", 2, ""}));
  EXPECT_EQ(parse_link_address("rfcomm:10:00:e8:aa:bb:cc").value(),
            (LinkAddress{LinkKind::rfcomm, "10:00:E8:AA:BB:CC", 1, ""}));
}

TEST(LinkAddress, ReadsWifiRobotsWithAndWithoutPort) {
  EXPECT_EQ(parse_link_address("tcp:192.168.1.20").value(), (LinkAddress{LinkKind::tcp, "192.168.1.20", 1000, ""}));
  EXPECT_EQ(parse_link_address("tcp:epuck-4.lab:2000").value(), (LinkAddress{LinkKind::tcp, "epuck-4.lab", 2000, ""}));
  EXPECT_EQ(to_text(parse_link_address("tcp:epuck-4").value()), "tcp:epuck-4:1000");
}

TEST(LinkAddress, NamesAreLookedUpOnce) {
  EXPECT_EQ(resolve({LinkKind::tcp, "localhost", 1000}).value().device, "127.0.0.1");
  const auto nobody = resolve({LinkKind::tcp, "no-such-robot.invalid", 1000});
  ASSERT_FALSE(nobody);
  EXPECT_NE(nobody.error().find("no-such-robot.invalid"), std::string::npos);
  EXPECT_EQ(resolve({LinkKind::serial, "/dev/ttyACM0"}).value().device, "/dev/ttyACM0");
}

TEST(LinkAddress, SaysWhatWasFoundAndWhatIsAllowed) {
  for (const char* const bad : {"",
                                "serial:",
                                "serial:ttyACM0",
                                "/dev/ttyACM0",
                                "rfcomm:",
                                "rfcomm:10:00:E8:AA:BB",
                                "rfcomm:10:00:E8:AA:BB:CG",
                                "rfcomm:10-00-E8-AA-BB-CC/1",
                                "rfcomm:10:00:E8:AA:BB:CC/",
                                "rfcomm:10:00:E8:AA:BB:CC/0",
                                "rfcomm:10:00:E8:AA:BB:CC/31",
                                "rfcomm:10:00:E8:AA:BB:CC/1x",
                                "tcp:",
                                "tcp::1000",
                                "tcp:10.0.0.1:",
                                "tcp:10.0.0.1:0",
                                "tcp:10.0.0.1:65536",
                                "tcp:[::1]:1000",
                                "udp:",
                                "udp:10.0.0.1:0",
                                "usb:10.0.0.1",
                                "lego+serial:/dev/ttyACM0",
                                "+serial:/dev/ttyACM0"}) {
    const auto address = parse_link_address(bad);
    ASSERT_FALSE(address) << bad;
    EXPECT_NE(address.error().find('"' + std::string(bad) + '"'), std::string::npos) << address.error();
    EXPECT_NE(address.error().find("allowed"), std::string::npos) << address.error();
  }
}

TEST(LinkAddress, AdaptersAreNamesOrAddresses) {
  for (const char* const good : {"", "hci0", "hci12", "00:1A:7D:DA:71:13"}) EXPECT_TRUE(check_adapter(good)) << good;
  for (const char* const bad : {"hci", "hcix", "0", "00:1A:7D:DA:71", "usb0", "hci0000"}) {
    ASSERT_FALSE(check_adapter(bad)) << bad;
    EXPECT_NE(check_adapter(bad).error().find(bad), std::string::npos);
  }
}

TEST(LinkAddress, TextMakesTheRoundTrip) {
  test::holds("parse(to_text(a)) == a", [](const std::array<std::uint8_t, 6>& bytes) {
    LinkAddress address{LinkKind::rfcomm, "", *rc::gen::inRange(1, 31), ""};
    for (const std::uint8_t byte : bytes) {
      constexpr const char* digits = "0123456789ABCDEF";
      if (!address.device.empty()) address.device += ':';
      address.device += {digits[byte >> 4], digits[byte & 15]};
    }
    RC_ASSERT(parse_link_address(to_text(address)).value() == address);
  });
}

TEST(LinkAddress, AnyTextIsReadOrRefused) {
  test::holds("no text breaks the parser", [](const std::string& noise) {
    RC_ASSERT(!parse_link_address(noise));
    (void)parse_link_address("rfcomm:" + noise);
    RC_ASSERT(!parse_link_address("rfcomm:10:00:E8:AA:BB:CC/" + noise + "x"));
  });
}

}  // namespace
}  // namespace skein::comms
