// Loaded into btvirt 5.66 in the guest (LD_PRELOAD): a PC's adapter can hold the links of seven robots.
//
// A connection has a handle at each end. btvirt hands data on with the sender's handle; where one controller has
// several links the ends' handles differ, and the data arrives on another robot's link. Here each packet gets the
// receiver's.
#include <dlfcn.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <vector>

namespace {

using Address = std::array<std::uint8_t, 6>;

// Of the Bluetooth core specification, volume 4, part E.
constexpr std::uint8_t data_packet = 2, event_packet = 4;
constexpr std::uint8_t connection_complete = 0x03, command_complete = 0x0E;
constexpr std::uint16_t read_address = 0x1009, handle_bits = 0x0FFF;

struct Controller {
  Address own{};
  std::map<Address, std::uint16_t> links;  // by the other end: this end's handle
};

std::map<int, Controller> controllers;  // by /dev/vhci's descriptor
int sender = -1;                        // whose data is being handed on

std::uint16_t two_bytes(const std::uint8_t* at) {
  return static_cast<std::uint16_t>(at[0] | at[1] << 8);
}
Address address_at(const std::uint8_t* at) {
  Address address;
  std::memcpy(address.data(), at, address.size());
  return address;
}

/// What an event says of a controller's address or links.
void learn(Controller& controller, const std::vector<std::uint8_t>& packet) {
  // Kind of packet, event, length, and then the event's own.
  if (packet.size() < 13) return;
  const std::uint8_t* const event = packet.data() + 3;
  if (packet[1] == command_complete && two_bytes(event + 1) == read_address) controller.own = address_at(event + 4);
  if (packet[1] == connection_complete && event[0] == 0) controller.links[address_at(event + 3)] = two_bytes(event + 1);
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" ssize_t read(int file, void* bytes, size_t size) {
  static const auto original = next<ssize_t (*)(int, void*, size_t)>("read");
  const ssize_t count = original(file, bytes, size);
  if (count > 0 && *static_cast<const std::uint8_t*>(bytes) == data_packet) sender = file;
  return count;
}

extern "C" ssize_t writev(int file, const iovec* parts, int count) {
  static const auto original = next<ssize_t (*)(int, const iovec*, int)>("writev");
  std::vector<std::uint8_t> packet;
  for (int i = 0; i < count; ++i) {
    const auto* const begin = static_cast<const std::uint8_t*>(parts[i].iov_base);
    packet.insert(packet.end(), begin, begin + parts[i].iov_len);
  }
  if (packet.size() > 3 && packet[0] == event_packet) learn(controllers[file], packet);
  if (packet.size() > 3 && packet[0] == data_packet) {
    const auto& links = controllers[file].links;
    if (const auto link = links.find(controllers[sender].own); link != links.end()) {
      const auto flags = static_cast<std::uint16_t>(two_bytes(packet.data() + 1) & ~handle_bits);
      const auto handle = static_cast<std::uint16_t>(flags | link->second);
      packet[1] = static_cast<std::uint8_t>(handle & 0xFF);
      packet[2] = static_cast<std::uint8_t>(handle >> 8);
    }
  }
  const iovec whole{packet.data(), packet.size()};
  return original(file, &whole, 1);
}
