#include "comms/link.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "comms/protocol.h"

namespace skein::comms {
Link::Link(LinkAddress address, const LinkOptions& options)
    : address_(std::move(address)),
      options_(options),
      fastest_(protocol_of(address_).unit.fastest),
      session_(protocol_of(address_).make_session(options)),
      wait_(options.reconnect_first) {}

WheelCommand Link::clamped(int left, int right) const noexcept {
  const auto clamp = [&](int speed) { return static_cast<std::int16_t>(std::clamp(speed, -fastest_, fastest_)); };
  return {clamp(left), clamp(right)};
}

pollfd Link::wanted() const noexcept {
  if (!transport_) return {.fd = -1, .events = 0, .revents = 0};  // poll() passes over negative descriptors
  const bool to_write = transport_->connecting() || (!session_->output().empty() && hushed_until_ == -never);
  return transport_->wanted(to_write);
}

double Link::deadline() const noexcept {
  if (!transport_) return try_at_;
  if (transport_->connecting()) return connecting_until_;
  if (hushed_until_ != -never) return hushed_until_;
  return std::min(session_->deadline(), session_->silent_since() + options_.silence_reconnect);
}

void Link::turn(short events, std::uint32_t emergency, double now) {
  if (!transport_ && now >= try_at_) open(now);
  if (transport_ && transport_->connecting()) {
    if (events != 0)
      finish_connecting(now);
    else if (now >= connecting_until_)
      lose({no_connection()}, now);
  }
  if (transport_ && (events & (POLLIN | POLLHUP | POLLERR)) != 0) read(now);
  if (transport_ && now < hushed_until_) return;
  hushed_until_ = -never;
  take_command(emergency, now);
  session_->advance(now);
  if (transport_ && session_->open() && now >= session_->silent_since() + options_.silence_reconnect)
    lose({fmt::format("the robot sent nothing for {:g} s", options_.silence_reconnect)}, now);
  if (transport_ && session_->garbled()) lose({session_->status(now).reason}, now);
  if (session_->up() && reopened_) {
    if (reached_) ++reconnects_;
    reached_ = true;
    reopened_ = false;
    refusal_.clear();
    wait_ = options_.reconnect_first;
  }
  write(now);
  if (transport_) transport_->set_stands(session_->stop_acknowledged());
}

void Link::open(double now) {
  // Once robots may drive, no search for whoever took this one's line may hold up the commands and stops of the others.
  auto transport = Transport::open(address_, /*name_holder=*/!reached_);
  if (!transport) {
    refusal_ = transport.error().reason;
    return lose(transport.error(), now);
  }
  transport_ = std::move(*transport);
  connecting_until_ = now + options_.connect_timeout;
  if (!transport_->connecting()) opened(now);
}

void Link::finish_connecting(double now) {
  if (const auto connected = transport_->finish_connecting(); !connected) {
    refusal_ = connected.error().reason;
    return lose(connected.error(), now);
  }
  opened(now);
}

std::string Link::no_connection() const {
  const std::string late = fmt::format("no connection within {:g} s", options_.connect_timeout);
  return refusal_.empty() ? late : fmt::format("{} (and then {})", refusal_, late);
}

void Link::opened(double now) {
  opened_at_ = now;
  reopened_ = true;
  session_->opened(now);
}

void Link::read(double now) {
  std::array<std::uint8_t, 512> bytes;
  // A few rounds: one robot that talks without end must not keep the others waiting.
  for (int round = 0; transport_ && !transport_->connecting() && round < 8; ++round) {
    const std::size_t undelivered = transport_->undelivered();
    const auto count = transport_->read(bytes);
    if (!count) return lose(count.error(), now);
    if (*count == 0) return;
    session_->undelivered(undelivered);
    session_->received(std::span(bytes).first(*count), now);
    if (session_->garbled()) return;
  }
}

void Link::take_command(std::uint32_t emergency, double now) {
  const CommandSlot::Content content = slot.content();
  if (content.ticket == taken_) return;
  taken_ = content.ticket;
  // Odd: stopped. Another epoch: given before a stop that has been released meanwhile.
  const bool void_now = (emergency & 1u) != 0 || content.epoch != static_cast<std::uint16_t>(emergency) || closing_;
  if (void_now)
    voided_ = content.ticket;
  else
    session_->command(content.command, content.ticket, now);
}

void Link::write(double now) {
  while (transport_ && !transport_->connecting() && !session_->output().empty()) {
    const auto count = transport_->write(session_->output());
    if (!count) return lose(count.error(), now);
    if (*count == 0) return;  // full: poll() says when there is room
    session_->sent(*count, now);
  }
}

void Link::note_times(double read_at, double written_at) noexcept {
  if (answered_ != session_->answered_ticket()) {
    answered_ = session_->answered_ticket();
    answered_at_.store(read_at);
  }
  const LinkSession::Written& written = session_->written();
  if (written.ticket != written_.ticket || written.count != written_.count) {
    written_ = written;
    written_at_.store(written_at);
    written_speeds_.store(std::uint32_t{static_cast<std::uint16_t>(written.speeds.left)} |
                          std::uint32_t{static_cast<std::uint16_t>(written.speeds.right)} << 16);
  }
  const double blind_way = session_->blind_way(written_at);
  blind_way_.store(session_->up() ? blind_way : std::max(blind_way, options_.blind_distance));
}

CommandTimes Link::times() const noexcept {
  const std::uint32_t speeds = written_speeds_.load();
  return {.written = written_at_.load(),
          .answered = answered_at_.load(),
          .speeds = {static_cast<std::int16_t>(speeds), static_cast<std::int16_t>(speeds >> 16)},
          .blind_way = blind_way_.load()};
}

void Link::lose(const TransportError& error, double now) {
  transport_.reset();
  reopened_ = false;
  session_->lost(error.reason, now);
  // A robot that was reached once may be moving: only a new connection can stop it, so that is tried for ever.
  failed_ = error.permanent && !reached_;
  try_at_ = failed_ ? never : now + wait_;
  wait_ = closing_ ? options_.reconnect_first : std::min(2.0 * wait_, options_.reconnect_longest);
}

void Link::stop(double now) {
  hushed_until_ = -never;
  voided_ = taken_;
  session_->stop(now);
}

void Link::begin_closing(double now) {
  closing_ = true;
  stop(now);
  if (!transport_) try_at_ = reached_ ? std::min(try_at_, now + options_.reconnect_first) : never;
}

void Link::fail(std::string reason, double now) {
  transport_.reset();
  session_->lost(std::move(reason), now);
  failed_ = true;
  try_at_ = never;
}

void Link::end() {
  ended_ = true;
  transport_.reset();
}

bool Link::settled() const noexcept {
  const std::uint16_t newest = slot.content().ticket;
  return newest == session_->answered_ticket() || newest == voided_;
}

bool Link::may_end() const noexcept {
  return session_->stop_acknowledged() || failed_ || (!reached_ && !session_->open());
}

double Link::worth_waiting_until() const noexcept {
  constexpr double stop_and_answer = 1.0;  // [s]
  if (!transport_ || may_end()) return 0.0;
  return stop_and_answer + (transport_->connecting() ? connecting_until_ : opened_at_);
}

LinkStatus Link::status(double now) const {
  LinkStatus status = session_->status(now);
  status.out_for = std::max(0.0, now - session_->out_since());
  status.reconnects = reconnects_;
  if (failed_ || (ended_ && !status.stop_acknowledged))
    status.state = LinkState::failed;
  else if (ended_)
    status.state = LinkState::closed;
  else if (transport_ && transport_->connecting())
    status.state = LinkState::connecting;
  return status;
}

}  // namespace skein::comms
