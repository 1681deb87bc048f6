#include "vision/v4l2_source.h"

#include <fmt/format.h>
#include <linux/videodev2.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>

#include "vision/media_loader.h"
#include "vision/v4l2_pixels.h"

namespace skein::vision {
namespace {

// Enough for the driver to fill one while one is read and one waits; more would only hold older frames.
constexpr unsigned buffers_wanted = 4;

// Opening the shutter and settling the exposure takes webcams a second or two. [s]
constexpr double first_frame_wait = 5.0;

// Frame times without a frame after which the camera counts as stuck, and the least wait. [frames, s]
constexpr double stall_frames = 5.0;
constexpr double least_stall_wait = 0.25;

std::string four_letters(std::uint32_t format) {
  std::string text;
  for (int i = 0; i < 4; ++i) text += static_cast<char>((format >> (8 * i)) & 0x7f);
  return text;
}

class V4l2Camera final : public FrameSource {
 public:
  V4l2Camera(std::string device, V4l2Kernel& kernel) : device_(std::move(device)), kernel_(kernel) {}
  ~V4l2Camera() override {
    if (streaming_) {
      int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      control(VIDIOC_STREAMOFF, &type);
    }
    for (const Buffer& buffer : buffers_) kernel_.unmap(buffer.start, buffer.length);
    if (fd_ >= 0) kernel_.close(fd_);
  }
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;

  /// Empty, or what is in the way.
  std::string open(const SourceOptions& options) {
    fd_ = kernel_.open(device_.c_str());
    if (fd_ < 0) return failed("cannot be opened");
    std::string problem = check_device();
    if (problem.empty()) problem = choose_format(options);
    if (problem.empty()) problem = map_buffers();
    return problem;
  }

  tl::expected<bool, std::string> read(Frame& frame) override {
    for (;;) {
      if (std::string problem = wait(); !problem.empty()) return tl::unexpected(problem);
      // Everything that has piled up while we were busy; only the last is of use.
      std::optional<v4l2_buffer> newest;
      for (;;) {
        v4l2_buffer buffer{};
        buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        buffer.memory = V4L2_MEMORY_MMAP;
        if (control(VIDIOC_DQBUF, &buffer) == -1) {
          if (errno == EAGAIN) break;
          return tl::unexpected(failed("stopped delivering frames"));
        }
        if (newest && control(VIDIOC_QBUF, &*newest) == -1) return tl::unexpected(failed("lost a buffer"));
        newest = buffer;
      }
      if (!newest) continue;
      const double arrived_at = monotonic_now();
      const bool whole = (newest->flags & V4L2_BUF_FLAG_ERROR) == 0 && convert(*newest, frame);
      if (whole) {
        damaged_ = 0;
        frame.captured_at = stamp(*newest);
        frame.arrived_at = arrived_at;
        frame.index = frames_++;
        frame.source = std::to_string(frame.index);
      }
      if (control(VIDIOC_QBUF, &*newest) == -1) return tl::unexpected(failed("lost a buffer"));
      if (whole) return true;
      // A damaged frame (a bad cable, a full bus): the next one may be well, but not for ever.
      if (++damaged_ > max_damaged) return tl::unexpected(device_ + ": sends only damaged frames");
    }
  }

  std::string describe() const override {
    return fmt::format("camera {} ({}x{} {}, {:.3g} frames/s)", device_, width_, height_, four_letters(format_),
                       1.0 / period_);
  }

 private:
  struct Buffer {
    void* start;
    std::size_t length;
  };
  static constexpr int max_damaged = 25;

  int control(unsigned long request, void* argument) const {
    int result = 0;
    do {
      result = kernel_.control(fd_, request, argument);
    } while (result == -1 && errno == EINTR);
    return result;
  }

  std::string failed(std::string_view what) const {
    return fmt::format("{}: {} ({})", device_, what, std::strerror(errno));
  }

  std::string check_device() {
    v4l2_capability capability{};
    if (control(VIDIOC_QUERYCAP, &capability) == -1) return device_ + ": is no V4L2 camera";
    const std::uint32_t can =
        (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
    if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0) {
      return device_ + ": does not capture video (a camera often has a second device that does)";
    }
    return {};
  }

  std::string choose_format(const SourceOptions& options) {
    // From free to costly: grey as it is, grey among colours, a JPEG to decode (3 ms at 1280x960).
    constexpr std::array liked = {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG};
    std::string offered;
    std::size_t best = liked.size();
    for (std::uint32_t i = 0;; ++i) {
      v4l2_fmtdesc description{};
      description.index = i;
      description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      if (control(VIDIOC_ENUM_FMT, &description) == -1) break;
      offered += (offered.empty() ? "" : ", ") + four_letters(description.pixelformat);
      const auto place = std::find(liked.begin(), liked.end(), description.pixelformat);
      best = std::min(best, static_cast<std::size_t>(place - liked.begin()));
    }
    if (best == liked.size()) {
      return fmt::format("{}: offers {}; needed: GREY, YUYV or MJPG", device_, offered.empty() ? "no format" : offered);
    }
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (control(VIDIOC_G_FMT, &format) == -1) return failed("does not tell its format");
    if (options.width > 0 && options.height > 0) {
      format.fmt.pix.width = static_cast<std::uint32_t>(options.width);
      format.fmt.pix.height = static_cast<std::uint32_t>(options.height);
    }
    format.fmt.pix.pixelformat = liked[best];
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = 0;
    if (control(VIDIOC_S_FMT, &format) == -1) return failed("refuses the format " + four_letters(liked[best]));
    format_ = format.fmt.pix.pixelformat;
    width_ = static_cast<int>(format.fmt.pix.width);
    height_ = static_cast<int>(format.fmt.pix.height);
    stride_ = format.fmt.pix.bytesperline;
    if (format_ != liked[best])
      return fmt::format("{}: gives {} where {} was asked for", device_, four_letters(format_),
                         four_letters(liked[best]));
    if (options.width > 0 && (width_ != options.width || height_ != options.height)) {
      return fmt::format("{}: cannot give {}x{} in {}, only {}x{}", device_, options.width, options.height,
                         four_letters(format_), width_, height_);
    }
    if (format_ == V4L2_PIX_FMT_MJPEG) {
      const auto module = media();
      if (!module) return module.error();
      media_ = *module;
    }
    set_rate(options.rate);
    return {};
  }

