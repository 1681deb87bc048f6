// Codec, session and emulated robot together: whatever hosts sent, however it was cut into writes, whatever failed
// meanwhile, one resynchronisation stops the robot.
#include <algorithm>
#include <limits>
#include <memory>
#include <ostream>
#include <span>
#include <vector>

#include "comms/asercom_session.h"
#include "comms/emulator/emulated_epuck.h"
#include "comms/epuck_wifi.h"
#include "comms/wifi_session.h"
#include "tests/comms/any_request.h"
#include "tests/comms/bytes.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

using core::MotorModel;
using test::Bytes;

constexpr double faults_end = 10.0;  // [s]
constexpr double step = 0.1;  // longer than an answer takes through the robot's ring, shorter than a time-out [s]

double between(double low, double high) {
  return low + (high - low) * (*rc::gen::inRange(0, 1001)) / 1000.0;
}

/// Radio faults that are over by `faults_end`; what is wrong with the robot itself may stay.
Fault any_fault() {
  Fault fault;
  fault.kind =
      *rc::gen::element(FaultKind::latency, FaultKind::loss, FaultKind::burst, FaultKind::corruption,
                        FaultKind::disconnect, FaultKind::reboot, FaultKind::stuck, FaultKind::ring, FaultKind::battery,
                        FaultKind::swapped_wheels, FaultKind::silent_encoders, FaultKind::stall);
  fault.at = between(0.0, 0.7 * faults_end);
  fault.duration = fault.kind == FaultKind::stuck ? 0.0 : between(0.001, 0.3 * faults_end);
  const bool of_the_robot = fault.kind == FaultKind::ring || fault.kind == FaultKind::battery ||
                            fault.kind == FaultKind::swapped_wheels || fault.kind == FaultKind::silent_encoders;
  if (of_the_robot && *rc::gen::arbitrary<bool>()) fault.duration = std::numeric_limits<double>::infinity();
  fault.median = between(0.001, 0.3);
  fault.p99 = fault.median * between(1.0, 5.0);
  fault.share = between(0.01, 1.0);
  return fault;
}

Bytes any_host(EpuckProgram protocol) {
  if (protocol == EpuckProgram::asercom || *rc::gen::inRange(0, 3) == 0) return *test::any_request();
  const auto speed = rc::gen::inRange<int>(-1500, 1500);
  const int left = *speed;
  const auto command = wifi_command(clamped(left, *speed));
  return {command.begin(), command.end()};
}

/// Requests of hosts, cut anywhere into writes, some with pauses between them. Returns when the last came.
double suffer(EmulatedEpuck& robot, EpuckProgram protocol) {
  double now = 0.0;
  for (int requests = *rc::gen::inRange(0, 12); requests > 0; --requests) {
    const Bytes request = any_host(protocol);
    for (std::size_t begin = 0; begin < request.size();) {
      const auto size = *rc::gen::inRange<std::size_t>(1, request.size() - begin + 1);
      robot.receive(std::span(request).subspan(begin, size), now);
      begin += size;
      if (*rc::gen::inRange(0, 4) == 0) now += between(0.0, 0.5);
    }
  }
  return now;
}

struct Kind {
  MotorModel model;
  EpuckProgram protocol;
};
void PrintTo(const Kind& kind, std::ostream* out) {
  *out << (kind.protocol == EpuckProgram::wifi ? "e-puck2 over WiFi"
           : kind.model == MotorModel::epuck1  ? "e-puck1"
                                               : "e-puck2");
}

class Resynchronisation : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Resynchronisation,
                         testing::Values(Kind{MotorModel::epuck1, EpuckProgram::asercom},
                                         Kind{MotorModel::epuck2, EpuckProgram::asercom},
                                         Kind{MotorModel::epuck2, EpuckProgram::wifi}));

constexpr LinkOptions patient_link{.reply_timeout = 0.2, .stop_repeat = 0.2, .command_silence = 0.0};

std::unique_ptr<LinkSession> session_of(EpuckProgram protocol) {
  if (protocol == EpuckProgram::wifi) return std::make_unique<WifiSession>(patient_link);
  return std::make_unique<AsercomSession>(patient_link);
}

TEST_P(Resynchronisation, StopsARobotAfterAnythingAtAll) {
  test::holds("one stop stops it, and the link comes up", [kind = GetParam()] {
    std::vector<Fault> faults(*rc::gen::inRange<std::size_t>(0, 6));
    for (Fault& fault : faults) fault = any_fault();
    EmulatedEpuck robot(kind.model, 0.0, faults_of(faults, 0), *rc::gen::arbitrary<std::uint16_t>(), kind.protocol);
    // Long enough for all that was in the air to come down.
    double now = std::max(suffer(robot, kind.protocol), faults_end) + 100.0;
    robot.advance(now);
    (void)robot.take();

    robot.accept();  // a new connection, on which the parser of an asercom robot is where the old one left it
    const auto session = session_of(kind.protocol);
    session->opened(now);
    const auto exchange = [&] {
      const Bytes request(session->output().begin(), session->output().end());
      session->sent(request.size(), now);
      robot.receive(request, now);
      now += step;
      robot.advance(now);
      session->received(robot.take(), now);
      session->advance(now);
    };
    exchange();
    RC_ASSERT(robot.wheels() == core::WheelSpeeds{});  // already
    for (int turn = 0; turn < 12 && !session->up(); ++turn) exchange();
    RC_ASSERT(session->up());
    RC_ASSERT(robot.wheels() == core::WheelSpeeds{});
    for (std::uint16_t turn = 1; turn < 5 && robot.wheels() == core::WheelSpeeds{}; ++turn) {
      session->command({100, 100}, turn, now);  // waits while a heartbeat is out
      exchange();
    }
    RC_ASSERT(robot.wheels() == (core::WheelSpeeds{100, 100}));
  });
}

}  // namespace
}  // namespace skein::comms
