// Frames of an MJPEG camera that were damaged on their way: a decoder goes on behind the damage, with everything
// elsewhere. What cameras put into whole frames is no damage.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <random>
#include <string_view>
#include <utility>

#include <jpeglib.h>

#include "tests/vision/support.h"
#include "tests/vision/v4l2/fake_camera.h"
#include "vision/modules/media_loader.h"
#include "vision/sources/open_source.h"
#include "vision/synthetic/synthetic_camera.h"
#include "vision/tracker/tracker.h"
#include "vision/v4l2/v4l2_source.h"

namespace skein::vision {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// As cameras code it: in colour, half as many of them along a row; `restarts`: a restart marker after each row of
/// blocks.
Bytes encode(const Frame& frame, bool restarts, int quality = 80) {
  jpeg_compress_struct coder{};
  jpeg_error_mgr errors{};
  coder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&coder);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&coder, &memory, &size);
  coder.image_width = static_cast<JDIMENSION>(frame.width);
  coder.image_height = static_cast<JDIMENSION>(frame.height);
  coder.input_components = 3;
  coder.in_color_space = JCS_RGB;
  jpeg_set_defaults(&coder);
  jpeg_set_quality(&coder, quality, TRUE);
  coder.comp_info[0].v_samp_factor = 1;
  coder.restart_in_rows = restarts ? 1 : 0;
  jpeg_start_compress(&coder, TRUE);
  Bytes colours(3 * static_cast<std::size_t>(frame.width));
  for (int v = 0; v < frame.height; ++v) {
    for (std::size_t u = 0; u < colours.size(); ++u) colours[u] = frame.row(v)[u / 3];
    JSAMPROW row = colours.data();
    jpeg_write_scanlines(&coder, &row, 1);
  }
  jpeg_finish_compress(&coder);
  Bytes bytes(memory, memory + size);
  jpeg_destroy_compress(&coder);
  std::free(memory);
  return bytes;
}

/// The control: a decoder that minds nothing but what it cannot decode at all. false: that.
bool decode_anything(const Bytes& bytes, Frame& frame) {
  struct Errors : jpeg_error_mgr {
    std::jmp_buf give_up;
  };
  jpeg_decompress_struct decoder{};
  Errors errors{};
  decoder.err = jpeg_std_error(&errors);
  errors.error_exit = [](j_common_ptr at) { std::longjmp(static_cast<Errors*>(at->err)->give_up, 1); };
  errors.emit_message = [](j_common_ptr, int) {};
  const bool decoded = setjmp(errors.give_up) == 0;
  if (decoded) {
    jpeg_create_decompress(&decoder);
    jpeg_mem_src(&decoder, bytes.data(), bytes.size());
    jpeg_read_header(&decoder, TRUE);
    decoder.out_color_space = JCS_GRAYSCALE;
    jpeg_start_decompress(&decoder);
    frame.resize(static_cast<int>(decoder.output_width), static_cast<int>(decoder.output_height));
    while (decoder.output_scanline < decoder.output_height) {
      JSAMPROW row = frame.row(static_cast<int>(decoder.output_scanline));
      jpeg_read_scanlines(&decoder, &row, 1);
    }
    jpeg_finish_decompress(&decoder);
  }
  jpeg_destroy_decompress(&decoder);
  return decoded;
}

JpegState decode(const Bytes& bytes, Frame& frame) {
  return media().value()->decode_jpeg(bytes.data(), bytes.size(), frame);
}

/// Where the coded blocks begin.
std::size_t scan_of(const Bytes& bytes) {
  for (std::size_t at = 0; at + 1 < bytes.size(); ++at)
    if (bytes[at] == 0xff && bytes[at + 1] == 0xda) return at + 2 + 256U * bytes[at + 2] + bytes[at + 3];
  ADD_FAILURE() << "no scan";
  return 0;
}

