#include "vision/detector/family_reader.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <mutex>

#include "vision/detector/detector.h"
#include "vision/detector/found_tags.h"
#include "vision/detector/likeness.h"

namespace skein::vision {
namespace {

/// How the pattern of 36h11 is changed.
enum class Change : std::uint8_t { none, mirrored, negative, other_family };

struct Entry {
  TagFamily family;
  Change change;
  int bits_corrected;  // none of other families, since the small ones find ghosts in any texture
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};
constexpr std::array families{
    Entry{{in_36h11}, Change::none, 2, tag36h11_create, tag36h11_destroy},
    Entry{{in_mirror}, Change::mirrored, 2, tag36h11_create, tag36h11_destroy},
    Entry{{in_negative}, Change::negative, 2, tag36h11_create, tag36h11_destroy},
    Entry{{"25h9"}, Change::other_family, 0, tag25h9_create, tag25h9_destroy},
    Entry{{"36h10"}, Change::other_family, 0, tag36h10_create, tag36h10_destroy},
    Entry{{"Standard41h12"}, Change::other_family, 0, tagStandard41h12_create, tagStandard41h12_destroy},
    Entry{{"Standard52h13"}, Change::other_family, 0, tagStandard52h13_create, tagStandard52h13_destroy},
    Entry{{"Circle21h7", true}, Change::other_family, 0, tagCircle21h7_create, tagCircle21h7_destroy},
    Entry{{"Circle49h12"}, Change::other_family, 0, tagCircle49h12_create, tagCircle49h12_destroy},
    Entry{{"Custom48h12"}, Change::other_family, 0, tagCustom48h12_create, tagCustom48h12_destroy},
    Entry{{"16h5", true}, Change::other_family, 0, tag16h5_create, tag16h5_destroy},
};

/// The code whose tag is the mirror image of this code's tag.
std::uint64_t mirrored(std::uint64_t code, const apriltag_family_t& family) {
  const auto last = static_cast<std::uint32_t>(family.width_at_border) - 1;
  const auto bit = [&](std::uint32_t i) { return std::uint64_t{1} << (family.nbits - 1 - i); };
  std::uint64_t image = 0;
  for (std::uint32_t i = 0; i < family.nbits; ++i)
    for (std::uint32_t j = 0; j < family.nbits; ++j)
      if (family.bit_x[j] == last - family.bit_x[i] && family.bit_y[j] == family.bit_y[i] && (code & bit(j)) != 0)
        image |= bit(i);
  return image;
}

/// A family as AprilTag is given it, with its table. All families that it creates of one kind share their codes, so
/// that changed ones are kept here.
class Family {
 public:
  explicit Family(const Entry& entry) : original_(entry.create(), entry.destroy), changed_(*original_) {
    codes_.assign(original_->codes, original_->codes + original_->ncodes);
    switch (entry.change) {
      case Change::none:
      case Change::other_family:
        break;
      case Change::mirrored:
        for (std::uint64_t& code : codes_) code = mirrored(code, *original_);
        break;
      case Change::negative:
        for (std::uint64_t& code : codes_) code = ~code & ((std::uint64_t{1} << original_->nbits) - 1);
        changed_.reversed_border = !original_->reversed_border;
        break;
    }
    changed_.codes = codes_.data();
    detail::make_table(changed_, entry.bits_corrected);
  }
  Family(const Family&) = delete;
  Family& operator=(const Family&) = delete;
  ~Family() = default;

  apriltag_family_t* get() { return &changed_; }

