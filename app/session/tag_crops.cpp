#include "app/session/tag_crops.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "app/session/picture_copy.h"
#include "vision/frames/frame.h"
#include "vision/recording/picture_file.h"

namespace skein::app {

std::string crop_file(int tag, std::size_t camera, std::size_t cameras) {
  return cameras == 1 ? fmt::format("tag-{}.png", tag) : fmt::format("camera-{}-tag-{}.png", camera + 1, tag);
}

tl::expected<void, std::string> write_crop(const TagCrop& crop, const std::string& folder) {
  vision::Frame frame;
  copy_pixels(*crop.picture, frame);
  return vision::write_png(frame, folder + '/' + crop.file);
}

void TagCrops::begin(std::vector<std::string> folders) {
  const std::lock_guard files(files_mutex_);
  folders_ = std::move(folders);
  const std::lock_guard lock(mutex_);
  crops_.clear();
}

void TagCrops::end_files() {
  const std::lock_guard files(files_mutex_);
  folders_.clear();
}

std::string TagCrops::add(TagCrop crop) {
  const std::lock_guard files(files_mutex_);
  std::string result;
  for (const std::string& folder : folders_) {
    const auto written = write_crop(crop, folder);
    if (result.empty()) result = written ? folder + '/' + crop.file : written.error();
  }
  const std::lock_guard lock(mutex_);
  const auto older =
      std::find_if(crops_.begin(), crops_.end(), [&](const TagCrop& one) { return one.file == crop.file; });
  if (older == crops_.end())
    crops_.push_back(std::move(crop));
  else
    *older = std::move(crop);
  return result;
}

std::vector<TagCrop> TagCrops::all() const {
  std::vector<TagCrop> all;
  {
    const std::lock_guard lock(mutex_);
    all = crops_;
  }
  std::sort(all.begin(), all.end(),
            [](const TagCrop& a, const TagCrop& b) { return std::tie(a.robot, a.file) < std::tie(b.robot, b.file); });
  return all;
}

}  // namespace skein::app
