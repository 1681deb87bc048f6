#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

namespace skein::app {

/// How a file may be created.
struct WriteRules {
  bool force = false;  ///< replace an existing file; the new one has its owner, group and mode
  bool whole = false;  ///< only a whole file is worth keeping: a killed program leaves none, where the disk allows it
};

/// "run-2.csv" for "run.csv", or the next number that no file has.
std::string free_name(const std::string& path);

/// Writes text to a file in a thread of its own, so that the caller does not wait for a disk that stalls. Text is on
/// the disk, not only in the system's cache, within a second.
///
/// A new file is written as PATH.part, and renamed by publish(): an existing file stays until then, and for
/// good without `force`. The draft is locked against a second program. With `whole` it has no name at all before
/// publish(), on most disks. A FIFO or a device is written to directly.
class DiskWriter {
 public:
  /// The error: it cannot be written there, or the file exists; then it names a free name.
  static tl::expected<DiskWriter, std::string> open(const std::string& path, WriteRules rules = {});
  DiskWriter(DiskWriter&&) noexcept;
  DiskWriter& operator=(DiskWriter&&) noexcept;
  ~DiskWriter();  ///< finish(), ignoring its result

  /// Queues text. If 64 MB already wait for the disk, blocks for at most 5 s. False: it was not accepted, or earlier
  /// text could not be written; failure() has the reason.
  bool write(std::string_view text);
  /// Renames the file, in sequence with the text. Without it no file remains.
  void publish();
  std::string failure() const;  ///< empty: none so far

  /// Waits until everything is on the disk, at most `patience` [s]; then the file is closed, or left to the thread if
  /// the disk stalls. The error says what is not written.
  tl::expected<void, std::string> finish(double patience);
  /// Waits likewise, and keeps the file open.
  tl::expected<void, std::string> flush(double patience);

 private:
  struct State;
  explicit DiskWriter(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;  // the thread has it too, and may outlive this
};

}  // namespace skein::app
