#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "vision/media/sources.h"

namespace skein::vision::media {
namespace {

std::unique_ptr<FrameSource> open(MediaKind kind, const std::string& path, std::string& error) {
  return kind == MediaKind::video ? open_video(path, error) : open_images(path, error);
}

bool decode_jpeg(const std::uint8_t* bytes, std::size_t size, Frame& frame) {
  const cv::Mat coded(1, static_cast<int>(size), CV_8U, const_cast<std::uint8_t*>(bytes));
  try {
    // The picture's own buffer is reused by OpenCV as long as the size stays.
    cv::Mat grey(frame.height, frame.width, CV_8U, frame.grey.data());
    cv::Mat decoded = cv::imdecode(coded, cv::IMREAD_GRAYSCALE, &grey);
    if (decoded.empty() || !decoded.isContinuous()) return false;
    if (decoded.data == frame.grey.data()) return true;
    frame.resize(decoded.cols, decoded.rows);
    std::copy(decoded.data, decoded.data + decoded.total(), frame.grey.data());
    return true;
  } catch (const cv::Exception&) {
    return false;
  }
}

}  // namespace
}  // namespace skein::vision::media

extern "C" __attribute__((visibility("default"))) const skein::vision::Media skein_media_1 = {
    .open = skein::vision::media::open, .decode_jpeg = skein::vision::media::decode_jpeg};
