#include "vision/v4l2/v4l2_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/videodev2.h>
#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <ctime>
#include <mutex>
#include <optional>
#include <utility>

#include "vision/frames/camera_patience.h"
#include "vision/frames/frame.h"
#include "vision/modules/media_loader.h"
#include "vision/v4l2/camera_controls.h"
#include "vision/v4l2/v4l2_device.h"
#include "vision/v4l2/v4l2_formats.h"

namespace skein::vision {
namespace {

// Enough for the driver to fill one while one is read and one waits; more would only hold older frames.
constexpr unsigned buffers_wanted = 4;

// The shortest time without a frame after which the camera counts as stuck. [s]
constexpr double least_stall_wait = 0.02;

// From one look at the exposure and at automatics that are on to the next.
constexpr std::int64_t frames_between_looks = 25;

constexpr const char* against_damage =
    "use another cable, a port of its own without a hub, a smaller size, a lower rate or another "
    "format (skein track --format)";

using detail::four_letters;

/// Whether something is so in most frames of late: an average over the last `frames` or so.
class Habit {
 public:
  Habit(double share, double frames) : share_(share), weight_(1.0 / frames) {}
  void add(bool so) { share_ += weight_ * ((so ? 1.0 : 0.0) - share_); }
  double share() const { return share_; }

 private:
  double share_, weight_;
};

/// What is wrong with frames of these fields, for people; nothing where all rows of a frame are of one moment.
const char* fields_lack(std::uint32_t field) {
  switch (field) {
    case V4L2_FIELD_INTERLACED:
    case V4L2_FIELD_INTERLACED_TB:
    case V4L2_FIELD_INTERLACED_BT:
      return "its frames are interlaced (INTERLACED), every other row is of another moment: robots that drive are seen "
             "at wrong places or not at all; select a progressive mode";
    case V4L2_FIELD_SEQ_TB:
    case V4L2_FIELD_SEQ_BT:
      return "its frames are interlaced (SEQUENTIAL), two pictures of half the height, one below the other: every tag "
             "is there twice; select a progressive mode";
    case V4L2_FIELD_ALTERNATE:
      return "its frames are interlaced (ALTERNATE), with the even rows of the picture and the odd ones in turn: every "
             "tag jumps by a row; select a progressive mode";
    case V4L2_FIELD_TOP:
    case V4L2_FIELD_BOTTOM:
      return "its frames have every other row of the picture (TOP or BOTTOM): select a progressive mode, or calibrate "
             "the camera in this one";
    default:  // NONE; some drivers leave ANY
      return nullptr;
  }
}

class V4l2Camera final : public FrameSource {
 public:
  V4l2Camera(std::string device, SourceOptions options, V4l2Kernel& kernel)
      : device_(std::move(device), kernel), options_(std::move(options)) {}
  ~V4l2Camera() override { close(); }
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;

  /// Empty, or what is in the way.
  std::string open() {
    std::string problem = device_.open();
    if (problem.empty()) problem = choose_format();
    if (problem.empty()) {
      const auto set = set_controls(device_, options_.controls);
      if (set)
        note(*set, {slow_rate(), automatic(), interlaced()});
      else
        problem = set.error();
    }
    if (problem.empty()) problem = map_buffers();
    exposure_ = 0.0;
    if (problem.empty())
      look_at_controls();
    else
      close();
    return problem;
  }

  tl::expected<bool, std::string> read(Frame& frame) override {
    for (;;) {
      std::string problem;
      const bool whole = read_frame(frame, problem);
      if (whole) return true;
      if (nobody_waits()) return false;
      if (!problem.empty())
        if (std::string given_up = reopen(problem); !given_up.empty()) {
          if (left_) return false;
          return tl::unexpected(given_up);
        }
      // A damaged frame (a bad cable, a full bus): the next one may be well, but not for ever.
      if (damaged_ > max_damaged)
        return tl::unexpected(fmt::format("{}: sends only damaged frames; {}", device_.path(), against_damage));
    }
  }

  TimeStamps stamps() const override { return stamps_.load(std::memory_order_relaxed); }
  SourceStatus status() const override {
    const std::lock_guard lock(status_mutex_);
    return status_;
  }
  std::string describe() const override {
    return fmt::format("camera {} ({}x{} {}, {:.3g} frames/s)", device_.path(), width_, height_, four_letters(format_),
                       1.0 / period_);
  }

 private:
  struct Buffer {
    void* start;
    std::size_t length;
  };

  void close() {
    if (streaming_) {
      int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      device_.control(VIDIOC_STREAMOFF, &type);
    }
    streaming_ = false;
    for (const Buffer& buffer : buffers_) device_.kernel().unmap(buffer.start, buffer.length);
    buffers_.clear();
    device_.close();
  }