/// A camera's own bytes before its restart markers, or before its end.
Bytes padded(const Bytes& bytes, bool restarts, std::size_t count) {
  Bytes more(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(scan_of(bytes)));
  for (std::size_t at = more.size(); at < bytes.size(); ++at) {
    const bool marker = at + 1 < bytes.size() && bytes[at] == 0xff && bytes[at + 1] != 0;
    if (marker && (bytes[at + 1] == 0xd9) != restarts) more.insert(more.end(), count, 0x5a);
    more.push_back(bytes[at]);
  }
  return more;
}

Bytes without(const Bytes& bytes, std::size_t at, std::size_t count) {
  Bytes fewer = bytes;
  const auto from = fewer.begin() + static_cast<std::ptrdiff_t>(at);
  fewer.erase(from, from + static_cast<std::ptrdiff_t>(count));
  return fewer;
}

/// Twelve tags on a floor, seen by a camera with noise.
struct Floor {
  Floor() {
    calibration.tag_size = 0.08;
    for (int k = 0; k < 12; ++k)
      tags.push_back({.tag = k, .pose = {-0.75 + 0.5 * (k % 4), -0.5 + 0.5 * (k / 4), 0.4 * k}, .size = 0.08});
    SyntheticCamera(calibration, {}, 3).render(tags, 0.0, frame);
  }
  Calibration calibration = overhead_calibration(2.0, 1.5);
  std::vector<SyntheticTag> tags;
  Frame frame;
};

TEST(Mjpeg, WhatCamerasPutBeforeTheirMarkersIsNoDamage) {
  const Floor floor;
  Frame frame, again;
  for (const bool restarts : {true, false}) {
    const Bytes whole = encode(floor.frame, restarts);
    ASSERT_EQ(decode(whole, frame), JpegState::whole);
    // Logitech's C270 and C910 have 1 to 10 bytes before each restart marker, others 8 to 12 before the end.
    for (std::size_t count = 1; count <= 12; ++count) {
      // Up to seven bytes before the end are in the decoder's hand already, and it does not mind.
      const JpegState state = decode(padded(whole, restarts, count), again);
      EXPECT_EQ(state, restarts || count > 7 ? JpegState::padded : state) << count;
      EXPECT_NE(state, JpegState::damaged) << count;
      EXPECT_EQ(again.grey, frame.grey) << count;
    }
    EXPECT_EQ(decode(padded(whole, restarts, 40), again), JpegState::damaged);
    Bytes followed = whole;
    followed.insert(followed.end(), 100, 0);
    EXPECT_EQ(decode(followed, again), JpegState::whole) << "what a buffer has behind it";
  }
}

TEST(Mjpeg, CamerasThatLeaveTheirTablesOutAreDecoded) {
  const Floor floor;
  Bytes bytes = encode(floor.frame, false);
  Frame frame, again;
  ASSERT_EQ(decode(bytes, frame), JpegState::whole);
  for (std::size_t at = 0; at + 3 < scan_of(bytes);)
    if (bytes[at] == 0xff && bytes[at + 1] == 0xc4)
      bytes = without(bytes, at, 2U + 256U * bytes[at + 2] + bytes[at + 3]);
    else
      ++at;
  EXPECT_EQ(decode(bytes, again), JpegState::whole);
  EXPECT_EQ(again.grey, frame.grey);
}

TEST(Mjpeg, AFrameThatWasCutAndEndedIsDamaged) {
  const Floor floor;
  for (const bool restarts : {true, false}) {
    Bytes bytes = encode(floor.frame, restarts);
    bytes.resize(bytes.size() / 2);
    Frame frame;
    EXPECT_EQ(decode(bytes, frame), JpegState::damaged);
    bytes.insert(bytes.end(), {0xff, 0xd9});
    EXPECT_EQ(decode(bytes, frame), JpegState::damaged) << "the rest of it would be grey";
    EXPECT_TRUE(decode_anything(bytes, frame)) << "the control";
  }
}

