#pragma once

#include <linux/videodev2.h>
#include <sys/mman.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "vision/v4l2/v4l2_kernel.h"

namespace skein::vision {

/// A camera as the kernel presents it, made of memory.
class FakeCamera final : public V4l2Kernel {
 public:
  // What the camera can do
  std::vector<std::uint32_t> formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_GREY};
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::uint32_t width = 640;
  std::uint32_t height = 480;
  bool fixed_size = false;
  std::map<std::uint32_t, std::vector<std::uint32_t>> rates{};  // by format, at every size; others give 30 and 15
  std::uint32_t rate = 10;                                      // as it is set, or what it gives for what it is asked
  std::uint32_t padding = 0;                                    // bytes at the end of each row
  std::uint32_t field = V4L2_FIELD_NONE;                        // that it gives whatever it is asked for
  std::uint32_t timestamp = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  std::string driver{};
  std::string hwtimestamps{};  // the parameter of uvcvideo
  bool busy = false;
  struct Control {
    std::string name;
    std::uint32_t type = V4L2_CTRL_TYPE_INTEGER;
    int least = 0, most = 255, value = 0;
    std::uint32_t flags = 0;
  };
  std::map<std::uint32_t, Control> controls{};  // by id, as the kernel lists them

  // What it has to deliver at the next poll: frames, all at once. Empty: nothing comes any more.
  struct Shot {
    std::uint8_t grey = 0;
    double at = 0.0;
    std::uint32_t flags = 0;
    std::size_t lost = 0;               // bytes that the bus lost
    std::vector<std::uint8_t> coded{};  // a JPEG, in place of the grey
  };
  std::deque<std::vector<Shot>> coming;
  int interruptions = 0;   // calls that a signal interrupts first
  int stalls = 0;          // waits that end without a frame first
  bool unplugged = false;  // while it is open
  int gone_for_ms = 0;     // its device is not there; runs out while somebody sleeps

  // What became of it
  int opened = 0;
  int mapped = 0;
  bool streaming = false;
  int opens = 0;  // in sum
  int last_wait_ms = 0;
  std::uint32_t pixelformat = 0;

  int open(const char*) override {
    if (gone_for_ms > 0) return fail(ENOENT);
    ++opened;
    ++opens;
    unplugged = false;
    return 7;
  }
  void close(int fd) override {
    EXPECT_EQ(fd, 7);
    --opened;
    idle_.clear();
    full_.clear();
  }
  void* map(int, std::size_t length, std::uint32_t offset) override {
    ++mapped;
    memory_.resize(std::max<std::size_t>(memory_.size(), offset + 1));
    memory_[offset].resize(length);
    return memory_[offset].data();
  }
  void unmap(void*, std::size_t) override { --mapped; }
  std::string parameter(const std::string& module, const std::string& name) override {
    return module == "uvcvideo" && name == "hwtimestamps" ? hwtimestamps : std::string();
  }

  int poll(pollfd* waiting, int milliseconds) override {
    if (waiting->fd == -1) {
      gone_for_ms -= milliseconds;
      return 0;
    }
    last_wait_ms = milliseconds;
    if (interruptions-- > 0) return fail(EINTR);
    if (unplugged) {
      waiting->revents = POLLERR;
      return 1;
    }
    if (stalls-- > 0 || coming.empty()) return 0;
    for (const Shot& shot : coming.front()) fill(shot);
    coming.pop_front();
    waiting->revents = POLLIN;
    return 1;
  }

