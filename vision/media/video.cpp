#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "vision/media/jpeg.h"
#include "vision/media/libav.h"
#include "vision/media/sources.h"

namespace skein::vision::media {
namespace {

constexpr std::int64_t most_pixels = 100'000'000;  // of a frame: more is a damaged file
constexpr std::size_t most_complaints = 1000;
constexpr std::int64_t most_held_back = 64;  // pictures, by a decoder

std::string first_bytes(const std::string& path) {
  std::array<char, 12> first{};
  std::ifstream(path, std::ios::binary).read(first.data(), first.size());
  return {first.data(), first.size()};
}

/// A picture in the container of MP4: FFmpeg reads none of it, or one of its tiles.
bool is_heif(const std::string& path) {
  const std::string first = first_bytes(path);
  const std::string kind = first.substr(4);
  return kind == "ftypheic" || kind == "ftypheix" || kind == "ftypmif1";
}

class Video final : public FrameSource {
 public:
  explicit Video(std::string path) : path_(std::move(path)) {}
  ~Video() override { avformat_close_input(&file_); }
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  /// Empty, or why the film cannot be read.
  std::string open() {
    const Errors errors;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "protocol_whitelist", "file", 0);  // a play list must not make us fetch anything
    int result = avformat_open_input(&file_, ("file:" + path_).c_str(), nullptr, &options);
    av_dict_free(&options);
    if (result >= 0) result = avformat_find_stream_info(file_, nullptr);
    if (result < 0) return not_readable(errors, result);
    const AVCodec* coder = nullptr;
    const int best = av_find_best_stream(file_, AVMEDIA_TYPE_VIDEO, -1, -1, &coder, 0);
    if (best == AVERROR_DECODER_NOT_FOUND)
      return fmt::format("{}: not a readable video: this system's FFmpeg has no decoder for it", path_);
    if (best < 0)
      return fmt::format("{}: not a readable video: there are no pictures in it{}", path_,
                         errors.any() ? fmt::format(" ({})", errors.last()) : "");
    stream_ = file_->streams[best];
    codec_.reset(avcodec_alloc_context3(coder));
    picture_.reset(av_frame_alloc());
    packet_.reset(av_packet_alloc());
    if (!codec_ || !picture_ || !packet_) return not_readable(errors, AVERROR(ENOMEM));
    result = avcodec_parameters_to_context(codec_.get(), stream_->codecpar);
    codec_->thread_count = 1;  // the same answer every time, and errors are told on this thread
    codec_->max_pixels = most_pixels;
    codec_->flags |= AV_CODEC_FLAG_UNALIGNED;  // else columns that the film crops on the left stay
    codec_->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER;
#ifdef AV_CODEC_FLAG_COPY_OPAQUE
    codec_->flags |= AV_CODEC_FLAG_COPY_OPAQUE;
#endif
    if (result >= 0) result = avcodec_open2(codec_.get(), coder, nullptr);
    if (result < 0) return not_readable(errors, result);
    if (codec_->width <= 0 || codec_->height <= 0)
      return fmt::format("{}: not a readable video: nothing in it tells how large its pictures are", path_);
    const AVDictionaryEntry* entry = nullptr;
    while ((entry = av_dict_get(file_->metadata, "", entry, AV_DICT_IGNORE_SUFFIX)) != nullptr)
      notes_[entry->key] = entry->value;
    const auto film = notes_.find(film_note);
    recorded_ = film != notes_.end() && film->second == film_version && has_stamps();
    const AVRational rate = av_guess_frame_rate(file_, stream_, nullptr);
    rate_ = rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0.0;
    what_ = fmt::format("{} {} ({}x{}, {:.3g} frames/s)", recorded_ ? "recording" : "video", path_, codec_->width,
                        codec_->height, rate_);
    // Which way up a phone was held changes from film to film; a calibration belongs to lens and sensor.
    if (const std::string turn = asked_turn(*stream_); !turn.empty())
      remarks_.push_back(fmt::format(
          "{}: asks players to {}; they are read as the sensor took them, for which a calibration holds", path_, turn));
    constexpr double square = 0.003;  // what `skein calibrate intrinsics` takes fx and fy for equal by
    const AVRational pixel = av_guess_sample_aspect_ratio(file_, stream_, nullptr);
    if (pixel.num > 0 && pixel.den > 0 && std::abs(av_q2d(pixel) - 1.0) > square)
      remarks_.push_back(
          fmt::format("{}: asks players to stretch its pictures to {:.3g} times their width; they are read as they are "
                      "stored: only a calibration from films of the same camera and mode holds for them",
                      path_, av_q2d(pixel)));
    switch (stream_->codecpar->field_order) {
      case AV_FIELD_TT:
      case AV_FIELD_BB:
      case AV_FIELD_TB:
      case AV_FIELD_BT:
        interlaced_ = true;
        break;
      case AV_FIELD_UNKNOWN:
      case AV_FIELD_PROGRESSIVE:
        break;
    }
    return {};
  }

