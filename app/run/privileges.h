#pragma once

namespace skein::app {

/// Whether this process holds a capability of the kernel (CAP_SYS_NICE). In a container root may lack it, or hold it
/// for the container's own users only.
bool has_capability(int capability);

/// The highest real-time priority that this process may give its threads; 0: none, -1: no limit.
long real_time_priority_limit();

}  // namespace skein::app