/// FFmpeg shows such a frame without a word, with tags that stand centimetres elsewhere.
TEST(Mjpeg, ADamagedFrameOfAFilmIsLeftOutAndSaid) {
  SyntheticCamera camera(overhead_calibration(2.0, 1.5), {}, 3);
  Frame frame;
  Bytes film;
  int noticed = 0;
  for (int k = 0; k < 5; ++k) {
    camera.render(std::vector{SyntheticTag{k, {0.1 * k, 0.0, 0.0}, 0.06}}, 0.04 * k, frame);
    Bytes bytes = encode(frame, false);
    if (k == 2) {
      const Bytes whole = bytes;
      for (std::size_t at = bytes.size() / 3; decode(bytes, frame) != JpegState::damaged; ++at) {
        bytes = whole;
        bytes[at] ^= 0x10;
      }
      ++noticed;
    }
    film.insert(film.end(), bytes.begin(), bytes.end());
  }
  ASSERT_EQ(noticed, 1);
  test::Folder folder;
  const std::string path = folder.file("film.mjpeg");
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(film.data()), static_cast<std::streamsize>(film.size()));
  const auto source = open_source("video:" + path);
  ASSERT_TRUE(source) << source.error();
  std::vector<std::int64_t> frames;
  while ((*source)->read(frame).value()) frames.push_back(frame.index);
  EXPECT_EQ(frames, (std::vector<std::int64_t>{0, 1, 3, 4}));
  ASSERT_EQ((*source)->skipped().size(), 1U);
  EXPECT_TRUE((*source)->skipped()[0].ends_with("is damaged")) << (*source)->skipped()[0];
}

TEST(Mjpeg, FramesOfAnotherSizeThanTheFilmAreLeftOutAndSaid) {
  test::Folder folder;
  const std::string path = folder.file("film.mjpeg");
  Bytes film;
  for (int k = 0; k < 6; ++k) {
    const Bytes bytes =
        encode(k == 3 || k == 4 ? test::uniform_frame(64, 48, 90) : test::uniform_frame(128, 96, 90), false);
    film.insert(film.end(), bytes.begin(), bytes.end());
  }
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(film.data()), static_cast<std::streamsize>(film.size()));
  const auto source = open_source("video:" + path);
  ASSERT_TRUE(source) << source.error();
  std::vector<std::int64_t> frames;
  for (Frame frame; (*source)->read(frame).value();) {
    frames.push_back(frame.index);
    EXPECT_EQ(frame.width, 128);
  }
  EXPECT_EQ(frames, (std::vector<std::int64_t>{0, 1, 2, 5}));
  ASSERT_EQ((*source)->skipped().size(), 1U);
  EXPECT_EQ((*source)->skipped()[0], path + ": frames 3 to 4: each is 64x48 px, and the film 128x96");
}

std::string number(std::uint32_t value, int bytes = 4) {
  std::string text;
  for (int k = 0; k < bytes; ++k) text += static_cast<char>(value >> (8 * k));
  return text;
}
std::string chunk(const std::string& name, const std::string& content) {
  return name + number(static_cast<std::uint32_t>(content.size())) + content + std::string(content.size() % 2, '\0');
}

/// An AVI of 25 frames/s, as other programs write it.
std::string avi_of(const std::vector<Bytes>& pictures, std::uint32_t width, std::uint32_t height) {
  const auto frames = static_cast<std::uint32_t>(pictures.size());
  const std::string film = number(40000) + number(0) + number(0) + number(0) + number(frames) + number(0) + number(1) +
                           number(0) + number(width) + number(height) + std::string(16, '\0');
  const std::string stream = "vidsMJPG" + number(0) + number(0) + number(0) + number(1) + number(25) + number(0) +
                             number(frames) + number(0) + number(0xffffffff) + number(0) + std::string(8, '\0');
  const std::string format = number(40) + number(width) + number(height) + number(1, 2) + number(24, 2) + "MJPG" +
                             number(3 * width * height) + std::string(16, '\0');
  std::string movie = "movi";
  for (const Bytes& picture : pictures) movie += chunk("00dc", std::string(picture.begin(), picture.end()));
  return chunk("RIFF", "AVI " +
                           chunk("LIST", "hdrl" + chunk("avih", film) +
                                             chunk("LIST", "strl" + chunk("strh", stream) + chunk("strf", format))) +
                           chunk("LIST", movie));
}

