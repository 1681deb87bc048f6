#include "vision/sources/open_source.h"

#include <array>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/vision/support.h"
#include "vision/frames/pixels.h"

namespace skein::vision {
namespace {

TEST(OpenSource, RefusesWhatItDoesNotKnow) {
  for (const char* source : {"", "images", "images:", "webcam:0", "/dev/video0", "synthetic"}) {
    const auto opened = open_source(source);
    ASSERT_FALSE(opened) << source;
    EXPECT_NE(opened.error().find("allowed: images:DIR, video:FILE, v4l2:DEVICE, aravis:CAMERA"), std::string::npos)
        << opened.error();
  }
}

TEST(OpenSource, NamesWhatIsMissingOrUnfit) {
  test::Folder folder;
  test::write_file(folder.file("text.mp4"), "no film");
  test::write_file(folder.file("empty.mp4"), "");
  test::write_file(folder.file("notes.txt"), "no picture");
  // An MP4 whose end was not written: its kind, and pictures of which nothing is known.
  test::write_file(folder.file("cut.mp4"), std::string("\0\0\0\x18"
                                                       "ftypisom\0\0\2\0isomiso2\0\0\x40\0mdat",
                                                       32) +
                                               std::string(4000, 'x'));
  const struct {
    std::string source;
    std::string message;
  } cases[] = {
      {"images:/nowhere", "/nowhere: no such file or folder"},
      {"images:" + folder.path(), folder.path() + ": no picture (png, jpg, pgm, ppm, bmp, tif, webp) in this folder"},
      {"video:/nowhere.mp4", "/nowhere.mp4: no such file"},
      {"images:/dev/zero", "/dev/zero: is a device or a FIFO, allowed: a file or a folder"},
      {"video:/dev/zero", "/dev/zero: is a device or a FIFO, allowed: a file"},
      {"video:" + folder.path(), folder.path() + ": no such file"},
      {"video:" + folder.file("text.mp4"),
       folder.file("text.mp4") + ": not a readable video: Invalid data found when processing input"},
      {"video:" + folder.file("empty.mp4"), folder.file("empty.mp4") + ": not a readable video: the file is empty"},
      {"video:" + folder.file("cut.mp4"),
       folder.file("cut.mp4") +
           ": not a readable video: its table of frames (moov), which is written last, is missing: the recording or "
           "its copy broke off. Copy it again; a program that repairs MP4 files needs a whole film of the same camera"},
      {"v4l2:/dev/no_such_camera", "/dev/no_such_camera: cannot be opened (No such file or directory)"},
      {"v4l2:/dev/null", "/dev/null: is not a V4L2 camera"},
  };
  for (const auto& [source, message] : cases) {
    const auto opened = open_source(source);
    ASSERT_FALSE(opened) << source;
    EXPECT_EQ(opened.error(), message);
  }
}

TEST(OpenSource, OnlyCamerasHaveSettings) {
  for (const char* film : {"images:/nowhere", "video:/nowhere.mp4"}) {
    EXPECT_EQ(camera_settings(film).error(),
              std::string(film) + " is not a camera; allowed: v4l2:DEVICE, aravis:CAMERA");
    EXPECT_FALSE(settable_while_read(film));
  }
  EXPECT_EQ(camera_settings("v4l2:/dev/no_such_camera").error(),
            "/dev/no_such_camera: cannot be opened (No such file or directory)");
  EXPECT_TRUE(settable_while_read("v4l2:/dev/no_such_camera"));
  EXPECT_FALSE(settable_while_read("aravis:no such camera"));
  EXPECT_FALSE(settable_while_read("webcam:0"));
}

TEST(Images, ComeByNameWithTheirPixels) {
  test::Folder folder;
  for (const int i : {2, 1, 3}) {
    Frame frame = test::uniform_frame(20 + i, 10, static_cast<std::uint8_t>(10 * i));
    frame.row(4)[7] = 255;
    test::write_pgm(folder.file("frame" + std::to_string(i) + ".pgm"), frame);
  }
  test::write_file(folder.file("README.txt"), "not a picture");
  auto source = open_source("images:" + folder.path());
  ASSERT_TRUE(source) << source.error();
  EXPECT_TRUE((*source)->stills());
  EXPECT_EQ((*source)->describe(), "images " + folder.path() + " (3 pictures)");
  Frame frame;
  for (int i = 1; i <= 3; ++i) {
    ASSERT_TRUE((*source)->read(frame).value());
    EXPECT_EQ(frame.source, "frame" + std::to_string(i) + ".pgm");
    EXPECT_EQ(frame.index, i - 1);
    EXPECT_DOUBLE_EQ(frame.captured_at, (i - 1) / 25.0);
    EXPECT_EQ(frame.width, 20 + i);
    EXPECT_EQ(frame.height, 10);
    EXPECT_EQ(frame.row(0)[0], 10 * i);
    EXPECT_EQ(frame.row(4)[7], 255);
  }
  EXPECT_FALSE((*source)->read(frame).value());
  EXPECT_FALSE((*source)->read(frame).value()) << "the end stays the end";
  EXPECT_TRUE((*source)->skipped().empty());
}

TEST(Images, DamagedOnesAreSkippedAndReported) {
  test::Folder folder;
  test::write_pgm(folder.file("a.pgm"), test::uniform_frame(16, 16, 1));
  test::write_file(folder.file("b.png"), "\x89PNG\r\n\x1a\n and then nothing of the kind");
  test::write_file(folder.file("c.jpg"), "\xff\xd8\xff\xe0 cut short");
  test::write_file(folder.file("d.pgm"), "");
  test::write_pgm(folder.file("e.pgm"), test::uniform_frame(16, 16, 2));
  auto source = open_source("images:" + folder.path());
  ASSERT_TRUE(source) << source.error();
  Frame frame;
  ASSERT_TRUE((*source)->read(frame).value());
  EXPECT_EQ(frame.source, "a.pgm");
  ASSERT_TRUE((*source)->read(frame).value());
  EXPECT_EQ(frame.source, "e.pgm");
  EXPECT_EQ(frame.index, 1);
  EXPECT_FALSE((*source)->read(frame).value());
  const auto skipped = (*source)->skipped();
  ASSERT_EQ(skipped.size(), 3U);
  EXPECT_EQ(skipped[0], folder.file("b.png") + ": cannot be decoded");
  EXPECT_EQ(skipped[1], folder.file("c.jpg") + ": is cut short");
  EXPECT_EQ(skipped[2], folder.file("d.pgm") + ": is empty");
  EXPECT_EQ((*source)->status().damaged, 3) << "a run says so";
}

/// They were turned, films were not: one folder's pictures of a board had two places for the lens's middle.
TEST(Images, AreReadAsTheSensorTookThemWhicheverWayUpTheCameraWasHeld) {
  test::Folder folder;
  cv::Mat picture(48, 64, CV_8U, cv::Scalar(200.0));
  picture(cv::Rect(0, 0, 16, 16)).setTo(20);
  std::vector<std::uint8_t> jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", picture, jpeg));
  for (const char orientation :
       {'\1', '\3', '\6', '\10'}) {  // upright, upside down, turned to the right and to the left
    std::string turned(jpeg.begin(), jpeg.begin() + 2);
    turned += std::string(
        "\xff\xe1\0\x22"
        "Exif\0\0II*\0\x8\0\0\0\x1\0\x12\x1\x3\0\x1\0\0\0",
        28);
    turned += orientation + std::string(7, '\0') + std::string(jpeg.begin() + 2, jpeg.end());
    const std::string file = folder.file(std::string(1, static_cast<char>('a' + orientation)) + ".jpg");
    test::write_file(file, turned);
    ASSERT_EQ(cv::imread(file).cols, orientation < 5 ? 64 : 48) << "viewers turn it";
  }
  auto source = open_source("images:" + folder.path());
  ASSERT_TRUE(source) << source.error();
  Frame frame;
  for (int k = 0; k < 4; ++k) {
    ASSERT_TRUE((*source)->read(frame).value());
    ASSERT_EQ(std::pair(frame.width, frame.height), std::pair(64, 48)) << frame.source;
    EXPECT_LT(frame.row(5)[5], 40) << frame.source;
    EXPECT_GT(frame.row(40)[60], 180) << frame.source;
  }
}

/// A sensor's 10 or 12 bits in files of 16, as other programs write them: they were read as if 16 were used, and almost
/// black. To FFmpeg a picture is a film of one frame.
TEST(Images, TheBitsThatAreUsedCount) {
  for (const int bits : {10, 12, 14, 16}) {
    test::Folder folder;
    std::string pixels;
    for (const int grey : {0, 10, 128, 255}) {
      const int value = grey << (bits - 8);
      pixels += {static_cast<char>(value >> 8), static_cast<char>(value & 255)};
    }
    test::write_file(folder.file("a.pgm"), "P5\n4 1\n65535\n" + pixels);
    for (const std::string& address : {"images:" + folder.path(), "video:" + folder.file("a.pgm")}) {
      const auto source = open_source(address);
      ASSERT_TRUE(source) << source.error();
      Frame frame;
      ASSERT_TRUE((*source)->read(frame).value()) << address;
      EXPECT_EQ(frame.grey, (Frame::Grey{0, 10, 128, 255})) << address << ", " << bits;
    }
  }
}

/// Appends `value` in as many bytes.
void put(std::string& bytes, bool little, std::size_t size, std::size_t value) {
  for (std::size_t k = 0; k < size; ++k) bytes += static_cast<char>(value >> (8 * (little ? k : size - 1 - k)) & 255);
}

struct Page {
  int orientation = 1;
  int kind = 0;         // 1: a preview
  bool planes = false;  // three colours of 16 bits, one behind the other
};
/// 6x4 pixels, the first two of each row black: without compression, with a table for each page.
std::string tiff_of(bool little, const std::vector<Page>& pages) {
  constexpr std::size_t width = 6, height = 4, entries = 12;
  std::string bytes = little ? "II" : "MM";
  put(bytes, little, 2, 42);
  put(bytes, little, 4, 8 + width * height);
  for (std::size_t v = 0; v < height; ++v) bytes += std::string("\0\0", 2) + std::string(width - 2, '\xc8');
  for (const Page& page : pages) {
    put(bytes, little, 2, entries);
    const auto entry = [&](std::size_t tag, int type, std::size_t value) {  // 3: SHORT, 4: LONG
      put(bytes, little, 2, tag);
      put(bytes, little, 2, static_cast<std::size_t>(type));
      put(bytes, little, 4, 1);
      put(bytes, little, type == 3 ? 2 : 4, value);
      if (type == 3) put(bytes, little, 2, 0);
    };
    entry(254, 4, static_cast<std::size_t>(page.kind));
    entry(256, 3, width);
    entry(257, 3, height);
    entry(258, 3, page.planes ? 16 : 8);
    entry(259, 3, 1);
    entry(262, 3, 1);
    entry(273, 4, 8);
    entry(274, 3, static_cast<std::size_t>(page.orientation));
    entry(277, 3, page.planes ? 3 : 1);
    entry(278, 3, height);
    entry(279, 4, width * height);
    entry(284, 3, page.planes ? 2 : 1);
    put(bytes, little, 4, &page == &pages.back() ? 0 : bytes.size() + 4);
  }
  return bytes;
}

/// OpenCV turns a TIFF even if it is told not to: pictures of one camera, as TIFF and as JPEG, were turned differently,
/// and upside down every pose was wrong in silence.
TEST(Images, ATiffIsReadAsTheSensorTookIt) {
  for (const bool little : {true, false})
    for (int orientation = 1; orientation <= 8; ++orientation) {
      test::Folder folder;
      test::write_file(folder.file("a.tif"), tiff_of(little, {{.orientation = orientation}}));
      ASSERT_EQ(cv::imread(folder.file("a.tif")).cols, orientation < 5 ? 6 : 4) << "viewers turn it";
      const auto source = open_source("images:" + folder.path());
      ASSERT_TRUE(source) << source.error();
      Frame frame;
      ASSERT_TRUE((*source)->read(frame).value());
      ASSERT_EQ(std::pair(frame.width, frame.height), std::pair(6, 4)) << orientation;
      EXPECT_EQ(frame.row(3)[1], 0) << orientation;
      EXPECT_EQ(frame.row(0)[2], 200) << orientation;
    }
}

std::string reason_for_leaving_out(const std::string& file) {
  const auto source = open_source("images:" + file);
  EXPECT_TRUE(source) << source.error();
  for (Frame frame; (*source)->read(frame).value();) {
  }
  const auto skipped = (*source)->skipped();
  return skipped.empty() ? "nothing" : skipped[0].substr(file.size() + 2);
}

/// Of all pages only the first was read, without a word; it may be a preview.
TEST(Images, ATiffOfWhichOnlyAPartWouldBeReadIsNamed) {
  test::Folder folder;
  const std::string file = folder.file("a.tif");
  test::write_file(file, tiff_of(true, {{}, {.kind = 1}}));
  EXPECT_EQ(reason_for_leaving_out(file), "nothing") << "the control: a preview behind the picture";
  test::write_file(file, tiff_of(true, {{}, {}, {}}));
  EXPECT_EQ(reason_for_leaving_out(file), "has 3 pages, allowed: one: save each as a file of its own");
  test::write_file(file, tiff_of(false, {{.kind = 1}, {}}));
  EXPECT_EQ(reason_for_leaving_out(file),
            "begins with a preview, which would be read in place of the picture: save it as PNG");
  test::write_file(file, tiff_of(true, {{.planes = true}}));  // OpenCV mixes them up
  EXPECT_EQ(
      reason_for_leaving_out(file),
      "has its colours of 16 bits in separate planes, which cannot be read: save it as PNG, or its colours together");
}

TEST(Images, WhatNoDecoderReadsIsNamed) {
  test::Folder folder;
  const std::string formats = "is of a format that cannot be read, allowed: png, jpg, pgm, ppm, bmp, tif, webp";
  test::write_file(folder.file("a.heic"),
                   std::string("\0\0\0\x18", 4) + "ftypheic" + std::string(4, '\0') + "mif1heic");
  EXPECT_EQ(reason_for_leaving_out(folder.file("a.heic")), formats);
  test::write_pgm(folder.file("b.pgm"), test::uniform_frame(4, 4, 1));
  const auto source = open_source("images:" + folder.path());
  ASSERT_TRUE(source) << source.error();
  for (Frame frame; (*source)->read(frame).value();) {
  }
  EXPECT_EQ((*source)->skipped().size(), 1U) << "it is not passed over beside others";
  // Levels from 0 to 1 were all black.
  test::write_file(folder.file("c.pfm"), "Pf\n2 1\n-1.0\n" + std::string("\0\0\0\0\0\0\x80\x3f", 8));
  EXPECT_EQ(reason_for_leaving_out(folder.file("c.pfm")),
            "has grey levels that are no whole numbers, allowed: 8 or 16 bits");
  const std::string heif = folder.file("a.heic");
  const auto film = open_source("video:" + heif);
  ASSERT_FALSE(film);
  EXPECT_EQ(film.error(),
            heif + ": is a picture (HEIF), not a film: convert it to PNG or JPEG, and give it as images:");
}

/// Cameras count without leading zeros, too.
TEST(Images, TheTenthComesBehindTheSecond) {
  test::Folder folder;
  for (const char* name : {"img10.pgm", "img2.pgm", "img1.pgm"})
    test::write_pgm(folder.file(name), test::uniform_frame(4, 4, 1));
  const auto source = open_source("images:" + folder.path());
  ASSERT_TRUE(source) << source.error();
  std::vector<std::string> names;
  for (Frame frame; (*source)->read(frame).value();) names.push_back(frame.source);
  EXPECT_EQ(names, (std::vector<std::string>{"img1.pgm", "img2.pgm", "img10.pgm"}));
}

/// A phone's picture has a film behind its end ("motion photo"), in which any bytes occur: it was called cut short.
TEST(Images, AFilmBehindAJpegIsNoDamage) {
  test::Folder folder;
  cv::Mat picture(48, 64, CV_8U, cv::Scalar(200.0));
  std::vector<std::uint8_t> jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", picture, jpeg));
  const std::string whole(jpeg.begin(), jpeg.end());
  const std::string file = folder.file("a.jpg");
  test::write_file(file, whole + std::string("\0\0\0\x18", 4) + "ftypmp42 \xff\xda film");
  EXPECT_EQ(reason_for_leaving_out(file), "nothing");
  // A preview in the header has an end marker of its own.
  const std::string preview = std::string("\xff\xe1", 2) + std::string("\0\x8", 2) + "\xff\xda..\xff\xd9";
  test::write_file(file, whole.substr(0, 2) + preview + whole.substr(2));
  EXPECT_EQ(reason_for_leaving_out(file), "nothing");
  test::write_file(file, whole.substr(0, 2) + preview + whole.substr(2, whole.size() - 10));
  EXPECT_EQ(reason_for_leaving_out(file), "is cut short") << "the control";
}

/// Planar: luma from `greys`, no colour. Raw, as FFmpeg's and GStreamer's y4menc write it.
std::string y4m_of(const std::string& parameters, const std::string& greys) {
  return "YUV4MPEG2 W4 H2 F25:1 " + parameters + " C444\nFRAME\n" + greys + std::string(2 * greys.size(), '\x80');
}

/// Black and white ended at 16 and 235 all the same: a bright picture was overexposed.
TEST(Films, TheirRangeOfGreyLevelsIsTheirOwn) {
  test::Folder folder;
  const std::string file = folder.file("a.y4m");
  const auto greys = [&](const std::string& range) {
    test::write_file(file, y4m_of(range, std::string("\x8\x10\x7d\xeb\xfc\x80\x80\x80", 8)));
    const auto source = open_source("video:" + file);
    EXPECT_TRUE(source) << source.error();
    Frame frame;
    EXPECT_TRUE((*source)->read(frame).value());
    return std::vector<int>(frame.grey.begin(), frame.grey.begin() + 5);
  };
  EXPECT_EQ(greys("XCOLORRANGE=LIMITED"), (std::vector{0, 0, 127, 255, 255})) << "the control";
  EXPECT_EQ(greys("XCOLORRANGE=FULL"), (std::vector{8, 16, 125, 235, 252}));
}

TEST(Films, PixelsThatAreNotSquareAreNamed) {
  test::Folder folder;
  const std::string file = folder.file("a.y4m");
  const auto remarks = [&](const std::string& shape) {
    test::write_file(file, y4m_of(shape, std::string(8, '\x80')));
    const auto source = open_source("video:" + file);
    EXPECT_TRUE(source) << source.error();
    return (*source)->status().remarks;
  };
  EXPECT_EQ(remarks("A1:1"), std::vector<std::string>()) << "the control";
  EXPECT_EQ(remarks("A0:0"), std::vector<std::string>()) << "not known";
  EXPECT_EQ(
      remarks("A4:3"),
      std::vector{file + ": asks players to stretch its pictures to 1.33 times their width; they are read as they "
                         "are stored: only a calibration from films of the same camera and mode holds for them"});
}

/// H.264 by x264: 64x48 px, of which its header crops 10 columns on the left and 6 on the right; the first 16 are
/// black. FFmpeg crops on the left only to where it can copy fast, unless told otherwise.
TEST(Films, AreCroppedAsTheyAsk) {
  constexpr std::string_view hex =
      "000000016764000aac7204447cc4f011000003000100000300320f122584600000000168e843810cb22c000001658881001d7ffef781bf32"
      "cb643faaad85268d00ec95c52650fc6c12b58d458ba10d";
  std::string bytes;
  for (std::size_t k = 0; k < hex.size(); k += 2)
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(k, 2)), nullptr, 16));
  test::Folder folder;
  const std::string file = folder.file("a.h264");
  test::write_file(file, bytes);
  const auto source = open_source("video:" + file);
  ASSERT_TRUE(source) << source.error();
  Frame frame;
  ASSERT_TRUE((*source)->read(frame).value());
  ASSERT_EQ(std::pair(frame.width, frame.height), std::pair(48, 48));
  EXPECT_LT(frame.row(20)[4], 30);
  EXPECT_GT(frame.row(20)[7], 220);
}

