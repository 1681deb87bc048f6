#pragma once

#include <semaphore.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <tl/expected.hpp>
#include <vector>

#include "vision/frames/film.h"
#include "vision/frames/frame.h"

namespace skein::vision {

struct RecorderStatus {
  std::int64_t written = 0;
  std::int64_t dropped = 0;  // offered when the disk or the encoder was too far behind, or after a problem
  std::string problem;       // why nothing more is written (a full disk); empty: all is well
};

/// Keeps frames in a film, on a thread of its own. Handing a frame over costs one copy of its pixels and never waits
/// for encoder or disk. Read back with open_source("video:..."), capture times and indices are the same bits, and so
/// are the pixels of a lossless film.
class Recorder {
 public:
  /// `capacity`: frames that may wait to be written. The error says why the film cannot be created.
  static tl::expected<std::unique_ptr<Recorder>, std::string> open(const std::string& path, const FilmNotes& notes = {},
                                                                   FilmCoding coding = FilmCoding::lossless,
                                                                   std::size_t capacity = 50);
  /// The same for a film that is already open.
  explicit Recorder(std::unique_ptr<FilmWriter> film, std::size_t capacity = 50);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// For the one thread that delivers the frames. Never waits; false: too many frames are waiting already, so this one
  /// is dropped and counted.
  bool offer(const Frame& frame);
  /// The same where time does not matter (films, the virtual clock): waits for room instead.
  void add(const Frame& frame);

  /// Writes the waiting frames and completes the file; no frame may be offered afterwards. Idempotent.
  RecorderStatus finish();
  /// Any thread, at any time.
  RecorderStatus status() const;
  /// Whether writing has ended: status() has the reason. Any thread, without a lock.
  bool broken() const noexcept { return broken_.load(std::memory_order_acquire); }

 private:
  void put(const Frame& frame);
  void work();
  void fail(std::string problem);

  std::unique_ptr<FilmWriter> film_;
  std::vector<Frame> waiting_;        // a ring: its buffers grow once
  std::atomic<std::int64_t> put_{0};  // frames that were put there; the offering thread's
  sem_t room_, ready_;                // std::counting_semaphore can miss a wake-up in GCC 12
  std::atomic<bool> broken_{false};
  std::atomic<std::int64_t> written_{0}, dropped_{0};
  mutable std::mutex problem_mutex_;
  std::string problem_;
  std::thread thread_;
};

}  // namespace skein::vision