  void note(const std::vector<std::string>& notices, const std::vector<std::string>& others) {
    told_of_damage_ = false;
    const std::lock_guard lock(status_mutex_);
    status_.notices = notices;
    std::copy_if(others.begin(), others.end(), std::back_inserter(status_.notices),
                 [](const std::string& other) { return !other.empty(); });
  }

  /// Empty, or what the camera sets by itself without having been asked to.
  std::string automatic() const {
    const std::vector<std::string> names = automatics_on(device_, options_.controls);
    if (names.empty()) return {};
    return fmt::format("{}: its {} {} automatic, and the picture changes by itself", device_.path(),
                       fmt::join(names, " and "), names.size() == 1 ? "is" : "are");
  }

  /// Empty, or a sentence that the camera gives fewer frames than requested.
  std::string slow_rate() const {
    if (options_.rate <= 0.0 || 1.0 / period_ >= as_good * options_.rate) return {};
    return fmt::format("{}: delivers {:.3g} frames/s at {}x{} {}, not {:.3g}", device_.path(), 1.0 / period_, width_,
                       height_, four_letters(format_), options_.rate);
  }

  /// Empty, or a sentence that its rows are not of one moment, or not all there.
  std::string interlaced() const {
    const char* lacks = fields_lack(field_);
    return lacks ? fmt::format("{}: {}", device_.path(), lacks) : std::string();
  }

  /// What others may change while frames are read. Before the wait for a frame: a kernel may ask the camera over USB
  /// (uvcvideo: for its exposure), and a frame that is there must not wait for that.
  void look_at_controls() {
    next_look_ = frames_ + frames_between_looks;
    exposure_ = fixed_exposure(device_).value_or(0.0);
    std::vector<std::string> automatics = automatics_on(device_, options_.controls);
    const std::lock_guard lock(status_mutex_);
    status_.automatics = std::move(automatics);
  }

  /// A camera may lower its rate in the dark: what counts as a stall follows it. [s]
  void learn_period(double stamp, int passed_over) {
    constexpr double slowest = 1.0;
    if (!fresh_) seen_period_ = std::clamp((stamp - last_stamp_) / (1 + passed_over), 0.0, slowest);
    last_stamp_ = stamp;
  }

  /// Waits for the newest frame. false: none, or a damaged one; `problem`: the camera has stopped delivering.
  bool read_frame(Frame& frame, std::string& problem) {
    if (frames_ >= next_look_) look_at_controls();
    problem = wait();
    if (!problem.empty()) return false;
    // Everything that has piled up while we were busy; only the last is of use.
    std::optional<v4l2_buffer> newest;
    int passed_over = 0;
    for (;;) {
      v4l2_buffer buffer{};
      buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      buffer.memory = V4L2_MEMORY_MMAP;
      if (device_.control(VIDIOC_DQBUF, &buffer) == -1) {
        if (errno == EAGAIN) break;
        problem = device_.failed("stopped delivering frames");
        return false;
      }
      passed_over += newest ? 1 : 0;
      if (newest && device_.control(VIDIOC_QBUF, &*newest) == -1) {
        problem = device_.failed("lost a buffer");
        return false;
      }
      newest = buffer;
    }
    if (!newest) return false;
    const double arrived_at = monotonic_now();
    const bool whole = (newest->flags & V4L2_BUF_FLAG_ERROR) == 0 && convert(*newest, frame);
    const bool first = fresh_ && whole;
    if (first) stamps_.store(stamps_of(*newest), std::memory_order_relaxed);
    if (whole) {
      frame.captured_at = captured_at(*newest, arrived_at);
      learn_period(frame.captured_at, passed_over);
      frame.arrived_at = arrived_at;
      frame.index = frames_++;
      frame.source = std::to_string(frame.index);
    }
    damaged_ = whole ? 0 : damaged_ + 1;
    damage_.add(!whole);
    const bool starves = !told_of_damage_ && damage_.share() > 0.5;
    told_of_damage_ = told_of_damage_ || starves;
    fresh_ = fresh_ && !whole;
    {
      const std::lock_guard lock(status_mutex_);
      if (const char* lacks = first ? stamps_lack(stamps()) : nullptr)
        status_.notices.push_back(fmt::format("{}: {}", device_.path(), lacks));
      if (starves)
        status_.notices.push_back(
            fmt::format("{}: most of its frames arrive damaged and are left out; {}", device_.path(), against_damage));
      status_.up = status_.up || whole;
      status_.damaged += whole ? 0 : 1;
      status_.passed_over += passed_over;
    }
    if (device_.control(VIDIOC_QBUF, &*newest) == -1) problem = device_.failed("lost a buffer");
    return whole;
  }

  /// Asked while no frame comes; once they have left, they have left.
  bool nobody_waits() {
    left_ = left_ || (options_.keep_waiting && !options_.keep_waiting());
    return left_;
  }

