#include "vision/aravis/aravis_source.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "vision/aravis/aravis_controls.h"
#include "vision/aravis/device_clock.h"
#include "vision/aravis/genicam.h"
#include "vision/frames/camera_patience.h"
#include "vision/frames/pixels.h"
#include "vision/frames/receive_buffer.h"

namespace skein::vision::detail {
namespace {

// One is being filled, one waits for packets to be sent again, one is read; more would only hold older frames.
constexpr int buffers = 5;

// What the kernel is asked to hold of them until Aravis reads it. [frames]
constexpr guint buffered_frames = 2;

// Below that of the control thread's ticks, above that of its poses.
constexpr int receiver_priority = 15;

// The shortest time without a frame after which the camera counts as stuck: to open a camera anew takes a second and
// more, which a hiccup of the network is not worth. [s]
constexpr double least_stall_wait = 0.25;

// Between two looks whether anybody still waits for a camera. [s]
constexpr double look = 0.05;

// An incomplete frame holds back those behind it: packets are requested again for no longer than the next frame takes.
// [s]
constexpr double least_retention = 0.005;
constexpr double most_retention = 0.1;

struct PixelKind {
  ArvPixelFormat number;
  bool (*to_grey)(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame);
  int bits;  // of a pixel, with all of its colours
};

// GenICam's numbers for what this Aravis has no names for.
constexpr ArvPixelFormat mono_10p = 0x010A0046;
constexpr ArvPixelFormat mono_12p = 0x010C0047;

// From free to costly.
constexpr std::array formats{
    PixelKind{ARV_PIXEL_FORMAT_MONO_8, grey_from_grey, 8},
    PixelKind{ARV_PIXEL_FORMAT_YUV_422_YUYV_PACKED, grey_from_yuyv, 16},
    PixelKind{ARV_PIXEL_FORMAT_YUV_422_PACKED, grey_from_uyvy, 16},
    PixelKind{ARV_PIXEL_FORMAT_MONO_10_PACKED, grey_from_gige_packed, 12},
    PixelKind{ARV_PIXEL_FORMAT_MONO_12_PACKED, grey_from_gige_packed, 12},
    PixelKind{mono_10p, grey_from_packed<10>, 10},
    PixelKind{mono_12p, grey_from_packed<12>, 12},
    PixelKind{ARV_PIXEL_FORMAT_MONO_10, grey_from_words<10>, 16},
    PixelKind{ARV_PIXEL_FORMAT_MONO_12, grey_from_words<12>, 16},
    PixelKind{ARV_PIXEL_FORMAT_MONO_14, grey_from_words<14>, 16},
    PixelKind{ARV_PIXEL_FORMAT_MONO_16, grey_from_words<16>, 16},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_RG_8, grey_from_bayer<8>, 8},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_GR_8, grey_from_bayer<8>, 8},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_GB_8, grey_from_bayer<8>, 8},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_BG_8, grey_from_bayer<8>, 8},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_RG_10, grey_from_bayer<10>, 16},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_GR_10, grey_from_bayer<10>, 16},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_GB_10, grey_from_bayer<10>, 16},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_BG_10, grey_from_bayer<10>, 16},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_RG_12, grey_from_bayer<12>, 16},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_GR_12, grey_from_bayer<12>, 16},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_GB_12, grey_from_bayer<12>, 16},
    PixelKind{ARV_PIXEL_FORMAT_BAYER_BG_12, grey_from_bayer<12>, 16},
    PixelKind{ARV_PIXEL_FORMAT_RGB_8_PACKED, grey_from_rgb, 24},
    PixelKind{ARV_PIXEL_FORMAT_BGR_8_PACKED, grey_from_rgb, 24},
};

/// How much the kernel holds at most for a program that receives; 0: unknown. [bytes]
long receive_buffer_limit() {
  long bytes = 0;
  std::ifstream(receive_buffer_setting) >> bytes;
  return bytes;
}
void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

class AravisSource final : public FrameSource {
 public:
  AravisSource(std::string name, SourceOptions options) : name_(std::move(name)), options_(std::move(options)) {}
  ~AravisSource() override { close(); }
  AravisSource(const AravisSource&) = delete;
  AravisSource& operator=(const AravisSource&) = delete;

