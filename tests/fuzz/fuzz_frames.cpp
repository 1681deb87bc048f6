// libFuzzer: build with clang and -DSKEIN_FUZZ=ON, run fuzz_frames -max_total_time=60. Films, pictures, and the frames
// of a camera that compresses them.
#include <unistd.h>
#include <filesystem>

#include <cstddef>
#include <opencv2/imgcodecs.hpp>

#include "tests/fuzz/vision_targets.h"
#include "vision/media/jpeg.h"
#include "vision/media/sources.h"

namespace {

using namespace skein;

/// Files that are well, and where the changed ones go.
struct Files {
  std::string path = (std::filesystem::temp_directory_path() / ("skein_fuzz_" + std::to_string(getpid()))).string();
  std::vector<vision::Frame> film = fuzz::small_film();
  std::vector<std::vector<std::uint8_t>> well;

  Files() {
    std::string error;
    const auto writer = vision::media::create_film(path, {}, vision::FilmCoding::lossless, error);
    for (const vision::Frame& frame : film) writer->write(frame);
    writer->finish();
    well.push_back(fuzz::read_bytes(path));
    const cv::Mat picture(film[0].height, film[0].width, CV_8UC1, film[0].grey.data());
    for (const char* kind : {".png", ".jpg", ".pgm", ".bmp", ".tif"}) cv::imencode(kind, picture, well.emplace_back());
  }
  ~Files() { std::filesystem::remove(path); }
};

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  setenv("OPENCV_IO_MAX_IMAGE_PIXELS", "16777216", 1);  // or large pictures would pass for leaks
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Files files;
  if (size == 0) return 0;
  const std::size_t which = data[0] % files.well.size();
  const auto bytes = fuzz::changed(files.well[which], {data + 1, size - 1});
  vision::Frame frame;
  vision::media::decode_jpeg(bytes, frame);
  fuzz::must_hold(frame.grey.size() == static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height));
  fuzz::write_bytes(files.path, bytes);
  const auto opener = [&](const std::string& path) {
    std::string error;
    auto source = which == 0 ? vision::media::open_video(path, error) : vision::media::open_images(path, error);
    fuzz::must_hold(source != nullptr || error.find(path) == 0);
    return source;
  };
  fuzz::frames(files.path, opener, files.film);
  return 0;
}
