#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace skein::vision {

/// A GigE Vision or USB3 Vision camera that has answered.
struct NetworkCamera {
  std::string name{};      ///< what follows "aravis:": vendor, model and serial number
  std::string model{};     ///< vendor and model
  std::string address{};   ///< in the network, or on the USB
  std::string protocol{};  ///< "GigEVision", "USB3Vision"
};

/// The cameras that answer within a second. The error: Aravis cannot be loaded.
tl::expected<std::vector<NetworkCamera>, std::string> network_cameras();

/// What the camera of a name or network address offers and its settings, for people, a line each. Does not change it,
/// but no other program may be reading frames from it.
tl::expected<std::vector<std::string>, std::string> describe_network_camera(const std::string& camera);

}  // namespace skein::vision