  /// Empty, or what is in the way.
  std::string open() {
    Failure failed;
    std::vector<std::string> notices;
    lost_.store(false, std::memory_order_relaxed);
    camera_ = open_named(name_, failed);
    last_arrival_ = monotonic_now();
    std::string problem = camera_ ? std::string() : failed_to("cannot be opened", failed);
    if (problem.empty()) {
      handler_ =
          g_signal_connect(arv_camera_get_device(camera_.get()), "control-lost", G_CALLBACK(on_control_lost), &lost_);
      arv_camera_set_acquisition_mode(camera_.get(), ARV_ACQUISITION_MODE_CONTINUOUS, &failed);
      problem = set_controls(camera_.get(), name_, options_.controls, notices);
    }
    if (problem.empty()) problem = choose_format();
    if (problem.empty()) problem = set_region();
    if (problem.empty()) problem = set_trigger();
    if (problem.empty()) problem = set_rate(notices);
    if (problem.empty()) problem = start(notices);
    if (!problem.empty()) {
      close();
      return problem;
    }
    read_clock(notices);
    const std::lock_guard lock(status_mutex_);
    status_.notices = std::move(notices);
    status_.automatics = automatics_on(camera_.get(), options_.controls);
    return {};
  }

  tl::expected<bool, std::string> read(Frame& frame) override {
    for (;;) {
      std::string problem;
      if (read_frame(frame, problem)) return true;
      if (nobody_waits()) return false;
      if (!problem.empty())
        if (std::string given_up = reopen(problem); !given_up.empty()) {
          if (left_) return false;
          return tl::unexpected(given_up);
        }
      // A damaged frame (a full network): the next one may be well, but not for ever.
      if (damaged_ > max_damaged) return tl::unexpected(address() + ": sends only damaged frames");
    }
  }

  TimeStamps stamps() const override { return stamps_.load(std::memory_order_relaxed); }
  SourceStatus status() const override {
    const std::lock_guard lock(status_mutex_);
    return status_;
  }
  std::string describe() const override {
    return fmt::format("camera {} ({}x{} {}, {:.3g} frames/s{})", address(), width_, height_, format_, 1.0 / period_,
                       options_.trigger.empty() ? "" : ", trigger " + options_.trigger);
  }

 private:
  // Aravis's thread.
  static void on_control_lost(ArvDevice*, std::atomic<bool>* lost) { lost->store(true, std::memory_order_relaxed); }

  std::string address() const { return "aravis:" + name_; }
  std::string failed_to(const char* what, const Failure& failed) const {
    return failed_to(what, failed ? failed.text() : "no reason given");
  }
  std::string failed_to(const char* what, const std::string& why) const {
    return fmt::format("{}: {} ({})", address(), what, why);
  }
  bool software_trigger() const { return options_.trigger == "software"; }

  /// What holds a camera.
  struct Held {
    Object<ArvCamera> camera;
    Object<ArvStream> stream;  // goes before its camera
    gulong handler = 0;

    void let_go() {
      Failure failed;
      if (stream) arv_camera_stop_acquisition(camera.get(), &failed);
      stream.reset();
      camera.reset();
    }
  };

  void close() {
    if (!camera_) return;
    g_signal_handler_disconnect(arv_camera_get_device(camera_.get()), handler_);
    Held held{std::move(camera_), std::move(stream_), handler_};
    if (!silent(held.stream.get())) return held.let_go();
    // With a camera that does not answer, every call takes seconds to fail; the caller does not wait for that.
    std::thread([held = std::move(held)]() mutable { held.let_go(); }).detach();
  }
  /// No frame has come for longer than frames take, and no unread frame is waiting.
  bool silent(ArvStream* stream) const {
    if (lost_.load(std::memory_order_relaxed)) return true;
    if (frames_ == 0 || stream == nullptr || monotonic_now() - last_arrival_ <= stall_wait()) return false;
    gint empty = 0;
    gint full = 0;
    arv_stream_get_n_buffers(stream, &empty, &full);
    return full == 0;
  }
  double stall_wait() const { return std::max(least_stall_wait, stall_frames * std::max(period_, seen_period_)); }

