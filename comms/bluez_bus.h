#pragma once

#include <functional>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

struct sd_bus;

namespace skein::comms {

/// The PC's adapters and the devices that the daemon knows, with the properties that Skein uses.
struct BluezAdapter {
  std::string path;     ///< "/org/bluez/hci0"
  std::string address;  ///< "00:1A:7D:DA:71:13"
  bool powered = false;

  std::string name() const { return path.substr(path.rfind('/') + 1); }  ///< "hci0"
};
struct BluezDevice {
  std::string path, adapter_path, address, name;
  bool paired = false;
  bool heard = false;  ///< by the present discovery
};
struct BluezObjects {
  std::vector<BluezAdapter> adapters;
  std::vector<BluezDevice> devices;
};

/// A conversation with org.bluez on the system bus. Errors are sentences for the operator. Not thread-safe.
class BluezBus {
 public:
  static tl::expected<BluezBus, std::string> open();

  tl::expected<BluezObjects, std::string> objects();
  /// The adapters to use: `wanted`, by name or address, or all that are on. Never none.
  tl::expected<std::vector<BluezAdapter>, std::string> adapters(const std::string& wanted);

  tl::expected<void, std::string> start_discovery(const BluezAdapter& adapter);
  void stop_discovery(const BluezAdapter& adapter);

  /// Pairs with a device; `pin` is the answer if it requests one. False from `keep_on` cancels.
  tl::expected<void, std::string> pair(const BluezDevice& device, const std::string& pin, bool can_type,
                                       double timeout_s, const std::function<bool()>& keep_on);

  /// Serves the bus until `until` returns true, `keep_on` false or the time is up; true: `until` did.
  bool serve(double timeout_s, const std::function<bool()>& keep_on, const std::function<bool()>& until);

 private:
  struct Close {
    void operator()(sd_bus* bus) const noexcept;
  };
  explicit BluezBus(sd_bus* bus) : bus_(bus) {}

  std::unique_ptr<sd_bus, Close> bus_;
};

}  // namespace skein::comms
