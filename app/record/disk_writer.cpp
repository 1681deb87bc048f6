#include "app/record/disk_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <thread>
#include <utility>

#include "app/run/follow_links.h"
#include "vision/frames/file_rights.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::size_t most_waiting = std::size_t{64} << 20;
constexpr auto longest_wait = 5s;
constexpr auto sync_period = 500ms;  // twice within the second that is promised
constexpr double last_patience = 5.0;
constexpr const char* draft_end = ".part";

std::string cannot(const std::string& path, int error) {
  return fmt::format("{}: cannot be written: {}", path, std::strerror(error));
}

void sync_directory(const std::string& path) {
  const fs::path parent = fs::path(path).parent_path();
  const int directory = ::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return;
  ::fsync(directory);
  ::close(directory);
}

/// Opens and locks the draft; -1 with errno, EWOULDBLOCK where another program has it.
int open_draft(const std::string& draft) {
  while (true) {
    const int file = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file < 0) return -1;
    struct stat opened {
    }, there{};
    const bool locked = ::flock(file, LOCK_EX | LOCK_NB) == 0;
    // Its previous holder may have renamed it just before.
    if (locked && ::fstat(file, &opened) == 0 && ::lstat(draft.c_str(), &there) == 0 && opened.st_ino == there.st_ino &&
        ::ftruncate(file, 0) == 0)
      return file;
    const int error = errno;
    ::close(file);
    if (!locked) {
      errno = error;
      return -1;
    }
  }
}

/// A file without a name in the folder of `path`; -1: the disk, such as one of a network, knows none.
int open_unnamed(const std::string& path) {
  if (::access("/proc/self/fd", X_OK) != 0) return -1;  // without it the file could not get a name
  const fs::path parent = fs::path(path).parent_path();
  return ::open(parent.empty() ? "." : parent.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666);
}

/// Whether a program is writing the file of this name, under the lock of its draft.
bool being_written(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (file < 0) return false;
  const bool locked = ::flock(file, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(file);
  return locked;
}

std::string written_by_another(const std::string& path) {
  return fmt::format("{}: another program is writing it now", path);
}

/// A FIFO is opened when its reader is there, which may take a moment.
int open_as_it_is(const std::string& path) {
  int file = -1;
  for (int look = 0; look < 50; ++look) {
    file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (file >= 0 || errno != ENXIO) break;
    std::this_thread::sleep_for(100ms);
  }
  return file;
}

}  // namespace

std::string free_name(const std::string& path) {
  const fs::path whole(path);
  for (int number = 2;; ++number) {
    const fs::path next =
        whole.parent_path() / fmt::format("{}-{}{}", whole.stem().string(), number, whole.extension().string());
    std::error_code ignored;
    if (!fs::exists(next, ignored)) return next.string();
  }
}

struct DiskWriter::State {
  std::string path, draft;  // draft empty: written to as it is
  bool force = false, unnamed = false;
  int file = -1;

  std::mutex mutex;
  std::condition_variable changed, written;
  // Guarded by mutex:
  std::string waiting, failure;
  bool busy = false, dirty = false, publish = false, published = false, ends = false, ended = false;
  std::size_t unwritten = 0;    // bytes, those that are being written included
  std::size_t before_name = 0;  // of these, those that must be written before the file gets its name

  void run() noexcept;
  bool write_all(std::string_view text);
  void give_name();
  bool due_a_name() {
    const std::lock_guard lock(mutex);
    return publish && !published && before_name == 0;
  }
  void fail(const std::string& why) {
    if (failure.empty()) failure = why;
  }
};

DiskWriter::DiskWriter(std::shared_ptr<State> state) : state_(std::move(state)) {}
DiskWriter::DiskWriter(DiskWriter&&) noexcept = default;
DiskWriter& DiskWriter::operator=(DiskWriter&&) noexcept = default;
DiskWriter::~DiskWriter() {
  if (state_) (void)finish(last_patience);
}

tl::expected<DiskWriter, std::string> DiskWriter::open(const std::string& path, WriteRules rules) {
  auto state = std::make_shared<State>();
  state->path = path;
  state->force = rules.force;
  struct stat there {};
  const bool exists = ::stat(path.c_str(), &there) == 0;
  if (exists && S_ISDIR(there.st_mode)) return tl::unexpected(cannot(path, EISDIR));
  if (exists && !S_ISREG(there.st_mode)) {
    state->file = open_as_it_is(path);
    state->published = true;
    if (state->file < 0 && errno == ENXIO)
      return tl::unexpected(fmt::format("{}: no process reads from this FIFO", path));
  } else if (exists && !rules.force) {
    return tl::unexpected(fmt::format("{}: already exists, and no run is overwritten; use the free name {}, or --force",
                                      path, free_name(path)));
  } else if (exists && being_written(path)) {
    return tl::unexpected(written_by_another(path));
  } else {
    const auto target = follow_links(path);  // a link to where runs are kept stays a link
    if (!target) return tl::unexpected(cannot(path, ELOOP));
    state->path = *target;
    state->draft = state->path + draft_end;
    if (rules.whole) state->file = open_unnamed(state->path);
    state->unnamed = state->file >= 0;
    if (state->unnamed)
      state->draft += fmt::format(".{}", ::getpid());  // for a moment, when it gets its name
    else
      state->file = open_draft(state->draft);
    if (state->file < 0 && errno == EWOULDBLOCK) return tl::unexpected(written_by_another(path));
  }
  if (state->file < 0) return tl::unexpected(cannot(path, errno));
  if (!state->published) vision::keep_rights(state->path, state->file);
  std::thread([state] { state->run(); }).detach();
  return DiskWriter(std::move(state));
}

