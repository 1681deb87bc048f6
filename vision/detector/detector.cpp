#include "vision/detector/detector.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>

#include "vision/detector/found_tags.h"
#include "vision/detector/likeness.h"

namespace skein::vision {

struct TagDetector::Parts {
  detail::AprilTagDetector detector = detail::create_detector();
  std::vector<std::uint8_t> cut;  // a window's pixels, without the gaps between its rows
  std::vector<detail::TagPattern> patterns = detail::tag_patterns();
  double least_likeness = 0.0;
  std::vector<Detection> found;

  void search(const Frame& frame, image_u8_t image, int left, int top) {
    found.clear();
    detail::expect_memory_for(image.width, image.height);
    zarray_t* detections = apriltag_detector_detect(detector.get(), &image);
    for (int i = 0; i < zarray_size(detections); ++i) {
      apriltag_detection_t* seen = nullptr;
      zarray_get(detections, i, &seen);
      Detection detection = detail::detection_of(seen->id, seen->decision_margin, seen->p, left, top);
      if (least_likeness > -1.0)
        detection.likeness =
            detail::likeness(frame, detection.corners, patterns[static_cast<std::size_t>(detection.tag)]);
      if (detection.likeness >= least_likeness) found.push_back(detection);
    }
    apriltag_detections_destroy(detections);
    std::sort(found.begin(), found.end(), detail::by_id);
  }
};

void detail::make_table(apriltag_family& family, int bits_corrected) {
  apriltag_detector_add_family_bits(create_detector().get(), &family, bits_corrected);
  if (family.impl == nullptr) throw std::bad_alloc();
}

apriltag_family& detail::family_36h11() {
  static apriltag_family& family = []() -> apriltag_family& {
    struct Destroy {
      void operator()(apriltag_family* of_no_use) const { tag36h11_destroy(of_no_use); }
    };
    std::unique_ptr<apriltag_family, Destroy> made(tag36h11_create());
    make_table(*made, 2);  // of a tag's 36 bits; 3 would take a second and a gigabyte, and find ghosts
    return *made.release();
  }();
  return family;
}

detail::AprilTagDetector detail::create_detector() {
  return AprilTagDetector(apriltag_detector_create());
}

void detail::DestroyDetector::operator()(apriltag_detector* detector) const {
  zarray_clear(detector->tag_families);
  apriltag_detector_destroy(detector);
}

void detail::add_family(apriltag_detector& detector, apriltag_family& family) {
  apriltag_detector_add_family(&detector, &family);
}

void detail::expect_memory_for(int width, int height) {
  // Of white noise, at full resolution, it takes 84 bytes a pixel, while its lists grow; of a floor less.
  constexpr std::size_t per_pixel = 96;
  const auto limited = [](auto kind) {
    rlimit limit{};
    return ::getrlimit(kind, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  };
  if (!limited(RLIMIT_AS) && !limited(RLIMIT_DATA)) return;
  void* volatile const room =
      std::malloc(per_pixel * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (room == nullptr) throw std::bad_alloc();
  std::free(room);
}

TagDetector::TagDetector(const DetectorOptions& options) : parts_(std::make_unique<Parts>()) {
  detail::add_family(*parts_->detector, detail::family_36h11());
  parts_->detector->nthreads = std::max(1, options.threads);
  parts_->least_likeness = options.least_likeness;
  set_decimate(options.decimate);
  set_min_white_black_diff(options.min_white_black_diff);
}

TagDetector::~TagDetector() = default;
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;

void TagDetector::set_decimate(double decimate) {
  parts_->detector->quad_decimate = static_cast<float>(std::max(1.0, decimate));
}

void TagDetector::set_min_white_black_diff(int grey_levels) {
  parts_->detector->qtp.min_white_black_diff = grey_levels;
}

const std::vector<Detection>& TagDetector::detect(const Frame& frame) {
  return detect(frame, Window{0, 0, frame.width, frame.height});
}

const std::vector<Detection>& TagDetector::detect(const Frame& frame, Window window) {
  const int left = std::max(0, window.left);
  const int top = std::max(0, window.top);
  const int width = std::min(frame.width, window.left + window.width) - left;
  const int height = std::min(frame.height, window.top + window.height) - top;
  if (width < detail::least_side || height < detail::least_side) {
    parts_->found.clear();
    return parts_->found;
  }

  // AprilTag only reads the pixels: it would write to them only if it had to blur before the search, which it is not
  // asked to do here.
  if (width == frame.width) {
    parts_->search(frame, {width, height, width, const_cast<std::uint8_t*>(frame.row(top))}, left, top);
    return parts_->found;
  }
  // Its buffers take over the rows' distance, so the few rows of a window would cost as much as rows of the whole
  // frame.
  std::vector<std::uint8_t>& cut = parts_->cut;
  cut.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int row = 0; row < height; ++row) {
    std::memcpy(cut.data() + static_cast<std::ptrdiff_t>(row) * width, frame.row(top + row) + left,
                static_cast<std::size_t>(width));
  }
  parts_->search(frame, {width, height, width, cut.data()}, left, top);
  return parts_->found;
}

std::vector<Detection> detect_at_both(TagDetector& detector, const Frame& frame) {
  detector.set_decimate(1.0);
  std::vector<Detection> found = detector.detect(frame);
  const auto before = static_cast<std::ptrdiff_t>(found.size());
  detector.set_decimate(2.0);
  for (const Detection& detection : detector.detect(frame)) {
    const bool known = std::any_of(found.begin(), found.begin() + before,
                                   [&](const auto& other) { return detail::same_tag(other, detection); });
    if (!known) found.push_back(detection);
  }
  std::sort(found.begin(), found.end(), detail::by_id);
  return found;
}

double decimate_for_edge(double edge_px) {
  return edge_px / 8.0 >= 3.5 ? 2.0 : 1.0;
}

}  // namespace skein::vision