  std::string choose_format() {
    Failure failed;
    guint count = 0;
    const std::unique_ptr<gint64, Free> numbers(arv_camera_dup_available_pixel_formats(camera_.get(), &count, &failed));
    if (!numbers) return failed_to("does not tell its formats", failed);
    Silence silence;
    const std::vector<std::string> names = words_of(camera_.get(), "PixelFormat", silence);
    if (const std::string why = silence.text(); !why.empty()) return failed_to("does not tell its formats", why);
    pixels_ = nullptr;
    for (const PixelKind& kind : formats) {
      for (guint i = 0; i < count && i < names.size() && pixels_ == nullptr; ++i)
        if (numbers.get()[i] == static_cast<gint64>(kind.number) &&
            (options_.format.empty() || options_.format == names[i])) {
          pixels_ = &kind;
          format_ = names[i];
        }
      if (pixels_ != nullptr) break;
    }
    if (pixels_ == nullptr)
      return fmt::format("{}: offers {}; needed: {}", address(), fmt::join(names, ", "),
                         options_.format.empty() ? "Mono, YUV422, Bayer, RGB8 or BGR8" : options_.format);
    arv_camera_set_pixel_format(camera_.get(), pixels_->number, &failed);
    return failed ? failed_to("does not take its format", failed) : std::string();
  }

  /// The requested size, from the middle of the sensor: the position of a smaller picture determines the calibration's
  /// centre.
  std::string set_region() {
    Failure failed;
    gint x = 0;
    gint y = 0;
    if (options_.width > 0 && options_.height > 0) {
      arv_camera_set_region(camera_.get(), 0, 0, -1, -1, &failed);  // its bounds depend on where it begins
      gint most = 0;
      gint least = 0;
      arv_camera_get_width_bounds(camera_.get(), &least, &most, &failed);
      if (failed) return failed_to("does not tell its sizes", failed);
      if (options_.width < least || options_.width > most)
        return refused_size(fmt::format("width: {} to {}", least, most));
      arv_camera_get_height_bounds(camera_.get(), &least, &most, &failed);
      if (failed) return failed_to("does not tell its sizes", failed);
      if (options_.height < least || options_.height > most)
        return refused_size(fmt::format("height: {} to {}", least, most));
      arv_camera_set_region(camera_.get(), 0, 0, options_.width, options_.height, &failed);
      if (failed) return refused_size(failed.text());
      const auto middle = [&](gint step) { return step > 0 ? most / 2 / step * step : 0; };
      arv_camera_get_x_offset_bounds(camera_.get(), &least, &most, &failed);
      x = failed ? 0 : middle(arv_camera_get_x_offset_increment(camera_.get(), &failed));
      arv_camera_get_y_offset_bounds(camera_.get(), &least, &most, &failed);
      y = failed ? 0 : middle(arv_camera_get_y_offset_increment(camera_.get(), &failed));
      arv_camera_set_region(camera_.get(), x, y, options_.width, options_.height, &failed);
      if (failed) return refused_size(failed.text());
    }
    arv_camera_get_region(camera_.get(), &x, &y, &width_, &height_, &failed);
    if (failed) return failed_to("does not tell its size", failed);
    if (options_.width > 0 && (width_ != options_.width || height_ != options_.height))
      return refused_size(fmt::format("it gives {}x{}", width_, height_));
    return {};
  }
  std::string refused_size(const std::string& why) const {
    gint width = 0;
    gint height = 0;
    arv_camera_get_sensor_size(camera_.get(), &width, &height, nullptr);
    return fmt::format("{}: cannot give {}x{}; its sensor has {}x{} ({})", address(), options_.width, options_.height,
                       width, height, why);
  }

  std::string set_trigger() {
    Failure failed;
    if (options_.trigger.empty()) {
      arv_camera_clear_triggers(camera_.get(), &failed);  // a camera without any says so
      return {};
    }
    Silence silence;
    const std::vector<std::string> lines = words_of(camera_.get(), "TriggerSource", silence);
    if (const std::string why = silence.text(); !why.empty()) return failed_to("does not tell its triggers", why);
    const std::string wanted = software_trigger() ? "Software" : options_.trigger;
    if (std::find(lines.begin(), lines.end(), wanted) == lines.end())
      return fmt::format("{}: trigger \"{}\"; allowed: software, {}", address(), options_.trigger,
                         fmt::join(lines, ", "));
    arv_camera_set_trigger(camera_.get(), wanted.c_str(), &failed);
    return failed ? failed_to("does not take its trigger", failed) : std::string();
  }