 private:
  std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> original_;
  std::vector<std::uint64_t> codes_;
  apriltag_family_t changed_;
};

/// All of them, made once in a process as the tracker's is: detectors only read them.
std::array<apriltag_family_t*, families.size()> families_with_tables() {
  static std::mutex one_makes_them;
  static std::array<Family*, families.size()> made{};
  const std::lock_guard lock(one_makes_them);
  std::array<apriltag_family_t*, families.size()> all{};
  for (std::size_t k = 0; k < families.size(); ++k) {
    const bool of_robots = families[k].change == Change::none;
    if (!of_robots && made[k] == nullptr) made[k] = std::make_unique<Family>(families[k]).release();
    all[k] = of_robots ? &detail::family_36h11() : made[k]->get();
  }
  return all;
}

class Reader {
 public:
  explicit Reader(int min_white_black_diff) {
    detector_->qtp.min_white_black_diff = min_white_black_diff;
    for (apriltag_family_t* family : families_) detail::add_family(*detector_, *family);
  }

  void read(const Frame& frame, double decimate, std::array<std::vector<Detection>, families.size()>& found) {
    detector_->quad_decimate = static_cast<float>(decimate);
    detail::expect_memory_for(frame.width, frame.height);
    // AprilTag only reads the pixels.
    image_u8_t image{frame.width, frame.height, frame.width, const_cast<std::uint8_t*>(frame.grey.data())};
    zarray_t* detections = apriltag_detector_detect(detector_.get(), &image);
    for (int i = 0; i < zarray_size(detections); ++i) {
      apriltag_detection_t* one = nullptr;
      zarray_get(detections, i, &one);
      for (std::size_t k = 0; k < families.size(); ++k)
        if (one->family == families_[k])
          accept(frame, families[k].change, detail::detection_of(one->id, one->decision_margin, one->p), found[k]);
    }
    apriltag_detections_destroy(detections);
  }

 private:
  void accept(const Frame& frame, Change change, Detection seen, std::vector<Detection>& found) const {
    if (!is_clear(frame, change, seen)) return;
    if (std::none_of(found.begin(), found.end(), [&](const Detection& other) { return detail::same_tag(other, seen); }))
      found.push_back(seen);
  }

  /// It is a tag, not a texture: by its likeness, which it is given, or else by its contrast.
  bool is_clear(const Frame& frame, Change change, Detection& seen) const {
    constexpr double clear_margin = 30.0;
    const auto likeness = [&](const Corners& corners) {
      return detail::likeness(frame, corners, patterns_[static_cast<std::size_t>(seen.tag)]);
    };
    const Corners& c = seen.corners;
    switch (change) {
      case Change::none:
        seen.likeness = likeness(c);
        break;
      case Change::mirrored:
        seen.likeness = likeness({c[1], c[0], c[3], c[2]});
        break;
      case Change::negative:
        seen.likeness = -likeness(c);
        break;
      case Change::other_family:
        return seen.decision_margin >= clear_margin;
    }
    return seen.likeness >= DetectorOptions{}.least_likeness;
  }

  std::array<apriltag_family_t*, families.size()> families_ = families_with_tables();
  detail::AprilTagDetector detector_ = detail::create_detector();
  std::vector<detail::TagPattern> patterns_ = detail::tag_patterns();
};

}  // namespace

std::vector<FamilyTag> read_families(const Frame& frame, int min_white_black_diff) {
  std::vector<FamilyTag> tags;
  if (frame.width < detail::least_side || frame.height < detail::least_side) return tags;
  Reader reader(min_white_black_diff);
  std::array<std::vector<Detection>, families.size()> found;
  for (const double decimate : {1.0, 2.0}) reader.read(frame, decimate, found);
  for (std::size_t k = 0; k < families.size(); ++k) {
    std::sort(found[k].begin(), found[k].end(), detail::by_id);
    for (const Detection& seen : found[k]) tags.push_back({&families[k].family, seen});
  }
  return tags;
}

std::vector<Detection> of_family(const std::vector<FamilyTag>& tags, std::string_view family) {
  std::vector<Detection> found;
  for (const FamilyTag& tag : tags)
    if (tag.family->name == family) found.push_back(tag.seen);
  return found;
}

}  // namespace skein::vision