  int control(int fd, unsigned long request, void* argument) override {
    EXPECT_EQ(fd, 7);
    if (interruptions-- > 0) return fail(EINTR);
    switch (request) {
      case VIDIOC_QUERYCAP:
        static_cast<v4l2_capability*>(argument)->capabilities = capabilities;
        std::memcpy(static_cast<v4l2_capability*>(argument)->driver, driver.data(), driver.size());
        return 0;
      case VIDIOC_ENUM_FMT: {
        auto* description = static_cast<v4l2_fmtdesc*>(argument);
        if (description->index >= formats.size()) return fail(EINVAL);
        description->pixelformat = formats[description->index];
        return 0;
      }
      case VIDIOC_G_FMT:
        describe(*static_cast<v4l2_format*>(argument));
        return 0;
      case VIDIOC_S_FMT: {
        auto& format = *static_cast<v4l2_format*>(argument);
        pixelformat = format.fmt.pix.pixelformat;
        if (!fixed_size) {
          width = format.fmt.pix.width;
          height = format.fmt.pix.height;
        }
        describe(format);
        return 0;
      }
      case VIDIOC_S_PARM:
        return fail(ENOTTY);  // as many cameras answer
      case VIDIOC_G_PARM:
        static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe = {1, rate_of(pixelformat)};
        return 0;
      case VIDIOC_REQBUFS:
        return busy ? fail(EBUSY) : 0;
      case VIDIOC_QUERYBUF: {
        auto* buffer = static_cast<v4l2_buffer*>(argument);
        buffer->length = stride() * height + stride() * height * halves_of_colours() / 2;
        buffer->m.offset = buffer->index;
        return 0;
      }
      case VIDIOC_QBUF:
        idle_.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF: {
        if (full_.empty()) return fail(EAGAIN);
        *static_cast<v4l2_buffer*>(argument) = full_.front();
        full_.pop_front();
        return 0;
      }
      case VIDIOC_STREAMON:
        streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        streaming = false;
        return 0;
      case VIDIOC_QUERYCTRL: {
        auto& query = *static_cast<v4l2_queryctrl*>(argument);
        const std::uint32_t after = query.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
        const auto next = controls.upper_bound(after);
        if (next == controls.end()) return fail(EINVAL);
        query = {};
        query.id = next->first;
        query.type = next->second.type;
        std::memcpy(query.name, next->second.name.data(), std::min<std::size_t>(31, next->second.name.size()));
        query.minimum = next->second.least;
        query.maximum = next->second.most;
        query.step = 1;
        query.flags = next->second.flags;
        return 0;
      }
      case VIDIOC_QUERYMENU: {
        auto& item = *static_cast<v4l2_querymenu*>(argument);
        if (item.index == 2) return fail(EINVAL);  // a gap
        const std::string_view name = item.index == 1 ? "Manual Mode" : "Auto Mode";
        std::memcpy(item.name, name.data(), name.size());  // zeros follow: the caller's struct is empty
        return 0;
      }
      case VIDIOC_G_CTRL:
      case VIDIOC_S_CTRL: {
        auto& control = *static_cast<v4l2_control*>(argument);
        const auto found = controls.find(control.id);
        if (found == controls.end()) return fail(EINVAL);
        if (request == VIDIOC_G_CTRL)
          control.value = found->second.value;
        else
          found->second.value =  // some steps are coarser than the driver says
              found->second.type == V4L2_CTRL_TYPE_INTEGER ? control.value / 2 * 2 : control.value;
        return 0;
      }
      case VIDIOC_ENUM_FRAMESIZES: {
        auto& size = *static_cast<v4l2_frmsizeenum*>(argument);
        if (size.index >= 2) return fail(EINVAL);
        size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
        size.discrete.width = size.index == 0 ? 640 : 1280;
        size.discrete.height = size.index == 0 ? 480 : 960;
        return 0;
      }
      case VIDIOC_ENUM_FRAMEINTERVALS: {
        auto& interval = *static_cast<v4l2_frmivalenum*>(argument);
        const auto known = rates.find(interval.pixel_format);
        const std::vector<std::uint32_t> listed = known == rates.end() ? std::vector{30U, 15U} : known->second;
        if (interval.index >= listed.size()) return fail(EINVAL);
        interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
        interval.discrete = {1, listed[interval.index]};
        return 0;
      }
      default:
        return fail(ENOTTY);
    }
  }

  std::size_t idle() const { return idle_.size(); }

 private:
  static int fail(int reason) {
    errno = reason;
    return -1;
  }
  std::uint32_t rate_of(std::uint32_t format) const {
    const auto known = rates.find(format);
    return known == rates.end() ? rate : known->second.front();
  }
  std::uint32_t stride() const {
    constexpr std::array of_two_bytes{V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_YVYU,    V4L2_PIX_FMT_UYVY,   V4L2_PIX_FMT_VYUY,
                                      V4L2_PIX_FMT_Y16,  V4L2_PIX_FMT_SGRBG10, V4L2_PIX_FMT_SBGGR12};
    const bool two = std::find(of_two_bytes.begin(), of_two_bytes.end(), pixelformat) != of_two_bytes.end();
    return (two ? 2 : 1) * width + padding;
  }
  /// Planes of colours after that of the grey, in halves of it.
  std::uint32_t halves_of_colours() const {
    if (pixelformat == V4L2_PIX_FMT_NV12 || pixelformat == V4L2_PIX_FMT_YUV420) return 1;
    return pixelformat == V4L2_PIX_FMT_NV16 || pixelformat == V4L2_PIX_FMT_YUV422P ? 2 : 0;
  }
  void describe(v4l2_format& format) const {
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.pixelformat = pixelformat;
    format.fmt.pix.bytesperline = stride();
    format.fmt.pix.field = field;
  }
  /// As a driver does: into the oldest free buffer, or nowhere when the program has them all.
  void fill(const Shot& shot) {
    if (idle_.empty()) return;
    v4l2_buffer buffer{};
    buffer.index = idle_.front();
    idle_.pop_front();
    std::vector<std::uint8_t>& bytes = memory_[buffer.index];
    std::fill(bytes.begin(), bytes.end(), shot.grey);
    std::copy(shot.coded.begin(), shot.coded.end(), bytes.begin());
    const std::size_t size = shot.coded.empty() ? bytes.size() : shot.coded.size();
    buffer.bytesused = static_cast<std::uint32_t>(size - std::min(size, shot.lost));
    buffer.flags = timestamp | shot.flags;
    buffer.timestamp.tv_sec = static_cast<time_t>(shot.at);
    buffer.timestamp.tv_usec = std::lround(1e6 * (shot.at - static_cast<double>(buffer.timestamp.tv_sec)));
    full_.push_back(buffer);
  }

  std::vector<std::vector<std::uint8_t>> memory_;
  std::deque<std::uint32_t> idle_;
  std::deque<v4l2_buffer> full_;
};

}  // namespace skein::vision
