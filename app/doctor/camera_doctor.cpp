#include "app/doctor/camera_doctor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <utility>

#include "app/experiment/toml_places.h"
#include "core/math/elementary.h"
#include "vision/diagnosis/camera_examination.h"
#include "vision/diagnosis/repeat_watch.h"
#include "vision/sources/open_source.h"
#include "vision/synthetic/synthetic_camera.h"
#include "vision/v4l2/camera_controls.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using State = Finding::State;

constexpr double settling = 1.0;  // [s]

Finding as_finding(const vision::CameraFinding& found) {
  State state = State::well;
  switch (found.state) {
    case vision::CameraFinding::State::well:
      break;
    case vision::CameraFinding::State::note:
      state = State::note;
      break;
    case vision::CameraFinding::State::ill:
      state = State::ill;
      break;
  }
  return {state, found.what, found.found, found.remedy};
}

/// Four robots that drive on a floor of 2 x 1.5 m: a camera without a fault.
class RenderedCamera final : public vision::FrameSource {
 public:
  RenderedCamera() : camera_(vision::overhead_calibration(2.0, 1.5)) {}
  vision::TimeStamps stamps() const override { return vision::TimeStamps::exposure_start; }
  std::string describe() const override { return "synthetic camera (1280x960, 25 frames/s, four robots)"; }
  tl::expected<bool, std::string> read(vision::Frame& frame) override {
    constexpr double rate = 25.0, radius = 0.3, turning = 0.3;
    const double t = frames_++ / rate;
    std::array<vision::SyntheticTag, 4> tags;
    for (int i = 0; i < 4; ++i) {
      const double angle = 1.5708 * i + turning * t;
      tags[static_cast<std::size_t>(i)] = {i + 1,
                                           {radius * core::math::cos(angle), radius * core::math::sin(angle), angle}};
    }
    camera_.render(tags, t, frame);
    return true;
  }

 private:
  vision::SyntheticCamera camera_;
  int frames_ = 0;
};

tl::expected<std::unique_ptr<vision::FrameSource>, std::string> open(const CameraCase& wanted) {
  if (wanted.source == "synthetic") return std::make_unique<RenderedCamera>();
  return vision::open_source(wanted.source, wanted.options);
}

std::string first_line(const fs::path& path) {
  std::string text;
  std::ifstream file(path);
  std::getline(file, text);
  return text;
}

/// A value to set by hand in place of an automatic; an exposure that keeps driving tags sharp. Drivers whose exposure
/// has no unit give whole numbers, which [camera] does not take: none for them.
std::optional<double> by_hand(const vision::CameraDescription& driver, const std::string& name, bool automatic) {
  constexpr double sharp = 0.005, most = 10.0;  // [s]
  const auto value = vision::present_setting(driver, name);
  if (!value || *value < 0.0 || name != "exposure") return value;
  if (*value > most) return {};
  return automatic ? std::min(*value, sharp) : *value;
}

/// The folder of the USB device that a video device belongs to; empty: none.
fs::path usb_device(const fs::path& system, const std::string& name) {
  std::error_code error;
  fs::path at = fs::canonical(system / "class/video4linux" / name / "device", error);
  for (int up = 0; !error && up < 4 && at.has_relative_path(); ++up, at = at.parent_path())
    if (fs::exists(at / "speed", error)) return at;
  return {};
}

}  // namespace

std::vector<Finding> driver_findings(const vision::CameraDescription& camera, int width, int height, double rate,
                                     double needed_rate) {
  std::vector<Finding> findings;
  const std::vector<std::string> automatics = vision::automatics_on(camera);
  if (automatics.empty()) findings.push_back({State::well, "automatics", "none of exposure, gain and focus is on", {}});
  for (const std::string& name : automatics) {
    const auto value = by_hand(camera, name, true);
    findings.push_back({State::note, fmt::format("automatic {}", name),
                        "is on: the picture changes by itself during a run",
                        value ? fmt::format("--set {}={:g}, and {} in [camera]", name, *value, name)
                              : "switch it off with the camera's own tool"});
  }
  std::vector<std::string> offers;
  std::string fast;
  for (const vision::CameraFormat& format : camera.formats) {
    if (format.width != width || format.height != height) continue;
    const auto most = std::max_element(format.rates.begin(), format.rates.end());
    if (most == format.rates.end()) {
      offers.push_back(format.format);
      continue;
    }
    offers.push_back(fmt::format("{} {:.4g}", format.format, *most));
    if (fast.empty() && *most >= needed_rate) fast = format.format;
  }
  if (offers.empty()) return findings;
  const bool slow = rate < 0.95 * needed_rate;
  findings.push_back({slow ? State::note : State::well, "formats",
                      fmt::format("at {}x{}, up to [frames/s]: {}", width, height, fmt::join(offers, ", ")),
                      !slow ? std::string()
                      : fast.empty()
                          ? "none is fast enough at this size: --size"
                          : fmt::format("--rate {:g} --format {}, and a shorter exposure", needed_rate, fast)});
  return findings;
}

