// A GigE Vision camera in software on 127.0.0.1 (Aravis's own), as a program of its own so that it can be killed. One
// at a time can have the protocol's port: it waits until the port is free, and says "ready".
//
//   skein_fake_gige [--clock] [--stamp-end] [--lost PER_THOUSAND] [--lose-frames N] [--line HZ] [--tags]
//
// Its pictures rise from left to right, the same in every format (grey_of). In Mono8 the first eight pixels are the
// time at which the exposure began, CLOCK_MONOTONIC as a double. Its own clock is 1234 s off and 50 ppm too fast; after
// the exposure it needs 1 to 3 ms until it sends. It stamps the beginning of the exposure, or its end (--stamp-end). Of
// each packet the network loses a part (--lost), and all packets of the first frames (--lose-frames).
#include <arv.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/vision/aravis/fake_gige.h"
#include "vision/calibration/calibration.h"
#include "vision/synthetic/synthetic_camera.h"

namespace {

using namespace skein;

constexpr guint32 clock_value = 0x8010;  // a register that nothing else uses

double monotonic_now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}
guint64 own_clock(double now) {
  static const double began = now;
  return static_cast<guint64>(1e9 * (1234.0 + (now - began) * 1.00005));
}

struct Scene {
  bool tags = false, stamp_end = false;
  vision::SyntheticCamera camera{vision::overhead_calibration(2.0, 1.5), {}, 1};
  vision::Frame frame;
  ArvGvFakeCamera* sender = nullptr;
  int lose_frames = 0;
  double lost = 0.0;  // part of the packets
};

void fill_tags(Scene& scene, std::uint8_t* pixels, int width, int height) {
  const auto tags = test::fake_gige_tags();
  if (scene.frame.grey.empty()) scene.camera.render(tags, 0.0, scene.frame);  // it stands still
  if (scene.frame.width == width && scene.frame.height == height)
    std::memcpy(pixels, scene.frame.grey.data(), scene.frame.grey.size());
}

void fill_ramp(ArvPixelFormat format, std::uint8_t* pixels, int width, int height) {
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const std::uint8_t grey = test::fake_gige_grey(u);
      switch (format) {
        case ARV_PIXEL_FORMAT_MONO_16:
          *pixels++ = 0;
          *pixels++ = grey;
          break;
        case ARV_PIXEL_FORMAT_RGB_8_PACKED:
          for (int i = 0; i < 3; ++i) *pixels++ = grey;
          break;
        default:
          *pixels++ = grey;
      }
    }
}

void fill(ArvBuffer* buffer, void* scene, guint32 exposure_us, guint32, ArvPixelFormat format) {
  const double began = monotonic_now();
  if (auto& what = *static_cast<Scene*>(scene); what.lose_frames >= 0)
    g_object_set(what.sender, "gvsp-lost-ratio", what.lose_frames-- > 0 ? 1.0 : what.lost, nullptr);
  arv_buffer_set_timestamp(buffer,
                           own_clock(began + (static_cast<Scene*>(scene)->stamp_end ? 1e-6 * exposure_us : 0.0)));
  std::size_t size = 0;
  auto* pixels = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &size)));
  const int width = arv_buffer_get_image_width(buffer);
  const int height = arv_buffer_get_image_height(buffer);
  if (auto& what = *static_cast<Scene*>(scene); what.tags && format == ARV_PIXEL_FORMAT_MONO_8)
    fill_tags(what, pixels, width, height);
  else
    fill_ramp(format, pixels, width, height);
  if (format == ARV_PIXEL_FORMAT_MONO_8) std::memcpy(pixels, &began, sizeof began);
  const double sends = began + 1e-6 * exposure_us + 1e-3 + 1e-3 * (std::rand() % 1000) / 500.0;
  while (monotonic_now() < sends) usleep(100);
}

