#include "app/doctor/checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/receive_buffer.h"
#include "vision/sources/open_source.h"

namespace skein::app::detail {
namespace {

namespace fs = std::filesystem;
using State = Finding::State;

/// Every camera of every experiment, with its file.
std::vector<std::pair<std::string, CameraSpec>> all_cameras(const Examination& examination) {
  std::vector<std::pair<std::string, CameraSpec>> all;
  for (const auto& [file, experiment] : examination.experiments)
    for (std::size_t k = 0; k < experiment.cameras(); ++k) all.emplace_back(file, experiment.camera_at(k));
  return all;
}

/// What the kernel holds of a GigE camera's frame while its receiver waits for a processor.
void check_receive_buffer(const Machine& machine, Findings& result) {
  constexpr double large_frame = 4 << 20;  // [bytes]
  const double limit = kernel_setting(machine, vision::receive_buffer_setting, 0.0);
  if (limit >= large_frame) return;
  const std::string setting = fmt::format("net.core.rmem_max={}", vision::good_receive_buffer_limit);
  result.push_back(
      {State::note,
       "receive buffer",
       fmt::format("{:.0f} bytes; a frame of a GigE camera may be larger, and is not whole when this machine "
                   "is busy",
                   limit),
       fmt::format("install skein-permissions, or as root: sysctl {}", setting),
       {{"sysctl", setting}}});
}

Findings cameras(const Machine& machine, const Examination& examination) {
  Findings result;
  const auto devices = entries(below(machine, "/sys/class/video4linux"), "video");
  std::vector<std::string> names;
  for (const fs::path& device : devices) {
    const std::string path = "/dev/" + device.filename().string();
    names.push_back(fmt::format("{} ({})", path, read(device / "name")));
    if (!machine.usable(path)) result.push_back(no_permission(machine, path, "video"));
  }
  bool wanted = false;
  bool receivers = false;
  std::map<const vision::SourceKind*, std::vector<std::string>> answered;  // asked once: an answer takes a second
  for (const auto& [file, camera] : all_cameras(examination)) {
    const auto address = vision::parse_source(camera.source);
    if (!address) continue;  // "none", "synthetic"
    const std::string& name = address->where;
    switch (address->kind->connection) {
      case vision::Connection::file:
        break;
      case vision::Connection::network: {
        const auto [of_kind, first] = answered.try_emplace(address->kind);
        std::vector<std::string>& there = of_kind->second;
        if (first) there = machine.network_cameras(*address->kind);
        if (std::find(there.begin(), there.end(), name) != there.end()) {
          names.push_back(name);
          receivers = true;
        } else {
          result.push_back({State::ill, name, fmt::format("does not answer; {} sees its robots with it", file),
                            "plug it in, or name another: skein camera list"});
        }
        break;
      }
      case vision::Connection::device: {
        wanted = true;
        std::error_code error;
        if (!devices.empty() && !fs::exists(below(machine, name), error))
          result.push_back({State::ill, name, fmt::format("is not there; {} uses it", file),
                            "plug it in, or name another: skein camera list"});
        break;
      }
    }
  }
  if (devices.empty() && !is_there(machine, device_classes))
    result.push_back(not_known("camera", device_classes, wanted ? State::ill : State::note));
  else if (devices.empty() && (wanted || (names.empty() && result.empty())))
    result.push_back({wanted ? State::ill : State::note, "camera", "none", "plug one in; skein camera list shows it"});
  else if (result.empty())
    result.push_back(well("camera", fmt::format("{}; examined by: skein camera doctor", fmt::join(names, ", "))));
  if (receivers) check_receive_buffer(machine, result);
  return result;
}

/// The calibrations of the experiments, and whether they agree about the tags that robots carry.
Findings calibrations(const Examination& examination) {
  Findings result;
  std::map<std::string, double> sizes;  // [m]
  for (const auto& [file, camera] : all_cameras(examination)) {
    if (camera.calibration.empty()) {
      if (camera.kind() == CameraKind::live)
        result.push_back({State::ill, "calibration", fmt::format("{} names none", file),
                          "skein calibrate, see docs/calibration.md"});
      continue;
    }
    const fs::path path = fs::path(file).parent_path() / camera.calibration;
    const auto calibration = load_calibration(path);
    if (!calibration) {
      result.push_back({State::ill, "calibration", calibration.error(), "skein calibrate, see docs/calibration.md"});
      continue;
    }
    if (!calibration->world_from_camera)
      result.push_back({State::ill, "calibration", fmt::format("{} has no pose of the camera", path.string()),
                        "skein calibrate floor"});
    sizes[path.string()] = calibration->tag_size;
  }
  if (sizes.empty()) return result;
  std::vector<std::string> words;
  double smallest = sizes.begin()->second, largest = smallest;
  for (const auto& [path, size] : sizes) {
    words.push_back(fmt::format("{:g} mm in {}", 1e3 * size, path));
    smallest = std::min(smallest, size), largest = std::max(largest, size);
  }
  constexpr double rounding = 1e-6;  // of a number that was computed [m]
  if (largest - smallest > rounding)
    result.push_back({State::ill, "tag size", fmt::format("{}", fmt::join(words, ", ")),
                      "measure the black edge of a robot's tag; skein calibrate floor --tag-size"});
  else
    result.push_back(
        well("tag size", fmt::format("{}: measure the black edge of a robot's tag", fmt::join(words, ", "))));
  return result;
}

}  // namespace

Findings check_cameras(const Machine& machine, const Examination& examination) {
  Findings result = cameras(machine, examination);
  append(result, calibrations(examination));
  return result;
}

}  // namespace skein::app::detail