/// FFmpeg takes an AVI for as long as what there is of it, whatever its header states.
TEST(Mjpeg, AnAviWhoseRestIsMissingSaysSo) {
  SyntheticCamera camera(overhead_calibration(2.0, 1.5), {}, 3);
  Frame frame;
  std::vector<Bytes> pictures;
  for (int k = 0; k < 20; ++k) {
    camera.render(std::vector{SyntheticTag{k, {0.0, 0.0, 0.0}, 0.06}}, 0.04 * k, frame);
    pictures.push_back(encode(frame, false));
  }
  const std::string avi =
      avi_of(pictures, static_cast<std::uint32_t>(frame.width), static_cast<std::uint32_t>(frame.height));
  test::Folder folder;
  const std::string path = folder.file("film.avi");
  for (const bool whole : {true, false}) {
    test::write_file(path, whole ? avi : avi.substr(0, avi.size() / 2));
    const auto source = open_source("video:" + path);
    ASSERT_TRUE(source) << source.error();
    std::int64_t frames = 0;
    while ((*source)->read(frame).value()) ++frames;
    EXPECT_EQ(frames == 20, whole) << frames;
    const auto said = (*source)->skipped();
    EXPECT_EQ(said.empty(), whole);
    if (whole) continue;
    EXPECT_NE(said.back().find("is missing: its header states 0.80 s"), std::string::npos) << said.back();
  }
}

/// An element of Matroska: its number, its length in four bytes, its content.
std::string element(const std::string& id, const std::string& content) {
  std::string size = number(0x10000000 + static_cast<std::uint32_t>(content.size()));
  std::reverse(size.begin(), size.end());
  return id + size + content;
}

/// A film in Matroska whose frames have these times. [ms]
std::string matroska_of(const Bytes& picture, const std::vector<std::uint16_t>& times, int width, int height,
                        const std::string& codec = "V_MJPEG", const std::string& fields = {}) {
  const auto two = [](int value) { return std::string{static_cast<char>(value >> 8), static_cast<char>(value)}; };
  const std::string video = element("\xb0", two(width)) + element("\xba", two(height)) + fields;
  const std::string track = element("\xd7", "\1") + element("\x73\xc5", "\1") + element("\x83", "\1") +
                            element("\x86", codec) + element("\xe0", video);
  std::string film = element("\x16\x54\xae\x6b", element("\xae", track));
  for (const std::uint16_t time : times)
    film += element("\x1f\x43\xb6\x75",
                    element("\xe7", two(time)) +
                        element("\xa3", std::string("\x81\0\0\x80", 4) + std::string(picture.begin(), picture.end())));
  return element("\x1a\x45\xdf\xa3", element("\x42\x82", "matroska")) + element("\x18\x53\x80\x67", film);
}

std::string four(std::int64_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
  return bytes;
}

