#include "app/run/privileges.h"

#include <linux/capability.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <string_view>

namespace skein::app {
namespace {

/// For priorities and locks of memory the kernel asks for capabilities in this one, not in that of a container.
bool in_the_first_user_namespace() {
  constexpr std::string_view first = "user:[4026531837]";  // a constant of the kernel, PROC_USER_INIT_INO
  std::array<char, 64> name{};
  const ssize_t size = ::readlink("/proc/self/ns/user", name.data(), name.size());
  return size < 0 || std::string_view(name.data(), static_cast<std::size_t>(size)) == first;
}

}  // namespace

bool has_capability(int capability) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> held{};
  const auto number = static_cast<unsigned>(capability);
  return in_the_first_user_namespace() && ::syscall(SYS_capget, &header, held.data()) == 0 &&
         (held.at(number / 32).effective >> (number % 32) & 1U) != 0;
}

long real_time_priority_limit() {
  rlimit limit{};
  if (has_capability(CAP_SYS_NICE)) return -1;
  if (::getrlimit(RLIMIT_RTPRIO, &limit) != 0) return 0;
  return limit.rlim_cur == RLIM_INFINITY ? -1 : static_cast<long>(limit.rlim_cur);
}

}  // namespace skein::app
