#include "app/run/privileges.h"

#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace skein::app {
namespace {

bool granted(int priority) {
  const sched_param wanted{priority};
  const bool real_time = ::sched_setscheduler(0, SCHED_FIFO, &wanted) == 0;
  const sched_param none{0};
  ::sched_setscheduler(0, SCHED_OTHER, &none);
  return real_time;
}

/// In a process of its own; 0: it holds.
bool elsewhere(int (*status_of)()) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(status_of());
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// As in a container: root without capabilities, and an ordinary user.
TEST(Privileges, AreWhatTheKernelGrants) {
  EXPECT_TRUE(elsewhere([] {
    if (real_time_priority_limit() < 0 && !granted(1)) return 1;
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_RTPRIO, &none);
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    const __user_cap_data_struct nothing[_LINUX_CAPABILITY_U32S_3] = {};
    if (::syscall(SYS_capset, &header, nothing) != 0) return 2;
    if (has_capability(CAP_SYS_NICE) || has_capability(CAP_CHECKPOINT_RESTORE)) return 3;
    return real_time_priority_limit() == 0 && !granted(1) ? 0 : 4;
  }));
}

/// A container without root: its root holds every capability, and none of them counts for the machine.
TEST(Privileges, OfAContainersOwnRootAreNone) {
  EXPECT_TRUE(elsewhere([] {
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_RTPRIO, &none);
    if (::unshare(CLONE_NEWUSER) != 0) return 0;  // not allowed here
    return real_time_priority_limit() == 0 && !granted(1) ? 0 : 1;
  }));
}

}  // namespace
}  // namespace skein::app