/// A film in MP4 of one picture, which its header asks players to turn or mirror: {a, b; c, d} of its matrix. `fields`:
/// in a frame.
std::string mp4_of(const Bytes& picture, int width, int height, const std::array<int, 4>& matrix, char fields = 1) {
  const auto box = [](const char* name, const std::string& content) {
    return four(static_cast<std::int64_t>(content.size()) + 8) + name + content;
  };
  const std::string none = four(0), one = four(1), size = four(width << 16) + four(height << 16);
  const auto turned = [](const std::array<int, 4>& m) {
    const auto fixed = [](int value) { return four(value * 65536LL); };
    return fixed(m[0]) + fixed(m[1]) + four(0) + fixed(m[2]) + fixed(m[3]) + four(0) + four(0) + four(0) +
           four(0x40000000);
  };
  const std::string header = box("mvhd", none + none + none + four(25) + one + four(0x10000) + std::string(12, '\0') +
                                             turned({1, 0, 0, 1}) + std::string(24, '\0') + four(2));
  const std::string track =
      box("tkhd", four(7) + none + none + one + none + one + std::string(16, '\0') + turned(matrix) + size);
  const std::string format =
      box("jpeg", std::string(6, '\0') + std::string("\0\1", 2) + std::string(16, '\0') + size.substr(0, 2) +
                      size.substr(4, 2) + four(0x480000) + four(0x480000) + none + std::string("\0\1", 2) +
                      std::string(32, '\0') + std::string("\0\x18\xff\xff", 4) + box("fiel", {fields, fields == 2}));
  const std::string data = box("mdat", std::string(picture.begin(), picture.end()));
  const std::string table = box("stsd", none + one + format) + box("stts", none + one + one + one) +
                            box("stsc", none + one + one + one + one) +
                            box("stsz", none + four(static_cast<std::int64_t>(picture.size())) + one);
  const std::string media = box("mdhd", none + none + none + four(25) + one + none) +
                            box("hdlr", none + none + "vide" + std::string(13, '\0'));
  const std::string begin = box("ftyp", "isom" + none);
  const std::string tables = box("stbl", table + box("stco", none + one + four(begin.size() + 8)));
  return begin + data + box("moov", header + box("trak", track + box("mdia", media + box("minf", tables))));
}

/// A phone's film was read as its sensor took it, and nothing said that players show it otherwise.
TEST(Mjpeg, AFilmThatPlayersAreToTurnSaysSo) {
  const Floor floor;
  const Bytes picture = encode(floor.frame, false);
  test::Folder folder;
  const std::string path = folder.file("film.mp4");
  const auto remarks = [&](const std::array<int, 4>& matrix) {
    test::write_file(path, mp4_of(picture, floor.frame.width, floor.frame.height, matrix));
    const auto source = open_source("video:" + path);
    EXPECT_TRUE(source) << source.error();
    Frame frame;
    EXPECT_TRUE((*source)->read(frame).value());
    EXPECT_EQ(frame.width, floor.frame.width) << "as the sensor took it";
    return (*source)->status().remarks;
  };
  EXPECT_EQ(remarks({1, 0, 0, 1}), std::vector<std::string>()) << "the control";
  const std::string asks = path + ": asks players to ";
  const std::string read = "; they are read as the sensor took them, for which a calibration holds";
  EXPECT_EQ(remarks({0, 1, -1, 0}), std::vector{asks + "turn its pictures by 90 degrees" + read});
  EXPECT_EQ(remarks({-1, 0, 0, -1}), std::vector{asks + "turn its pictures by 180 degrees" + read});
  EXPECT_EQ(remarks({-1, 0, 0, 1}), std::vector{asks + "mirror its pictures" + read});
}

/// Its fields were read as one picture, and nothing said that they were not taken at once.
TEST(Mjpeg, AnInterlacedFilmSaysSo) {
  const Floor floor;
  test::Folder folder;
  const std::string path = folder.file("film.mp4");
  test::write_file(
      path, mp4_of(encode(floor.frame, false), floor.frame.width, floor.frame.height, {1, 0, 0, 1}, /*fields=*/2));
  const auto source = open_source("video:" + path);
  ASSERT_TRUE(source) << source.error();
  ASSERT_EQ((*source)->status().remarks.size(), 1U);
  EXPECT_TRUE((*source)->status().remarks[0].starts_with(path + ": its frames are interlaced"));
}