  tl::expected<bool, std::string> read(Frame& frame) override {
    while (decode()) {
      const std::string damage = convert(frame);
      if (damage.empty()) {
        ++whole_;
        return true;
      }
      complain(damage);
    }
    if (whole_ == 0) return tl::unexpected(what_ + ": not a single frame can be decoded");
    return false;
  }

  TimeStamps stamps() const override { return TimeStamps::film; }
  std::string describe() const override { return what_; }
  bool recorded() const override { return recorded_; }
  const FilmNotes& notes() const override { return notes_; }
  std::span<const std::string> skipped() const override { return skipped_; }
  SourceStatus status() const override {
    SourceStatus status{.damaged = left_out_.load(std::memory_order_relaxed), .remarks = remarks_};
    if (interlaced_.load(std::memory_order_relaxed))
      status.remarks.push_back(fmt::format(
          "{}: its frames are interlaced: every other row was taken later, and tags that move are measured wrongly. "
          "Record without, or convert it: ffmpeg -i IN -vf bwdif -c:v ffv1 OUT.mkv",
          path_));
    if (const std::int64_t frames = out_of_order_.load(std::memory_order_relaxed); frames > 0)
      status.notices.push_back(fmt::format(
          "{}: {} frame{} not later than the frame before, by the film's own times: the frames were counted "
          "on at its usual rate, and no time of this film can be relied on",
          path_, frames, frames == 1 ? " is" : "s are"));
    return status;
  }

 private:
  std::string not_readable(const Errors& errors, int result) const {
    const bool no_table = errors.last().find("moov atom not found") != std::string::npos;
    if (no_table && begins_as_mp4())
      return fmt::format(
          "{}: not a readable video: its table of frames (moov), which is written last, is missing: the "
          "recording or its copy broke off. Copy it again; a program that repairs MP4 files needs a "
          "whole film of the same camera",
          path_);
    return fmt::format("{}: not a readable video: {}", path_,
                       errors.any() && !no_table ? errors.last()
                       : result == AVERROR_EOF   ? "there are no pictures in it"
                                                 : reason(result));
  }

  /// FFmpeg takes anything for one that has such a name.
  bool begins_as_mp4() const {
    const std::string box = first_bytes(path_).substr(4, 4);
    return box == "ftyp" || box == "wide" || box == "mdat";  // MP4, QuickTime
  }

  /// The next picture of the film into picture_; false: there is none. Packets that cannot be decoded are passed over.
  bool decode() {
    for (;;) {
      const int got = avcodec_receive_frame(codec_.get(), picture_.get());
      if (got >= 0) return true;
      if (got == AVERROR_EOF) return false;
      if (got != AVERROR(EAGAIN)) {  // the decoder has thrown a packet away
        ++pictures_;
        complain("cannot be decoded");
        continue;
      }
      if (!feed()) return false;
    }
  }

  /// Other programs that code a recorded film anew keep its notes, but not what it carries beside its frames.
  bool has_stamps() {
    constexpr std::size_t looked_at = 25;  // packets: the first ones may be damaged
    while (ahead_.size() < looked_at && read_packet(*packet_) >= 0) {
      const bool stamped = stamp_of_packet().has_value();
      ahead_.emplace_back(av_packet_alloc());
      if (!ahead_.back()) return false;
      av_packet_move_ref(ahead_.back().get(), packet_.get());
      if (stamped) return true;
    }
    return false;
  }