  /// A camera that cannot set its rate keeps its own.
  void set_rate(double rate) {
    v4l2_streamparm parameters{};
    parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    v4l2_fract& period = parameters.parm.capture.timeperframe;
    if (rate > 0.0) {
      period = {1000, static_cast<std::uint32_t>(std::max(1.0, rate * 1000.0))};
      control(VIDIOC_S_PARM, &parameters);
    }
    if (control(VIDIOC_G_PARM, &parameters) == 0 && period.numerator > 0 && period.denominator > 0) {
      period_ = static_cast<double>(period.numerator) / period.denominator;
    }
  }

  std::string map_buffers() {
    v4l2_requestbuffers request{};
    request.count = buffers_wanted;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (control(VIDIOC_REQBUFS, &request) == -1 || request.count < 2) {
      return failed(errno == EBUSY ? "is in use by another program" : "has no buffers to map");
    }
    for (std::uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer{};
      buffer.index = i;
      buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      buffer.memory = V4L2_MEMORY_MMAP;
      if (control(VIDIOC_QUERYBUF, &buffer) == -1) return failed("does not describe its buffers");
      void* start = kernel_.map(fd_, buffer.length, buffer.m.offset);
      if (start == MAP_FAILED) return failed("does not share its buffers");
      buffers_.push_back({start, buffer.length});
      if (control(VIDIOC_QBUF, &buffer) == -1) return failed("does not take its buffers");
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (control(VIDIOC_STREAMON, &type) == -1) return failed("does not start");
    streaming_ = true;
    return {};
  }

  /// Until a frame is there. Empty, or why none will come.
  std::string wait() const {
    const double seconds = frames_ == 0 ? first_frame_wait : std::max(least_stall_wait, stall_frames * period_);
    pollfd waiting{fd_, POLLIN, 0};
    const int ready = kernel_.poll(&waiting, static_cast<int>(seconds * 1000.0));
    if (ready == -1 && errno != EINTR) return failed("cannot be waited for");
    if (ready == 0) return fmt::format("{}: no frame for {:.3g} s (unplugged, or the bus is full?)", device_, seconds);
    if (ready > 0 && (waiting.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) {
      return device_ + ": stopped delivering frames (unplugged?)";
    }
    return {};
  }

  bool convert(const v4l2_buffer& buffer, Frame& frame) const {
    if (buffer.index >= buffers_.size()) return false;
    const auto* bytes = static_cast<const std::uint8_t*>(buffers_[buffer.index].start);
    const std::size_t used = std::min<std::size_t>(buffer.bytesused, buffers_[buffer.index].length);
    if (format_ == V4L2_PIX_FMT_MJPEG) {
      return media_->decode_jpeg(bytes, used, frame) && frame.width == width_ && frame.height == height_;
    }
    frame.resize(width_, height_);
    return format_ == V4L2_PIX_FMT_GREY ? grey_from_grey({bytes, used}, stride_, frame)
                                        : grey_from_yuyv({bytes, used}, stride_, frame);
  }

  /// When the frame was taken, by the driver (start of exposure or end of frame, as it can); else now, which is later.
  static double stamp(const v4l2_buffer& buffer) {
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
      return static_cast<double>(buffer.timestamp.tv_sec) + 1e-6 * static_cast<double>(buffer.timestamp.tv_usec);
    }
    return monotonic_now();
  }
  static double monotonic_now() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

  std::string device_;
  V4l2Kernel& kernel_;
  int fd_ = -1;
  bool streaming_ = false;
  std::vector<Buffer> buffers_;
  std::uint32_t format_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::size_t stride_ = 0;  // bytes from row to row
  double period_ = 1.0 / 25.0;
  const Media* media_ = nullptr;
  std::int64_t frames_ = 0;
  int damaged_ = 0;  // frames in a row
};

}  // namespace

tl::expected<std::unique_ptr<FrameSource>, std::string> open_v4l2(const std::string& device,
                                                                  const SourceOptions& options, V4l2Kernel& kernel) {
  auto camera = std::make_unique<V4l2Camera>(device, kernel);
  if (std::string problem = camera->open(options); !problem.empty()) return tl::unexpected(problem);
  return camera;
}

}  // namespace skein::vision
