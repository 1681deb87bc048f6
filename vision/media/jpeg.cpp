#include "vision/media/jpeg.h"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>

#include <jpeglib.h>

#include <jerror.h>  // after jpeglib.h, whose version its numbers depend on

namespace skein::vision::media {
namespace {

struct Judge : jpeg_error_mgr {
  std::jmp_buf give_up;
  bool in_scan;  // what is unusual in headers does not matter
  JpegState state;
  JDIMENSION row;  // of blocks, at the last warning
};

[[noreturn]] void give_up(j_common_ptr decoder) {
  std::longjmp(static_cast<Judge*>(decoder->err)->give_up, 1);
}

/// The decoder warns, and goes on with what it takes for the next block.
void judge(j_common_ptr decoder, int level) {
  // Some cameras put 1 to 10 bytes of their own before each restart marker, others 8 to 12 before the end.
  constexpr std::size_t most_padding = 12;  // bytes
  auto& judge = static_cast<Judge&>(*decoder->err);
  if (level >= 0 || !judge.in_scan) return;
  // The decoder adds up those that it has already read when it meets a restart marker, until it has not at another one.
  const auto& picture = *reinterpret_cast<j_decompress_ptr>(decoder);
  std::size_t markers = 1;
  if (picture.restart_interval > 0)
    markers += std::size_t{picture.input_iMCU_row - judge.row} * picture.MCUs_per_row / picture.restart_interval;
  judge.row = picture.input_iMCU_row;
  const int bytes = judge.msg_parm.i[0], marker = judge.msg_parm.i[1];
  const bool of_a_camera = judge.msg_code == JWRN_EXTRANEOUS_DATA && bytes >= 0 &&
                           static_cast<std::size_t>(bytes) <= most_padding * markers &&
                           ((marker >= JPEG_RST0 && marker <= JPEG_RST0 + 7) || marker == JPEG_EOI);
  judge.state = std::max(judge.state, of_a_camera ? JpegState::padded : JpegState::damaged);
}

/// Where the first scan starts; the size if there is none. A header may hold a preview with scans of its own.
std::size_t first_scan(std::span<const std::uint8_t> bytes) {
  std::size_t at = 2;
  while (at + 4 <= bytes.size()) {
    const int marker = bytes[at] == 0xff ? bytes[at + 1] : 0;
    if (marker == 0xda) return at;
    const bool segment = marker >= 0xc0 && marker != 0xff && (marker < 0xd0 || marker > 0xd9);
    at += segment ? 2U + (bytes[at + 2] << 8 | bytes[at + 3]) : 1U;
  }
  return bytes.size();
}

}  // namespace

bool jpeg_breaks_off(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 4 || bytes[0] != 0xff || bytes[1] != 0xd8) return false;
  if (bytes[bytes.size() - 2] == 0xff && bytes.back() == 0xd9) return false;
  constexpr std::array<std::uint8_t, 2> end{0xff, 0xd9};
  const auto pixels = bytes.subspan(first_scan(bytes));
  return std::search(pixels.begin(), pixels.end(), end.begin(), end.end()) == pixels.end();
}

JpegState decode_jpeg(std::span<const std::uint8_t> bytes, Frame& frame) {
  if (jpeg_breaks_off(bytes)) return JpegState::damaged;
  jpeg_decompress_struct decoder{};
  Judge errors{};
  decoder.err = jpeg_std_error(&errors);
  errors.error_exit = give_up;
  errors.emit_message = judge;
  errors.state = JpegState::whole;
  if (setjmp(errors.give_up) == 0) {
    jpeg_create_decompress(&decoder);
    jpeg_mem_src(&decoder, bytes.data(), bytes.size());
    jpeg_read_header(&decoder, TRUE);
    errors.in_scan = true;
    // A block of 8x8 pixels takes two bits at least: a damaged header must not ask for all of the memory.
    constexpr std::size_t most_pixels = 256;  // a byte
    if (std::size_t{decoder.image_width} * decoder.image_height <= most_pixels * bytes.size()) {
      decoder.out_color_space = JCS_GRAYSCALE;
      jpeg_start_decompress(&decoder);
      frame.resize(static_cast<int>(decoder.output_width), static_cast<int>(decoder.output_height));
      while (decoder.output_scanline < decoder.output_height) {
        JSAMPROW row = frame.row(static_cast<int>(decoder.output_scanline));
        jpeg_read_scanlines(&decoder, &row, 1);
      }
      jpeg_finish_decompress(&decoder);
    } else {
      errors.state = JpegState::damaged;
    }
  } else {
    errors.state = JpegState::damaged;
  }
  jpeg_destroy_decompress(&decoder);
  return errors.state;
}

}  // namespace skein::vision::media
