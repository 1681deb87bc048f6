#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

#include <cstdarg>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "vision/frames/frame.h"

// What reading and writing films have in common.

namespace skein::vision::media {

struct CodecDeleter {
  void operator()(AVCodecContext* c) const { avcodec_free_context(&c); }
};
struct FrameDeleter {
  void operator()(AVFrame* f) const { av_frame_free(&f); }
};
struct PacketDeleter {
  void operator()(AVPacket* p) const { av_packet_free(&p); }
};
struct ScalerDeleter {
  void operator()(SwsContext* s) const { sws_freeContext(s); }
};
using Codec = std::unique_ptr<AVCodecContext, CodecDeleter>;
using Picture = std::unique_ptr<AVFrame, FrameDeleter>;
using Packet = std::unique_ptr<AVPacket, PacketDeleter>;
using Scaler = std::unique_ptr<SwsContext, ScalerDeleter>;

/// How a film asks players to show its pictures: "turn its pictures by 90 degrees"; empty: as they are.
std::string asked_turn(const AVStream& stream);

/// What is kept from picture to picture of a film.
struct Greys {
  Scaler scaler{};
  int bits = 0;  // of pixels with 16: those that the brightest one so far needs
};
/// A decoded picture as grey values; false: its pixel format cannot be converted.
bool to_grey(const AVFrame& picture, Greys& greys, Frame& frame);

/// FFmpeg's message for one of its error numbers.
std::string reason(int error);

/// What FFmpeg's log calls an error, of this thread, while this lives: it goes on behind most errors, and nothing but
/// its log tells of them. Nothing of its log is printed from the first one on.
class Errors {
 public:
  Errors();
  ~Errors();
  Errors(const Errors&) = delete;
  Errors& operator=(const Errors&) = delete;

  bool any() const { return count_ > 0; }
  /// The words of the last one, or none.
  const std::string& last() const { return last_; }

 private:
  static void hear(void* what, int level, const char* format, va_list values);

  int count_ = 0;
  std::string last_;
  Errors* outer_;
};

/// The note that marks a recorded film, and its value: the format of Stamp.
inline constexpr const char* film_note = "SKEIN_FILM";
inline constexpr const char* film_version = "1";

/// What a recorded frame carries in addition to its pixels, as Matroska's BlockAdditional: the container itself keeps
/// times to the millisecond only.
struct Stamp {
  std::int64_t index = 0;
  double captured_at = 0.0;    // [s]
  std::uint32_t checksum = 0;  // CRC-32 of all this and the pixels, as they are read back: a codec's own checksum, if
                               // any, covers only what the codec has encoded
  std::string note{};          // of the frame, not empty where there is one
};
Stamp stamp_of(const Frame& frame);
/// "index captured_at checksum", and a note behind them; numbers are the shortest that read back to the same bits.
std::string to_text(const Stamp& stamp);
std::optional<Stamp> parse_stamp(std::string_view text);

}  // namespace skein::vision::media
