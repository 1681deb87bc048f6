#include "app/guard/stop_socket.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <utility>

#include "app/guard/run_marker.h"
#include "app/run/clocks.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

constexpr double longest_wait = 5.0;  // for robots to stand [s]
constexpr double answer_patience = 8.0;
constexpr std::string_view stopping = "stopping\n", end_line = "end\n";

bool readable(int descriptor, double patience) noexcept {
  pollfd polled{descriptor, POLLIN, 0};
  return ::poll(&polled, 1, static_cast<int>(std::ceil(1e3 * std::max(0.0, patience)))) > 0;
}

void send_text(int descriptor, std::string_view text) noexcept {
  [[maybe_unused]] const auto sent = ::send(descriptor, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

/// Calls `use` with the address of a socket. Its name may be longer than an address holds: then by its directory.
template <typename Use>
int with_address(const std::string& path, Use&& use) {
  const int directory = ::open(fs::path(path).parent_path().c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return -1;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = path.size() < sizeof address.sun_path
                               ? path
                               : fmt::format("/proc/self/fd/{}/{}", directory, fs::path(path).filename().string());
  int result = -1;
  errno = ENAMETOOLONG;
  if (name.size() < sizeof address.sun_path) {
    std::copy(name.begin(), name.end(), address.sun_path);
    result = use(reinterpret_cast<const sockaddr*>(&address), static_cast<socklen_t>(sizeof address));
  }
  const int kept = errno;
  ::close(directory);
  errno = kept;
  return result;
}

bool same_user(int descriptor, pid_t* process = nullptr) noexcept {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return false;
  if (process) *process = peer.pid;
  return peer.uid == ::geteuid() || peer.uid == 0;
}

std::vector<StopResult> parse_results(std::string_view text) {
  std::vector<StopResult> results;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size()), tab = text.find('\t');
    if (tab < end) {
      const std::string_view said = text.substr(tab + 1, end - tab - 1);
      const bool stopped = said == "stopped";
      results.push_back({std::string(text.substr(0, tab)), stopped, stopped ? "" : std::string(said)});
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return results;
}

/// A connection to a stop socket.
class Client {
 public:
  explicit Client(const std::string& path)
      : descriptor_(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    const auto connect = [&](const sockaddr* address, socklen_t size) { return ::connect(descriptor_, address, size); };
    // EAGAIN: too many clients are waiting already, and none has been answered.
    reached_ = descriptor_ >= 0 && (with_address(path, connect) == 0 || errno == EAGAIN);
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  bool reached() const noexcept { return reached_; }
  int descriptor() const noexcept { return descriptor_; }

 private:
  int descriptor_;
  bool reached_ = false;
};

}  // namespace

tl::expected<StopSocket, std::string> StopSocket::listen(const std::string& path) {
  const int descriptor = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  ::unlink(path.c_str());  // that of the run, which preceded the guard
  const auto bind = [&](const sockaddr* address, socklen_t size) { return ::bind(descriptor, address, size); };
  if (descriptor < 0 || with_address(path, bind) != 0 || ::listen(descriptor, 64) != 0) {
    const std::string error = fmt::format("{}: no stop socket: {}", path, std::strerror(errno));
    if (descriptor >= 0) ::close(descriptor);
    return tl::unexpected(error);
  }
  return StopSocket(descriptor);
}

StopSocket::StopSocket(StopSocket&& other) noexcept
    : listening_(std::exchange(other.listening_, -1)), callers_(std::exchange(other.callers_, {})) {}
StopSocket& StopSocket::operator=(StopSocket&& other) noexcept {
  std::swap(listening_, other.listening_);
  std::swap(callers_, other.callers_);
  return *this;
}
StopSocket::~StopSocket() {
  for (const Caller& caller : callers_) ::close(caller.descriptor);
  if (listening_ >= 0) ::close(listening_);
}

void StopSocket::turn(const std::function<void(std::string_view word)>& heard,
                      const std::function<std::vector<StopResult>()>& results, bool last) {
  while (true) {
    const int caller = ::accept4(listening_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (caller < 0) break;
    std::array<char, 16> word{};
    // A client has its word ready; one that has not must not hold up the others.
    const ssize_t size = same_user(caller) && readable(caller, 0.05) ? ::read(caller, word.data(), word.size()) : 0;
    std::string_view said(word.data(), static_cast<std::size_t>(std::max<ssize_t>(0, size)));
    if (said.ends_with('\n')) said.remove_suffix(1);
    if (said.empty()) {
      ::close(caller);
      continue;
    }
    heard(said);
    send_text(caller, stopping);
    callers_.push_back({caller, monotonic_seconds() + longest_wait});
  }
  if (callers_.empty()) return;
  const std::vector<StopResult> robots = results();
  const bool all = std::all_of(robots.begin(), robots.end(), [](const StopResult& robot) { return robot.stopped; });
  std::erase_if(callers_, [&](const Caller& caller) {
    if (!all && !last && monotonic_seconds() < caller.until) return false;
    std::string text;
    for (const StopResult& robot : robots)
      text += fmt::format("{}\t{}\n", robot.address, robot.stopped ? "stopped" : robot.reason);
    send_text(caller.descriptor, text + std::string(end_line));
    ::close(caller.descriptor);
    return true;
  });
}

bool listens(const std::string& path) {
  return Client(path).reached();
}

StopAnswer ask_run(const std::string& path, std::string_view word, double patience) {
  StopAnswer answer;
  const Client client(path);
  const int descriptor = client.descriptor();
  answer.reached = client.reached();
  if (!answer.reached || !same_user(descriptor, &answer.process)) return answer;
  send_text(descriptor, word);
  std::string text;
  double until = monotonic_seconds() + patience;
  for (double left = patience; left > 0.0 && !interrupted(); left = until - monotonic_seconds()) {
    if (!readable(descriptor, std::min(left, 0.1))) continue;
    std::array<char, 4096> bytes;
    const ssize_t size = ::read(descriptor, bytes.data(), bytes.size());
    answer.ended = size <= 0;
    if (answer.ended) break;
    text.append(bytes.data(), static_cast<std::size_t>(size));
    if (!std::exchange(answer.heard, true)) until = monotonic_seconds() + answer_patience;
    if (text.ends_with(end_line)) {
      answer.robots = parse_results(text);
      break;
    }
  }
  return answer;
}

}  // namespace skein::app