/// Such a file is left out like any other that is no picture; its bytes were read, and memory ended.
TEST(Images, OneThatIsFarTooLargeIsLeftOut) {
  test::Folder folder;
  test::write_file(folder.file("a.png"), "");
  std::filesystem::resize_file(folder.file("a.png"), std::uintmax_t{1} << 40);  // a hole, which takes no place
  test::write_file(folder.file("b.pgm"), "P5\n2 1\n255\nab");
  const auto source = open_source("images:" + folder.path());
  ASSERT_TRUE(source) << source.error();
  Frame frame;
  EXPECT_TRUE((*source)->read(frame).value());
  EXPECT_EQ(frame.source, "b.pgm");
  ASSERT_EQ((*source)->skipped().size(), 1U);
  EXPECT_EQ((*source)->skipped()[0], folder.file("a.png") + ": has more than 1 GB");
}

TEST(Images, MayBeOneFile) {
  test::Folder folder;
  test::write_pgm(folder.file("one.pgm"), test::uniform_frame(16, 16, 1));
  test::write_pgm(folder.file("two.pgm"), test::uniform_frame(16, 16, 1));
  auto source = open_source("images:" + folder.file("one.pgm"));
  ASSERT_TRUE(source) << source.error();
  Frame frame;
  ASSERT_TRUE((*source)->read(frame).value());
  EXPECT_EQ(frame.source, "one.pgm");
  EXPECT_FALSE((*source)->read(frame).value());
}

