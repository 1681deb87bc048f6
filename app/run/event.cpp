#include "app/run/event.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/words.h"

namespace skein::app {
namespace {

using namespace events;

// The words behind an event's own, in their order, for printing and reading alike. A kind of event that is in none of
// these does not compile.

void fields(auto&, one_of<Start, Pause, Resume, Stop, Stage, Staged, FilmBroken> auto&) {}

void fields(auto& io, one_of<Hold, Release, Lost, Found, Avoid, Clear, Deadlock, NoNumber, Obeys> auto& e) {
  io.number_of('r', e.robot);
}

void fields(auto& io, one_of<NoWay> auto& e) {
  io.number_of('r', e.robot);
  io.number_of_any('r', e.other, nobody);
  io.optional("margin", e.margin);
}

void fields(auto& io, one_of<Perturb, Kidnap> auto& e) {
  io.number_of('r', e.robot);
  io.named("dx", e.dx), io.named("dy", e.dy), io.named("dtheta", e.dtheta);
}

void fields(auto& io, one_of<Move> auto& e) {
  io.number_of('r', e.robot);
  io.named("x", e.pose.x), io.named("y", e.pose.y), io.named("theta", e.pose.theta);
}

void fields(auto& io, one_of<Kick> auto& e) {
  io.number_of('r', e.robot);
  io.named("vx", e.vx), io.named("vy", e.vy);
}

void fields(auto& io, one_of<PutObstacle> auto& e) {
  io.number_of('o', e.number);
  io.named("x", e.obstacle.x), io.named("y", e.obstacle.y), io.named("radius", e.obstacle.radius);
}

void fields(auto& io, one_of<Gain> auto& e) {
  io.word_of(e.gain);
  io.change(e.from, e.to);
  io.optional("ramp", e.ramp);
}

void fields(auto& io, one_of<Schedule, ScheduleTracking> auto& e) {
  io.word_of(e.gain);
  io.change(e.from, e.to);
}

void fields(auto& io, one_of<GainHeld> auto& e) {
  io.word_of(e.gain);
  io.change(e.asked, e.held);
}

void fields(auto& io, one_of<PairGain> auto& e) {
  io.number_of('r', e.i), io.number_of('r', e.j);
  io.word_of(e.gain);
  io.change(e.from, e.to);
  io.optional("ramp", e.ramp);
}

void fields(auto& io, one_of<PairGainHeld> auto& e) {
  io.number_of('r', e.i), io.number_of('r', e.j);
  io.word_of(e.gain);
  io.change(e.asked, e.held);
}

void fields(auto& io, one_of<Parameter> auto& e) {
  io.text(e.name);
  io.change(e.from, e.to);
}

void fields(auto& io, one_of<Couple, Uncouple> auto& e) {
  io.number_of('r', e.i), io.number_of('r', e.j);
}

void fields(auto& io, one_of<DeadlineMissed> auto& e) {
  io.bare(e.ticks);
}

void fields(auto& io, one_of<NoProgress> auto& e) {
  io.number_of('r', e.robot);
  io.bare(e.distance);
  io.word_of(e.hindrance);
}

void fields(auto& io, one_of<Runaway> auto& e) {
  io.number_of('r', e.robot);
  io.bare(e.v);
}

void fields(auto& io, one_of<Outside> auto& e) {
  io.number_of('r', e.robot);
  io.bare(e.over);
}

void fields(auto& io, one_of<CameraMoved> auto& e) {
  io.number_of_any('c', e.camera, only_camera);
  io.named("tags", e.tags), io.named("by", e.by), io.named("turn", e.turn);
  io.optional("marks", e.marks), io.optional("scale", e.scale);
}

void fields(auto& io, one_of<CamerasDisagree, CamerasDiffer> auto& e) {
  io.number_of('r', e.robot);
  io.number_of('c', e.camera), io.number_of('c', e.other);
  io.named("by", e.by);
}

void fields(auto& io, one_of<PicturesLate> auto& e) {
  io.named("by", e.by);
}

void fields(auto& io, one_of<CameraLost, CameraFound> auto& e) {
  io.number_of('c', e.camera);
}

void fields(auto& io, one_of<VRise> auto& e) {
  io.bare(e.rise);
}

void fields(auto& io, one_of<events::Controller> auto& e) {
  io.word_of(e.state);
}

void fields(auto& io, one_of<events::NotSeen> auto& e) {
  io.number_of('r', e.robot);
  io.word_of(e.why);
}

void fields(auto& io, one_of<events::Link> auto& e) {
  io.number_of('r', e.robot);
  io.word_of(e.state);
}

/// Appends the words of an event to a text.
class Printer {
 public:
  explicit Printer(std::string& text) : text_(text) {}

  void number_of(char letter, std::size_t number) { append(" {}{}", letter, number + 1); }
  void number_of_any(char letter, std::size_t number, std::size_t unsaid) {
    if (number != unsaid) number_of(letter, number);
  }
  void named(std::string_view name, auto value) { append(" {}={}", name, value); }
  void optional(std::string_view name, auto value) {
    if (value > 0 || value < 0) named(name, value);
  }
  void change(double from, double to) { append(" {} -> {}", from, to); }
  void bare(auto value) { append(" {}", value); }
  void text(const ParameterName& name) { append(" {}", name.text()); }
  void word_of(auto value) { append(" {}", word(value)); }