  /// The camera has gone: unplugged, or stuck until it is started anew. Empty once it runs again.
  std::string reopen(const std::string& problem) {
    {
      const std::lock_guard lock(status_mutex_);
      status_.outages += status_.up ? 1 : 0;
      status_.up = false;
      status_.reason = problem;
    }
    const bool was_fresh = std::exchange(fresh_, true);
    // One that has never delivered, or has not since it was opened again, uses up the time as well.
    out_for_ = was_fresh && frames_ > 0 ? out_for_ + first_frame_wait : 0.0;
    const int width = width_;
    const int height = height_;
    close();
    while (frames_ > 0 && out_for_ < options_.reopen_for) {
      if (nobody_waits()) return problem;
      const std::string again = open();
      if (again.empty()) {
        if (width_ == width && height_ == height) return {};
        return fmt::format("{}: came back with {}x{} px instead of {}x{}", device_.path(), width_, height_, width,
                           height);
      }
      pollfd nothing{-1, 0, 0};
      device_.kernel().poll(&nothing, static_cast<int>(reopen_pause * 1000.0));
      out_for_ += reopen_pause;
    }
    return problem;
  }

  std::string choose_format() {
    const SourceOptions& options = options_;
    const auto chosen = detail::choose_format(device_, {options.width, options.height, options.rate, options.format});
    if (!chosen) return chosen.error();
    pixels_ = *chosen;
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (device_.control(VIDIOC_G_FMT, &format) == -1) return device_.failed("does not tell its format");
    if (options.width > 0 && options.height > 0) {
      format.fmt.pix.width = static_cast<std::uint32_t>(options.width);
      format.fmt.pix.height = static_cast<std::uint32_t>(options.height);
    }
    format.fmt.pix.pixelformat = pixels_->number;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = 0;
    if (device_.control(VIDIOC_S_FMT, &format) == -1)
      return device_.failed("refuses the format " + four_letters(pixels_->number));
    format_ = format.fmt.pix.pixelformat;
    width_ = static_cast<int>(format.fmt.pix.width);
    height_ = static_cast<int>(format.fmt.pix.height);
    stride_ = format.fmt.pix.bytesperline;
    field_ = format.fmt.pix.field;
    if (format_ != pixels_->number)
      return fmt::format("{}: gives {} instead of the requested {}", device_.path(), four_letters(format_),
                         four_letters(pixels_->number));
    if (options.width > 0 && (width_ != options.width || height_ != options.height)) {
      return fmt::format("{}: cannot give {}x{} in {}, only {}x{}", device_.path(), options.width, options.height,
                         four_letters(format_), width_, height_);
    }
    if (pixels_->to_grey == nullptr) {
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
      device_.control(VIDIOC_S_PARM, &parameters);
    }
    if (device_.control(VIDIOC_G_PARM, &parameters) == 0 && period.numerator > 0 && period.denominator > 0) {
      period_ = static_cast<double>(period.numerator) / period.denominator;
    }
  }

