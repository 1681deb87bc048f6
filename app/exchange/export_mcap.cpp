// A run as topics: /group, /r1, /r2 ... with the CSV's columns; /events and /tf in the words that Foxglove's own panels
// know.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/exchange/json_cell.h"
#include "app/exchange/mcap_writer.h"
#include "app/exchange/run_exporter.h"
#include "app/record/csv_columns.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t second = 1'000'000'000;

Json time_schema() {
  return {{"type", "object"}, {"properties", {{"sec", {{"type", "integer"}}}, {"nsec", {{"type", "integer"}}}}}};
}
Json numbers_schema(std::initializer_list<const char*> names) {
  Json schema{{"type", "object"}, {"properties", Json::object()}};
  for (const char* const name : names) schema["properties"][name] = {{"type", "number"}};
  return schema;
}

/// foxglove.Log: what its log panel shows.
std::string log_schema() {
  Json schema{{"title", "foxglove.Log"}, {"type", "object"}, {"properties", Json::object()}};
  Json& keys = schema["properties"];
  keys["timestamp"] = time_schema();
  keys["level"] = {{"type", "integer"}};
  for (const char* const text : {"message", "name", "file"}) keys[text] = {{"type", "string"}};
  keys["line"] = {{"type", "integer"}};
  return schema.dump();
}

/// foxglove.FrameTransforms: where its 3D panel shows the robots, frames r1, r2 ... in the frame world.
std::string frames_schema() {
  Json frame{{"type", "object"}, {"properties", Json::object()}};
  frame["properties"]["timestamp"] = time_schema();
  for (const char* const text : {"parent_frame_id", "child_frame_id"}) frame["properties"][text] = {{"type", "string"}};
  frame["properties"]["translation"] = numbers_schema({"x", "y", "z"});
  frame["properties"]["rotation"] = numbers_schema({"x", "y", "z", "w"});
  return Json{{"title", "foxglove.FrameTransforms"},
              {"type", "object"},
              {"properties", {{"transforms", {{"type", "array"}, {"items", frame}}}}}}
      .dump();
}

std::string stamp(std::uint64_t time) {
  return fmt::format(R"({{"sec":{},"nsec":{}}})", time / second, time % second);
}

class McapExporter final : public RunExporter {
 public:
  McapExporter(const CsvReader& reader, const ExportOptions& options)
      : reader_(reader), epoch_(options.epoch), mcap_(options.compressed), topics_(reader.robots() + 1) {
    const CsvHead& head = reader.head();
    mcap_.metadata("skein", {{"version", head.version},
                             {"experiment", head.name},
                             {"hash", head.hash},
                             {"seed", std::to_string(head.seed)}});
    mcap_.attach("experiment.toml", "application/toml", head.source);
    for (std::size_t i = 0; i < reader.columns().size(); ++i) sort_in(i);
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      Json schema{{"type", "object"}, {"properties", Json::object()}};
      for (const auto& [column, key, words] : topics_[i].keys)
        schema["properties"][key] = {{"type", words ? "string" : "number"}};
      topics_[i].channel = mcap_.add_channel(i == 0 ? "/group" : fmt::format("/r{}", i),
                                             i == 0 ? "skein.Group" : "skein.Robot", schema.dump());
    }
    events_ = mcap_.add_channel("/events", "foxglove.Log", log_schema());
    frames_ = mcap_.add_channel("/tf", "foxglove.FrameTransforms", frames_schema());
  }

  void row(const TickRecord& record) override {
    const auto time =
        static_cast<std::uint64_t>(std::llround(std::max(0.0, epoch_ + record.now) * static_cast<double>(second)));
    for (const Topic& topic : topics_) {
      json_ = "{";
      for (const auto& [column, key, words] : topic.keys) {
        const std::string_view cell = reader_.cells()[column];
        if (cell.empty()) continue;  // JSON has no NaN
        json_ += fmt::format("\"{}\":{},", key, json_cell(cell, words));
      }
      if (json_.back() == ',') json_.pop_back();
      json_ += '}';
      mcap_.message(topic.channel, time, json_);
    }
    for (const Event& event : record.events) {
      constexpr int info = 2;
      mcap_.message(events_, time,
                    Json{{"timestamp", {{"sec", time / second}, {"nsec", time % second}}},
                         {"level", info},
                         {"message", describe(event)},
                         {"name", "skein"},
                         {"file", ""},
                         {"line", 0}}
                        .dump(-1, ' ', false, Json::error_handler_t::replace));
    }
    json_ = R"({"transforms":[)";
    for (std::size_t i = 0; i < record.robots.size(); ++i) {
      const core::Pose& pose = record.robots[i].pose;
      if (!std::isfinite(pose.x + pose.y + pose.theta)) continue;
      json_ += fmt::format(
          R"({{"timestamp":{},"parent_frame_id":"world","child_frame_id":"r{}","translation":{{"x":{},"y":{},"z":0}},)"
          R"("rotation":{{"x":0,"y":0,"z":{},"w":{}}}}},)",
          stamp(time), i + 1, pose.x, pose.y, core::math::sin(0.5 * pose.theta), core::math::cos(0.5 * pose.theta));
    }
    if (json_.back() == ',') json_.pop_back();
    mcap_.message(frames_, time, json_ + "]}");
  }

  void finish() override { mcap_.finish(); }
  std::string take() override { return mcap_.take(); }

 private:
  struct Key {
    std::size_t column;
    std::string name;
    bool words;
  };
  struct Topic {
    McapWriter::Channel channel = 0;
    std::vector<Key> keys;
  };

  /// Columns "r<i>_..." belong to a robot; an event is a message of its own.
  void sort_in(std::size_t column) {
    const std::string& name = reader_.columns()[column];
    if (name == "event") return;
    std::size_t topic = 0, cut = 0;
    for (std::size_t i = 1; i < topics_.size(); ++i)
      if (const std::string prefix = fmt::format("r{}_", i); name.starts_with(prefix)) topic = i, cut = prefix.size();
    topics_[topic].keys.push_back({column, name.substr(cut), holds_words(name)});
  }

  const CsvReader& reader_;
  double epoch_;
  McapWriter mcap_;
  std::vector<Topic> topics_;
  McapWriter::Channel events_ = 0, frames_ = 0;
  std::string json_;
};

}  // namespace

std::unique_ptr<RunExporter> mcap_exporter(const CsvReader& reader, const ExportOptions& options) {
  return std::make_unique<McapExporter>(reader, options);
}

}  // namespace skein::app
