#include "app/run/memory_lock.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <string>
#include <vector>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool sanitized = true;  // a sanitizer passes no request for a lock on to the kernel
#else
constexpr bool sanitized = false;
#endif

namespace skein::app {
namespace {

/// Some pages of a file on a disk.
class Pages {
 public:
  Pages() : file_(::open(".", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600)) {
    const std::string some(size, 'x');
    good_ = file_ >= 0 && ::write(file_, some.data(), size) == static_cast<ssize_t>(size) && ::fsync(file_) == 0;
    if (good_) at_ = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file_, 0);
    for (std::size_t k = 0; good_ && k < size; k += page) read_ += static_cast<const volatile char*>(at_)[k];
  }
  ~Pages() {
    if (at_ != MAP_FAILED) ::munmap(at_, size);
    if (file_ >= 0) ::close(file_);
  }
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

  bool good() const { return good_ && at_ != MAP_FAILED; }
  /// The kernel is asked to take them away, as it does when memory runs out. How many are left?
  std::ptrdiff_t left() const {
    ::madvise(at_, size, MADV_PAGEOUT);
    std::vector<unsigned char> resident(size / page);
    ::mincore(at_, size, resident.data());
    return std::count_if(resident.begin(), resident.end(), [](unsigned char one) { return (one & 1) != 0; });
  }
  static constexpr std::size_t page = 4096, all = 16, size = page * all;

 private:
  int file_;
  bool good_ = false;
  void* at_ = MAP_FAILED;
  int read_ = 0;
};

TEST(MemoryLock, HoldsWhatTheKernelWouldTakeAway) {
  if (sanitized || memory_lock_limit() >= 0) GTEST_SKIP() << MemoryLock().refused();
  if (const Pages without; !without.good() || without.left() == Pages::all)
    GTEST_SKIP() << "the kernel takes no pages away here";
  {
    const MemoryLock lock;
    ASSERT_EQ(lock.refused(), "");
    const Pages with;
    ASSERT_TRUE(with.good());
    EXPECT_EQ(with.left(), Pages::all);
  }
  const Pages after;
  EXPECT_LT(after.left(), Pages::all) << "the lock lasts as long as its object";
}

/// Under a limit every later allocation could be refused.
TEST(MemoryLock, IsNotTriedUnderALimit) {
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit limit{8 << 20, 8 << 20};
    ::setrlimit(RLIMIT_MEMLOCK, &limit);
    if (::geteuid() == 0 && ::setuid(65534) != 0) ::_exit(2);  // root may lock what it likes
    const MemoryLock lock;
    ::_exit(memory_lock_limit() == 8 << 20 && lock.refused().starts_with("limit 8192 kB, needed: none") ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace skein::app