  std::string map_buffers() {
    v4l2_requestbuffers request{};
    request.count = buffers_wanted;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (device_.control(VIDIOC_REQBUFS, &request) == -1 || request.count < 2) {
      return device_.failed(errno == EBUSY ? "is in use by another program" : "has no buffers to map");
    }
    for (std::uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer{};
      buffer.index = i;
      buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      buffer.memory = V4L2_MEMORY_MMAP;
      if (device_.control(VIDIOC_QUERYBUF, &buffer) == -1) return device_.failed("does not describe its buffers");
      void* start = device_.kernel().map(device_.fd(), buffer.length, buffer.m.offset);
      if (start == MAP_FAILED) return device_.failed("does not share its buffers");
      buffers_.push_back({start, buffer.length});
      if (device_.control(VIDIOC_QBUF, &buffer) == -1) return device_.failed("does not take its buffers");
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (device_.control(VIDIOC_STREAMON, &type) == -1) return device_.failed("does not start");
    streaming_ = true;
    return {};
  }

  /// Until a frame is there. Empty, or why none will come.
  std::string wait() const {
    const double seconds =
        fresh_ ? first_frame_wait : std::max(least_stall_wait, stall_frames * std::max(period_, seen_period_));
    pollfd waiting{device_.fd(), POLLIN, 0};
    const int ready = device_.kernel().poll(&waiting, static_cast<int>(seconds * 1000.0));
    if (ready == -1 && errno != EINTR) return device_.failed("cannot be waited for");
    if (ready == 0)
      return fmt::format("{}: no frame for {:.3g} s (unplugged, or the bus is full?)", device_.path(), seconds);
    if (ready > 0 && (waiting.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0)
      return device_.path() + ": stopped delivering frames (unplugged?)";
    return {};
  }

  bool convert(const v4l2_buffer& buffer, Frame& frame) {
    if (buffer.index >= buffers_.size()) return false;
    const auto* bytes = static_cast<const std::uint8_t*>(buffers_[buffer.index].start);
    const std::size_t used = std::min<std::size_t>(buffer.bytesused, buffers_[buffer.index].length);
    if (pixels_->to_grey == nullptr) {
      const JpegState state = media_->decode_jpeg(bytes, used, frame);
      if (frame.width != width_ || frame.height != height_) return false;
      switch (state) {
        case JpegState::whole:
          padding_.add(false);
          return true;
        case JpegState::padded:
          padding_.add(true);
          return padding_.share() > 0.3;
        case JpegState::damaged:
          return false;
      }
      return false;
    }
    frame.resize(width_, height_);
    return pixels_->to_grey({bytes, used}, stride_, frame);
  }

  TimeStamps stamps_of(const v4l2_buffer& buffer) const {
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return TimeStamps::arrival;
    if ((buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) != V4L2_BUF_FLAG_TSTAMP_SRC_SOE) return TimeStamps::frame_end;
    // uvcvideo calls every stamp the start of exposure, and reads the camera's own only if its option says so.
    const bool camera_stamps = device_.driver() != "uvcvideo" ||
                               device_.kernel().parameter("uvcvideo", "hwtimestamps").find_first_of("1Yy") == 0;
    return camera_stamps ? TimeStamps::exposure_start : TimeStamps::first_packet;
  }
  /// What is wrong with the driver's stamps, for people; nothing where they say when the exposure began.
  static const char* stamps_lack(TimeStamps stamps) {
    switch (stamps) {
      case TimeStamps::arrival:
        return "its driver does not report capture times: a frame counts as captured when it arrives, which is later";
      case TimeStamps::frame_end:
        return "its driver stamps the end of a frame, not the start of its exposure: skein camera latency measures how "
               "much later that is";
      case TimeStamps::first_packet:
        return "its driver stamps the first packet of a frame, not the start of its exposure: skein camera latency "
               "measures how much later that is";
      case TimeStamps::exposure_start:
      case TimeStamps::film:
      case TimeStamps::nominal:
        return nullptr;
    }
    return nullptr;
  }

  /// The middle of the first row's exposure, as far as it is known: what the camera needs besides, to read out a global
  /// shutter, to encode and to send, is not.
  double captured_at(const v4l2_buffer& buffer, double arrived_at) const {
    const double stamp =
        static_cast<double>(buffer.timestamp.tv_sec) + 1e-6 * static_cast<double>(buffer.timestamp.tv_usec);
    const double half = 0.5 * exposure_;
    switch (stamps_.load(std::memory_order_relaxed)) {
      case TimeStamps::exposure_start:
        return stamp + half;
      case TimeStamps::first_packet:
        return stamp - half;
      case TimeStamps::frame_end:
        return stamp - options_.readout - half;
      case TimeStamps::arrival:
      case TimeStamps::film:
      case TimeStamps::nominal:
        break;
    }
    return arrived_at - options_.readout - half;
  }

  detail::V4l2Device device_;
  SourceOptions options_;
  bool streaming_ = false;
  std::vector<Buffer> buffers_;
  std::uint32_t format_ = 0;
  const detail::PixelFormat* pixels_ = nullptr;
  std::uint32_t field_ = V4L2_FIELD_NONE;
  int width_ = 0;
  int height_ = 0;
  std::size_t stride_ = 0;      // bytes from row to row
  double period_ = 1.0 / 25.0;  // as the driver says [s]
  double seen_period_ = 0.0;    // as the last frames were
  double exposure_ = 0.0;       // [s]; 0: not known, or not constant
  const Media* media_ = nullptr;
  std::int64_t frames_ = 0;
  std::int64_t next_look_ = 0;  // at the controls: when so many frames have come
  int damaged_ = 0;             // frames in a row
  Habit damage_{0.0, 50.0};
  bool told_of_damage_ = false;
  // A camera that pads its JPEGs pads all of them; until it has shown that it does not, it may.
  Habit padding_{1.0, 10.0};
  bool left_ = false;     // the caller no longer waits for a frame
  bool fresh_ = true;     // no frame since it was opened
  double out_for_ = 0.0;  // how long it has not delivered [s]
  double last_stamp_ = 0.0;
  std::atomic<TimeStamps> stamps_{TimeStamps::arrival};  // until a frame has said better
  mutable std::mutex status_mutex_;
  SourceStatus status_;
};

}  // namespace

tl::expected<std::unique_ptr<FrameSource>, std::string> open_v4l2(const std::string& device,
                                                                  const SourceOptions& options, V4l2Kernel& kernel) {
  auto camera = std::make_unique<V4l2Camera>(device, options, kernel);
  if (std::string problem = camera->open(); !problem.empty()) return tl::unexpected(problem);
  return camera;
}

}  // namespace skein::vision
