#include "vision/v4l2/v4l2_formats.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <limits>

#include "vision/frames/camera_patience.h"

namespace skein::vision::detail {
namespace {

// From free to costly (a JPEG of 1280x960 takes 3 ms). Those of one kind are the same to us: colours are not looked at.
constexpr std::array formats{
    PixelFormat{V4L2_PIX_FMT_GREY, grey_from_grey},
    PixelFormat{V4L2_PIX_FMT_NV12, grey_from_plane<1>},
    PixelFormat{V4L2_PIX_FMT_NV21, grey_from_plane<1>},
    PixelFormat{V4L2_PIX_FMT_YUV420, grey_from_plane<1>},
    PixelFormat{V4L2_PIX_FMT_YVU420, grey_from_plane<1>},
    PixelFormat{V4L2_PIX_FMT_NV16, grey_from_plane<2>},
    PixelFormat{V4L2_PIX_FMT_NV61, grey_from_plane<2>},
    PixelFormat{V4L2_PIX_FMT_YUV422P, grey_from_plane<2>},
    PixelFormat{V4L2_PIX_FMT_YUYV, grey_from_yuyv},
    PixelFormat{V4L2_PIX_FMT_YVYU, grey_from_yuyv},
    PixelFormat{V4L2_PIX_FMT_UYVY, grey_from_uyvy},
    PixelFormat{V4L2_PIX_FMT_VYUY, grey_from_uyvy},
    PixelFormat{V4L2_PIX_FMT_Y10, grey_from_words<10>},
    PixelFormat{V4L2_PIX_FMT_Y12, grey_from_words<12>},
    PixelFormat{V4L2_PIX_FMT_Y16, grey_from_words<16>},
    PixelFormat{V4L2_PIX_FMT_SRGGB8, grey_from_bayer<8>},
    PixelFormat{V4L2_PIX_FMT_SGRBG8, grey_from_bayer<8>},
    PixelFormat{V4L2_PIX_FMT_SGBRG8, grey_from_bayer<8>},
    PixelFormat{V4L2_PIX_FMT_SBGGR8, grey_from_bayer<8>},
    PixelFormat{V4L2_PIX_FMT_SRGGB10, grey_from_bayer<10>},
    PixelFormat{V4L2_PIX_FMT_SGRBG10, grey_from_bayer<10>},
    PixelFormat{V4L2_PIX_FMT_SGBRG10, grey_from_bayer<10>},
    PixelFormat{V4L2_PIX_FMT_SBGGR10, grey_from_bayer<10>},
    PixelFormat{V4L2_PIX_FMT_SRGGB12, grey_from_bayer<12>},
    PixelFormat{V4L2_PIX_FMT_SGRBG12, grey_from_bayer<12>},
    PixelFormat{V4L2_PIX_FMT_SGBRG12, grey_from_bayer<12>},
    PixelFormat{V4L2_PIX_FMT_SBGGR12, grey_from_bayer<12>},
    PixelFormat{V4L2_PIX_FMT_MJPEG, nullptr},
    PixelFormat{V4L2_PIX_FMT_JPEG, nullptr},
};

constexpr double any_rate = std::numeric_limits<double>::infinity();

bool gives_size(const V4l2Device& device, std::uint32_t format, const WantedFormat& wanted) {
  if (wanted.width <= 0 || wanted.height <= 0) return true;
  const auto width = static_cast<std::uint32_t>(wanted.width);
  const auto height = static_cast<std::uint32_t>(wanted.height);
  v4l2_frmsizeenum size{};
  size.pixel_format = format;
  for (; device.control(VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
    if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      if (size.discrete.width == width && size.discrete.height == height) return true;
      continue;
    }
    return width >= size.stepwise.min_width && width <= size.stepwise.max_width && height >= size.stepwise.min_height &&
           height <= size.stepwise.max_height;
  }
  return size.index == 0;  // a driver that lists none
}

/// [frames/s]
double fastest(const V4l2Device& device, std::uint32_t format, const WantedFormat& wanted) {
  v4l2_frmivalenum interval{};
  interval.pixel_format = format;
  interval.width = static_cast<std::uint32_t>(wanted.width);
  interval.height = static_cast<std::uint32_t>(wanted.height);
  double rate = 0.0;
  for (; device.control(VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0; ++interval.index) {
    const bool discrete = interval.type == V4L2_FRMIVAL_TYPE_DISCRETE;
    const v4l2_fract& period = discrete ? interval.discrete : interval.stepwise.min;
    if (period.numerator > 0) rate = std::max(rate, static_cast<double>(period.denominator) / period.numerator);
    if (!discrete) break;
  }
  return rate > 0.0 ? rate : any_rate;
}

std::string known_formats() {
  std::string names;
  for (const PixelFormat& format : formats) names += (names.empty() ? "" : ", ") + four_letters(format.number);
  return names;
}

}  // namespace

const PixelFormat* pixel_format(std::uint32_t number) {
  const auto found = std::find_if(formats.begin(), formats.end(), [&](const auto& f) { return f.number == number; });
  return found == formats.end() ? nullptr : &*found;
}

tl::expected<const PixelFormat*, std::string> choose_format(const V4l2Device& device, const WantedFormat& wanted) {
  std::vector<std::uint32_t> offered;
  std::string names;
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; device.control(VIDIOC_ENUM_FMT, &description) == 0; ++description.index) {
    offered.push_back(description.pixelformat);
    names += (names.empty() ? "" : ", ") + four_letters(description.pixelformat);
  }
  const PixelFormat* best = nullptr;
  const PixelFormat* of_any_size = nullptr;
  double best_rate = 0.0;
  for (const PixelFormat& format : formats) {
    if (std::find(offered.begin(), offered.end(), format.number) == offered.end()) continue;
    if (!wanted.format.empty() && four_letters(format.number) != wanted.format) continue;
    if (of_any_size == nullptr) of_any_size = &format;
    if (!gives_size(device, format.number, wanted)) continue;
    const double rate = wanted.width > 0 && wanted.rate > 0.0 ? fastest(device, format.number, wanted) : any_rate;
    if (rate >= as_good * wanted.rate) return &format;
    if (rate <= best_rate) continue;
    best = &format;
    best_rate = rate;
  }
  if (best != nullptr) return best;
  if (of_any_size != nullptr) return of_any_size;  // the driver has the last word on sizes
  return tl::unexpected(fmt::format("{}: offers {}; needed: {}", device.path(), names.empty() ? "no format" : names,
                                    wanted.format.empty() ? known_formats() : wanted.format));
}

}  // namespace skein::vision::detail
