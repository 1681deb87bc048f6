#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "vision/frames/file_rights.h"
#include "vision/media/libav.h"
#include "vision/media/sources.h"

extern "C" {
#include <libavutil/intreadwrite.h>
#include <libavutil/opt.h>
}

namespace skein::vision::media {
namespace {

constexpr AVRational milliseconds{1, 1000};     // Matroska's own
constexpr int frames_between_whole_ones = 25;   // of a small film: what a damaged frame may damage
constexpr const char* constant_quality = "20";  // x264's CRF, of a small film

class MatroskaFilm final : public FilmWriter {
 public:
  MatroskaFilm(std::string path, FilmNotes notes, FilmCoding coding)
      : path_(std::move(path)), notes_(std::move(notes)), coding_(coding) {}
  ~MatroskaFilm() override { finish(); }
  MatroskaFilm(const MatroskaFilm&) = delete;
  MatroskaFilm& operator=(const MatroskaFilm&) = delete;

  /// Empty, or what is in the way.
  std::string create() {
    renew();
    if (avformat_alloc_output_context2(&file_, nullptr, "matroska", path_.c_str()) < 0) return failed(AVERROR(ENOMEM));
    const int opened = avio_open(&file_->pb, ("file:" + path_).c_str(), AVIO_FLAG_WRITE);
    return opened < 0 ? failed(opened) : std::string();
  }

  std::string write(const Frame& frame) override {
    if (frames_ == 0)
      if (std::string problem = begin(frame); !problem.empty()) return problem;
    if (frame.width != codec_->width || frame.height != codec_->height)
      return fmt::format("{}: frame {} is {}x{} px, and the film {}x{}", path_, frame.index, frame.width, frame.height,
                         codec_->width, codec_->height);
    picture_->data[0] = const_cast<std::uint8_t*>(frame.grey.data());
    picture_->linesize[0] = frame.width;
    // For players: what counts stands in the stamp.
    const double elapsed = 1000.0 * (frame.captured_at - first_at_);
    const bool sane = std::isfinite(elapsed) && std::abs(elapsed) < 1e12;
    last_pts_ = std::max<std::int64_t>(last_pts_ + 1, sane ? std::llround(elapsed) : 0);
    picture_->pts = last_pts_;
    int result = avcodec_send_frame(codec_.get(), picture_.get());
    if (result >= 0) result = avcodec_receive_packet(codec_.get(), packet_.get());
    if (result >= 0 && decoder_) result = read_back(frame);
    if (result >= 0) result = attach(to_text(stamp_of(decoder_ ? read_ : frame)));
    if (result >= 0) {
      packet_->duration = 1;
      result = av_write_frame(file_, packet_.get());
      av_packet_unref(packet_.get());
    }
    if (result >= 0) result = file_->pb->error;
    if (result < 0) return failed(result);
    ++frames_;
    return {};
  }

  std::string finish() override {
    if (file_ == nullptr) return {};
    int result = begun_ ? av_write_trailer(file_) : 0;
    if (file_->pb != nullptr) {
      if (result >= 0) result = file_->pb->error;
      const int closed = avio_closep(&file_->pb);
      if (result >= 0) result = closed;
    }
    avformat_free_context(file_);
    file_ = nullptr;
    return result < 0 ? failed(result) : std::string();
  }

 private:
  /// A kept run may hold what was there by a name of its own: a new film is a new file, with the rights of the old one.
  void renew() const {
    std::error_code error;
    const std::filesystem::path there = std::filesystem::canonical(path_, error);
    if (error || !std::filesystem::is_regular_file(there, error)) return;
    const std::string draft = there.string() + ".new";
    const int file = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR);
    if (file < 0) return;
    keep_rights(there, file);
    ::close(file);
    std::filesystem::rename(draft, there, error);
    if (error) std::filesystem::remove(draft, error);
  }

  std::string failed(int error) const { return fmt::format("{}: cannot be written: {}", path_, reason(error)); }

