#pragma once

namespace skein::vision {

/// The kernel's limit on a program's receive buffer, and a size that is enough for several frames of every camera.
/// Debian's default holds a sixth of a megapixel. [bytes]
inline constexpr const char* receive_buffer_setting = "/proc/sys/net/core/rmem_max";
inline constexpr long good_receive_buffer_limit = 32L << 20;

}  // namespace skein::vision
