#include "vision/recording/recorder.h"

#include <algorithm>
#include <cerrno>
#include <exception>

#include "vision/modules/media_loader.h"

namespace skein::vision {
namespace {

void wait(sem_t& semaphore) {
  while (sem_wait(&semaphore) == -1 && errno == EINTR) {
  }
}

/// Over whatever `path` held before. None: why not is in `error`.
std::unique_ptr<FilmWriter> create_film(const std::string& path, const FilmNotes& notes, FilmCoding coding,
                                        std::string& error) {
  const auto module = media();
  if (module) return (*module)->create_film(path, notes, coding, error);
  error = module.error();
  return nullptr;
}

}  // namespace

tl::expected<std::unique_ptr<Recorder>, std::string> Recorder::open(const std::string& path, const FilmNotes& notes,
                                                                    FilmCoding coding, std::size_t capacity) {
  std::string error;
  auto film = create_film(path, notes, coding, error);
  if (!film) return tl::unexpected(error);
  return std::make_unique<Recorder>(std::move(film), capacity);
}

Recorder::Recorder(std::unique_ptr<FilmWriter> film, std::size_t capacity)
    : film_(std::move(film)), waiting_(std::max<std::size_t>(1, capacity)) {
  sem_init(&room_, 0, static_cast<unsigned>(waiting_.size()));
  sem_init(&ready_, 0, 0);
  thread_ = std::thread([this] { work(); });
}

Recorder::~Recorder() {
  finish();
  sem_destroy(&room_);
  sem_destroy(&ready_);
}

bool Recorder::offer(const Frame& frame) {
  if (broken_.load(std::memory_order_relaxed) || sem_trywait(&room_) == -1) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  put(frame);
  return true;
}

void Recorder::add(const Frame& frame) {
  wait(room_);
  put(frame);
}

void Recorder::put(const Frame& frame) {
  const std::int64_t number = put_.load(std::memory_order_relaxed);
  waiting_[static_cast<std::size_t>(number) % waiting_.size()] = frame;
  put_.store(number + 1, std::memory_order_release);
  sem_post(&ready_);
}

void Recorder::work() {
  for (std::int64_t done = 0;; ++done) {
    wait(ready_);
    // One post a frame, and one behind the last: a thread that is woken and finds no frame has written all of them.
    if (done == put_.load(std::memory_order_acquire)) break;
    const std::size_t next = static_cast<std::size_t>(done) % waiting_.size();
    if (!broken_.load(std::memory_order_relaxed)) {
      try {
        fail(film_->write(waiting_[next]));
      } catch (const std::exception& error) {
        fail(error.what());
      }
    }
    (broken_.load(std::memory_order_relaxed) ? dropped_ : written_).fetch_add(1, std::memory_order_relaxed);
    sem_post(&room_);
  }
  const std::string problem = film_->finish();
  if (!broken_.load(std::memory_order_relaxed)) fail(problem);
}

void Recorder::fail(std::string problem) {
  if (problem.empty()) return;
  {
    const std::lock_guard lock(problem_mutex_);
    problem_ = std::move(problem);
  }
  broken_.store(true, std::memory_order_release);
}

RecorderStatus Recorder::finish() {
  if (thread_.joinable()) {
    sem_post(&ready_);
    thread_.join();
  }
  return status();
}

RecorderStatus Recorder::status() const {
  const std::lock_guard lock(problem_mutex_);
  return {written_.load(std::memory_order_relaxed), dropped_.load(std::memory_order_relaxed), problem_};
}

}  // namespace skein::vision