std::vector<Finding> usb_findings(const fs::path& system, const std::string& device, int width, int height,
                                  double rate) {
  constexpr double usable = 0.8;  // of a port's speed
  std::error_code error;
  const fs::path target = fs::canonical(device, error);
  const fs::path usb = usb_device(system, (error ? fs::path(device) : target).filename().string());
  if (usb.empty()) return {};
  const double speed = std::atof(first_line(usb / "speed").c_str());  // [Mbit/s]
  if (speed <= 0.0) return {};
  const std::string bus = first_line(usb / "busnum");
  std::vector<fs::path> sharing;
  for (fs::directory_iterator it(system / "class/video4linux", error), end; !error && it != end; it.increment(error)) {
    const fs::path other = usb_device(system, it->path().filename().string());
    if (other.empty() || other == usb || first_line(other / "busnum") != bus) continue;
    if (std::find(sharing.begin(), sharing.end(), other) == sharing.end()) sharing.push_back(other);
  }
  const double needed = 16e-6 * width * height * rate;  // [Mbit/s]
  const std::string found = fmt::format(
      "{:g} Mbit/s; two bytes a pixel take {:.0f} at this size and rate{}", speed, needed,
      sharing.empty()
          ? std::string()
          : fmt::format("; {} other camera{} on the same bus", sharing.size(), sharing.size() == 1 ? "" : "s"));
  if (needed * static_cast<double>(sharing.size() + 1) <= usable * speed) return {{State::well, "USB", found, {}}};
  return {{State::note, "USB", found,
           sharing.empty() ? "a USB 3 port, or a format with less: --format GREY, NV12 or MJPG"
                           : "a port of another bus for each camera, or a format with less: --format MJPG"}};
}

std::string camera_table(const CameraCase& examined, const std::optional<vision::CameraDescription>& driver) {
  std::string table = fmt::format("[camera]\nsource = {}\n", toml_string(examined.source));
  if (!examined.calibration_file.empty())
    table += fmt::format("calibration = {}\n", toml_string(examined.calibration_file));
  else if (examined.source != "synthetic")
    table += "calibration = \"cal.toml\"    # that skein calibrate writes\n";
  if (!examined.options.trigger.empty()) table += fmt::format("trigger = {}\n", toml_string(examined.options.trigger));
  const std::vector<std::string> automatics = driver ? vision::automatics_on(*driver) : std::vector<std::string>();
  for (const std::string name : {"exposure", "gain", "focus"}) {
    const auto& settings = examined.options.controls;
    const auto asked = std::find_if(settings.begin(), settings.end(), [&](const auto& s) { return s.first == name; });
    const bool automatic = std::find(automatics.begin(), automatics.end(), name) != automatics.end();
    std::optional<double> value;
    if (asked != settings.end())
      value = asked->second;
    else if (driver)
      value = by_hand(*driver, name, automatic);
    if (!value) continue;
    table += fmt::format("{} = {:g}{}\n", name, *value, automatic ? "    # was automatic: look at the picture" : "");
  }
  return table;
}