  /// Sets the rate and reads the exposure, by which frames are dated.
  std::string set_rate(std::vector<std::string>& notices) {
    Failure failed;
    const bool free = options_.trigger.empty();
    if (free && options_.rate > 0.0) arv_camera_set_frame_rate(camera_.get(), options_.rate, &failed);
    const double given = free ? arv_camera_get_frame_rate(camera_.get(), &failed) : options_.rate;
    if (given > 0.0) period_ = 1.0 / given;
    if (free && given > 0.0 && given < as_good * options_.rate)
      notices.push_back(fmt::format("{}: gives {:.3g} frames/s at {}x{} {}, not {:.3g}", address(), given, width_,
                                    height_, format_, options_.rate));
    Silence silence;
    exposure_ = arv_camera_is_exposure_time_available(camera_.get(), &silence)
                    ? 1e-6 * arv_camera_get_exposure_time(camera_.get(), &silence)
                    : 0.0;
    if (const std::string why = silence.text(); !why.empty()) return failed_to("does not tell its exposure", why);
    return {};
  }

  /// How a GigE camera's packets reach us. The kernel holds what the receiver has not read yet: where it cannot hold a
  /// frame, a receiver that waits for a processor for a millisecond or two loses packets.
  void choose_receiver(guint payload, std::vector<std::string>& notices) const {
    if (!arv_camera_is_gv_device(camera_.get())) return;
    const long limit = receive_buffer_limit();
    if (limit < static_cast<long>(payload)) {
      notices.push_back(fmt::format(
          "{}: a frame has {} bytes, and this machine holds {} of a receiver that is busy: frames may not be whole; as "
          "root: sysctl net.core.rmem_max={}",
          address(), payload, limit, good_receive_buffer_limit));
      return;
    }
    // As root Aravis would read the network's packets raw, and until its filter is in place others' too, which it takes
    // for frames. A buffer that holds a frame is good enough for root as well.
    arv_camera_gv_set_stream_options(camera_.get(), ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  }
  /// Gives Aravis's receiving thread a real-time priority. Where it is refused, so is that of the control thread, and
  /// `skein run` says so.
  static void on_stream(void*, ArvStreamCallbackType type, ArvBuffer*) {
    if (type != ARV_STREAM_CALLBACK_TYPE_INIT) return;
    sched_param wanted{};
    wanted.sched_priority = receiver_priority;
    ::pthread_setschedparam(::pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &wanted);
  }

  std::string start(std::vector<std::string>& notices) {
    Failure failed;
    const guint payload = arv_camera_get_payload(camera_.get(), &failed);
    if (failed) return failed_to("does not tell how large its frames are", failed);
    choose_receiver(payload, notices);
    stream_.reset(arv_camera_create_stream(camera_.get(), on_stream, nullptr, &failed));
    if (!stream_) return failed_to("does not stream", failed);
    if (ARV_IS_GV_STREAM(stream_.get())) {
      const auto retention = static_cast<guint>(1e6 * std::clamp(period_, least_retention, most_retention));
      g_object_set(stream_.get(), "packet-resend", ARV_GV_STREAM_PACKET_RESEND_ALWAYS, "frame-retention", retention,
                   "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                   static_cast<gint>(buffered_frames * payload), nullptr);
    }
    for (int i = 0; i < buffers; ++i) arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(payload));
    arv_camera_start_acquisition(camera_.get(), &failed);
    return failed ? failed_to("does not start", failed) : std::string();
  }

  /// The camera's clock beside the host's: the quickest of some answers.
  void read_clock(std::vector<std::string>& notices) {
    Silence silence;  // seen at the first latch
    const ClockFeatures features = clock_features(camera_.get(), silence);
    std::optional<double> offset;
    double quickest = std::numeric_limits<double>::infinity();
    for (int i = 0; features.latch != nullptr && i < 8; ++i) {
      Failure failed;
      const double before = monotonic_now();
      arv_camera_execute_command(camera_.get(), features.latch, &failed);
      const double after = monotonic_now();
      if (failed) break;
      const gint64 value = arv_camera_get_integer(camera_.get(), features.value, &failed);
      if (failed) break;
      if (after - before >= quickest) continue;
      quickest = after - before;
      offset = 0.5 * (before + after) - static_cast<double>(value) / features.frequency;
    }
    clock_ = DeviceClock(offset);
    if (!offset && !software_trigger())
      notices.push_back(fmt::format(
          "{}: its clock cannot be read: its exposure counts as over when the first packet of its frame arrives",
          address()));
  }

  struct Unqueue {
    ArvStream* stream;
    void operator()(ArvBuffer* buffer) const { arv_stream_push_buffer(stream, buffer); }
  };
  using Buffer = std::unique_ptr<ArvBuffer, Unqueue>;

  /// Waits for the newest frame. false: none, or a damaged one; `problem`: the camera has stopped delivering.
  bool read_frame(Frame& frame, std::string& problem) {
    if (!trigger(problem)) return false;
    int passed_over = 0;
    Buffer newest = wait(problem);
    if (!newest) return false;
    // Everything that has piled up while we were busy; only the last is of use.
    while (ArvBuffer* newer = arv_stream_try_pop_buffer(stream_.get())) {
      ++passed_over;
      newest = Buffer(newer, {stream_.get()});
    }
    const double arrived_at = monotonic_now();
    last_arrival_ = arrived_at;
    const bool whole = arv_buffer_get_status(newest.get()) == ARV_BUFFER_STATUS_SUCCESS && convert(*newest, frame);
    if (whole) {
      frame.captured_at = captured_at(*newest, arrived_at, passed_over);
      frame.arrived_at = arrived_at;
      frame.index = frames_++;
      frame.source = std::to_string(frame.index);
      if (!fresh_) seen_period_ = std::clamp((frame.captured_at - last_capture_) / (1 + passed_over), 0.0, 1.0);
      last_capture_ = frame.captured_at;
    }
    damaged_ = whole ? 0 : damaged_ + 1;
    fresh_ = fresh_ && !whole;
    const std::lock_guard lock(status_mutex_);
    status_.up = status_.up || whole;
    status_.passed_over += passed_over;
    if (!whole && status_.damaged++ == 0) status_.notices.push_back(loss());
    return whole;
  }

  std::string loss() const {
    guint64 again = 0;
    guint64 missing = 0;
    if (ARV_IS_GV_STREAM(stream_.get())) arv_gv_stream_get_statistics(ARV_GV_STREAM(stream_.get()), &again, &missing);
    return fmt::format(
        "{}: a frame was not whole ({} packets sent again, {} missing): is the network full, or its receive buffer too "
        "small?",
        address(), again, missing);
  }

  /// Software trigger: requests a frame when it is time. false: the caller no longer waits, or the camera did not
  /// receive it.
  bool trigger(std::string& problem) {
    if (!software_trigger()) return true;
    const double now = monotonic_now();
    trigger_at_ = std::max(trigger_at_ + period_, now - period_);
    while (monotonic_now() < trigger_at_) {
      if (nobody_waits()) return false;
      sleep_for(std::clamp(trigger_at_ - monotonic_now(), 0.0, look));
    }
    // What came of triggers that were thought lost is none of this one's.
    while (ArvBuffer* late = arv_stream_try_pop_buffer(stream_.get())) Buffer(late, {stream_.get()});
    asked_ = 0;
    return ask(problem);
  }
  /// Sends one software trigger. false: the camera did not hear it.
  bool ask(std::string& problem) {
    Failure failed;
    const double before = monotonic_now();
    arv_camera_software_trigger(camera_.get(), &failed);
    triggered_at_ = 0.5 * (before + monotonic_now());
    ++asked_;
    if (failed) problem = failed_to("did not hear its trigger", failed);
    return !failed;
  }

  /// Waits for a frame. None: `problem` says why none will come, or the caller no longer waits.
  Buffer wait(std::string& problem) {
    // Cameras ignore a trigger that comes before they are ready, and networks lose frames: one that does not come is
    // asked for again.
    const double patience = stall_wait();
    const double seconds = fresh_ ? first_frame_wait : software_trigger() ? 2.0 * patience : patience;
    const double until = monotonic_now() + seconds;
    while (monotonic_now() < until) {
      const auto slice = static_cast<guint64>(1e6 * std::clamp(until - monotonic_now(), 0.0, look));
      if (ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream_.get(), slice))
        return Buffer(buffer, {stream_.get()});
      if (nobody_waits()) return Buffer(nullptr, {stream_.get()});
      if (lost_.load(std::memory_order_relaxed)) {
        problem = address() + ": stopped answering (unplugged, or another program took it?)";
        return Buffer(nullptr, {stream_.get()});
      }
      if (software_trigger() && monotonic_now() - triggered_at_ > patience && !ask(problem))
        return Buffer(nullptr, {stream_.get()});
    }
    problem = fmt::format(
        "{}: no frame for {:.3g} s (unplugged{}?)", address(), seconds,
        options_.trigger.empty() || software_trigger() ? ", or the network is full" : ", or nothing triggers it");
    return Buffer(nullptr, {stream_.get()});
  }

