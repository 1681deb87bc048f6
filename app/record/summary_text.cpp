#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/record/statistics.h"
#include "app/run/terminal_text.h"

namespace skein::app {
namespace {

using Json = nlohmann::ordered_json;

/// To a millionth: of a metre, of a second. What is left out is noise, and the numbers stay readable. Never -0.
double rounded(double value) {
  return std::round(value * 1e6) / 1e6 + 0.0;
}

Json json(double value) {
  return std::isfinite(value) ? Json(rounded(value)) : Json();
}
Json json(const std::optional<double>& value) {
  return value ? json(*value) : Json();
}
std::vector<int> from_one(const std::vector<int>& robots) {
  std::vector<int> numbers = robots;
  for (int& number : numbers) ++number;
  return numbers;
}

Json json(const PerturbationResult& p, bool waits) {
  Json result{{"t", json(p.t)},
              {"robot", p.robot + 1},
              {"what", p.what},
              {"formation_1cm", json(p.settling.formation_1cm)},
              {"formation_5mm", json(p.settling.formation_5mm)},
              {"tracking_1cm", json(p.settling.tracking_1cm)},
              {"tracking_5mm", json(p.settling.tracking_5mm)},
              {"relative_1cm", json(p.settling.relative_1cm)},
              {"relative_5mm", json(p.settling.relative_5mm)},
              {"formation_first", p.formation_first()},
              {"relative_first", p.relative_first()},
              {"others_away", json(p.others_away)}};
  if (waits)
    result.update({{"whole_1cm", json(p.settling.whole_1cm)},
                   {"whole_5mm", json(p.settling.whole_5mm)},
                   {"whole_5mm_after", json(p.settling.whole_5mm_after)}});
  return result;
}

Json json(const Histogram& histogram) {
  return {{"median", json(histogram.quantile(0.5))},
          {"p99", json(histogram.quantile(0.99))},
          {"largest", json(histogram.largest())}};
}

/// Those stages that there were, and the whole way.
Json latency(const Statistics::Summary& s) {
  Json result = Json::object();
  for (std::size_t stage = 0; stage < stages; ++stage)
    if (s.latency[stage].total() > 0) result[std::string(word(static_cast<Stage>(stage)))] = json(s.latency[stage]);
  if (s.latency_total.total() > 0) result["total"] = json(s.latency_total);
  return result;
}

Json lateness(const Histogram& late) {
  return {{"p50", json(late.quantile(0.5))},
          {"p99", json(late.quantile(0.99))},
          {"p999", json(late.quantile(0.999))},
          {"largest", json(late.largest())}};
}

/// The timing certificate: how late ticks began, beside a thread that did nothing else.
Json timing(const std::optional<Timing>& timing) {
  Json result = Json::object();
  if (!timing || timing->tick.total() == 0) return result;
  result["tick"] = lateness(timing->tick);
  result["bare_thread"] = lateness(timing->bare);
  result["real_time_priority"] = timing->priority > 0 ? Json(timing->priority) : Json();
  if (timing->priority == 0) result["no_priority"] = timing->no_priority;
  if (timing->cpu_latency) result["cpu_latency_limit"] = 1e-6 * *timing->cpu_latency;
  if (!timing->no_cpu_latency.empty()) result["no_cpu_latency_limit"] = timing->no_cpu_latency;
  if (timing->memory_locked) result["memory_locked"] = true;
  if (!timing->no_memory_lock.empty()) result["no_memory_lock"] = timing->no_memory_lock;
  return result;
}

Json json(int robot, const RobotStatus& link) {
  return {{"robot", robot + 1},
          {"link", word(link.link)},
          {"reason", link.reason},
          {"version", link.version},
          {"battery", json(link.battery)},
          {"rtt_median", json(link.round_trip)},
          {"rtt_p99", json(link.round_trip_p99)},
          {"exchanges", link.exchanges},
          {"timeouts", link.timeouts},
          {"resynchronisations", link.resynchronisations},
          {"reconnects", link.reconnects},
          {"bytes_sent", link.bytes_sent},
          {"bytes_received", link.bytes_received}};
}

/// The summary once, for both forms: what stands here in this order stands in the lines as well.
Json json(const Statistics::Summary& s) {
  Json result{{"name", s.name},
              {"ticks", s.ticks},
              {"duration", json(s.duration)},
              {"final_error", json(s.final_error)},
              {"final_formation_error", json(s.final_formation_error)},
              {"arrived", json(s.arrived)},
              {"min_distance", json(s.min_distance)},
              {"obstacle_gap", json(s.obstacle_gap)},
              {"outside", json(s.outside)},
              {"collisions", s.collisions},
              {"missed_deadlines", s.missed_deadlines},
              {"dropped_rows", s.dropped_rows},
              {"camera_outages", s.camera_outages},
              {"camera_damaged", s.camera_damaged},
              {"video_frames", s.video_frames},
              {"video_dropped", s.video_dropped},
              {"video_problem", s.video_problem},
              {"largest_period", json(s.largest_period)},
              {"median_compute", json(s.median_compute)},
              {"largest_compute", json(s.largest_compute)},
              {"latency", latency(s)},
              {"timing", timing(s.timing)},
              {"loop_delay", json(s.loop_delay)},
              {"delay_margin", json(s.delay_margin)},
              {"stopped", s.stopped},
              {"failure", s.failure},
              {"not_stopped", from_one(s.not_stopped)},
              {"links", Json::array()},
              {"perturbations", Json::array()},
              {"events", Json::array()}};
  if (s.largest_lag) result["largest_lag"] = json(s.largest_lag), result["final_lag"] = json(s.final_lag);
  if (s.run_into) result["run_into"] = *s.run_into;
  if (!s.kept.empty()) result["kept"] = s.kept;
  if (s.published) result["published_rows"] = s.published->sent, result["published_dropped"] = s.published->dropped;
  for (const auto& [robot, link] : s.links) result["links"].push_back(json(robot, link));
  for (const PerturbationResult& p : s.perturbations)
    result["perturbations"].push_back(json(p, s.largest_lag.has_value()));
  for (const auto& [t, what] : s.events) result["events"].push_back({{"t", json(t)}, {"what", what}});
  return result;
}

/// Values as people read them: texts without quotes, "none" where there is no value.
std::string text(const Json& value) {
  if (value.is_null()) return "none";
  if (value.is_string()) return shown(value.get<std::string>());
  if (!value.is_array()) return value.dump();
  std::string list;
  for (const Json& element : value) list += (list.empty() ? "" : " ") + text(element);
  return list.empty() ? "none" : list;
}

}  // namespace

std::string as_lines(const Statistics::Summary& summary) {
  std::string lines;
  const Json all = json(summary);
  for (const auto& [key, value] : all.items()) {
    if (key == "perturbations") {
      for (std::size_t i = 0; i < value.size(); ++i)
        for (const auto& [name, part] : value[i].items())
          lines += fmt::format("perturbation_{}_{}: {}\n", i + 1, name, text(part));
    } else if (key == "latency") {
      for (const auto& [stage, part] : value.items())
        for (const auto& [what, seconds] : part.items())
          lines += fmt::format("latency_{}_{}: {}\n", stage, what, text(seconds));
    } else if (key == "timing") {
      for (const auto& [what, part] : value.items()) {
        if (!part.is_object()) {
          lines += fmt::format("timing_{}: {}\n", what, text(part));
          continue;
        }
        for (const auto& [share, seconds] : part.items())
          lines += fmt::format("timing_{}_late_{}: {}\n", what, share, text(seconds));
      }
    } else if (key == "links") {
      for (const auto& link : value)
        for (const auto& [name, part] : link.items())
          if (name != "robot" && part != Json(""))
            lines += fmt::format("r{}_{}: {}\n", link["robot"].get<int>(), name, text(part));
    } else if (key == "events") {
      lines += fmt::format("events: {}\n", value.size());
    } else if (!value.is_string() || !value.get<std::string>().empty()) {
      lines += fmt::format("{}: {}\n", key, text(value));
    }
  }
  return lines;
}

std::string as_json(const Statistics::Summary& summary) {
  return json(summary).dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace skein::app
