#include "tests/comms/fake_service.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>

namespace skein::test {
namespace {

constexpr const char* system_bus = "DBUS_SYSTEM_BUS_ADDRESS";

}  // namespace

PrivateBus::PrivateBus() {
  std::array<int, 2> says{};
  if (::pipe(says.data()) != 0) return;
  daemon_ = ::fork();
  if (daemon_ == 0) {
    ::dup2(says[1], STDOUT_FILENO);
    ::dup2(::open("/dev/null", O_WRONLY), STDERR_FILENO);
    ::execlp("dbus-daemon", "dbus-daemon", "--session", "--nofork", "--nopidfile", "--print-address=1", nullptr);
    ::_exit(127);
  }
  ::close(says[1]);
  std::array<char, 256> line{};
  const ssize_t count = ::read(says[0], line.data(), line.size());
  ::close(says[0]);
  if (count <= 0) return;
  address_.assign(line.data(), static_cast<std::size_t>(count));
  address_.erase(address_.find('\n'));
  ::setenv(system_bus, address_.c_str(), 1);
}

PrivateBus::~PrivateBus() {
  if (daemon_ > 0) {
    ::kill(daemon_, SIGTERM);
    ::waitpid(daemon_, nullptr, 0);
  }
  ::unsetenv(system_bus);
}

FakeService::FakeService(const PrivateBus& bus) {
  sd_bus_new(&bus_);
  sd_bus_set_address(bus_, bus.address().c_str());
  sd_bus_set_bus_client(bus_, 1);
  sd_bus_negotiate_fds(bus_, 1);
  sd_bus_start(bus_);
}

FakeService::~FakeService() {
  end();
  sd_bus_flush_close_unref(bus_);
}

void FakeService::serve(const char* name) {
  sd_bus_request_name(bus_, name, 0);
  thread_ = std::thread([this] {
    while (!ending_)
      if (sd_bus_process(bus_, nullptr) == 0) sd_bus_wait(bus_, 10'000);
  });
}

void FakeService::end() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
}

}  // namespace skein::test
