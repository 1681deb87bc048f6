// A message bus with a logind that grants every inhibitor, until its input ends: says the bus's address, then how many
// inhibitors are held, whenever that changes.
#include <poll.h>
#include <unistd.h>

#include <cstdio>

#include "tests/comms/fake_logind.h"

int main() {
  const skein::test::PrivateBus bus;
  if (!bus.running()) return std::fputs("there is no dbus-daemon\n", stderr), 1;
  const skein::test::FakeLogind logind(bus);
  std::printf("%s\n", bus.address().c_str());
  constexpr int look_every = 2;  // [ms]
  int before = -1;
  for (pollfd input{STDIN_FILENO, POLLIN, 0}; ::poll(&input, 1, look_every) == 0;) {
    const int now = logind.inhibitors();
    if (now != before) std::printf("%d\n", before = now);
    std::fflush(stdout);
  }
}
