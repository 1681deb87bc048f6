// A camera as the kernel presents it, made of memory: what the source asks of it, and what it makes of its answers.
#include "vision/v4l2_source.h"

#include <linux/videodev2.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <deque>

#include "tests/vision/support.h"

namespace skein::vision {
namespace {

class FakeCamera final : public V4l2Kernel {
 public:
  // What the camera can do
  std::vector<std::uint32_t> formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_GREY};
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::uint32_t width = 640;
  std::uint32_t height = 480;
  bool fixed_size = false;
  std::uint32_t padding = 0;  // bytes at the end of each row
  std::uint32_t timestamp = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  bool busy = false;

  // What it has to deliver at the next poll: frames, all at once. Empty: nothing comes any more.
  struct Shot {
    std::uint8_t grey = 0;
    double at = 0.0;
    std::uint32_t flags = 0;
    bool cut_short = false;
  };
  std::deque<std::vector<Shot>> coming;
  int interruptions = 0;  // calls that a signal interrupts first
  bool unplugged = false;

  // What became of it
  int opened = 0;
  int mapped = 0;
  bool streaming = false;
  int last_wait_ms = 0;
  std::uint32_t pixelformat = 0;

  int open(const char*) override {
    ++opened;
    return 7;
  }
  void close(int fd) override {
    EXPECT_EQ(fd, 7);
    --opened;
  }
  void* map(int, std::size_t length, std::uint32_t offset) override {
    ++mapped;
    memory_.resize(std::max<std::size_t>(memory_.size(), offset + 1));
    memory_[offset].resize(length);
    return memory_[offset].data();
  }
  void unmap(void*, std::size_t) override { --mapped; }

