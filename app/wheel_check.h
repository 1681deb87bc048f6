#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <tl/expected.hpp>

#include "app/session.h"
#include "comms/link_supervisor.h"

namespace skein::app {

/// Turns each wheel of a robot about 10 mm forward and compares the counters with the command: wheels that are swapped
/// or turn backwards, counters that are silent. The robot's link is up, and nobody else tells it anything meanwhile; it
/// stands when this is over. `keep_on` is asked before every command: a sentence ends the check, as its error. Blocks
/// for some seconds.
tl::expected<WheelCheck, std::string> check_wheels(comms::LinkSupervisor& links, std::size_t link,
                                                   const std::function<std::string()>& keep_on);

}  // namespace skein::app
