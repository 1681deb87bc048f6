#include "comms/emulator/tcp_epuck.h"

#include <utility>

namespace skein::comms {
namespace {

std::vector<EmulatorLoop::Robot> on_port(int port) {
  std::vector<EmulatorLoop::Robot> robots(1);
  robots[0] = {core::MotorModel::epuck2, EpuckProgram::wifi, make_socket_endpoint({LinkKind::tcp, "127.0.0.1", port})};
  return robots;
}

}  // namespace

TcpEpuck::TcpEpuck(std::function<double()> clock, int port) : loop_(on_port(port), nullptr, std::move(clock), {}, 0) {}

int TcpEpuck::port() const {
  return parse_link_address(loop_.address(0))->channel;
}

}  // namespace skein::comms
