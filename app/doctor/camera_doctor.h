#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/doctor/doctor.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/frame_source.h"
#include "vision/v4l2/camera_controls.h"

namespace skein::app {

/// What `skein camera doctor` is to examine.
struct CameraCase {
  std::string source;  ///< as for vision::open_source; "synthetic": rendered frames of four robots
  vision::SourceOptions options{};
  std::string calibration_file{};  ///< as given; empty: none
  std::optional<vision::Calibration> calibration{};
  double seconds = 10.0;                  ///< of frames
  double needed_rate = 25.0;              ///< [frames/s]
  std::function<bool()> keep_going{};     ///< asked after every frame
  std::filesystem::path system = "/sys";  ///< where the kernel describes its devices
};

struct CameraReport {
  std::string camera;  ///< FrameSource::describe()
  std::vector<Finding> findings;
  std::string table;  ///< [camera], as an experiment file takes it
};

/// Reads the camera's frames and judges them (vision::CameraExamination), its formats, settings and bus. Leaves out the
/// first second of a camera, in which it settles. The error: it cannot be opened, or fails.
tl::expected<CameraReport, std::string> examine_camera(const CameraCase& wanted);

/// Findings about a camera's driver, for frames of this size and rate: settings that the camera changes by itself, and
/// formats.
std::vector<Finding> driver_findings(const vision::CameraDescription& camera, int width, int height, double rate,
                                     double needed_rate);

/// Whether frames of two bytes a pixel fit through the USB port of a "/dev/video0"; none: it is not on a USB, or this
/// is not known.
std::vector<Finding> usb_findings(const std::filesystem::path& system, const std::string& device, int width, int height,
                                  double rate);

/// The table to paste into an experiment file: the requested settings, otherwise the camera's present ones.
std::string camera_table(const CameraCase& examined, const std::optional<vision::CameraDescription>& driver);

}  // namespace skein::app