  int poll(pollfd* waiting, int milliseconds) override {
    last_wait_ms = milliseconds;
    if (interruptions-- > 0) return fail(EINTR);
    if (unplugged) {
      waiting->revents = POLLERR;
      return 1;
    }
    if (coming.empty()) return 0;
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
        static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe = {1, 10};
        return 0;
      case VIDIOC_REQBUFS:
        return busy ? fail(EBUSY) : 0;
      case VIDIOC_QUERYBUF: {
        auto* buffer = static_cast<v4l2_buffer*>(argument);
        buffer->length = stride() * height;
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
  std::uint32_t stride() const { return (pixelformat == V4L2_PIX_FMT_YUYV ? 2 : 1) * width + padding; }
  void describe(v4l2_format& format) const {
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.pixelformat = pixelformat;
    format.fmt.pix.bytesperline = stride();
  }
  /// As a driver does: into the oldest free buffer, or nowhere when the program has them all.
  void fill(const Shot& shot) {
    if (idle_.empty()) return;
    v4l2_buffer buffer{};
    buffer.index = idle_.front();
    idle_.pop_front();
    std::vector<std::uint8_t>& bytes = memory_[buffer.index];
    std::fill(bytes.begin(), bytes.end(), shot.grey);
    buffer.bytesused = static_cast<std::uint32_t>(shot.cut_short ? bytes.size() / 2 : bytes.size());
    buffer.flags = timestamp | shot.flags;
    buffer.timestamp.tv_sec = static_cast<time_t>(shot.at);
    buffer.timestamp.tv_usec =
        static_cast<suseconds_t>(1e6 * (shot.at - static_cast<double>(buffer.timestamp.tv_sec)) + 0.5);
    full_.push_back(buffer);
  }

  std::vector<std::vector<std::uint8_t>> memory_;
  std::deque<std::uint32_t> idle_;
  std::deque<v4l2_buffer> full_;
};

TEST(V4l2, GivesTheNewestFrameWithTheDriversTime) {
  FakeCamera fake;
  fake.coming = {{{10, 1.25}}, {{20, 2.0}, {30, 2.1}, {40, 2.25}}};
  {
    auto camera = open_v4l2("/dev/fake", {}, fake);
    ASSERT_TRUE(camera) << camera.error();
    EXPECT_EQ((*camera)->describe(), "camera /dev/fake (640x480 GREY, 10 frames/s)");
    EXPECT_FALSE((*camera)->stills());
    EXPECT_TRUE(fake.streaming);
    EXPECT_EQ(fake.idle(), 4U);
    Frame frame;
    ASSERT_TRUE((*camera)->read(frame).value());
    EXPECT_EQ(frame.width, 640);
    EXPECT_EQ(frame.height, 480);
    EXPECT_EQ(frame.row(479)[639], 10);
    EXPECT_DOUBLE_EQ(frame.captured_at, 1.25);
    ASSERT_TRUE((*camera)->read(frame).value());
    EXPECT_EQ(frame.row(0)[0], 40) << "older ones are passed over";
    EXPECT_DOUBLE_EQ(frame.captured_at, 2.25);
    EXPECT_EQ(frame.index, 1);
    EXPECT_EQ(fake.idle(), 4U) << "every buffer is given back";
  }
  EXPECT_FALSE(fake.streaming);
  EXPECT_EQ(fake.opened, 0);
  EXPECT_EQ(fake.mapped, 0);
}

TEST(V4l2, TakesGreyOutOfColours) {
  FakeCamera fake;
  fake.formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV};
  fake.padding = 64;
  fake.coming = {{{77, 1.0}}};
  auto camera = open_v4l2("/dev/fake", {.width = 320, .height = 240}, fake);
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ(fake.pixelformat, V4L2_PIX_FMT_YUYV);
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(frame.width, 320);
  EXPECT_EQ(frame.grey, std::vector<std::uint8_t>(320 * 240, 77));
}

TEST(V4l2, StampsFramesItselfWhenTheDriversClockIsAnother) {
  FakeCamera fake;
  fake.timestamp = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  fake.coming = {{{1, 5e8}}};
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  timespec before{};
  clock_gettime(CLOCK_MONOTONIC, &before);
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_NEAR(frame.captured_at, static_cast<double>(before.tv_sec), 10.0);
}

TEST(V4l2, PassesDamagedFramesOver) {
  FakeCamera fake;
  fake.coming = {{{1, 1.0, V4L2_BUF_FLAG_ERROR}}, {{2, 1.1, 0, true}}, {{3, 1.2}}};
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(frame.row(0)[0], 3);
  EXPECT_EQ(frame.index, 0);
  for (int i = 0; i < 100; ++i) fake.coming.push_back({{1, 2.0, V4L2_BUF_FLAG_ERROR}});
  const auto read = (*camera)->read(frame);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error(), "/dev/fake: sends only damaged frames");
}

TEST(V4l2, AStalledOrUnpluggedCameraIsAnError) {
  FakeCamera fake;
  fake.coming = {{{1, 1.0}}};
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  Frame frame;
  ASSERT_TRUE((*camera)->read(frame).value());
  EXPECT_EQ(fake.last_wait_ms, 5000) << "the first frame may take its time";
  auto read = (*camera)->read(frame);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error(), "/dev/fake: no frame for 0.5 s (unplugged, or the bus is full?)");
  EXPECT_EQ(fake.last_wait_ms, 500) << "five frame times";
  fake.unplugged = true;
  read = (*camera)->read(frame);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error(), "/dev/fake: stopped delivering frames (unplugged?)");
}

TEST(V4l2, SignalsDoNotDisturb) {
  FakeCamera fake;
  fake.interruptions = 3;
  auto camera = open_v4l2("/dev/fake", {}, fake);
  ASSERT_TRUE(camera) << camera.error();
  fake.interruptions = 3;
  fake.coming = {{{9, 1.0}}};
  Frame frame;
  EXPECT_TRUE((*camera)->read(frame).value());
}

TEST(V4l2, RefusesWhatDoesNotFit) {
  const auto error_of = [](FakeCamera& fake, const SourceOptions& options = {}) {
    const auto camera = open_v4l2("/dev/fake", options, fake);
    EXPECT_EQ(fake.opened + (camera ? 1 : 0), camera ? 2 : 0) << "closed again";
    return camera ? std::string() : camera.error();
  };
  FakeCamera metadata;
  metadata.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  EXPECT_EQ(error_of(metadata), "/dev/fake: does not capture video (a camera often has a second device that does)");
  FakeCamera h264;
  h264.formats = {V4L2_PIX_FMT_H264};
  EXPECT_EQ(error_of(h264), "/dev/fake: offers H264; needed: GREY, YUYV or MJPG");
  FakeCamera small;
  small.fixed_size = true;
  EXPECT_EQ(error_of(small, {.width = 1280, .height = 960}), "/dev/fake: cannot give 1280x960 in GREY, only 640x480");
  FakeCamera busy;
  busy.busy = true;
  EXPECT_EQ(error_of(busy), "/dev/fake: is in use by another program (Device or resource busy)");
}

}  // namespace
}  // namespace skein::vision