TEST(CameraPixels, AreTakenFromPaddedRows) {
  Frame frame = test::uniform_frame(2, 2, 0);
  const std::vector<std::uint8_t> grey = {1, 2, 99, 3, 4};  // the last row needs no padding
  ASSERT_TRUE(grey_from_grey(grey, 3, frame));
  EXPECT_EQ(frame.grey, (Frame::Grey{1, 2, 3, 4}));
  const std::vector<std::uint8_t> yuyv = {1, 128, 2, 128, 99, 99, 3, 128, 4, 128};
  ASSERT_TRUE(grey_from_yuyv(yuyv, 6, frame));
  EXPECT_EQ(frame.grey, (Frame::Grey{1, 2, 3, 4}));
  EXPECT_TRUE(grey_from_grey(std::vector<std::uint8_t>{5, 6, 7, 8}, 0, frame));
  EXPECT_EQ(frame.grey, (Frame::Grey{5, 6, 7, 8}));
  EXPECT_FALSE(grey_from_grey(std::vector<std::uint8_t>{5, 6, 7}, 0, frame)) << "a frame cut short on the bus";
  EXPECT_FALSE(grey_from_yuyv(std::vector<std::uint8_t>{5, 6, 7, 8}, 0, frame));
}

Frame blank(int width, int height) {
  Frame frame;
  frame.resize(width, height);
  return frame;
}