  int read_packet(AVPacket& packet) {
    const Errors errors;
    const int read = av_read_frame(file_, &packet);
    if (read >= 0 && errors.any()) say_of_file(errors.last());
    return read;
  }

  int next_packet() {
    if (ahead_.empty()) return read_packet(*packet_);
    av_packet_move_ref(packet_.get(), ahead_.front().get());
    ahead_.pop_front();
    return 0;
  }

  /// One packet of the film into the decoder, or the news that there are no more; false: it knows that already.
  bool feed() {
    for (;;) {
      av_packet_unref(packet_.get());
      const int read = ended_ ? AVERROR_EOF : next_packet();
      if (read < 0) {
        if (ended_) return false;
        ended_ = true;
        look_for_a_rest();
        return avcodec_send_packet(codec_.get(), nullptr) >= 0;
      }
      if (packet_->stream_index != stream_->index) continue;
      if (packet_->pts != AV_NOPTS_VALUE)
        ends_at_ =
            std::max(ends_at_, static_cast<double>(packet_->pts + packet_->duration) * av_q2d(stream_->time_base));
      if (recorded_) remember_stamp();
      if (codec_->codec_id == AV_CODEC_ID_MJPEG && is_damaged_jpeg()) {
        ++pictures_;
        complain("is damaged");
        continue;
      }
      if (send()) return true;
      ++pictures_;  // those behind it keep their numbers
      complain("cannot be decoded");
    }
  }

  // The decoder hands a packet's number on to its picture: as `opaque` since FFmpeg 6, and only as `reordered_opaque`
  // before.
#ifdef AV_CODEC_FLAG_COPY_OPAQUE
  void give_number(std::int64_t number) {
    packet_->opaque = reinterpret_cast<void*>(static_cast<std::intptr_t>(number));
  }
  std::int64_t number_of_picture() const { return reinterpret_cast<std::intptr_t>(picture_->opaque); }
#else
  void give_number(std::int64_t number) { codec_->reordered_opaque = number; }
  std::int64_t number_of_picture() const { return picture_->reordered_opaque; }
#endif

  // Containers need not say it: DV, capture cards.
#ifdef AV_FRAME_FLAG_INTERLACED
  bool is_interlaced() const { return (picture_->flags & AV_FRAME_FLAG_INTERLACED) != 0; }
#else
  bool is_interlaced() const { return picture_->interlaced_frame != 0; }
#endif

  /// The packet into the decoder, which works on it at once; false: it cannot.
  bool send() {
    const std::int64_t number = packets_++;
    if ((packet_->flags & AV_PKT_FLAG_KEY) != 0) {
      whole_from_ = damaged_ ? std::optional(packet_->pts) : std::nullopt;
      damaged_ = false;
    }
    give_number(number);
    const Errors errors;
    const bool sent = avcodec_send_packet(codec_.get(), packet_.get()) >= 0;
    // How whole a JPEG is has been judged, and a recorded film has its checksums.
    const bool judged = recorded_ || codec_->codec_id == AV_CODEC_ID_MJPEG;
    const bool damaged = (errors.any() && !judged) || !sent || (packet_->flags & AV_PKT_FLAG_CORRUPT) != 0;
    const bool leading = whole_from_ && packet_->pts != AV_NOPTS_VALUE && packet_->pts < *whole_from_;
    if (damaged)
      doubts_[number] = "is damaged";
    else if (!recorded_ && (damaged_ || leading))
      doubts_[number] = "builds on a damaged one";
    if (damaged) damaged_ = true;
    return sent;
  }

  /// FFmpeg goes on where it finds the next frame.
  void say_of_file(const std::string& what) {
    if (skipped_.size() >= most_complaints) return;
    skipped_.push_back(fmt::format("{}: the file is damaged before frame {}, and frames may be missing there ({})",
                                   path_, whole_ + left_out_.load(std::memory_order_relaxed), what));
    fault_.clear();
  }

