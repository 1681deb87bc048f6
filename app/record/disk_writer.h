#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

namespace skein::app {

/// How a file may be begun.
struct WriteRules {
  bool force = false;  ///< take the place of a file that is there
};

/// "run-2.csv" for "run.csv", or the next number that no file has.
std::string free_name(const std::string& path);

/// Text on its way to a file, written by a thread of its own, so that nobody waits for a disk that stalls. It is on the
/// disk, not only with the system, within a second.
///
/// A new file is written beside its place, as PATH.part, and takes its name with publish(): what was there before stays
/// until then, and stays for good without `force`. The draft is locked: no second program writes there. A FIFO or a
/// device is written to as it is.
class DiskWriter {
 public:
  /// The error: it cannot be written there, or there is a file already, with a name that is free.
  static tl::expected<DiskWriter, std::string> open(const std::string& path, WriteRules rules = {});
  DiskWriter(DiskWriter&&) noexcept;
  DiskWriter& operator=(DiskWriter&&) noexcept;
  ~DiskWriter();  ///< finish(), and nobody hears how it went

  /// Hands text over. Where 64 MB already wait for the disk, waits itself, at most 5 s. False: it was not taken, or
  /// what was handed over before could not be written; failure() says why.
  bool write(std::string_view text);
  /// The file takes its name, in its turn. Without it there is no file in the end.
  void publish();
  std::string failure() const;  ///< empty: none so far

  /// Waits until everything is on the disk, at most `patience` [s]; then the file is closed, or left to the thread
  /// where the disk does not take it. The error says what is not written.
  tl::expected<void, std::string> finish(double patience);
  /// Waits likewise, and goes on.
  tl::expected<void, std::string> flush(double patience);

 private:
  struct State;
  explicit DiskWriter(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;  // the thread has it too, and may outlive this
};

}  // namespace skein::app
