#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/session/link_watch.h"
#include "comms/asercom.h"
#include "comms/asercom_session.h"
#include "comms/emulator/emulated_epuck.h"

namespace skein::test {

/// Four emulated e-pucks, the links to them and a control thread that commands them 25 times a second, or at another
/// period, in virtual time and steps of a millisecond: what the links' and the recorder's thread do on the wall clock,
/// without either.
class FailureLinks {
 public:
  static constexpr std::size_t robots = 4;
  static constexpr double tick = 0.04, look = 0.02, step = 0.001;  // [s]

  explicit FailureLinks(const std::vector<comms::Fault>& faults, double bridge = app::FailureSpec{}.link_bridge,
                        double period = tick, double command_silence = comms::LinkOptions{}.command_silence)
      : watch_({0, 1, 2, 3}, bridge, true), tick_steps_(static_cast<int>(std::lround(period / step))) {
    options_.command_silence = command_silence;
    options_.reply_timeout = app::LinksSpec{}.reply_timeout;
    for (std::size_t i = 0; i < robots; ++i)
      links_.push_back(std::make_unique<Link>(options_, comms::faults_of(faults, i), i));
  }

  /// Until `time`, commanding while `ticking`.
  void run_until(double time, bool ticking = true) {
    for (; now_ < time - 0.5 * step; now_ = step * ++steps_) {
      if (ticking && steps_ % tick_steps_ == 0) {
        watch_.tell(events_);
        for (const app::Event& event : events_) told_.emplace_back(now_, app::describe(event));
        const app::EventList told = std::exchange(events_, {});
        // Another one every time: what a robot obeys can be seen.
        for (std::size_t i = 0; i < robots && !on_tick; ++i) command(i, comms::clamped(300 + steps_ % 80, 300));
        if (on_tick) on_tick(told);
      }
      for (auto& link : links_) turn(*link);
      if (steps_ % 20 == 0) {
        std::vector<comms::LinkStatus> status;
        for (auto& link : links_) {
          status.push_back(link->session.status(now_));
          status.back().out_for = std::max(0.0, now_ - link->session.out_since());
          status.back().reconnects = link->reconnects;
        }
        if (auto lost = watch_.update(status); lost && !lost_at) lost_at = now_, why = *lost;
      }
    }
  }
  void stop() {
    for (auto& link : links_) link->session.stop(now_);
    for (auto& link : links_) turn(*link);
  }

  /// At each tick instead of a command to all: what the control thread was told.
  std::function<void(const app::EventList& told)> on_tick;
  void command(std::size_t robot, comms::WheelCommand speeds) {
    links_[robot]->session.command(speeds, ++ticket_, now_);
  }

  double now() const { return now_; }
  /// When the newest connection to it was made.
  double opened_at(std::size_t robot) const { return links_[robot]->opened_at; }
  /// As Link tells the tick.
  double blind_way(std::size_t robot) const {
    const comms::LinkSession& of = links_[robot]->session;
    return of.up() ? of.blind_way(now_) : std::max(of.blind_way(now_), options_.blind_distance);
  }
  bool stands(std::size_t robot) const { return links_[robot]->robot.wheels() == core::WheelSpeeds{}; }
  const comms::LinkSession& session(std::size_t robot) const { return links_[robot]->session; }
  const comms::EmulatedEpuck& robot(std::size_t robot) const { return links_[robot]->robot; }
  /// What the control thread was told, and when.
  const std::vector<std::pair<double, std::string>>& told() const { return told_; }
  std::optional<double> lost_at;  // when a link was found lost: all stop at once, where the file says so
  std::string why;

 private:
  struct Link {
    Link(const comms::LinkOptions& options, std::vector<comms::Fault> faults, std::uint64_t seed)
        : robot(core::MotorModel::epuck2, 0.0, std::move(faults), seed), session(options) {
      session.opened(0.0);
    }
    comms::EmulatedEpuck robot;
    comms::AsercomSession session;
    std::uint64_t breaks = 0;
    double again_at = 0.0, opened_at = 0.0;
    bool reopened = false;
    std::uint64_t reconnects = 0;
  };

  void turn(Link& link) {
    link.robot.advance(now_);
    if (link.robot.breaks() != link.breaks) {
      link.breaks = link.robot.breaks();
      link.session.lost("the line hung up", now_);
      link.again_at = now_ + options_.reconnect_first;
    }
    if (!link.session.open() && now_ >= link.again_at && link.robot.connected()) {
      link.session.opened(now_);
      link.opened_at = now_;
      link.reopened = true;
    }
    const auto heard = link.robot.take();
    if (link.session.open()) link.session.received(heard, now_);
    link.session.advance(now_);
    while (link.session.open() && !link.session.output().empty()) {
      const std::vector<std::uint8_t> bytes(link.session.output().begin(), link.session.output().end());
      link.session.sent(bytes.size(), now_);
      link.robot.receive(bytes, now_);
      link.session.received(link.robot.take(), now_);
    }
    if (link.session.up() && std::exchange(link.reopened, false)) ++link.reconnects;
  }

  comms::LinkOptions options_;
  std::vector<std::unique_ptr<Link>> links_;
  app::LinkWatch watch_;
  app::EventList events_;
  std::vector<std::pair<double, std::string>> told_;
  double now_ = 0.0;
  int steps_ = 0, tick_steps_;
  std::uint16_t ticket_ = 0;
};

}  // namespace skein::test