tl::expected<CameraReport, std::string> examine_camera(const CameraCase& wanted) {
  auto source = open(wanted);
  if (!source) return tl::unexpected(source.error());
  const bool live = vision::is_camera(wanted.source);
  vision::CameraFacts facts{.needed_rate = wanted.needed_rate};
  if (wanted.calibration) facts.row_time = wanted.calibration->row_time;

  // A camera may know how its frames are stamped only once one has come.
  std::optional<vision::CameraExamination> examination;
  std::optional<double> first;
  vision::Frame frame;
  vision::RepeatWatch repeat_watch;
  std::int64_t frames = 0, repeated = 0;
  int width = 0, height = 0;
  for (;;) {
    repeat_watch.keep(frame);
    const auto more = (*source)->read(frame);
    if (!more) return tl::unexpected(more.error());
    if (!*more) break;
    if (!first) first = frame.captured_at + (live ? settling : 0.0);
    if (frame.captured_at - *first >= wanted.seconds) break;
    if (frame.captured_at >= *first) {
      if (!examination) {
        facts.stamps = (*source)->stamps();
        examination.emplace(facts);
        width = frame.width;
        height = frame.height;
      }
      examination->add(frame);
      ++frames;
      repeated += repeat_watch.repeats(frame) ? 1 : 0;
    }
    if (wanted.keep_going && !wanted.keep_going()) break;
  }
  const auto skipped = (*source)->skipped();
  if (!examination)
    return tl::unexpected((*source)->describe() + ": no frame came" +
                          (skipped.empty() ? "" : fmt::format(" (skipped {})", skipped.front())));

  CameraReport report;
  report.camera = (*source)->describe();
  const vision::CameraMeasurements measured = examination->measure();
  for (const vision::CameraFinding& finding : examination->judge(measured))
    report.findings.push_back(as_finding(finding));
  const auto calibrated = [&](State state, std::string found, std::string remedy) {
    report.findings.push_back({state, "calibration", std::move(found), std::move(remedy)});
  };
  if (wanted.calibration && (wanted.calibration->width != width || wanted.calibration->height != height))
    calibrated(State::ill,
               fmt::format("{} holds for {}x{}, the frames are {}x{}", wanted.calibration_file,
                           wanted.calibration->width, wanted.calibration->height, width, height),
               "skein calibrate at this size");
  if (wanted.calibration && !wanted.calibration->world_from_camera)
    calibrated(State::note, fmt::format("{} has no pose of the camera", wanted.calibration_file),
               "skein calibrate floor");
  const vision::SourceStatus status = (*source)->status();
  for (const std::string& notice : status.notices)
    report.findings.push_back(live ? Finding{State::note, "camera", notice, "skein camera list shows its settings"}
                                   : Finding{State::ill, "times", notice, "record it anew, with the frames' times"});
  for (const std::string& remark : status.remarks) report.findings.push_back({State::note, "film", remark, {}});
  if (status.passed_over > 0)
    report.findings.push_back(
        {State::note, "passed over",
         fmt::format("{} frames, of those that are missing: newer ones had come", status.passed_over),
         "this machine was too busy to read them: close other programs"});
  if (repeated > 0 && live)
    report.findings.push_back(
        {State::ill, "repeated frames",
         fmt::format(
             "{} of {} show, at least in a part, exactly what an earlier one showed; no pose is taken from them",
             repeated, frames),
         "a shorter exposure, more light or a lower --rate; a capture program: look whether its input runs"});
  if (status.damaged > 0)
    report.findings.push_back(
        {State::ill, "damaged frames",
         fmt::format("{}{}", status.damaged, skipped.empty() ? "" : fmt::format(" ({})", skipped.front())),
         live ? "another cable, a port of its own; for GigE jumbo frames and larger receive buffers"
              : "copy the file again, or record it anew"});
  if (status.outages > 0)
    report.findings.push_back({State::ill, "outages", fmt::format("{}, the last: {}", status.outages, status.reason),
                               "look at cable and power"});
  std::optional<vision::CameraDescription> driver;
  const auto address = vision::parse_source(wanted.source);  // none: "synthetic"
  switch (address ? address->kind->connection : vision::Connection::file) {
    case vision::Connection::file:
      break;
    case vision::Connection::device:
      if (auto described = vision::describe_camera(address->where)) driver = std::move(*described);
      if (driver)
        for (Finding& finding : driver_findings(*driver, width, height, measured.rate, wanted.needed_rate))
          report.findings.push_back(std::move(finding));
      for (Finding& finding : usb_findings(wanted.system, address->where, width, height, wanted.needed_rate))
        report.findings.push_back(std::move(finding));
      break;
    case vision::Connection::network:
      source->reset();  // a camera that is being read does not answer
      constexpr std::string_view formats = "formats: ";
      if (const auto lines = address->kind->describe(address->where))
        for (const std::string& line : *lines)
          if (line.starts_with(formats))
            report.findings.push_back({State::well, "formats", line.substr(formats.size()), {}});
      break;
  }
  report.table = camera_table(wanted, driver);
  return report;
}

}  // namespace skein::app
