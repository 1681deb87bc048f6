#include "app/run/memory_lock.h"

#include <fmt/format.h>
#include <link.h>
#include <linux/capability.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "app/run/privileges.h"

namespace skein::app {
namespace {

/// The first object is the program. Kernels before 5.14 cannot be asked: there the code is read in as it is used.
int read_in(dl_phdr_info* object, std::size_t, void*) {
#ifdef MADV_POPULATE_READ
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  for (int k = 0; k < object->dlpi_phnum; ++k) {
    const auto& segment = object->dlpi_phdr[k];
    if (segment.p_type != PT_LOAD) continue;
    const std::uintptr_t begin = object->dlpi_addr + segment.p_vaddr, first = begin / page * page;
    void* const at = reinterpret_cast<void*>(first);  // NOLINT(performance-no-int-to-ptr): the loader has numbers
    ::madvise(at, begin + segment.p_memsz - first, MADV_POPULATE_READ);
  }
#else
  static_cast<void>(object);
#endif
  return 1;
}

}  // namespace

long memory_lock_limit() {
  rlimit limit{};
  if (has_capability(CAP_IPC_LOCK) || ::getrlimit(RLIMIT_MEMLOCK, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
    return -1;
  return static_cast<long>(limit.rlim_cur);
}

MemoryLock::MemoryLock() {
  // Under a limit, what is allocated later would be refused: a program that runs out of memory is worse than one that
  // waits.
  if (const long limit = memory_lock_limit(); limit >= 0)
    refused_ = fmt::format("limit {} kB, needed: none; `skein doctor` has the remedy", limit / 1024);
  else if (::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0)
    refused_ = std::strerror(errno);
  else
    ::dl_iterate_phdr(read_in, nullptr);
}

MemoryLock::~MemoryLock() {
  if (granted()) ::munlockall();
}

}  // namespace skein::app
