#include <algorithm>
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

bool decode_jpeg(const std::uint8_t* bytes, std::size_t size, Frame& frame) {
  if (jpeg_breaks_off({bytes, size})) return false;
  const cv::Mat coded(1, static_cast<int>(size), CV_8U, const_cast<std::uint8_t*>(bytes));
  try {
    // Decoding into the frame at once would save a copy (0.1 ms of 3) and leave the last picture in it when this one is
    // damaged.
    const cv::Mat decoded = cv::imdecode(coded, cv::IMREAD_GRAYSCALE);
    if (decoded.empty() || !decoded.isContinuous()) return false;
    frame.resize(decoded.cols, decoded.rows);
    std::copy(decoded.data, decoded.data + decoded.total(), frame.grey.data());
    return true;
  } catch (const cv::Exception&) {
    return false;
  }
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
const skein::vision::Media skein_media_9 = {.open = skein::vision::media::open,
                                            .decode_jpeg = skein::vision::media::decode_jpeg,
                                            .encode_jpeg = skein::vision::media::encode_jpeg,
                                            .encode_png = skein::vision::media::encode_png,
                                            .create_film = skein::vision::media::create_film};