TEST(Pixels, GreyOutOfEveryFormat) {
  Frame frame = blank(2, 2);
  const std::vector<std::uint8_t> uyvy{128, 10, 128, 20, 0, 0, 128, 30, 128, 40, 0, 0};  // two bytes between rows
  ASSERT_TRUE(grey_from_uyvy(uyvy, 6, frame));
  EXPECT_EQ(frame.grey, (Frame::Grey{10, 20, 30, 40}));
  const std::vector<std::uint8_t> y10{0xff, 0x03, 0x00, 0x02, 0x04, 0x00, 0x00, 0x00};
  ASSERT_TRUE(grey_from_words<10>(y10, 0, frame));
  EXPECT_EQ(frame.grey, (Frame::Grey{255, 128, 1, 0}));
  const std::vector<std::uint8_t> y16{0xff, 0xff, 0x00, 0x80, 0xff, 0x00, 0x00, 0x01};
  ASSERT_TRUE(grey_from_words<16>(y16, 0, frame));
  EXPECT_EQ(frame.grey, (Frame::Grey{255, 128, 0, 1}));
  EXPECT_FALSE(grey_from_words<16>(std::span(y16).first(7), 0, frame)) << "a byte is missing";
  EXPECT_FALSE(grey_from_uyvy(std::span(uyvy).first(9), 6, frame));
}

TEST(Pixels, BayerIsTheSameGreyAtEveryColour) {
  // Red 40, green 80, blue 120, in each order of the four: 0.25 * 40 + 0.5 * 80 + 0.25 * 120.
  constexpr int width = 6;
  constexpr int height = 4;
  for (const auto& [even, odd] : std::vector<std::pair<std::array<int, 2>, std::array<int, 2>>>{
           {{40, 80}, {80, 120}}, {{80, 40}, {120, 80}}, {{80, 120}, {40, 80}}, {{120, 80}, {80, 40}}}) {
    std::vector<std::uint8_t> bytes;
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u)
        bytes.push_back(static_cast<std::uint8_t>((v % 2 == 0 ? even : odd)[static_cast<std::size_t>(u % 2)]));
    Frame frame = blank(width, height);
    ASSERT_TRUE(grey_from_bayer(bytes, 0, frame));
    EXPECT_EQ(frame.grey, Frame::Grey(width * height, 80));
  }
}

}  // namespace
}  // namespace skein::vision
