#include "app/controllers/bounded_process.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <future>
#include <iterator>
#include <string_view>

#include "app/run/output.h"

namespace skein::app {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t most_printed = std::size_t{64} << 10;
constexpr std::size_t longest_kept = 300;  // of the last line

/// How many processes and threads this user has: RLIMIT_NPROC counts all of them.
std::int64_t tasks_of_user() {
  std::int64_t tasks = 0;
  DIR* const all = ::opendir("/proc");
  if (!all) return 0;
  while (const dirent* const entry = ::readdir(all)) {
    const std::string name = entry->d_name;
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    struct stat owner {};
    if (::stat(("/proc/" + name).c_str(), &owner) != 0 || owner.st_uid != ::getuid()) continue;
    std::ifstream status("/proc/" + name + "/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("Threads:")) tasks += std::strtoll(line.c_str() + 8, nullptr, 10);
  }
  ::closedir(all);
  return tasks;
}

#if defined(__x86_64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t architecture = 0;  // no filter: RLIMIT_NPROC alone
#endif

/// A filter of system calls: no process can leave the group; if `forks` is false, only threads may be started.
std::vector<sock_filter> filter(bool forks) {
  std::vector<sock_filter> code;
  const auto add = [&](std::uint16_t what, std::uint32_t value, std::uint8_t yes = 0, std::uint8_t no = 0) {
    code.push_back({what, yes, no, value});
  };
  const auto load = [&](std::size_t offset) { add(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)); };
  const auto give = [&](std::uint32_t what) { add(BPF_RET | BPF_K, what); };
  const auto refuse = [&](long call, int error) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 1);
    give(SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(error));
  };
  load(offsetof(seccomp_data, arch));
  add(BPF_JMP | BPF_JEQ | BPF_K, architecture, 1, 0);
  give(SECCOMP_RET_KILL_PROCESS);
  load(offsetof(seccomp_data, nr));
#if defined(__x86_64__)
  add(BPF_JMP | BPF_JGE | BPF_K, 0x40000000u, 0, 1);  // x32
  give(SECCOMP_RET_ERRNO | ENOSYS);
#endif
  refuse(SYS_setsid, EPERM);
  refuse(SYS_setpgid, EPERM);
  if (!forks) {
#if defined(__x86_64__)
    refuse(SYS_fork, EAGAIN);
    refuse(SYS_vfork, EAGAIN);
#endif
    refuse(SYS_clone3, ENOSYS);  // its flags are in memory; the C library tries clone then
    add(BPF_JMP | BPF_JEQ | BPF_K, SYS_clone, 0, 3);
    load(offsetof(seccomp_data, args));
    add(BPF_JMP | BPF_JSET | BPF_K, CLONE_THREAD, 1, 0);
    give(SECCOMP_RET_ERRNO | EAGAIN);
  }
  give(SECCOMP_RET_ALLOW);
  return code;
}

/// Between fork and exec: nothing here allocates or locks.
struct Child {
  char* const* words;
  char* const* environment;
  const char* directory;
  const int* files;
  int count;
  int output, error;  // pipes
  pid_t parent;
  std::array<std::pair<int, rlimit>, 7> limits;
  sock_fprog filter;

  [[noreturn]] void fail() const noexcept {
    const int reason = errno;
    (void)!::write(error, &reason, sizeof reason);
    ::_exit(127);
  }

