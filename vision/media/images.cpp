#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <system_error>
#include <vector>

#include "vision/media/jpeg.h"
#include "vision/media/sources.h"
#include "vision/media/tiff.h"

namespace skein::vision::media {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t most_bytes = 1'000'000'000;  // of a file: more is no picture

void to_eight_bits(cv::Mat& picture) {
  double brightest = 0.0;
  cv::minMaxLoc(picture, nullptr, &brightest);
  const int bits = bits_used(static_cast<int>(brightest));
  for (int v = 0; v < picture.rows; ++v) {
    auto* const row = picture.ptr<std::uint16_t>(v);
    for (int u = 0; u < picture.cols; ++u) row[u] = static_cast<std::uint16_t>(row[u] >> (bits - 8));
  }
  picture.convertTo(picture, CV_8U);
}

bool looks_like_a_picture(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  // Those behind .webp are read by few OpenCVs, or none: named, not passed over.
  static constexpr std::array known = {".png",  ".jpg",  ".jpeg", ".pgm",  ".ppm",  ".pnm", ".pbm", ".bmp", ".tif",
                                       ".tiff", ".webp", ".heic", ".heif", ".avif", ".jxl", ".gif", ".dng"};
  return std::find(known.begin(), known.end(), extension) != known.end();
}

class Images final : public FrameSource {
 public:
  Images(std::vector<fs::path> files, std::string what) : files_(std::move(files)), what_(std::move(what)) {}

  tl::expected<bool, std::string> read(Frame& frame) override {
    while (next_ < files_.size()) {
      const fs::path& file = files_[next_++];
      if (const std::string problem = load(file, frame); !problem.empty()) {
        skipped_.push_back(fmt::format("{}: {}", file.string(), problem));
        left_out_.fetch_add(1, std::memory_order_relaxed);
        continue;
      }
      frame.index = frames_++;
      frame.source = file.filename().string();
      frame.captured_at = static_cast<double>(frame.index) / 25.0;
      return true;
    }
    return false;
  }

  std::string describe() const override {
    return fmt::format("{} ({} {})", what_, files_.size(), files_.size() == 1 ? "picture" : "pictures");
  }
  TimeStamps stamps() const override { return TimeStamps::nominal; }
  bool stills() const override { return true; }
  std::span<const std::string> skipped() const override { return skipped_; }
  SourceStatus status() const override { return {.damaged = left_out_.load(std::memory_order_relaxed)}; }

 private:
  /// Empty, or what is wrong with the file.
  std::string load(const fs::path& file, Frame& frame) {
    std::ifstream in(file, std::ios::binary);
    std::error_code not_known;
    const std::uintmax_t size = fs::file_size(file, not_known);
    if (!in || not_known) return "cannot be read";
    if (size > most_bytes) return "has more than 1 GB";
    bytes_.resize(size);  // at once, which is faster than byte by byte
    in.read(reinterpret_cast<char*>(bytes_.data()), static_cast<std::streamsize>(size));
    bytes_.resize(static_cast<std::size_t>(in.gcount()));
    if (bytes_.empty()) return "is empty";
    if (jpeg_breaks_off(bytes_)) return "is cut short";
    if (std::string problem = prepare_tiff(bytes_); !problem.empty()) return problem;
    try {
      // As the sensor took it, for which a calibration holds: how a camera that looks down was held, it only guesses.
      constexpr int as_taken = cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION;
      decoded_ = cv::imdecode(bytes_, as_taken | cv::IMREAD_ANYDEPTH);
      if (decoded_.depth() == CV_32F || decoded_.depth() == CV_64F)
        return "has grey levels that are no whole numbers, allowed: 8 or 16 bits";  // nothing tells which one is white
      if (decoded_.depth() == CV_16U) to_eight_bits(decoded_);
      if (decoded_.depth() != CV_8U) decoded_ = cv::imdecode(bytes_, as_taken);
    } catch (const cv::Exception& problem) {
      return problem.code == cv::Error::StsNoMem ? "needs more memory than there is" : "cannot be decoded";
    }
    if (decoded_.empty())
      return cv::haveImageReader(file.string())
                 ? "cannot be decoded"
                 : "is of a format that cannot be read, allowed: png, jpg, pgm, ppm, bmp, tif, webp";
    frame.resize(decoded_.cols, decoded_.rows);
    for (int v = 0; v < decoded_.rows; ++v) {
      std::copy(decoded_.ptr(v), decoded_.ptr(v) + decoded_.cols, frame.row(v));
    }
    return {};
  }

  std::vector<fs::path> files_;
  std::string what_;
  std::size_t next_ = 0;
  std::int64_t frames_ = 0;
  std::atomic<std::int64_t> left_out_ = 0;
  std::vector<std::string> skipped_;
  std::vector<std::uint8_t> bytes_;
  cv::Mat decoded_;
};

}  // namespace

std::unique_ptr<FrameSource> open_images(const std::string& path, std::string& error) {
  std::error_code code;
  std::vector<fs::path> files;
  if (fs::is_directory(path, code)) {
    for (const auto& entry : fs::directory_iterator(path, code)) {
      if (entry.is_regular_file(code) && looks_like_a_picture(entry.path())) files.push_back(entry.path());
    }
    if (files.empty()) {
      error = fmt::format("{}: no picture (png, jpg, pgm, ppm, bmp, tif, webp) in this folder", path);
      return nullptr;
    }
    // Cameras count without leading zeros, too: img2 comes before img10.
    std::sort(files.begin(), files.end(),
              [](const fs::path& a, const fs::path& b) { return strverscmp(a.c_str(), b.c_str()) < 0; });
  } else if (fs::is_regular_file(path, code)) {
    files.emplace_back(path);
  } else {
    const bool other = fs::exists(path, code);
    error = fmt::format("{}: {}", path,
                        other ? "is a device or a FIFO, allowed: a file or a folder" : "no such file or folder");
    return nullptr;
  }
  return std::make_unique<Images>(std::move(files), "images " + path);
}

}  // namespace skein::vision::media
