#include "vision/bench/bench_cold.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <new>
#include <stdexcept>
#include <vector>

#include "vision/bench/bench_methods.h"
#include "vision/modules/media_loader.h"

namespace skein::vision::detail {
namespace {

// The first frames are not timed: the tracker finds its tags and learns what the floor has that looks like one.
constexpr int settling = 50;

// The slow methods take so many of the frames: they have no memory, and AprilTag's times vary little.
constexpr int slow_ones_in = 5;

constexpr int quality = 75;  // of an MJPEG camera's pictures

/// Other work between two frames: what the caches held is not there any more.
class OtherWork {
 public:
  OtherWork() : size_(last_level_cache() / step * 5 / 4 * step), memory_(allocate(size_)) {
    std::fill_n(memory_.get(), size_, std::uint8_t{1});  // a page that was never written is the same for all
  }

  void walk() {
    const std::size_t part = size_ / streams;
    std::uint64_t sum = 0;
    for (std::size_t at = 0; at < part; at += line)
      for (std::size_t stream = 0; stream < streams; ++stream) sum += memory_[stream * part + at];
    seen_ = sum;
  }

 private:
  static constexpr std::size_t line = 64;     // of a cache [bytes]
  static constexpr std::size_t streams = 16;  // at once: one alone waits for each line
  static constexpr std::size_t huge = std::size_t{1} << 21;
  static constexpr std::size_t step = huge * streams;
  struct Free {
    void operator()(std::uint8_t* memory) const { ::operator delete[](memory, std::align_val_t{huge}); }
  };

  static std::unique_ptr<std::uint8_t[], Free> allocate(std::size_t size) {
    auto* const memory = static_cast<std::uint8_t*>(::operator new[](size, std::align_val_t{huge}));
    madvise(memory, size, MADV_HUGEPAGE);  // saves time; it works without
    return std::unique_ptr<std::uint8_t[], Free>(memory);
  }

  std::size_t size_;
  std::unique_ptr<std::uint8_t[], Free> memory_;
  volatile std::uint64_t seen_ = 0;
};

/// What a camera delivers.
struct Shot {
  BenchMoment moment;
  Frame frame;
  std::vector<std::uint8_t> jpeg;
};

/// A scene's frames, a few at a time, through one method after the other.
class Pass {
 public:
  Pass(const BenchScene& scene, int frames, OtherWork* between)
      : scene_(scene),
        frames_(settling + frames),
        between_(between),
        camera_(scene.calibration, scene.options, 17),
        methods_(bench_methods(scene)) {
    std::erase_if(methods_, [](const auto& method) { return method->name == "OpenCV ArUco"; });
    if (!scene.mjpeg) return;
    const auto module = media();
    if (!module) throw std::runtime_error(module.error());
    media_ = *module;
  }

  Scores run() {
    constexpr int round = 25;
    auto moment_of = scene_.moment;  // it may have a memory
    std::vector<Shot> film(round);
    for (int first = 0; first < frames_; first += round) {
      const int count = std::min(round, frames_ - first);
      for (int k = 0; k < count; ++k) {
        Shot& shot = film[static_cast<std::size_t>(k)];
        shot.moment = moment_of(first + k);
        const double at = bench_period * (first + k);
        camera_.render(shot.moment.tags, shot.moment.discs, at, shot.frame);
        shot.frame.captured_at = at;
        if (media_ != nullptr) coded_bytes_ += code(shot);
      }
      for (const auto& method : methods_) {
        const bool slow = method != methods_.back();
        for (int k = 0; k < count; ++k) {
          const int at = first + k - settling;
          if (slow && (at < 0 || at % slow_ones_in != 0)) continue;
          take(film[static_cast<std::size_t>(k)], *method, at >= 0);
        }
      }
    }
    return std::move(scores_);
  }

  double jpeg_bytes() const { return coded_bytes_ / frames_; }

 private:
  double code(Shot& shot) {
    if (!media_->encode_jpeg(shot.frame, quality, shot.jpeg)) throw std::runtime_error("a JPEG cannot be made");
    return static_cast<double>(shot.jpeg.size());
  }

  void take(const Shot& shot, BenchMethod& method, bool timed) {
    // As a camera's driver does.
    if (media_ == nullptr)
      frame_ = shot.frame;
    else
      bytes_ = shot.jpeg;
    if (between_ != nullptr && timed) between_->walk();
    const double start = own_ms();
    if (media_ != nullptr) {
      if (media_->decode_jpeg(bytes_.data(), bytes_.size(), frame_) != JpegState::whole)
        throw std::runtime_error("a JPEG is damaged");
      frame_.captured_at = shot.frame.captured_at;
    }
    const double decoded = own_ms();
    const std::vector<TagPose>& poses = method.detect(frame_);
    const double end = own_ms();
    if (!timed) return;
    Score& score = scores_[method.name];
    score.ms.push_back(end - start);
    score.add(shot.moment, poses);
    if (media_ != nullptr) scores_["decoding"].ms.push_back(decoded - start);
  }

  const BenchScene& scene_;
  int frames_;
  OtherWork* between_;
  SyntheticCamera camera_;
  std::vector<std::unique_ptr<BenchMethod>> methods_;
  const Media* media_ = nullptr;
  double coded_bytes_ = 0.0;
  Scores scores_;
  Frame frame_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

std::size_t last_level_cache() {
  constexpr std::size_t likely = std::size_t{32} << 20;
  const long third = sysconf(_SC_LEVEL3_CACHE_SIZE);
  const long second = sysconf(_SC_LEVEL2_CACHE_SIZE);
  return std::max(likely, static_cast<std::size_t>(std::max({third, second, 0L})));
}

ColdScores measure_cold(const BenchScene& scene, int frames) {
  ColdScores scores;
  {
    OtherWork other_work;
    scores.cold = Pass(scene, frames, &other_work).run();
  }
  Pass warm(scene, frames, nullptr);
  scores.warm = warm.run();
  scores.jpeg_bytes = warm.jpeg_bytes();
  return scores;
}

}  // namespace skein::vision::detail