 private:
  template <typename... T>
  void append(fmt::format_string<T...> format, T&&... values) {
    text_ += fmt::format(format, std::forward<T>(values)...);
  }
  std::string& text_;
};

/// Reads the same words one after the other; `whole` says whether they were all there and no others.
class Reader {
 public:
  explicit Reader(std::string_view text) : rest_(text) {}

  std::string_view next() {
    const std::size_t end = std::min(rest_.find(' '), rest_.size());
    const std::string_view part = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return part;
  }
  void number_of(char letter, std::size_t& number) {
    const std::string_view part = next();
    std::size_t from_one = 0;
    const bool good = part.starts_with(letter) && read(part.substr(1), from_one) && from_one > 0;
    ok_ = ok_ && good;
    if (good) number = from_one - 1;
  }
  void number_of_any(char letter, std::size_t& number, std::size_t unsaid) {
    number = unsaid;
    if (rest_.starts_with(letter)) number_of(letter, number);
  }
  void named(std::string_view name, auto& value) {
    std::string_view part = next();
    const bool good = part.starts_with(name) && part.substr(name.size()).starts_with('=');
    ok_ = ok_ && good && read(part.substr(name.size() + 1), value);
  }
  void optional(std::string_view name, auto& value) {
    if (rest_.starts_with(name) && rest_.substr(name.size()).starts_with('=')) named(name, value);
  }
  void change(double& from, double& to) {
    bare(from);
    ok_ = ok_ && next() == "->";
    bare(to);
  }
  void bare(auto& value) { ok_ = ok_ && read(next(), value); }
  void text(ParameterName& name) {
    const std::string_view part = next();
    ok_ = ok_ && is_plain_name(part);
    name = ParameterName(part);
  }
  template <typename Enum>
  void word_of(Enum& value) {
    const auto found = core::from_word<Enum>(next());
    ok_ = ok_ && found;
    if (found) value = *found;
  }
  bool whole() const noexcept { return ok_ && rest_.empty(); }

 private:
  template <typename Number>
  static bool read(std::string_view text, Number& value) {
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && stop == text.data() + text.size();
  }
  std::string_view rest_;
  bool ok_ = true;
};

/// Tries each kind of event for its word; two kinds may share one.
template <std::size_t... k>
std::optional<Event> parse(std::string_view text, std::index_sequence<k...>) {
  std::optional<Event> found;
  const std::string_view first = Reader(text).next();
  const auto read_as = [&]<typename Kind>(Kind event) {
    if (first != Kind::word) return false;
    Reader reader(text);
    reader.next();
    fields(reader, event);
    if (reader.whole()) found = event;
    return reader.whole();
  };
  (void)(read_as(std::variant_alternative_t<k, Event>{}) || ...);
  return found;
}

/// Asks whether all numbers of an event are finite.
struct Finite {
  bool all = true;
  void number_of(char, std::size_t) {}
  void number_of_any(char, std::size_t, std::size_t) {}
  void named(std::string_view, auto value) { all = all && std::isfinite(static_cast<double>(value)); }
  void optional(std::string_view, auto value) { all = all && std::isfinite(static_cast<double>(value)); }
  void change(double from, double to) { all = all && std::isfinite(from) && std::isfinite(to); }
  void bare(double value) { all = all && std::isfinite(value); }
  void word_of(auto) {}
  void text(const ParameterName&) {}
};

}  // namespace

std::optional<std::size_t> robot_of(const Event& event) noexcept {
  return std::visit(
      [](const auto& e) -> std::optional<std::size_t> {
        if constexpr (requires { e.robot; })
          return e.robot;
        else
          return std::nullopt;
      },
      event);
}

std::string describe(const Event& event) {
  return std::visit(
      [](const auto& e) {
        std::string text(e.word);
        Printer printer(text);
        fields(printer, e);
        return text;
      },
      event);
}

std::string describe(const EventList& events) {
  std::string text;
  for (const Event& event : events) text += (text.empty() ? "" : "; ") + describe(event);
  if (events.dropped() > 0) text += fmt::format("; +{} more", events.dropped());
  return text;
}

std::optional<Event> parse_event(std::string_view text) {
  return parse(text, std::make_index_sequence<std::variant_size_v<Event>>());
}

bool is_action(const Event& event) noexcept {
  return std::visit(
      Overloaded{
          [](const one_of<Move, Hold, Release, Kick, PutObstacle, Gain, PairGain, Parameter, Couple, Uncouple> auto&) {
            return true;
          },
          [](const one_of<Start, Pause, Resume, Stop, Perturb, Kidnap, Schedule, ScheduleTracking, GainHeld,
                          PairGainHeld, Lost, Found, Avoid, Clear, Stage, Staged, Deadlock, NoWay, NoProgress, Outside,
                          DeadlineMissed, VRise, events::Link, CameraMoved, PicturesLate, CamerasDisagree,
                          CamerasDiffer, CameraLost, CameraFound, events::NotSeen, FilmBroken, events::Controller,
                          NoNumber, Runaway, Obeys> auto&) { return false; },
      },
      event);
}

std::optional<Event> parse_action(std::string_view text) {
  const std::optional<Event> event = parse_event(text);
  if (!event || !is_action(*event)) return std::nullopt;
  Finite finite;
  std::visit([&](const auto& e) { fields(finite, e); }, *event);
  return finite.all ? event : std::nullopt;
}

}  // namespace skein::app
