// What is no tag of ours, or not quite: nothing of it may be reported, by the detector or by the tracker, and least of
// all at first sight, when nothing is known yet of where a tag could be.
#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

#include "tests/vision/support.h"
#include "vision/bench/bench_scenes.h"
#include "vision/detector/detector.h"
#include "vision/synthetic/random.h"
#include "vision/tags/tag_family.h"
#include "vision/tags/tag_plane.h"
#include "vision/tracker/tracker.h"

namespace skein::vision {
namespace {

/// A square print of any family: cells[row][column] is white, rows from the top as printed, its white border included.
struct Print {
  int side = 0;
  std::vector<bool> cells{};
  int border = 1;  // cells outside the black square on each side
};

std::vector<Print> prints(apriltag_family_t* family, void (*destroy)(apriltag_family_t*), std::size_t most) {
  std::vector<Print> all;
  for (std::uint32_t id = 0; id < std::min<std::size_t>(family->ncodes, most); ++id) {
    image_u8_t* image = apriltag_to_image(family, static_cast<int>(id));
    Print print{.side = image->width, .border = (family->total_width - family->width_at_border) / 2};
    for (int i = 0; i < print.side * print.side; ++i)
      print.cells.push_back(image->buf[i / print.side * image->stride + i % print.side] > 127);
    all.push_back(std::move(print));
    std::free(image->buf);
    std::free(image);
  }
  destroy(family);
  return all;
}

/// Where the camera looks on the plane of the tags, at 4x4 points of each pixel: the prints of all families lie in the
/// same places.
class Looks {
 public:
  static constexpr int side = 4;
  using Points = std::array<Eigen::Vector2d, side * side>;

  explicit Looks(const Calibration& calibration) : calibration_(calibration) {}
  const Calibration& calibration() const { return calibration_; }

  const Points& into(int u, int v) {
    const auto [found, is_new] = points_.try_emplace(v * calibration_.width + u);
    for (int k = 0; is_new && k < side * side; ++k) {
      const int column = k % side, row = k / side;
      const double du = (column + 0.5) / side - 0.5, dv = (row + 0.5) / side - 0.5;
      found->second[static_cast<std::size_t>(k)] =
          world_from_pixel(calibration_, {u + du, v + dv}, calibration_.tag_height).value();
    }
    return found->second;
  }

