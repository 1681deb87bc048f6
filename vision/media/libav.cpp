#include "vision/media/libav.h"

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/display.h>
#include <libavutil/intreadwrite.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

#include "vision/media/sources.h"

namespace skein::vision::media {

std::string reason(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

namespace {
thread_local Errors* listening = nullptr;
}  // namespace

Errors::Errors() : outer_(listening) {
  av_log_set_callback(&Errors::hear);
  listening = this;
}

Errors::~Errors() {
  listening = outer_;
}

void Errors::hear(void* what, int level, const char* format, va_list values) {
  if (level > AV_LOG_ERROR || listening == nullptr) return;
  std::array<char, 200> line{};
  int prefix = 0;  // without the name of what says it
  av_log_format_line2(what, level, format, values, line.data(), static_cast<int>(line.size()), &prefix);
  std::string_view words = line.data();
  while (words.ends_with('\n') || words.ends_with('.') || words.ends_with(' ')) words.remove_suffix(1);
  ++listening->count_;
  if (!words.empty()) listening->last_ = words;
}

std::string asked_turn(const AVStream& stream) {
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 15, 100)
  const AVPacketSideData* const data = av_packet_side_data_get(
      stream.codecpar->coded_side_data, stream.codecpar->nb_coded_side_data, AV_PKT_DATA_DISPLAYMATRIX);
  const std::uint8_t* const bytes = data == nullptr ? nullptr : data->data;
#else
  const std::uint8_t* const bytes = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
#endif
  if (bytes == nullptr) return {};
  std::array<std::int32_t, 9> matrix{};
  std::memcpy(matrix.data(), bytes, sizeof matrix);
  const double mirrored = static_cast<double>(matrix[0]) * matrix[4] - static_cast<double>(matrix[1]) * matrix[3];
  if (mirrored < 0.0) return "mirror its pictures";
  const double degrees = std::abs(av_display_rotation_get(matrix.data()));
  return degrees > 0.5 ? fmt::format("turn its pictures by {:.0f} degrees", degrees) : std::string();
}

namespace {

/// Grey levels of 16 bits, of which a sensor may fill fewer: what converts them takes all of them for used.
void words_to_grey(const AVFrame& picture, int& bits, Frame& frame) {
  const bool little = picture.format == AV_PIX_FMT_GRAY16LE;
  const auto for_each = [&](auto&& use) {
    for (int v = 0; v < frame.height; ++v) {
      const std::uint8_t* row = picture.data[0] + static_cast<std::ptrdiff_t>(v) * picture.linesize[0];
      for (int u = 0; u < frame.width; ++u, row += 2) use(v, u, little ? AV_RL16(row) : AV_RB16(row));
    }
  };
  int brightest = 0;
  for_each([&](int, int, int grey) { brightest = std::max(brightest, grey); });
  bits = std::max(bits, bits_used(brightest));
  for_each([&](int v, int u, int grey) { frame.row(v)[u] = static_cast<std::uint8_t>(grey >> (bits - 8)); });
}

}  // namespace

bool to_grey(const AVFrame& picture, Greys& greys, Frame& frame) {
  const int width = picture.width;
  const int height = picture.height;
  if (width <= 0 || height <= 0) return false;
  frame.resize(width, height);
  if (picture.format == AV_PIX_FMT_GRAY8) {
    for (int v = 0; v < height; ++v)
      std::copy_n(picture.data[0] + static_cast<std::ptrdiff_t>(v) * picture.linesize[0], width, frame.row(v));
    return true;
  }
  if (picture.format == AV_PIX_FMT_GRAY16LE || picture.format == AV_PIX_FMT_GRAY16BE) {
    words_to_grey(picture, greys.bits, frame);
    return true;
  }
  Scaler& scaler = greys.scaler;
  scaler.reset(sws_getCachedContext(scaler.release(), width, height, static_cast<AVPixelFormat>(picture.format), width,
                                    height, AV_PIX_FMT_GRAY8, SWS_POINT, nullptr, nullptr, nullptr));
  if (!scaler) return false;
  // Otherwise only formats that are always of full range (YUVJ) are taken for it, and the others' black and white end
  // at 16 and 235.
  const int* const colours = sws_getCoefficients(SWS_CS_DEFAULT);
  if (picture.color_range == AVCOL_RANGE_JPEG)
    sws_setColorspaceDetails(scaler.get(), colours, 1, colours, 1, 0, 1 << 16, 1 << 16);
  std::uint8_t* const rows[4] = {frame.grey.data(), nullptr, nullptr, nullptr};
  const int strides[4] = {width, 0, 0, 0};
  return sws_scale(scaler.get(), picture.data, picture.linesize, 0, height, rows, strides) == height;
}

Stamp stamp_of(const Frame& frame) {
  const AVCRC* table = av_crc_get_table(AV_CRC_32_IEEE);
  const auto add = [&](std::uint32_t sum, const auto& value) {
    return av_crc(table, sum, reinterpret_cast<const std::uint8_t*>(&value), sizeof value);
  };
  std::uint32_t sum = add(add(~0U, frame.index), frame.captured_at);
  sum = add(add(sum, frame.width), frame.height);
  sum = av_crc(table, sum, frame.grey.data(), frame.grey.size());
  sum = av_crc(table, sum, reinterpret_cast<const std::uint8_t*>(frame.note.data()), frame.note.size());
  return {frame.index, frame.captured_at, sum, frame.note};
}

std::string to_text(const Stamp& stamp) {
  return fmt::format("{} {} {}{}{}", stamp.index, stamp.captured_at, stamp.checksum, stamp.note.empty() ? "" : " ",
                     stamp.note);
}

std::optional<Stamp> parse_stamp(std::string_view text) {
  Stamp stamp;
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto number = [&](auto& value) {
    const auto [behind, error] = std::from_chars(at, end, value);
    at = behind;
    return error == std::errc{};
  };
  const auto space = [&] { return at != end && *at++ == ' '; };
  if (!number(stamp.index) || !space() || !number(stamp.captured_at) || !space() || !number(stamp.checksum)) return {};
  if (at != end) {
    if (!space() || at == end) return {};
    stamp.note.assign(at, end);
  }
  if (!std::isfinite(stamp.captured_at) || stamp.index < 0) return {};
  return stamp;
}

}  // namespace skein::vision::media