  /// Copies that broke off and disks that were full end a film early; FFmpeg takes that for its end.
  void look_for_a_rest() {
    const bool stated = file_->duration_estimation_method == AVFMT_DURATION_FROM_STREAM;
    double length = -1.0;  // of the film, as its header states it [s]
    if (stated && stream_->duration != AV_NOPTS_VALUE)
      length = static_cast<double>(stream_->duration) * av_q2d(stream_->time_base);
    else if (stated && file_->nb_streams == 1 && file_->duration != AV_NOPTS_VALUE)
      length = static_cast<double>(file_->duration) / AV_TIME_BASE;
    if (std::string_view(file_->iformat->name) == "avi")  // whose length FFmpeg takes from what there is
      length = std::max(length, static_cast<double>(stream_->nb_frames) * av_q2d(stream_->time_base));
    const double rounding = rate_ > 0.0 ? 2.0 / rate_ : 0.1;  // headers and last frames are not that exact [s]
    if (ends_at_ < 0.0 || length < ends_at_ + rounding) return;
    fault_.clear();
    skipped_.push_back(
        fmt::format("{}: all behind {:.2f} s is missing: its header states {:.2f} s", path_, ends_at_, length));
  }

  /// FFmpeg goes on behind a flipped bit and says nothing, though what follows may stand elsewhere: tags, too.
  bool is_damaged_jpeg() {
    return decode_jpeg({packet_->data, static_cast<std::size_t>(packet_->size)}, judged_) == JpegState::damaged;
  }

  /// A picture has the time of the packet that it comes from; a decoder may hold some back.
  void remember_stamp() {
    if (const auto stamp = stamp_of_packet()) stamps_[packet_->pts] = *stamp;
  }

  std::optional<Stamp> stamp_of_packet() const {
    std::size_t size = 0;
    const std::uint8_t* data = av_packet_get_side_data(packet_.get(), AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, &size);
    if (data == nullptr || size <= 8) return {};
    return parse_stamp({reinterpret_cast<const char*>(data) + 8, size - 8});
  }

  /// What is known of the picture's packet; a decoder may hold some back, and gives them in another order.
  std::string doubt() {
    const std::int64_t number = number_of_picture();
    const auto known = doubts_.extract(number);
    doubts_.erase(doubts_.begin(), doubts_.lower_bound(number - most_held_back));  // that no picture came from
    if ((picture_->flags & AV_FRAME_FLAG_CORRUPT) == 0 && picture_->decode_error_flags == 0)
      return known ? known.mapped() : std::string();
    if (!recorded_ && !damaged_ && !known) {
      damaged_ = true;
      for (std::int64_t later = number + 1; later < packets_; ++later) doubts_[later] = "builds on a damaged one";
    }
    return "is damaged";
  }

  /// Empty, or what is wrong with the picture.
  std::string convert(Frame& frame) {
    const std::int64_t number = pictures_++;
    if (is_interlaced()) interlaced_.store(true, std::memory_order_relaxed);
    if (std::string damage = doubt(); !damage.empty()) return damage;
    if (width_ == 0) {
      width_ = picture_->width;
      height_ = picture_->height;
    }
    if (picture_->width != width_ || picture_->height != height_)
      return fmt::format("is {}x{} px, and the film {}x{}", picture_->width, picture_->height, width_, height_);
    if (!to_grey(*picture_, greys_, frame)) return "is of a pixel format that cannot be converted";
    if (recorded_) {
      const auto stamp = stamps_.extract(picture_->pts);
      stamps_.erase(stamps_.begin(), stamps_.lower_bound(picture_->pts));  // of packets that no picture came from
      if (!stamp) return "has lost its capture time";
      frame.index = stamp.mapped().index;
      frame.captured_at = stamp.mapped().captured_at;
      frame.note = std::move(stamp.mapped().note);
      if (stamp_of(frame).checksum != stamp.mapped().checksum) return "is damaged";
    } else {
      frame.index = number;
      frame.captured_at = time_in_film();
    }
    frame.source = std::to_string(frame.index);
    return {};
  }

