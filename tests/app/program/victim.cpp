// A program that drives robots until it is killed: victim PROGRAM LINK... Its guard is `PROGRAM guard`; "-": it has
// none. Says "driving" once the robots have obeyed.
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>
#include <vector>

#include "app/guard/safety_net.h"
#include "comms/crash_stop.h"
#include "comms/link_supervisor.h"

int main(int argc, char** argv) {
  using namespace skein;
  std::vector<comms::LinkAddress> robots;
  for (int i = 2; i < argc; ++i) robots.push_back(comms::parse_link_address(argv[i]).value());
  tl::expected<app::SafetyNet, std::string> net;
  if (std::strcmp(argv[1], "-") != 0) net = app::SafetyNet::spread({"victim", robots, argv[1]});
  if (!net) return std::fprintf(stderr, "victim: %s\n", net.error().c_str()), 1;
  comms::stop_robots_on_crash();
  comms::LinkSupervisor links(robots, {.command_silence = 0.25, .standstill = 0.5});
  if (const auto started = links.start(20.0); !started)
    return std::fprintf(stderr, "victim: %s\n", started.error().c_str()), 1;
  if (net)
    net->on_stop(
        [&](const std::string&) { links.emergency_stop(); },
        [&] {
          std::vector<app::StopResult> results;
          for (const comms::LinkStatus& status : links.status())
            results.push_back({comms::to_text(robots[results.size()]), status.stop_acknowledged, status.reason});
          return results;
        });
  for (bool said = false;;) {
    for (std::size_t i = 0; i < robots.size(); ++i) links.command(i, 300, 300);
    if (!said && (said = links.wait_acknowledged(10.0))) std::puts("driving"), std::fflush(stdout);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}
