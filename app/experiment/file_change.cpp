#include "app/experiment/file_change.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "app/run/follow_links.h"
#include "vision/frames/file_rights.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

tl::unexpected<std::string> failed(const std::string& path) {
  return tl::unexpected(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
}

}  // namespace

FileChange::FileChange(std::string path, std::string target, int draft)
    : path_(std::move(path)), target_(std::move(target)), draft_(draft) {}
FileChange::FileChange(FileChange&& other) noexcept
    : path_(std::move(other.path_)), target_(std::move(other.target_)), draft_(std::exchange(other.draft_, -1)) {}

FileChange::~FileChange() {
  if (draft_ < 0) return;
  ::unlink(draft_path().c_str());  // while it is locked: no other program has it
  ::close(draft_);
}

std::string FileChange::draft_path() const {
  return target_ + ".new";
}

tl::expected<FileChange, std::string> FileChange::begin(const std::string& path) {
  std::error_code error;
  const fs::path directory = fs::path(path).parent_path();
  if (!directory.empty()) fs::create_directories(directory, error);  // what is wrong with it, open says
  const auto target = follow_links(path);  // a link to the file that is shared between machines stays a link
  if (!target) {
    errno = ELOOP;
    return failed(path);
  }
  FileChange change(path, *target, -1);
  // The previous holder of the lock may have given its draft the name of the file, or have removed it.
  while (true) {
    const int draft = ::open(change.draft_path().c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (draft < 0) return failed(path);
    struct stat locked {};
    struct stat there {};
    if (::flock(draft, LOCK_EX) != 0) {
      ::close(draft);
      return failed(path);
    }
    if (::fstat(draft, &locked) == 0 && ::lstat(change.draft_path().c_str(), &there) == 0 &&
        locked.st_ino == there.st_ino) {
      change.draft_ = draft;
      return change;
    }
    ::close(draft);
  }
}

tl::expected<void, std::string> FileChange::save(std::string_view text) {
  if (::ftruncate(draft_, 0) != 0) return failed(path_);
  for (std::string_view rest = text; !rest.empty();) {
    const ssize_t count = ::write(draft_, rest.data(), rest.size());
    if (count <= 0) return failed(path_);
    rest.remove_prefix(static_cast<std::size_t>(count));
  }
  vision::keep_rights(target_, draft_);
  // On the disk before it takes the name: a power cut leaves the old file or the new one.
  if (::fsync(draft_) != 0 || std::rename(draft_path().c_str(), target_.c_str()) != 0) return failed(path_);
  ::close(std::exchange(draft_, -1));
  const fs::path parent = fs::path(target_).parent_path();
  const int directory = ::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory >= 0) {
    ::fsync(directory);
    ::close(directory);
  }
  return {};
}

}  // namespace skein::app