  /// Some containers carry no stamps: then the frames are evenly spaced. So are those whose stamps are set back.
  double time_in_film() {
    const std::int64_t stamp = picture_->best_effort_timestamp;
    if (first_stamp_ == AV_NOPTS_VALUE) first_stamp_ = stamp;
    const double at =
        stamp == AV_NOPTS_VALUE ? -1.0 : static_cast<double>(stamp - first_stamp_) * av_q2d(stream_->time_base);
    const bool stamped = at > last_time_ || (last_time_ < 0.0 && at >= 0.0);
    if (stamp != AV_NOPTS_VALUE) {
      if (last_stamp_ != AV_NOPTS_VALUE && stamp <= last_stamp_) out_of_order_.fetch_add(1, std::memory_order_relaxed);
      last_stamp_ = stamp;
    }
    last_time_ = stamped ? at : last_time_ < 0.0 ? 0.0 : last_time_ + (rate_ > 0.0 ? 1.0 / rate_ : 0.04);
    return last_time_;
  }

  /// One line for frames side by side with the same fault.
  void complain(const std::string& what) {
    const std::int64_t frame = whole_ + left_out_.fetch_add(1, std::memory_order_relaxed);
    if (more_ == 0 && what == fault_ && frame == faulty_to_ + 1) {
      faulty_to_ = frame;
      skipped_.back() = fmt::format("{}: frames {} to {}: each {}", path_, faulty_from_, frame, what);
      return;
    }
    fault_ = what;
    faulty_from_ = faulty_to_ = frame;
    if (skipped_.size() < most_complaints)
      skipped_.push_back(fmt::format("{}: frame {} {}", path_, frame, what));
    else
      skipped_.back() = fmt::format("{}: {} more", path_, more_ = std::max<std::int64_t>(2, more_ + 1));
  }

  std::string path_;
  std::string what_;
  AVFormatContext* file_ = nullptr;
  AVStream* stream_ = nullptr;
  Codec codec_;
  Picture picture_;
  Packet packet_;
  std::deque<Packet> ahead_;  // that were looked at when the film was opened
  Greys greys_;
  Frame judged_;  // of a JPEG, read by a decoder that tells what it meets
  FilmNotes notes_;
  std::vector<std::string> remarks_;
  bool recorded_ = false;
  bool ended_ = false;
  double rate_ = 0.0;
  double last_time_ = -1.0;
  double ends_at_ = -1.0;  // its newest packet, in its own time [s]
  std::int64_t first_stamp_ = AV_NOPTS_VALUE, last_stamp_ = AV_NOPTS_VALUE;
  std::map<std::int64_t, Stamp> stamps_;  // of a recorded film's packets that are being decoded, by their times
  std::int64_t pictures_ = 0;             // that the decoder gave
  std::int64_t whole_ = 0;                // that were handed on
  std::atomic<std::int64_t> left_out_ = 0;
  std::atomic<bool> interlaced_ = false;
  std::atomic<std::int64_t> out_of_order_ = 0;  // whose times are not later than the previous frame's
  int width_ = 0;                               // of the first picture
  int height_ = 0;
  std::int64_t packets_ = 0;                      // that the decoder was given
  bool damaged_ = false;                          // since the newest picture that builds on no other
  std::optional<std::int64_t> whole_from_;        // the time of that one, where there was damage before it
  std::map<std::int64_t, const char*> doubts_;    // what is wrong with pictures that are still to come, by packet
  std::string fault_;                             // of the frame that was left out last
  std::int64_t faulty_from_ = 0, faulty_to_ = 0;  // frames with that fault
  std::int64_t more_ = 0;                         // faults that are only counted
  std::vector<std::string> skipped_;
};

}  // namespace

std::unique_ptr<FrameSource> open_video(const std::string& path, std::string& error) {
  if (std::error_code code; !std::filesystem::is_regular_file(path, code)) {
    const bool other = std::filesystem::exists(path, code) && !std::filesystem::is_directory(path, code);
    error = fmt::format("{}: {}", path, other ? "is a device or a FIFO, allowed: a file" : "no such file");
    return nullptr;
  }
  if (std::error_code not_known; std::filesystem::file_size(path, not_known) == 0) {
    error = fmt::format("{}: not a readable video: the file is empty", path);
    return nullptr;
  }
  if (is_heif(path)) {
    error = fmt::format("{}: is a picture (HEIF), not a film: convert it to PNG or JPEG, and give it as images:", path);
    return nullptr;
  }
  auto video = std::make_unique<Video>(path);
  error = video->open();
  return error.empty() ? std::move(video) : nullptr;
}

}  // namespace skein::vision::media
