// A message bus with a logind that grants every inhibitor, until its input ends: says the bus's address, then how many
// inhibitors are held, whenever that changes. A byte of its input: the machine is about to be shut down; then it also
// says "down", once nobody delays that any more.
#include <poll.h>
#include <unistd.h>

#include <cstdio>

#include "tests/comms/fake_logind.h"

int main() {
  const skein::test::PrivateBus bus;
  if (!bus.running()) return std::fputs("there is no dbus-daemon\n", stderr), 1;
  skein::test::FakeLogind logind(bus);
  std::printf("%s\n", bus.address().c_str());
  constexpr int look_every = 2;  // [ms]
  int before = -1;
  bool shuts_down = false;
  while (true) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    char byte = 0;
    if (::poll(&input, 1, look_every) > 0) {
      if (::read(STDIN_FILENO, &byte, 1) <= 0) return 0;
      logind.announce("PrepareForShutdown", true);
      shuts_down = true;
    }
    const int now = logind.inhibitors();
    if (now != before) std::printf("%d\n", before = now);
    if (shuts_down && logind.delays() == 0) {
      shuts_down = false;
      std::printf("down\n");
    }
    std::fflush(stdout);
  }
}