/// The file calls its frames whole ones, as ffmpeg does if it is not told, or says nothing, as with DV: only the
/// decoder sees that they are not.
TEST(Mjpeg, AFilmWhoseDecoderFindsFieldsSaysSo) {
  constexpr std::string_view mpeg2 =  // 64x48 px, by ffmpeg -flags +ildct+ilme
      "000001b304003023ffffe018000001b5148200010000000001b80008004000000100000ffff8000001b58ffff30000000001012b2d29488b"
      "4"
      "a52911694a5222d294a4440000001022b2d29488b4a52911694a5222d294a4440000001032b2d29488b4a52911694a5222d294a444000000"
      "1042b2d29488b4a52911694a5222d294a4440";
  Bytes picture;
  for (std::size_t k = 0; k < mpeg2.size(); k += 2)
    picture.push_back(static_cast<std::uint8_t>(std::stoi(std::string(mpeg2.substr(k, 2)), nullptr, 16)));
  test::Folder folder;
  const std::string path = folder.file("film.mkv");
  test::write_file(path, matroska_of(picture, {0}, 64, 48, "V_MPEG2", element("\x9a", "\2")));
  const auto source = open_source("video:" + path);
  ASSERT_TRUE(source) << source.error();
  EXPECT_EQ((*source)->status().remarks, std::vector<std::string>()) << "the control: by the file they are whole";
  Frame frame;
  ASSERT_TRUE((*source)->read(frame).value());
  ASSERT_EQ((*source)->status().remarks.size(), 1U);
  EXPECT_TRUE((*source)->status().remarks[0].starts_with(path + ": its frames are interlaced"));
}

/// Their frames were given other times in silence, and `skein camera doctor` called those regular.
TEST(Mjpeg, AFilmWhoseTimesAreSetBackSaysSo) {
  const Floor floor;
  const Bytes picture = encode(floor.frame, false);
  test::Folder folder;
  const std::string path = folder.file("film.mkv");
  const auto times_and_notices = [&](const std::vector<std::uint16_t>& times) {
    test::write_file(path, matroska_of(picture, times, floor.frame.width, floor.frame.height));
    const auto source = open_source("video:" + path);
    EXPECT_TRUE(source) << source.error();
    std::vector<double> read;
    for (Frame frame; (*source)->read(frame).value();) read.push_back(frame.captured_at);
    EXPECT_EQ(read.size(), times.size());
    EXPECT_EQ(std::adjacent_find(read.begin(), read.end(), std::greater_equal<>()), read.end()) << "each is later";
    return std::pair{read, (*source)->status().notices};
  };
  const auto [even, none] = times_and_notices({0, 40, 80, 120, 160, 200});
  EXPECT_NEAR(even[5], 0.2, 1e-9);
  EXPECT_EQ(none, std::vector<std::string>()) << "the control";
  EXPECT_EQ(times_and_notices({0, 40, 80, 2120, 2160, 2200}).second, std::vector<std::string>()) << "a gap";
  const auto [back, said] = times_and_notices({2000, 2040, 2080, 120, 160, 200});
  ASSERT_EQ(said.size(), 1U);
  EXPECT_TRUE(said[0].starts_with(path + ": 1 frame is not later than the frame before, by the film's own times"))
      << said[0];
  const auto [still, also] = times_and_notices({0, 40, 40, 40, 80, 120});
  ASSERT_EQ(also.size(), 1U);
  EXPECT_TRUE(also[0].starts_with(path + ": 2 frames are not later")) << also[0];
}

TEST(Mjpeg, AHeaderThatAsksForAllOfTheMemoryIsDamaged) {
  const Floor floor;
  Bytes bytes = encode(floor.frame, false);
  for (std::size_t at = 0; at + 8 < scan_of(bytes); ++at)
    if (bytes[at] == 0xff && bytes[at + 1] == 0xc0) bytes[at + 5] = bytes[at + 7] = 0xff;  // height and width
  Frame frame;
  EXPECT_EQ(decode(bytes, frame), JpegState::damaged);
  EXPECT_EQ(frame.grey.capacity(), 0U);
}