/// The camera's own features, and those by which its clock is read.
std::string with_clock(ArvFakeCamera* camera) {
  std::size_t size = 0;
  const char* letters = arv_fake_camera_get_genicam_xml(camera, &size);
  std::string xml(letters, strnlen(letters, size));
  const std::string features = R"(
	<Command Name="TimestampLatch" NameSpace="Standard"><pValue>TimestampLatchRegister</pValue><CommandValue>1</CommandValue></Command>
	<IntReg Name="TimestampLatchRegister" NameSpace="Custom"><Address>0x8000</Address><Length>4</Length><AccessMode>RW</AccessMode>
		<pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
	<Integer Name="TimestampLatchValue" NameSpace="Standard"><pValue>TimestampLatchValueRegister</pValue></Integer>
	<IntReg Name="TimestampLatchValueRegister" NameSpace="Custom"><Address>0x8010</Address><Length>8</Length><AccessMode>RO</AccessMode>
		<pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
)";
  const std::size_t place = xml.find("<Category Name=\"DeviceControl\"");
  return xml.insert(place, features);
}

ArvGvFakeCamera* start(const std::string& genicam) {
  for (;;) {  // another test may have the port
    ArvGvFakeCamera* camera =
        arv_gv_fake_camera_new_full("127.0.0.1", test::fake_gige_serial, genicam.empty() ? nullptr : genicam.c_str());
    if (arv_gv_fake_camera_is_running(camera)) return camera;
    g_object_unref(camera);
    usleep(50'000);
  }
}

}  // namespace

int main(int count, char** words) {
  const pid_t parent = ::getppid();
  bool clock = false;
  double line = 0.0;
  Scene scene;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    if (word == "--clock") clock = true;
    if (word == "--stamp-end") scene.stamp_end = true;
    if (word == "--tags") scene.tags = true;
    if (word == "--lost") scene.lost = std::atof(words[++i]) / 1000.0;
    if (word == "--lose-frames") scene.lose_frames = std::atoi(words[++i]);
    if (word == "--line") line = std::atof(words[++i]);
  }
  std::string genicam;
  if (clock) {
    ArvFakeCamera* plain = arv_fake_camera_new(test::fake_gige_serial);
    genicam = "/tmp/skein_fake_gige_" + std::to_string(getpid()) + ".xml";
    std::ofstream(genicam) << with_clock(plain);
    g_object_unref(plain);
  }
  const test::PortLock lock;
  ArvGvFakeCamera* camera = start(genicam);
  if (clock) std::remove(genicam.c_str());
  scene.sender = camera;
  ArvFakeCamera* registers = arv_gv_fake_camera_get_fake_camera(camera);
  arv_fake_camera_set_fill_pattern(registers, fill, &scene);
  arv_fake_camera_set_trigger_frequency(registers, 1000.0);
  (void)own_clock(monotonic_now());
  std::puts("ready");
  std::fflush(stdout);

  const auto reads = [registers](guint32 address) {
    guint32 value = 0;
    arv_fake_camera_read_register(registers, address, &value);
    return value;
  };
  double next_pulse = monotonic_now();
  bool pulsed = false;
  // Exits when the test that started it dies: otherwise it would keep the port, and the output that ctest waits for.
  while (::getppid() == parent) {
    const guint64 value = GUINT64_TO_BE(own_clock(monotonic_now()));
    arv_fake_camera_write_memory(registers, clock_value, sizeof value, &value);
    // Its line, which the software camera does not have: a frame all the same. Before the first one the software camera
    // looks only every 100 ms whether one is asked for: the pulse waits for that.
    if (pulsed && reads(ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOFTWARE) == 0) {
      arv_fake_camera_write_register(registers, ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOURCE, 0);
      pulsed = false;
    }
    if (line > 0.0 && monotonic_now() >= next_pulse) {
      next_pulse += 1.0 / line;
      const bool by_line = pulsed || reads(ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOURCE) == 0;
      if (reads(ARV_FAKE_CAMERA_REGISTER_TRIGGER_MODE) == 1 && by_line) {
        arv_fake_camera_write_register(registers, ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOFTWARE, 1);
        arv_fake_camera_write_register(registers, ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOURCE, 1);
        pulsed = true;
      }
    }
    usleep(50);
  }
}
