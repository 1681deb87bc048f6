#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "vision/media/jpeg.h"
#include "vision/media/sources.h"

namespace skein::vision::media {
namespace {

std::unique_ptr<FrameSource> open(MediaKind kind, const std::string& path, std::string& error) {
  switch (kind) {
    case MediaKind::images:
      return open_images(path, error);
    case MediaKind::video:
      return open_video(path, error);
  }
  return nullptr;
}

JpegState decode(const std::uint8_t* bytes, std::size_t size, Frame& frame) {
  return decode_jpeg({bytes, size}, frame);
}

bool encode_jpeg(const Frame& frame, int quality, std::vector<std::uint8_t>& bytes) {
  const cv::Mat grey(frame.height, frame.width, CV_8U, const_cast<std::uint8_t*>(frame.grey.data()));
  try {
    const std::array<cv::Mat, 3> same{grey, grey, grey};
    cv::Mat colours;
    cv::merge(same, colours);
    return cv::imencode(".jpg", colours, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  } catch (const cv::Exception&) {
    return false;
  }
}

bool encode_png(const Frame& frame, std::vector<std::uint8_t>& bytes) {
  const cv::Mat grey(frame.height, frame.width, CV_8U, const_cast<std::uint8_t*>(frame.grey.data()));
  try {
    return cv::imencode(".png", grey, bytes);
  } catch (const cv::Exception&) {
    return false;
  }
}

}  // namespace
}  // namespace skein::vision::media

extern "C" __attribute__((visibility("default")))
const skein::vision::Media skein_media_10 = {.open = skein::vision::media::open,
                                             .decode_jpeg = skein::vision::media::decode,
                                             .encode_jpeg = skein::vision::media::encode_jpeg,
                                             .encode_png = skein::vision::media::encode_png,
                                             .create_film = skein::vision::media::create_film};
