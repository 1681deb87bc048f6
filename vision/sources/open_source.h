#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "vision/frames/camera_setting.h"
#include "vision/frames/frame_source.h"

namespace skein::vision {

/// How the frames of a source come to this machine.
enum class Connection {
  file,     ///< films and pictures: no camera
  device,   ///< a camera with a driver of the kernel; its address names a file of /dev
  network,  ///< a camera that answers a question, in the network or on USB
};

/// A camera that is connected.
struct ConnectedCamera {
  std::string where{};  ///< what follows the colon of its address
  std::string also{};   ///< another name for it, which `open` takes too; empty: none
  std::string what{};   ///< for people: "HD Webcam (uvcvideo)"
};

/// A kind of source: one entry of the table in open_source.cpp.
struct SourceKind {
  std::string_view name;   ///< what stands before the colon
  std::string_view where;  ///< what follows it, in capitals for messages: "DEVICE"
  std::string_view what;   ///< for people: "a film"
  Connection connection;
  tl::expected<std::unique_ptr<FrameSource>, std::string> (*open)(const std::string& where,
                                                                  const SourceOptions& options);

  // Cameras only; null: films and pictures have none.
  /// Sets controls and reads back exposure, gain and focus, as far as the camera has them.
  tl::expected<CameraSettings, std::string> (*settings)(const std::string& where, const ControlSettings& set) = nullptr;
  /// Those that are connected; takes up to a second. The error: they cannot be searched.
  tl::expected<std::vector<ConnectedCamera>, std::string> (*connected)() = nullptr;
  /// What the camera can do and how it is set, one line each, for the operator. Does not change the camera.
  tl::expected<std::vector<std::string>, std::string> (*describe)(const std::string& where) = nullptr;

  bool triggers = false;             ///< the camera can be triggered, see SourceOptions::trigger
  bool settable_while_read = false;  ///< `settings` works while frames are read from the camera
};

/// All kinds. An experiment's "synthetic" camera is not among them: it renders simulated robots.
std::span<const SourceKind> source_kinds();

/// "KIND:WHERE", taken apart.
struct SourceAddress {
  const SourceKind* kind = nullptr;  // of source_kinds()
  std::string where;

  /// A camera, whose frames come in real time.
  bool live() const { return kind->connection != Connection::file; }
};

/// The error says what is allowed.
tl::expected<SourceAddress, std::string> parse_source(std::string_view address);

/// True where the address is that of a camera.
bool is_camera(std::string_view address);

/// What an address may look like, for messages and help: "images:DIR, video:FILE, v4l2:DEVICE, aravis:CAMERA".
std::string source_forms();
/// The same of the cameras among them: "v4l2:DEVICE, aravis:CAMERA".
std::string camera_forms();

/// Opens "KIND:WHERE":
///   images:DIR or images:FILE  png, jpg, pgm, ppm, bmp, tif, webp, sorted by name, img2 before img10. One that cannot
///                              be decoded is passed over (see FrameSource::skipped).
///   video:FILE                 a film; one that Skein recorded gives back capture times and indices to the bit.
///                              Damaged frames are passed over.
///   v4l2:DEVICE                a camera through the kernel: the newest frame only. One that stops delivering for three
///                              frame times is opened again; where that does not help, it is an error.
///   aravis:CAMERA              a GigE Vision or USB3 Vision camera, by the name that `skein camera list` gives it
///                              or its network address; as above.
tl::expected<std::unique_ptr<FrameSource>, std::string> open_source(std::string_view address,
                                                                    const SourceOptions& options = {});

/// Sets controls of the camera at an address, as open_source does, and reads back exposure, gain and focus, as far as
/// the camera has them. The error: it is not a camera, it does not answer, or a control cannot be set as requested.
tl::expected<CameraSettings, std::string> camera_settings(std::string_view address, const ControlSettings& set = {});

/// Whether camera_settings() works while frames are read from the camera.
bool settable_while_read(std::string_view address);

}  // namespace skein::vision