  std::string begin(const Frame& frame) {
    const AVCodec* coder = encoder();
    if (coder == nullptr) return fmt::format("{}: this system's FFmpeg cannot write {} films", path_, word(coding_));
    codec_.reset(avcodec_alloc_context3(coder));
    picture_.reset(av_frame_alloc());
    packet_.reset(av_packet_alloc());
    AVStream* stream = avformat_new_stream(file_, nullptr);
    if (!codec_ || !picture_ || !packet_ || stream == nullptr) return failed(AVERROR(ENOMEM));
    codec_->width = picture_->width = frame.width;
    codec_->height = picture_->height = frame.height;
    codec_->pix_fmt = AV_PIX_FMT_GRAY8;
    picture_->format = AV_PIX_FMT_GRAY8;
    codec_->color_range = picture_->color_range = AVCOL_RANGE_JPEG;
    codec_->time_base = milliseconds;
    codec_->thread_count = 1;
    if ((file_->oformat->flags & AVFMT_GLOBALHEADER) != 0) codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    tune();
    int result = avcodec_open2(codec_.get(), coder, nullptr);
    if (result >= 0) result = avcodec_parameters_from_context(stream->codecpar, codec_.get());
    if (result >= 0) result = open_decoder(*stream->codecpar);
    if (result < 0) return failed(result);
    stream->time_base = milliseconds;
    for (const auto& [name, text] : notes_) av_dict_set(&file_->metadata, name.c_str(), text.c_str(), 0);
    av_dict_set(&file_->metadata, film_note, film_version, 0);
    av_dict_set(&file_->metadata, coding_note, std::string(word(coding_)).c_str(), 0);
    // Ends a cluster every second: a run that breaks off loses no more than that.
    AVDictionary* options = nullptr;
    av_dict_set(&options, "cluster_time_limit", "1000", 0);
    result = avformat_write_header(file_, &options);
    av_dict_free(&options);
    if (result < 0) return failed(result);
    begun_ = true;
    first_at_ = frame.captured_at;
    return {};
  }

  const AVCodec* encoder() const {
    switch (coding_) {
      case FilmCoding::lossless:
        return avcodec_find_encoder(AV_CODEC_ID_FFV1);
      case FilmCoding::small:
        return avcodec_find_encoder_by_name("libx264");
    }
    return nullptr;
  }

  void tune() {
    switch (coding_) {
      case FilmCoding::lossless:
        codec_->gop_size = 1;  // a damaged frame damages no other
        codec_->level = 3;
        av_opt_set(codec_->priv_data, "slicecrc", "1", 0);
        break;
      case FilmCoding::small:
        codec_->gop_size = frames_between_whole_ones;
        av_opt_set(codec_->priv_data, "preset", "superfast", 0);
        av_opt_set(codec_->priv_data, "tune", "zerolatency", 0);  // a packet for every frame, at once
        av_opt_set(codec_->priv_data, "crf", constant_quality, 0);
        break;
    }
  }

  int open_decoder(const AVCodecParameters& parameters) {
    if (coding_ == FilmCoding::lossless) return 0;
    const AVCodec* coder = avcodec_find_decoder(parameters.codec_id);
    if (coder == nullptr) return AVERROR_DECODER_NOT_FOUND;
    decoder_.reset(avcodec_alloc_context3(coder));
    decoded_.reset(av_frame_alloc());
    if (!decoder_ || !decoded_) return AVERROR(ENOMEM);
    int result = avcodec_parameters_to_context(decoder_.get(), &parameters);
    decoder_->thread_count = 1;
    decoder_->flags |= AV_CODEC_FLAG_LOW_DELAY;  // a picture for every packet, at once
    if (result >= 0) result = avcodec_open2(decoder_.get(), coder, nullptr);
    return result;
  }

  /// The frame as the film's reader will see it goes to read_: its checksum shows later that nothing is damaged.
  int read_back(const Frame& frame) {
    int result = avcodec_send_packet(decoder_.get(), packet_.get());
    if (result >= 0) result = avcodec_receive_frame(decoder_.get(), decoded_.get());
    if (result < 0) return result;
    read_.index = frame.index;
    read_.captured_at = frame.captured_at;
    read_.note = frame.note;
    return to_grey(*decoded_, greys_, read_) ? 0 : AVERROR_INVALIDDATA;
  }

  /// Text beside the frame: BlockAdditional, whose id, 1, comes first.
  int attach(const std::string& text) {
    std::uint8_t* data = av_packet_new_side_data(packet_.get(), AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, 8 + text.size());
    if (data == nullptr) return AVERROR(ENOMEM);
    AV_WB64(data, 1);
    std::copy(text.begin(), text.end(), data + 8);  // its length is the packet's
    return 0;
  }

  std::string path_;
  FilmNotes notes_;
  FilmCoding coding_;
  AVFormatContext* file_ = nullptr;
  Codec codec_, decoder_;  // there is a decoder where pixels do not come back as they were
  Picture picture_, decoded_;
  Packet packet_;
  Greys greys_;
  Frame read_;
  bool begun_ = false;
  double first_at_ = 0.0;
  std::int64_t last_pts_ = -1;
  std::int64_t frames_ = 0;
};

}  // namespace

std::unique_ptr<FilmWriter> create_film(const std::string& path, const FilmNotes& notes, FilmCoding coding,
                                        std::string& error) {
  av_log_set_level(AV_LOG_QUIET);  // the caller reports what matters
  auto film = std::make_unique<MatroskaFilm>(path, notes, coding);
  error = film->create();
  if (!error.empty()) return nullptr;
  return film;
}

}  // namespace skein::vision::media