  [[noreturn]] void become() const noexcept {
    sigset_t nothing;
    sigemptyset(&nothing);
    for (int signal = 1; signal < NSIG; ++signal) ::signal(signal, SIG_DFL);
    ::sigprocmask(SIG_SETMASK, &nothing, nullptr);
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);
    const sched_param ordinary{};
    ::sched_setscheduler(0, SCHED_OTHER, &ordinary);
    const int null = ::open("/dev/null", O_RDONLY);
    if (null < 0 || ::dup2(null, STDIN_FILENO) < 0 || ::dup2(output, STDOUT_FILENO) < 0 ||
        ::dup2(output, STDERR_FILENO) < 0)
      fail();
    // First out of the way of 3, 4, ..., then there; the error's pipe behind them.
    constexpr int away = 500, most = 8;
    int kept[most];
    for (int k = 0; k < count; ++k)
      if ((kept[k] = ::fcntl(files[k], F_DUPFD, away)) < 0) fail();
    const int told = ::fcntl(error, F_DUPFD_CLOEXEC, away);
    if (told < 0) fail();
    for (int k = 0; k < count; ++k)
      if (::dup2(kept[k], 3 + k) < 0) fail();
    if (::dup3(told, 3 + count, O_CLOEXEC) < 0) fail();
    Child last = *this;
    last.error = 3 + count;
    ::syscall(SYS_close_range, 4 + count, ~0u, 0);
    last.restrain();
  }

  [[noreturn]] void restrain() const noexcept {
    if (*directory && ::chdir(directory) != 0) fail();
    for (const auto& [what, limit] : limits) {
      rlimit now{};
      ::getrlimit(static_cast<__rlimit_resource>(what), &now);
      const rlim_t most = std::min(limit.rlim_max, now.rlim_max);
      const rlimit asked{std::min(limit.rlim_cur, most), most};
      if (::setrlimit(static_cast<__rlimit_resource>(what), &asked) != 0) fail();
    }
    if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) fail();
    if (architecture != 0 && ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0 && errno != EINVAL) fail();
    ::execvpe(words[0], words, environment);
    fail();
  }
};

std::string sentence_of(int status) {
  if (WIFSIGNALED(status)) return fmt::format("it was killed by {}", ::strsignal(WTERMSIG(status)));
  return fmt::format("it exited with status {}", WEXITSTATUS(status));
}

}  // namespace

tl::expected<std::unique_ptr<BoundedProcess>, std::string> BoundedProcess::start(const Setup& setup) {
  std::unique_ptr<BoundedProcess> made(new BoundedProcess);
  const auto told = std::make_shared<std::promise<tl::expected<void, std::string>>>();
  auto spawned = told->get_future();
  made->drainer_ = std::jthread([&setup, told, self = made.get(), prints = setup.prints](const std::stop_token& stop) {
    auto result = self->spawn(setup);
    const bool good = result.has_value();
    told->set_value(std::move(result));
    if (good) self->drain(stop, prints);
  });
  if (auto result = spawned.get(); !result) return tl::unexpected(result.error());
  return made;
}