bool DiskWriter::write(std::string_view text) {
  std::unique_lock lock(state_->mutex);
  const bool room = state_->written.wait_for(
      lock, longest_wait, [&] { return state_->waiting.size() < most_waiting || !state_->failure.empty(); });
  if (!room) state_->fail(fmt::format("{}: the disk has stalled for too long", state_->path));
  if (!state_->failure.empty()) return false;
  state_->waiting += text;
  state_->unwritten += text.size();
  state_->changed.notify_one();
  return true;
}

void DiskWriter::publish() {
  const std::lock_guard lock(state_->mutex);
  if (!std::exchange(state_->publish, true)) state_->before_name = state_->unwritten;
  state_->changed.notify_one();
}

std::string DiskWriter::failure() const {
  const std::lock_guard lock(state_->mutex);
  return state_->failure;
}

tl::expected<void, std::string> DiskWriter::flush(double patience) {
  std::unique_lock lock(state_->mutex);
  state_->changed.notify_one();
  const bool done = state_->written.wait_for(lock, std::chrono::duration<double>(patience), [&] {
    return (state_->unwritten == 0 && !state_->busy && state_->publish == state_->published) ||
           !state_->failure.empty();
  });
  if (!state_->failure.empty()) return tl::unexpected(state_->failure);
  if (done) return {};
  return tl::unexpected(fmt::format("{}: the last {:.1f} kB are NOT written: the disk has stalled for {:g} s",
                                    state_->published ? state_->path : state_->draft,
                                    1e-3 * static_cast<double>(state_->unwritten), patience));
}

tl::expected<void, std::string> DiskWriter::finish(double patience) {
  const auto state = std::exchange(state_, nullptr);
  if (!state) return {};
  std::unique_lock lock(state->mutex);
  state->ends = true;
  state->changed.notify_one();
  state->written.wait_for(lock, std::chrono::duration<double>(patience), [&] { return state->ended; });
  if (!state->failure.empty()) return tl::unexpected(state->failure);
  if (state->ended) return {};
  return tl::unexpected(fmt::format("{}: the last {:.1f} kB are NOT written: the disk refuses them",
                                    state->published ? state->path : state->draft,
                                    1e-3 * static_cast<double>(state->unwritten)));
}

// --- The thread -------------------------------------------------------------------------------------------------

bool DiskWriter::State::write_all(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(file, text.data(), text.size());
    if (count > 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
      const std::lock_guard lock(mutex);
      unwritten -= static_cast<std::size_t>(count);
      before_name -= std::min(before_name, static_cast<std::size_t>(count));
    } else if (count < 0 && errno == EAGAIN) {
      pollfd room{file, POLLOUT, 0};
      ::poll(&room, 1, 1000);
    } else if (count == 0 || errno != EINTR) {
      const int error = count == 0 ? ENOSPC : errno;
      const std::lock_guard lock(mutex);
      fail(cannot(path, error));
      return false;
    }
  }
  return true;
}

void DiskWriter::State::give_name() {
  if (unnamed && ::linkat(AT_FDCWD, fmt::format("/proc/self/fd/{}", file).c_str(), AT_FDCWD, draft.c_str(),
                          AT_SYMLINK_FOLLOW) != 0) {
    const int error = errno;
    const std::lock_guard lock(mutex);
    published = true;
    return fail(cannot(path, error));
  }
  if (force && being_written(path)) {  // since the draft was opened
    const std::lock_guard lock(mutex);
    published = true;
    return fail(fmt::format("{}; what was written is in {}", written_by_another(path), draft));
  }
  const unsigned flags = force ? 0u : static_cast<unsigned>(RENAME_NOREPLACE);
  int result = ::renameat2(AT_FDCWD, draft.c_str(), AT_FDCWD, path.c_str(), flags);
  // Not every file system knows how not to replace.
  if (result != 0 && errno == EINVAL && ::access(path.c_str(), F_OK) != 0)
    result = ::rename(draft.c_str(), path.c_str());
  const int error = errno;
  if (result == 0) sync_directory(path);
  const std::lock_guard lock(mutex);
  published = true;
  if (result != 0) fail(fmt::format("{}: {}; what was written is in {}", path, std::strerror(error), draft));
}

void DiskWriter::State::run() noexcept {
  sigset_t pipe;  // a reader that has gone is an error of writing
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  ::pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
  try {
    auto synced = Clock::now();
    std::unique_lock lock(mutex);
    for (std::string text;;) {
      const auto something = [this] { return !waiting.empty() || (publish && !published) || ends; };
      if (dirty)
        changed.wait_until(lock, synced + sync_period, something);
      else
        changed.wait(lock, something);
      busy = true;
      text.swap(waiting);
      waiting.clear();
      const bool last = ends && text.empty();
      lock.unlock();
      const bool any = !text.empty();
      const bool well = !any || write_all(text);
      text.clear();
      if (due_a_name()) give_name();  // also of what a full disk has cut off: its rows are all there is of the run
      const bool sync = (dirty || any) && (last || Clock::now() - synced >= sync_period);
      int error = 0;
      if (sync && ::fdatasync(file) != 0 && errno != EINVAL && errno != EROFS) error = errno;
      if (sync) synced = Clock::now();
      lock.lock();
      if (error != 0) fail(cannot(path, error));
      dirty = (dirty || any) && !sync;
      busy = false;
      written.notify_all();
      if (!well || (last && waiting.empty()) || (ends && !failure.empty())) break;
    }
    const bool keep = published || draft.empty();
    lock.unlock();
    if (!keep) ::unlink(draft.c_str());
    ::close(std::exchange(file, -1));
    lock.lock();
    ended = true;
    written.notify_all();
  } catch (...) {
    ended = true;  // no memory: waiting callers give up by themselves
  }
}

}  // namespace skein::app