/// What a tracker makes of a damaged frame: how far its tags are from where they are, at most. [m]
class Damage {
 public:
  Damage(bool restarts, bool pads) : coded_(encode(floor_.frame, restarts)) {
    if (pads) coded_ = padded(coded_, restarts, restarts ? 3 : 10);
    EXPECT_EQ(decode(coded_, frame_), pads ? JpegState::padded : JpegState::whole);
    EXPECT_TRUE(decode_anything(coded_, whole_));
    while (tracker_.counters().frames < 60) track();
    EXPECT_EQ(track(), 12U);
    EXPECT_LT(worst_, 0.5e-3);
  }
  const Bytes& coded() const { return coded_; }

  void take(const Bytes& bytes) {
    ++frames;
    const JpegState state = decode(bytes, judged_);
    noticed += state == JpegState::damaged ? 1 : 0;
    padded_like += state == JpegState::padded ? 1 : 0;
    if (!decode_anything(bytes, frame_) || frame_.width != floor_.frame.width) return;
    track();
    const bool wrong = worst_ > 1e-3;
    wrong_before += wrong ? 1 : 0;
    worst_before = std::max(worst_before, worst_);
    if (state == JpegState::whole) {
      wrong_whole += wrong ? 1 : 0;
      worst_whole = std::max(worst_whole, worst_);
    }
    if (state != JpegState::damaged) {
      wrong_kept += wrong ? 1 : 0;
      worst_kept = std::max(worst_kept, worst_);
    }
    frame_ = whole_;
    for (int k = 0; k < 2; ++k) track();
  }
  int frames = 0, noticed = 0, padded_like = 0, wrong_before = 0, wrong_whole = 0, wrong_kept = 0;
  double worst_before = 0.0, worst_whole = 0.0, worst_kept = 0.0;  // [m]

 private:
  std::size_t track() {
    frame_.captured_at = 0.04 * static_cast<double>(tracker_.counters().frames);
    const auto& seen = tracker_.process(frame_);
    worst_ = 0.0;
    for (const TagPose& tag : seen)
      worst_ = std::max(worst_, core::distance(tag.pose, floor_.tags[static_cast<std::size_t>(tag.tag)].pose));
    return seen.size();
  }
  Floor floor_;
  Bytes coded_;
  Frame frame_, judged_, whole_;
  TagTracker tracker_{floor_.calibration, {.tags = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}}};
  double worst_ = 0.0;
};

TEST(Mjpeg, TagsThatStandElsewhereBelowADamageAreLeftOut) {
  const int frames = test::sanitized ? 10 : 200;
  for (const bool restarts : {false, true})
    for (const bool lost : {false, true}) {
      Damage damage(restarts, false);
      const Bytes& whole = damage.coded();
      const std::size_t scan = scan_of(whole);
      std::mt19937 random(4);
      for (int k = 0; k < frames; ++k) {
        const std::size_t at = scan + random() % (whole.size() - scan - 3100);
        Bytes bytes = lost ? without(whole, at, 1 + random() % 3000) : whole;
        if (!lost) bytes[at] ^= static_cast<std::uint8_t>(1U << random() % 8);
        damage.take(bytes);
      }
      if (!test::sanitized) {
        EXPECT_GT(damage.noticed, lost ? 195 : 20);
      }
      EXPECT_EQ(damage.wrong_whole, 0) << "with any other tag elsewhere";
      EXPECT_LE(damage.wrong_kept, lost || restarts ? 0 : 2) << "where a camera pads its frames";
      fmt::print(
          "{}, {} restart markers: {} of {} frames show a tag more than 1 mm elsewhere, by up to {:.1f} mm.\n"
          "  {} frames are left out as damaged, {} have as few bytes left over as some cameras put there.\n"
          "  Of the others {} show a tag elsewhere, by up to {:.1f} mm; if the camera pads its frames {}, by up to "
          "{:.1f} mm\n",
          lost ? "up to 3000 bytes lost" : "a bit flipped", restarts ? "with" : "without", damage.wrong_before,
          damage.frames, 1e3 * damage.worst_before, damage.noticed, damage.padded_like, damage.wrong_whole,
          1e3 * damage.worst_whole, damage.wrong_kept, 1e3 * damage.worst_kept);
    }
}

