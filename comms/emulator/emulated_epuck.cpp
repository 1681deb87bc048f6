#include "comms/emulator/emulated_epuck.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

namespace skein::comms {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double byte_time = 10.0 / 115200.0;  // start bit, 8 data bits, stop bit [s]
// The ring has 64 places and two counters of bytes received and read: what finds no room overwrites the oldest, and is
// read in its place as well as in its own.
constexpr std::size_t ring_places = 64;
constexpr double noticeable_latency = 0.02;  // median, there and back: half a tick [s]
constexpr double sigmas_to_p99 = 2.3263;     // of a Gaussian
// TCP sends again what was lost, as Linux does: after 0.2 s, then after twice as long, and so on, 15 times.
constexpr double first_retransmission = 0.2, longest_retransmission = 120.0;  // [s]
constexpr int retransmissions = 15;

// What a host may leave behind in the parser: half a line, a line that only lacks its end, binary commands that wait
// for all, for some or for 35 of their arguments.
constexpr std::array<std::string_view, 5> half_commands{"D,0", "D,900,900", "\xBC", "\xBC\x64\x03", "\x89"};

std::span<const std::uint8_t> as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

EmulatedEpuck::EmulatedEpuck(core::MotorModel model, double now, std::vector<Fault> faults, std::uint64_t seed,
                             EpuckProgram protocol)
    : EmulatedEpuck(std::make_unique<EpuckFirmware>(model, protocol), now, std::move(faults), seed) {}

EmulatedEpuck::EmulatedEpuck(std::unique_ptr<RobotFirmware> firmware, double now, std::vector<Fault> faults,
                             std::uint64_t seed)
    : firmware_(std::move(firmware)),
      epuck_(dynamic_cast<EpuckFirmware*>(firmware_.get())),
      faults_(std::move(faults)),
      random_(seed, 0),
      start_(now),
      time_(now),
      ring_read_at_(now) {
  advance(now);  // what is wrong from the beginning
}

const Fault* EmulatedEpuck::active(FaultKind kind) const noexcept {
  // The newest of its kind counts.
  const auto found =
      std::find_if(active_.rbegin(), active_.rend(), [kind](const Fault& fault) { return fault.kind == kind; });
  return found == active_.rend() ? nullptr : &*found;
}

bool EmulatedEpuck::carries() const noexcept {
  // Messages in a stream do not overtake one another: a late one holds up the next.
  if (!to_robot_.empty() && to_robot_.back().due > time_ + noticeable_latency) return false;
  if (loses() || active(FaultKind::stall)) return false;
  return std::none_of(active_.begin(), active_.end(), [](const Fault& fault) {
    return fault.kind == FaultKind::latency && fault.p99 > noticeable_latency;
  });
}

bool EmulatedEpuck::answers_late() const noexcept {
  return !to_host_.empty() && to_host_.back().due > time_ + noticeable_latency;
}

bool EmulatedEpuck::loses() const noexcept {
  return std::any_of(active_.begin(), active_.end(), [](const Fault& fault) {
    switch (fault.kind) {
      case FaultKind::loss:
      case FaultKind::burst:
      case FaultKind::corruption:
      case FaultKind::disconnect:
      case FaultKind::reboot:
        return true;
      case FaultKind::latency:
      case FaultKind::stall:
      case FaultKind::stuck:
      case FaultKind::ring:
      case FaultKind::battery:
      case FaultKind::swapped_wheels:
      case FaultKind::silent_encoders:
        break;
    }
    return false;
  });
}

// --- Time -----------------------------------------------------------------------------------------------------------

double EmulatedEpuck::next_event() const noexcept {
  double next = next_fault_ < faults_.size() ? start_ + faults_[next_fault_].at : never;
  for (const Fault& fault : active_) next = std::min(next, start_ + fault.end());
  if (!ring_.empty()) next = std::min(next, ring_read_at_);
  if (streams() && !off() && !active(FaultKind::stall)) next = std::min(next, stream_at_);
  if (!to_robot_.empty()) next = std::min(next, to_robot_.front().due);
  return std::min(next, time_ + firmware_->acts_in());
}

double EmulatedEpuck::deadline() const noexcept {
  return to_host_.empty() ? next_event() : std::min(next_event(), to_host_.front().due);
}

void EmulatedEpuck::advance(double now) {
  const auto pass = [this](double until) {
    firmware_->advance(until - time_);
    time_ = until;
  };
  for (double next = next_event(); next <= now; next = next_event()) {
    if (next > time_) pass(next);
    run_event(time_);
  }
  if (now > time_) pass(now);
}

void EmulatedEpuck::run_event(double now) {
  change_faults(now);
  if (const Fault* battery = active(FaultKind::battery))
    firmware_->set_battery(battery->volts - battery->sag * (now - start_ - battery->at) / 60.0);
  if (!ring_.empty() && ring_read_at_ <= now) {
    std::vector<std::uint8_t> bytes = std::exchange(ring_, {});
    for (std::size_t k = bytes.size(); k-- > ring_places;) bytes[k - ring_places] = bytes[k];
    hear(bytes, now);
  }
  if (streams() && !off() && !active(FaultKind::stall) && stream_at_ <= now) {
    std::vector<std::uint8_t> packet;
    epuck_->stream(packet);
    send(to_host_, packet, now);
    stream_at_ = now + EpuckFirmware::stream_period;
  }
  while (!to_robot_.empty() && to_robot_.front().due <= now) {
    const Message message = std::move(to_robot_.front());
    to_robot_.pop_front();
    deliver(message.bytes, now);
  }
}

// --- Faults ---------------------------------------------------------------------------------------------------------

void EmulatedEpuck::change_faults(double now) {
  for (std::size_t i = 0; i < active_.size();) {
    if (start_ + active_[i].end() > now) {
      ++i;
      continue;
    }
    const Fault over = active_[i];
    active_.erase(active_.begin() + static_cast<std::ptrdiff_t>(i));
    end(over);
  }
  for (; next_fault_ < faults_.size() && start_ + faults_[next_fault_].at <= now; ++next_fault_) {
    const Fault& fault = faults_[next_fault_];
    if (fault.duration > 0.0) active_.push_back(fault);
    begin(fault);
  }
  firmware_->swap_wheels(active(FaultKind::swapped_wheels) != nullptr);
  firmware_->silence_encoders(active(FaultKind::silent_encoders) != nullptr);
}

void EmulatedEpuck::begin(const Fault& fault) {
  if (fault.kind == FaultKind::disconnect) {
    ++breaks_;
    forget_messages();
  }
  if (fault.kind == FaultKind::reboot) {
    firmware_->boot();
    hosts_ = 0;
    forget_messages();
    if (fault.duration <= 0.0) end(fault);
  }
  if (fault.kind == FaultKind::stuck && !off() && epuck_ && !over_tcp()) {
    const auto which = static_cast<std::size_t>(random_.uniform() * static_cast<double>(half_commands.size()));
    std::vector<std::uint8_t> answer;  // a half command has none
    epuck_->forget_half_command();     // two halves must not make a command that was never sent
    firmware_->receive(as_bytes(half_commands[which]), answer);
  }
}

void EmulatedEpuck::end(const Fault& fault) {
  if (fault.kind == FaultKind::reboot && !off()) send(to_host_, as_bytes(firmware_->greeting()), time_);
}

void EmulatedEpuck::reboot() {
  begin({.kind = FaultKind::reboot, .duration = 0.0});
}

void EmulatedEpuck::accept() {
  forget_messages();
  firmware_->new_host();
  if (over_tcp()) ++hosts_;
}

void EmulatedEpuck::forget_messages() {
  to_robot_.clear();
  to_host_.clear();
  ring_.clear();
}

// --- Bytes ----------------------------------------------------------------------------------------------------------

/// Whether a message is lost that is sent at a time from now on. Over TCP one that arrives as another counts too: a
/// checksum finds it.
bool EmulatedEpuck::lost(std::size_t bytes, double at) {
  const auto loses_it = [&](const Fault& fault) {
    if (start_ + fault.at > at || start_ + fault.end() <= at) return false;
    if (fault.kind == FaultKind::burst) return true;
    if (fault.kind == FaultKind::loss) return random_.uniform() < fault.share;
    const bool checked = over_tcp() && fault.kind == FaultKind::corruption;
    return checked && random_.uniform() > std::pow(1.0 - fault.share, static_cast<double>(bytes));
  };
  bool any = std::any_of(active_.begin(), active_.end(), loses_it);
  for (std::size_t i = next_fault_; !any && i < faults_.size() && start_ + faults_[i].at <= at; ++i)
    any = loses_it(faults_[i]);
  return any;
}

/// When it leaves for the other end; infinity: never.
double EmulatedEpuck::carried_at(std::size_t bytes, double now) {
  if (!over_tcp()) return lost(bytes, now) ? never : now;
  double wait = first_retransmission;
  for (int k = 0; k <= retransmissions; ++k) {
    if (!lost(bytes, now)) return now;
    now += std::min(std::exchange(wait, 2.0 * wait), longest_retransmission);
  }
  return never;
}

void EmulatedEpuck::send(std::deque<Message>& way, std::span<const std::uint8_t> bytes, double now) {
  if (bytes.empty() || !connected()) return;
  const double carried = carried_at(bytes.size(), now);
  if (carried == never) return;
  Message message{carried, {bytes.begin(), bytes.end()}};
  if (const Fault* corruption = active(FaultKind::corruption); corruption && !over_tcp())
    for (std::uint8_t& byte : message.bytes)
      if (random_.uniform() < corruption->share)
        byte = static_cast<std::uint8_t>(byte ^ (1 + static_cast<int>(255.0 * random_.uniform())));
  if (const Fault* latency = active(FaultKind::latency)) {
    const double sigma = std::log(latency->p99 / latency->median) / sigmas_to_p99;
    message.due += 0.5 * latency->median * std::exp(sigma * random_.gaussian());
    if (&way == &to_robot_) held_up_until_ = std::max(held_up_until_, message.due);
  }
  if (adapter_) message.due = std::max(message.due, adapter_->arrival(place_, &way == &to_robot_, bytes.size(), now));
  if (!way.empty()) message.due = std::max(message.due, way.back().due);  // a stream: no message overtakes another
  way.push_back(std::move(message));
}

void EmulatedEpuck::receive(std::span<const std::uint8_t> bytes, double now) {
  advance(now);
  send(to_robot_, bytes, now);
  advance(now);
}

void EmulatedEpuck::deliver(std::span<const std::uint8_t> bytes, double now) {
  if (off()) return;
  if (!active(FaultKind::ring) || over_tcp()) return hear(bytes, now);
  ring_.insert(ring_.end(), bytes.begin(), bytes.end());
  ring_read_at_ = std::max(ring_read_at_, now) + static_cast<double>(bytes.size()) * byte_time;
}

void EmulatedEpuck::hear(std::span<const std::uint8_t> bytes, double now) {
  if (!streams()) stream_at_ = now;  // its loop, which waited for a first command, takes it at once
  std::vector<std::uint8_t> answer;
  firmware_->receive(bytes, answer);
  send(to_host_, answer, now);
}

std::vector<std::uint8_t> EmulatedEpuck::take() {
  std::vector<std::uint8_t> bytes;
  while (!to_host_.empty() && to_host_.front().due <= time_) {
    bytes.insert(bytes.end(), to_host_.front().bytes.begin(), to_host_.front().bytes.end());
    to_host_.pop_front();
  }
  return bytes;
}

}  // namespace skein::comms
