#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/run/status.h"

namespace skein::app {

/// What the camera showed of a robot's tag that was not seen, or of the place where it was last.
struct TagCrop {
  std::size_t robot = 0;
  std::string file;      ///< its name in whichever folder it is written to: see crop_file()
  std::string sentence;  ///< why the tag was not seen
  std::shared_ptr<const Picture> picture;
};

/// tag-3.png; of several cameras, counted from 0, camera-2-tag-3.png.
std::string crop_file(int tag, std::size_t camera, std::size_t cameras);

/// Writes its picture to a folder, over an older one. The error names the file.
tl::expected<void, std::string> write_crop(const TagCrop& crop, const std::string& folder);

/// The newest crop of each tag that was not seen by a camera of a session, in memory and, while that is wanted, as
/// files. Any thread.
class TagCrops {
 public:
  /// Forgets what it has; from now on each crop is also written to these folders.
  void begin(std::vector<std::string> folders);
  /// From now on no file is written: one that is being written is waited for.
  void end_files();
  /// Takes a crop, in place of an older one of the same file. Returns the path in the first folder, or why it could not
  /// be written; empty: there is no folder.
  std::string add(TagCrop crop);
  /// In the order of the robots.
  std::vector<TagCrop> all() const;

 private:
  std::mutex files_mutex_;  // of the folders, held while a file is written
  std::vector<std::string> folders_;
  mutable std::mutex mutex_;  // of the crops
  std::vector<TagCrop> crops_;
};

}  // namespace skein::app