/// A camera whose frames are these, one after the other, as its driver hands them over.
struct MjpegCamera {
  explicit MjpegCamera(const std::vector<Bytes>& frames) {
    fake.formats = {V4L2_PIX_FMT_MJPEG};
    double t = 1.0;
    for (const Bytes& frame : frames) fake.coming.push_back({{.at = t += 0.04, .coded = frame}});
    auto opened = open_v4l2("/dev/fake", {}, fake);
    EXPECT_TRUE(opened) << opened.error();
    source = std::move(*opened);
  }
  /// Of the frames that it gives until nothing comes any more.
  int read() {
    Frame frame;
    int whole = 0;
    while (!fake.coming.empty() && source->read(frame).value_or(false)) ++whole;
    return whole;
  }
  std::vector<std::string> starving() const {
    std::vector<std::string> said = source->status().notices;
    std::erase_if(said, [](const std::string& notice) { return notice.find("damaged") == std::string::npos; });
    return said;
  }
  FakeCamera fake;
  std::unique_ptr<FrameSource> source;
};

struct MjpegSource : ::testing::Test {
  MjpegSource() {
    std::mt19937 random(1);
    Frame frame;
    frame.resize(640, 480);
    for (int v = 0; v < frame.height; ++v)
      for (int u = 0; u < frame.width; ++u)
        frame.row(v)[u] = static_cast<std::uint8_t>(40 + 150 * ((u / 40 + v / 30) % 2) + random() % 9);
    whole = encode(frame, true);
    pads = padded(whole, true, 5);
    damaged = without(whole, whole.size() / 2, 700);
  }
  Bytes whole, pads, damaged;
};

TEST_F(MjpegSource, OfACameraThatPadsItsFramesGivesAllOfThem) {
  MjpegCamera camera(std::vector<Bytes>(100, pads));
  EXPECT_EQ(camera.read(), 100);
  EXPECT_EQ(camera.source->status().damaged, 0);
}

TEST_F(MjpegSource, OfACameraThatDoesNotTakesThemForDamage) {
  std::vector<Bytes> frames(100, whole);
  for (const std::size_t k : {30U, 50U, 80U, 81U}) frames[k] = pads;
  MjpegCamera camera(frames);
  EXPECT_EQ(camera.read(), 96);
  EXPECT_EQ(camera.source->status().damaged, 4);
  EXPECT_TRUE(camera.starving().empty());
}

TEST_F(MjpegSource, TellsOnceThatMostFramesAreDamaged) {
  std::vector<Bytes> frames;
  for (int k = 0; k < 300; ++k) frames.push_back(k % 5 == 4 ? whole : damaged);
  MjpegCamera bad(frames);
  EXPECT_EQ(bad.read(), 60);
  ASSERT_EQ(bad.starving().size(), 1U);
  EXPECT_EQ(bad.starving()[0],
            "/dev/fake: most of its frames arrive damaged and are left out; use another cable, a port of its own "
            "without a hub, a smaller size, a lower rate or another format (skein track --format)");
  for (int k = 0; k < 300; ++k) frames[static_cast<std::size_t>(k)] = k % 5 == 0 ? damaged : whole;
  MjpegCamera good(frames);
  EXPECT_EQ(good.read(), 240);
  EXPECT_TRUE(good.starving().empty()) << "the control";
}

}  // namespace
}  // namespace skein::vision
