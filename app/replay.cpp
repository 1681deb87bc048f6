#include "app/replay.h"

#include <fmt/format.h>

#include <bit>
#include <span>

#include "app/control_tick.h"
#include "app/csv_reader.h"
#include "app/experiment_file.h"

namespace skein::app {
namespace {

/// What the operator did at a recorded tick.
std::vector<OperatorCommand> commands_of(const TickRecord& row) {
  std::vector<OperatorCommand> commands;
  for (const Event& event : row.events) switch (event.kind) {
      case Event::Kind::gain:
        commands.push_back({OperatorCommand::Kind::gain, event.gain, event.values[1]});
        break;
      case Event::Kind::start:
        commands.push_back({OperatorCommand::Kind::start, {}, 0.0});
        break;
      case Event::Kind::pause:
        commands.push_back({OperatorCommand::Kind::pause, {}, 0.0});
        break;
      case Event::Kind::resume:
        commands.push_back({OperatorCommand::Kind::resume, {}, 0.0});
        break;
      default:
        break;
    }
  return commands;
}

bool contains(const EventList& events, Event::Kind kind) {
  for (const Event& event : events)
    if (event.kind == kind) return true;
  return false;
}

bool same_bits(double a, double b) noexcept {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

void compare(const TickRecord& recorded, const TickRecord& again, ReplayResult& result) {
  for (std::size_t i = 0; i < recorded.robots.size(); ++i) {
    const RobotRecord& a = recorded.robots[i];
    const RobotRecord& b = again.robots[i];
    struct Value {
      const char* name;
      double recorded, again;
    };
    const Value values[] = {{"v", a.command.v, b.command.v},
                            {"omega", a.command.omega, b.command.omega},
                            {"wheel_left", a.wheels.left, b.wheels.left},
                            {"wheel_right", a.wheels.right, b.wheels.right}};
    bool same = true;
    for (const Value& value : values) {
      if (same_bits(value.recorded, value.again)) continue;
      same = false;
      if (result.first.empty())
        result.first = fmt::format("tick {} (t = {} s), r{}_{}: recorded {}, replayed {}", recorded.tick, recorded.t,
                                   i + 1, value.name, value.recorded, value.again);
    }
    ++result.commands;
    result.different += same ? 0 : 1;
  }
}

}  // namespace

tl::expected<ReplayResult, std::string> replay(std::istream& csv, const std::string& file) {
  auto reader = CsvReader::open(csv, file);
  if (!reader) return tl::unexpected(reader.error());
  const auto experiment = parse_experiment(reader->head().source, file + " (experiment)");
  if (!experiment) return tl::unexpected(experiment.error().front().message());
  if (experiment->robots.size() != reader->robots())
    return tl::unexpected(fmt::format("{}: {} robots in its experiment, but {} in its columns", file,
                                      experiment->robots.size(), reader->robots()));
  ReplayResult result;
  result.experiment = reader->head().name;
  if (!reader->head().intact)
    result.warnings.push_back("the experiment in the file has been changed since it was recorded");
  if (reader->head().version != SKEIN_VERSION)
    result.warnings.push_back(fmt::format("recorded by skein {}, replayed by " SKEIN_VERSION, reader->head().version));

  ControlTick tick(*experiment);
  std::vector<core::Measurement> measurements(experiment->robots.size());
  TickRecord row;
  std::int64_t last_tick = 0;
  while (true) {
    const auto more = reader->next(row);
    if (!more) return tl::unexpected(more.error());
    if (!*more) break;
    for (std::size_t i = 0; i < measurements.size(); ++i) measurements[i] = row.robots[i].measurement;
    const std::vector<OperatorCommand> commands = commands_of(row);
    TickInput input;
    input.now = row.now;
    input.elapsed = static_cast<int>(std::max<std::int64_t>(1, row.tick - last_tick));
    input.stop = contains(row.events, Event::Kind::stop);
    input.measurements = measurements;
    input.commands = commands;
    for (const Event& event : row.events)
      if (event.kind == Event::Kind::perturb || event.kind == Event::Kind::move) input.events.add(event);
    compare(row, tick.step(input), result);
    last_tick = row.tick;
    ++result.ticks;
  }
  return result;
}

}  // namespace skein::app