/// On the thread that will drain it.
tl::expected<void, std::string> BoundedProcess::spawn(const Setup& setup) {
  const auto failed = [&](int error) {
    return tl::unexpected(fmt::format("{}: cannot be started: {}", setup.words.front(), std::strerror(error)));
  };
  int output[2], error[2];
  if (::pipe2(output, O_CLOEXEC) != 0) return failed(errno);
  if (::pipe2(error, O_CLOEXEC) != 0) {
    const int reason = errno;
    ::close(output[0]), ::close(output[1]);
    return failed(reason);
  }
  std::vector<char*> words, environment;
  for (const std::string& word : setup.words) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  for (const std::string& variable : setup.environment) environment.push_back(const_cast<char*>(variable.c_str()));
  for (char** variable = environ; *variable; ++variable) {
    const std::string_view text = *variable;
    const std::string_view name = text.substr(0, text.find('=') + 1);
    const bool replaced = std::any_of(setup.environment.begin(), setup.environment.end(),
                                      [&](const std::string& own) { return own.starts_with(name); });
    if (!replaced) environment.push_back(*variable);
  }
  environment.push_back(nullptr);
  const ProcessBounds& bounds = setup.bounds;
  const auto both = [](std::int64_t value) { return rlimit{static_cast<rlim_t>(value), static_cast<rlim_t>(value)}; };
  constexpr std::int64_t megabyte = 1 << 20;
  std::vector<sock_filter> code = filter(bounds.processes > 0);
  const std::int64_t tasks = bounds.processes > 0 ? tasks_of_user() + bounds.processes : 0;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  const rlimit memory{RLIM_INFINITY, RLIM_INFINITY};  // of sanitizers' shadows there is no end
#else
  const rlimit memory = both(bounds.memory * megabyte);
#endif
  Child child{words.data(),
              environment.data(),
              setup.directory.c_str(),
              setup.files.data(),
              static_cast<int>(setup.files.size()),
              output[1],
              error[1],
              ::getpid(),
              {{{RLIMIT_AS, memory},
                {RLIMIT_CPU, both(bounds.cpu_seconds)},
                {RLIMIT_FSIZE, both(bounds.file * megabyte)},
                {RLIMIT_NOFILE, both(256)},
                {RLIMIT_CORE, both(0)},
                {RLIMIT_RTPRIO, both(0)},
                {RLIMIT_NPROC, tasks > 0 ? both(tasks) : rlimit{RLIM_INFINITY, RLIM_INFINITY}}}},
              {static_cast<unsigned short>(code.size()), code.data()}};
  const pid_t process = ::fork();
  if (process == 0) child.become();
  const int reason = errno;
  ::close(output[1]);
  ::close(error[1]);
  int told = 0;
  if (process < 0) {
    ::close(output[0]), ::close(error[0]);
    return failed(reason);
  }
  ::setpgid(process, process);  // whoever is first
  ssize_t n = 0;
  while ((n = ::read(error[0], &told, sizeof told)) < 0 && errno == EINTR) {
  }
  ::close(error[0]);
  if (n == sizeof told) {
    ::close(output[0]);
    ::waitpid(process, nullptr, 0);
    return failed(told);
  }
  process_ = process;
  output_ = output[0];
  return {};
}

BoundedProcess::~BoundedProcess() {
  if (process_ > 0) {
    end();
    reap(10.0);
  }
  drainer_.request_stop();
  if (drainer_.joinable()) drainer_.join();
  if (output_ >= 0) ::close(output_);
}

void BoundedProcess::end() noexcept {
  if (!gone_.load()) ::kill(-process_, SIGKILL);
}

/// What it prints: bounded on the terminal, and never kept waiting.
void BoundedProcess::drain(const std::stop_token& stop, bool prints) {
  std::string line;
  std::size_t printed = 0;
  std::array<char, 4096> block{};
  while (!stop.stop_requested()) {
    pollfd ready{output_, POLLIN, 0};
    if (::poll(&ready, 1, 50) <= 0) continue;
    const ssize_t n = ::read(output_, block.data(), block.size());
    if (n <= 0) return;
    const std::string_view text(block.data(), static_cast<std::size_t>(n));
    if (prints && printed < most_printed) {
      printed += text.size();
      print_error_as_is(text);
      if (printed >= most_printed) print_error("\nskein: further output of the controller is not shown\n");
    }
    const std::lock_guard lock(mutex_);
    for (const char c : text) {
      if (c != '\n') {
        if (line.size() < longest_kept) line += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
        continue;
      }
      if (!line.empty()) last_line_ = line;
      line.clear();
    }
  }
}

bool BoundedProcess::reap(double patience) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience);
  while (true) {
    {
      const std::lock_guard lock(mutex_);
      if (reaped_) return true;
      siginfo_t info{};
      // Only looked at: while the leader is not reaped, no other group has its number.
      if (::waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0) {
        ::kill(-process_, SIGKILL);  // whom it left behind
        gone_.store(true);
        ::waitpid(process_, &status_, 0);
        return reaped_ = true;
      }
    }
    if (std::chrono::steady_clock::now() >= until) return false;
    std::this_thread::sleep_for(1ms);
  }
}

std::string BoundedProcess::how_it_ended(double patience) {
  if (!reap(patience)) return {};
  std::this_thread::sleep_for(20ms);  // its last words
  const std::lock_guard lock(mutex_);
  const std::string how = sentence_of(status_);
  return last_line_.empty() ? how : how + ": " + last_line_;
}

}  // namespace skein::app