 private:
  Calibration calibration_;
  std::unordered_map<int, Points> points_;
};

/// Into a picture that is there already: a print whose black square has the edge `size` [m], anti-aliased and noisy.
void paint(Looks& looks, const Print& print, const core::Pose& pose, double size, detail::Random& random,
           Frame& frame) {
  const Calibration& calibration = looks.calibration();
  const auto centre = pixel_from_world(calibration, {pose.x, pose.y, calibration.tag_height});
  const double cell = size / (print.side - 2 * print.border);
  const double reach = 0.75 * print.side * cell * tag_edge_px(calibration) / calibration.tag_size;
  const double c = std::cos(pose.theta), s = std::sin(pose.theta);
  for (int v = static_cast<int>(centre->y() - reach); v < centre->y() + reach; ++v) {
    for (int u = static_cast<int>(centre->x() - reach); u < centre->x() + reach; ++u) {
      if (u < 0 || v < 0 || u >= frame.width || v >= frame.height) continue;
      if (std::hypot(u - centre->x(), v - centre->y()) > reach) continue;
      double grey = 0.0;
      std::uint8_t& pixel = frame.row(v)[u];
      for (const Eigen::Vector2d& at : looks.into(u, v)) {
        const double x = at.x() - pose.x, y = at.y() - pose.y;
        const int column = static_cast<int>(std::floor((c * x + s * y) / cell + 0.5 * print.side));
        const int row = static_cast<int>(std::floor(0.5 * print.side - (c * y - s * x) / cell));
        const bool on_it = column >= 0 && row >= 0 && column < print.side && row < print.side;
        const bool white = on_it && print.cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(print.side) +
                                                static_cast<std::size_t>(column)];
        grey += on_it ? (white ? 210.0 : 35.0) + random.between(-20.0, 20.0) : static_cast<double>(pixel);
      }
      pixel = static_cast<std::uint8_t>(std::lround(grey / (Looks::side * Looks::side)));
    }
  }
}

std::vector<int> all_ids() {
  std::vector<int> ids;
  for (int id = 0; id <= largest_tag; ++id) ids.push_back(id);
  return ids;
}

core::Pose place(int k) {
  const int column = k % 8, row = k / 8;
  return {-0.85 + 0.243 * column, -0.6 + 0.24 * row, core::wrap_angle(0.7 * k)};
}
constexpr int places = 48;

struct Family {
  const char* name;
  std::vector<Print> prints;
};

std::vector<Family> families() {
  std::vector<Family> all;
  all.push_back({"16h5", prints(tag16h5_create(), tag16h5_destroy, 30)});
  all.push_back({"25h9", prints(tag25h9_create(), tag25h9_destroy, 35)});
  all.push_back({"36h10", prints(tag36h10_create(), tag36h10_destroy, test::sanitized ? 48 : 192)});
  // What the dictionaries of others look like, ArUco's 4x4 to 6x6 among them: any bits in a black frame.
  for (const int bits : {4, 5, 6}) {
    detail::Random random(static_cast<std::uint64_t>(bits));
    Family any{"any bits", {}};
    for (int k = 0; k < places; ++k) {
      Print print{.side = bits + 4};
      for (int i = 0; i < print.side * print.side; ++i) {
        const int from_edge = std::min(
            {i % print.side, i / print.side, print.side - 1 - i % print.side, print.side - 1 - i / print.side});
        print.cells.push_back(from_edge == 0 || (from_edge > 1 && random.below(2) == 1));
      }
      any.prints.push_back(std::move(print));
    }
    all.push_back(std::move(any));
  }
  return all;
}

TEST(FalseTags, OtherFamiliesAreNotOurs) {
  Calibration calibration = overhead_calibration(2.0, 1.5);
  calibration.tag_size = 0.06;
  SyntheticCamera camera(calibration, {}, 5);
  TagDetector detector;
  TagTracker tracker(calibration, {.tags = test::sanitized ? std::vector{0, 1, 2, 7} : all_ids()});
  detail::Random random(9);
  Frame floor, frame;
  camera.render({}, 0.0, floor);
  const core::Pose ours{0.95, 0.7, 0.4};  // drawn as the others are
  Looks looks(calibration);
  paint(looks, prints(tag36h11_create(), tag36h11_destroy, 8).back(), ours, 0.06, random, floor);
  int frames = 0;
  for (const Family& family : families()) {
    for (std::size_t first = 0; first < family.prints.size(); first += places) {
      frame = floor;
      frame.captured_at = 0.04 * frames++;
      const std::size_t last = std::min(family.prints.size(), first + places);
      for (std::size_t k = first; k < last; ++k)
        paint(looks, family.prints[k], place(static_cast<int>(k - first)), 0.06, random, frame);
      const auto& seen = detector.detect(frame);
      ASSERT_EQ(seen.size(), 1U) << family.name << " from " << first;
      EXPECT_EQ(seen[0].tag, 7);
      for (int again = 0; again < (test::sanitized ? 2 : 6); ++again) {  // the tracker looks part by part
        const auto& poses = tracker.process(frame);
        frame.captured_at = 0.04 * frames++;
        ASSERT_EQ(poses.size(), 1U) << family.name << " from " << first;
        EXPECT_EQ(poses[0].tag, 7);
        EXPECT_LT(core::distance(poses[0].pose, ours), 1e-3);
      }
    }
  }
}

TEST(FalseTags, TextureThatHappensToDecodeIsNoTag) {
  // Floors on which AprilTag 3.3 finds one by itself; 3.4.5 finds none on them.
  std::size_t by_itself = 0;
  for (const std::uint64_t floor : {1149, 1215}) {
    SyntheticCamera camera(overhead_calibration(2.0, 1.5), {}, floor);
    Frame frame;
    camera.render({}, 0.0, frame);
    TagDetector as_it_comes({.least_likeness = -1.0});
    by_itself += as_it_comes.detect(frame).size();
    TagDetector detector;
    EXPECT_EQ(detector.detect(frame).size(), 0U);
  }
  if (by_itself == 0) GTEST_SKIP() << "this AprilTag finds no tags where there are none";
  EXPECT_EQ(by_itself, 2U) << "or this test tests nothing";
}

TEST(FalseTags, TagsTooSmallForTheFitAreStillTags) {
  // 1.5 px a module: blur makes all tags alike, and what AprilTag decodes is all that there is to go by.
  Calibration calibration = overhead_calibration(2.0, 1.5);
  calibration.width /= 2;
  calibration.height /= 2;
  calibration.fx = calibration.fy = 0.5 * calibration.fx;
  calibration.cx = 0.5 * (calibration.width - 1);
  calibration.cy = 0.5 * (calibration.height - 1);
  calibration.tag_size = 0.04;
  SyntheticCamera camera(calibration, {}, 17);
  TagTracker tracker(calibration, {.tags = {0, 1, 2, 3, 4, 5}});
  Frame frame;
  int seen = 0;
  const int frames = test::sanitized ? 4 : 20;
  for (int k = 0; k < frames; ++k) {
    std::vector<SyntheticTag> tags;
    tags.reserve(6);
    for (int i = 0; i < 6; ++i)
      tags.push_back({i, {-0.8 + 0.3 * i + 0.003 * k, -0.4 + 0.15 * i, 0.1 * i + 0.02 * k}, 0.04});
    camera.render(tags, 0.04 * k, frame);
    for (const TagPose& pose : tracker.process(frame)) {
      EXPECT_LT(core::distance(pose.pose, tags[static_cast<std::size_t>(pose.tag)].pose), 3e-3);
      ++seen;
    }
  }
  EXPECT_GT(seen, 2 * frames);
}

constexpr int first_sights = test::sanitized ? 1 : 6;

/// Every frame is a tracker's first.
int wrong_at_first_sight(const std::string& name, const SceneOptions& options, double smear,
                         const std::function<void(detail::BenchMoment&, int)>& change, int& seen) {
  const auto scenes = detail::bench_scenes();
  const auto scene = std::find_if(scenes.begin(), scenes.end(), [&](const auto& s) { return s.name == name; });
  SyntheticCamera camera(scene->calibration, options, 3);
  TrackerOptions wanted;
  for (int i = 0; i < scene->tags; ++i) wanted.tags.push_back(i);
  int wrong = 0;
  Frame frame;
  for (int k = 0; k < first_sights; ++k) {
    detail::BenchMoment moment = scene->moment(15 * k);
    for (SyntheticTag& tag : moment.tags) tag.smear = smear;
    if (change) change(moment, k);
    camera.render(moment.tags, moment.discs, 0.0, frame);
    TagTracker tracker(scene->calibration, wanted);
    std::set<int> reported;
    for (const TagPose& pose : tracker.process(frame)) {
      const core::Pose& truth = moment.tags[static_cast<std::size_t>(pose.tag)].pose;
      wrong += core::distance(pose.pose, truth) > 2e-3 ||
               std::abs(core::wrap_angle(pose.pose.theta - truth.theta)) > 2.0 * core::pi / 180.0 ||
               !reported.insert(pose.tag).second;
      ++seen;
    }
  }
  return wrong;
}

TEST(FalseTags, NothingWrongAtFirstSight) {
  const SceneOptions light;
  const SceneOptions dim{.noise_sigma = 6.0, .brightness = 0.2};
  const auto fingers = [](detail::BenchMoment& m, int k) {
    for (std::size_t i = 0; i < m.tags.size(); ++i) {
      const core::Pose& pose = m.tags[i].pose;
      const double aside = 0.048 - 0.007 * k;
      m.discs.push_back({pose.x + aside * std::cos(0.4 * static_cast<double>(i)),
                         pose.y + aside * std::sin(0.4 * static_cast<double>(i)), 0.012, 0.06,
                         i % 3 == 0   ? 20.0
                         : i % 3 == 1 ? 120.0
                                      : 230.0,
                         0.0});
    }
  };
  const auto lamps = [](detail::BenchMoment& m, int k) {
    for (std::size_t i = 0; i < m.tags.size(); i += 2) {
      const core::Pose& pose = m.tags[i].pose;
      m.discs.push_back({pose.x + 0.06 - 0.016 * k, pose.y + 0.01, 0.06, 0.06, 255.0, 0.05});
    }
  };
  struct Case {
    const char* what;
    SceneOptions options;
    double smear;
    std::function<void(detail::BenchMoment&, int)> change;
    int least_seen;
  };
  const double px = 0.06 / 38.4;
  const Case cases[] = {{"fingers", light, 0.0, fingers, 5},
                        {"lamps", light, 0.0, lamps, 10},
                        {"blur of 5 px", light, 5.0 * px, {}, 30},
                        {"blur of 12 px", light, 12.0 * px, {}, 0},
                        {"fingers in dim light, blurred", dim, 4.0 * px, fingers, 0},
                        {"lamps, blurred", light, 5.0 * px, lamps, 5}};
  for (const Case& one : cases) {
    for (const char* scene : {"n=16", "640x480"}) {
      int seen = 0;
      EXPECT_EQ(wrong_at_first_sight(scene, one.options, one.smear, one.change, seen), 0) << one.what << ", " << scene;
      if (std::string(scene) == "n=16") {
        EXPECT_GE(seen, one.least_seen * first_sights / 6) << one.what;
      }
    }
  }
}

}  // namespace
}  // namespace skein::vision
