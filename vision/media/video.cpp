#include <fmt/format.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "vision/media/sources.h"

namespace skein::vision::media {
namespace {

class Video final : public FrameSource {
 public:
  Video(cv::VideoCapture capture, const std::string& path) : capture_(std::move(capture)) {
    rate_ = capture_.get(cv::CAP_PROP_FPS);
    what_ = fmt::format("video {} ({:.0f}x{:.0f}, {:.3g} frames/s)", path, capture_.get(cv::CAP_PROP_FRAME_WIDTH),
                        capture_.get(cv::CAP_PROP_FRAME_HEIGHT), rate_);
  }

  tl::expected<bool, std::string> read(Frame& frame) override {
    try {
      if (!capture_.read(colour_) || colour_.empty()) {
        if (frames_ == 0) return tl::unexpected(what_ + ": not a single frame can be decoded");
        return false;
      }
      frame.resize(colour_.cols, colour_.rows);
      cv::Mat grey(colour_.rows, colour_.cols, CV_8U, frame.grey.data());
      if (colour_.channels() == 1) {
        colour_.copyTo(grey);
      } else {
        cv::cvtColor(colour_, grey, cv::COLOR_BGR2GRAY);
      }
    } catch (const cv::Exception& problem) {
      return tl::unexpected(fmt::format("{}: {}", what_, problem.what()));
    }
    frame.index = frames_++;
    frame.source = std::to_string(frame.index);
    const double stamp = capture_.get(cv::CAP_PROP_POS_MSEC) / 1000.0;
    // Some containers carry no stamps: then the frames are evenly spaced.
    const bool stamped = stamp > last_stamp_ || (frame.index == 0 && stamp >= 0.0);
    frame.captured_at = stamped ? stamp : last_stamp_ + (rate_ > 0.0 ? 1.0 / rate_ : 0.04);
    last_stamp_ = frame.captured_at;
    return true;
  }

  std::string describe() const override { return what_; }

 private:
  cv::VideoCapture capture_;
  std::string what_;
  double rate_ = 0.0;
  double last_stamp_ = 0.0;
  std::int64_t frames_ = 0;
  cv::Mat colour_;
};

}  // namespace

std::unique_ptr<FrameSource> open_video(const std::string& path, std::string& error) {
  // OpenCV's own message for a missing file is about its backends.
  if (std::error_code code; !std::filesystem::is_regular_file(path, code)) {
    error = fmt::format("{}: no such file", path);
    return nullptr;
  }
  try {
    cv::VideoCapture capture(path, cv::CAP_FFMPEG);
    if (capture.isOpened()) return std::make_unique<Video>(std::move(capture), path);
  } catch (const cv::Exception&) {
    // said below
  }
  error = fmt::format("{}: not a video that can be read", path);
  return nullptr;
}

}  // namespace skein::vision::media