  bool convert(ArvBuffer& buffer, Frame& frame) const {
    std::size_t size = 0;
    const auto* bytes = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(&buffer, &size));
    if (bytes == nullptr || arv_buffer_get_image_width(&buffer) != width_ ||
        arv_buffer_get_image_height(&buffer) != height_ ||
        arv_buffer_get_image_pixel_format(&buffer) != pixels_->number)
      return false;
    gint padding = 0;  // bytes behind each row
    gint below = 0;
    arv_buffer_get_image_padding(&buffer, &padding, &below);
    const std::size_t row = (static_cast<std::size_t>(width_) * static_cast<std::size_t>(pixels_->bits) + 7) / 8;
    frame.resize(width_, height_);
    return pixels_->to_grey({bytes, size}, row + static_cast<std::size_t>(std::max(0, padding)), frame);
  }

  /// The middle of the exposure, CLOCK_MONOTONIC [s].
  double captured_at(ArvBuffer& buffer, double arrived_at, int passed_over) {
    // The library stamps a frame's first packet by the wall clock, which may have been set meanwhile. Both clocks are
    // read here, the wall clock first: an interruption between them makes the packet late, which DeviceClock expects,
    // and never early.
    const double wall = 1e-6 * static_cast<double>(g_get_real_time());
    const double now = monotonic_now();
    const double since = wall - 1e-9 * static_cast<double>(arv_buffer_get_system_timestamp(&buffer));
    const double first_packet = std::min(arrived_at, now - std::clamp(since, 0.0, 1.0));
    const double stamped = clock_.host(1e-9 * static_cast<double>(arv_buffer_get_timestamp(&buffer)), first_packet);
    const double half = 0.5 * exposure_;
    if (clock_.read()) {
      stamps_.store(TimeStamps::exposure_start, std::memory_order_relaxed);
      // A frame that left the camera sooner after its stamp than it was exposed was stamped at the end.
      const bool at_the_end = clock_.delay() && *clock_.delay() < 0.9 * exposure_;
      return at_the_end ? stamped - half : stamped + half;
    }
    // A frame that was requested twice may belong to either trigger.
    if (software_trigger() && passed_over == 0 && asked_ == 1) {
      stamps_.store(TimeStamps::exposure_start, std::memory_order_relaxed);
      return triggered_at_ + half;
    }
    stamps_.store(clock_.usable() ? TimeStamps::frame_end : TimeStamps::arrival, std::memory_order_relaxed);
    return stamped - half;
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
    // One that has never delivered, or has not since it was opened again, uses up the time as well.
    if (!std::exchange(fresh_, true)) out_since_ = monotonic_now();
    const int width = width_;
    const int height = height_;
    close();
    while (frames_ > 0 && monotonic_now() - out_since_ < options_.reopen_for) {
      if (nobody_waits()) return problem;
      if (open().empty()) {
        if (width_ == width && height_ == height) return {};
        return fmt::format("{}: came back with {}x{} px instead of {}x{}", address(), width_, height_, width, height);
      }
      sleep_for(reopen_pause);
    }
    return problem;
  }

  std::string name_;
  SourceOptions options_;
  std::atomic<bool> lost_{false};  // Aravis's thread says so
  Object<ArvCamera> camera_;
  Object<ArvStream> stream_;
  gulong handler_ = 0;  // of Aravis's word that the camera is lost
  const PixelKind* pixels_ = nullptr;
  std::string format_;
  int width_ = 0;
  int height_ = 0;
  double period_ = 1.0 / 25.0;  // as the camera says [s]
  double seen_period_ = 0.0;    // as the last frames were
  double exposure_ = 0.0;       // [s]; 0: not known
  DeviceClock clock_;
  std::int64_t frames_ = 0;
  int damaged_ = 0;         // frames in a row
  bool left_ = false;       // the caller no longer waits for a frame
  bool fresh_ = true;       // no frame since it was opened
  double out_since_ = 0.0;  // since when it has not delivered
  double last_capture_ = 0.0;
  double last_arrival_ = 0.0;  // or when it was opened
  double trigger_at_ = 0.0, triggered_at_ = 0.0;
  int asked_ = 0;                                        // triggers sent for the frame that is awaited
  std::atomic<TimeStamps> stamps_{TimeStamps::arrival};  // until a frame has said better
  mutable std::mutex status_mutex_;
  SourceStatus status_;
};

}  // namespace

std::unique_ptr<FrameSource> open_camera(const std::string& camera, const SourceOptions& options, std::string& error) {
  auto source = std::make_unique<AravisSource>(camera, options);
  error = source->open();
  if (!error.empty()) return nullptr;
  return source;
}

}  // namespace skein::vision::detail
