// Each reason for which a tag is not reported, made and told apart from the others.
#include "vision/diagnosis/diagnosis.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard52h13.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include "tests/vision/support.h"
#include "vision/modules/media_loader.h"
#include "vision/synthetic/synthetic_camera.h"
#include "vision/tracker/tracker.h"

namespace skein::vision {
namespace {

/// A camera that is calibrated for 60 mm tags, and what it shows.
struct DiagnosisLab {
  Calibration calibration = overhead_calibration(2.0, 1.5);
  Frame frame;

  DiagnosisLab() { calibration.tag_size = 0.06; }
  void show(const std::vector<SyntheticTag>& tags, const SceneOptions& scene = {}) {
    SyntheticCamera(calibration, scene, 5).render(tags, 0.0, frame);
  }
  TagDiagnosis diagnosis(const MissingTag& missing = {3, {}}) const {
    return diagnose(frame, calibration, std::vector{missing}).front();
  }
  std::string said() const { return sentence(diagnosis(), calibration); }
  /// What the tracker makes of the frame.
  bool tracked() const { return !TagTracker(calibration, {.tags = {3}}).process(frame).empty(); }
};

TEST(Diagnosis, WrongSizeIsSaidInMillimetres) {
  DiagnosisLab lab;
  lab.show({{3, {0.3, -0.2, 0.4}, 0.04}});
  ASSERT_FALSE(lab.tracked());
  const TagDiagnosis found = lab.diagnosis();
  EXPECT_EQ(found.why, NotSeen::wrong_size);
  EXPECT_NEAR(found.size, 0.04, 0.001);
  EXPECT_TRUE(lab.said().starts_with("tag 3 is there, but its edge is 40 mm, 33 % smaller than [tags] size 60 mm"))
      << lab.said();
  const auto middle = pixel_from_world(lab.calibration, {0.3, -0.2, lab.calibration.tag_height});
  ASSERT_EQ(found.crops.size(), 1U);
  const Window& crop = found.crops.front();
  EXPECT_GT(middle->x(), crop.left);
  EXPECT_LT(middle->x(), crop.left + crop.width);
  EXPECT_GT(middle->y(), crop.top);
  EXPECT_LT(middle->y(), crop.top + crop.height);
}

/// The tracker takes sizes that differ by less than about 5 %. At its limit a tag that is all there was called covered.
TEST(Diagnosis, ASizeAtTheTrackersLimitIsNoCover) {
  DiagnosisLab lab;
  lab.calibration.tag_size = 0.04;
  int not_taken = 0;
  for (const double size : {0.0374, 0.0376, 0.0378, 0.038, 0.042, 0.0422, 0.0424}) {
    lab.show({{3, {0.3, -0.2, 0.4}, size}});
    if (lab.tracked()) continue;
    ++not_taken;
    EXPECT_EQ(lab.diagnosis().why, NotSeen::wrong_size) << size << ": " << lab.said();
  }
  EXPECT_GE(not_taken, 3);
}

/// Where the others have the size that the calibration says, the calibration is not what must be corrected.
TEST(Diagnosis, OneTagOfAnotherSizeThanTheOthersIsToBePrintedAnew) {
  DiagnosisLab lab;
  const std::vector<SyntheticTag> others{{1, {-0.4, 0.3, 1.0}, 0.06}, {2, {-0.2, -0.5, 2.0}, 0.06}};
  const auto with = [&](double size) {
    std::vector<SyntheticTag> tags = others;
    tags.push_back({3, {0.3, -0.2, 0.4}, size});
    lab.show(tags);
    return lab.said();
  };
  EXPECT_EQ(with(0.054),
            "tag 3 is there, but its edge is 54 mm, 10 % smaller than [tags] size 60 mm, which fits the other tags: "
            "print it anew");
  EXPECT_EQ(with(0.066),
            "tag 3 is there, but its edge is 66 mm, 10 % larger than [tags] size 60 mm, which fits the other tags: "
            "print it anew, or put its robot down if it is held up");
}

/// A camera whose pixels are wider than the calibration says sees each tag as if it were tilted.
TEST(Diagnosis, ATagThatIsTiltedALittleIsNoCoveredOne) {
  DiagnosisLab lab;
  lab.calibration.tag_size = 0.04;
  int not_taken = 0;
  for (const double degrees : {20.0, 20.5, 21.0, 25.0}) {
    Calibration squeezed = lab.calibration;
    squeezed.fx *= std::cos(degrees * core::pi / 180.0);
    const core::Pose middle{0.0, 0.0, 0.8};
    SyntheticCamera(squeezed, {}, 5).render(std::vector{SyntheticTag{3, middle, 0.04}}, 0.0, lab.frame);
    if (lab.tracked()) continue;
    ++not_taken;
    EXPECT_EQ(lab.diagnosis().why, NotSeen::tilted) << degrees << ": " << lab.said();
  }
  EXPECT_GE(not_taken, 3);
}

/// AprilTag takes the cover's edge for the tag's, so that the tag seems no square.
TEST(Diagnosis, ATagOfWhichTheEdgeIsCoveredIsNoTiltedOne) {
  DiagnosisLab lab;
  int covered = 0;
  for (int id = 4; id < 7; ++id)
    for (const double part : {0.02, 0.1}) {
      lab.show({{id, {0.0, 0.0, 0.0}, 0.06}}, {.noise_sigma = 2.0});
      const auto at = pixel_from_world(lab.calibration, {0.0, 0.0, lab.calibration.tag_height});
      const double edge = tag_edge_px(lab.calibration), paper = 0.62 * edge;
      const int to = static_cast<int>(at->x() - (0.5 - part) * edge);
      for (int v = static_cast<int>(at->y() - paper); v < static_cast<int>(at->y() + paper); ++v)
        for (int u = static_cast<int>(at->x() - paper); u < to; ++u) lab.frame.row(v)[u] = 76;
      const TagDiagnosis found = lab.diagnosis({id, {}});
      EXPECT_NE(found.why, NotSeen::tilted) << id << ' ' << part;
      covered += found.why == NotSeen::covered ? 1 : 0;
    }
  EXPECT_GE(covered, 1);
}

TEST(Diagnosis, APictureShowsTheTagOrWhereItWasLastSeen) {
  DiagnosisLab lab;
  // A picture is of the tag if the tag can be read in it.
  const auto reads = [&](const Frame& picture) {
    std::vector<int> ids;
    TagDetector detector;
    for (const Detection& seen : detector.detect(picture)) ids.push_back(seen.tag);
    return ids;
  };
  lab.show({{3, {0.3, -0.2, 0.4}, 0.04}, {1, {-0.4, 0.3, 1.0}, 0.06}});
  EXPECT_EQ(reads(picture_of(lab.frame, lab.diagnosis())), std::vector{3}) << "of another size";
  EXPECT_EQ(picture_of(lab.frame, lab.diagnosis({4, {}})).width, 0) << "the control: nobody knows where to look";
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}, {3, {-0.5, 0.1, 2.0}, 0.06}});
  EXPECT_EQ(reads(picture_of(lab.frame, lab.diagnosis())), (std::vector{3, 3})) << "twice: both places";
  lab.show({{5, {0.3, -0.2, 0.4}, 0.06}});
  const Frame there = picture_of(lab.frame, lab.diagnosis({3, core::Pose{0.3, -0.2, 0.0}}));
  EXPECT_EQ(reads(there), std::vector{5}) << "what lies where it was last seen";
  const Frame corner = picture_of(lab.frame, lab.diagnosis({3, core::Pose{-1.05, 0.0, 0.0}}));
  EXPECT_GT(corner.width, 0);
  EXPECT_LT(corner.width, there.width) << "the border of the frame cuts it";
}

TEST(Diagnosis, LargerTagToo) {
  DiagnosisLab lab;
  lab.calibration.tag_size = 0.04;
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}});
  ASSERT_FALSE(lab.tracked());
  EXPECT_NE(lab.said().find("its edge is 60 mm, 50 % larger than [tags] size 40 mm"), std::string::npos) << lab.said();
}

TEST(Diagnosis, ARobotThatIsHeldUp) {
  DiagnosisLab lab;
  SyntheticTag lifted{3, {0.3, -0.2, 0.4}, 0.06};
  lifted.lifted = 0.04;
  lab.show({lifted, {1, {-0.4, 0.3, 1.0}, 0.06}, {2, {-0.2, -0.5, 2.0}, 0.06}});
  const TagDiagnosis found = lab.diagnosis();
  EXPECT_EQ(found.why, NotSeen::lifted);
  EXPECT_NEAR(found.above, 0.04, 0.012);
  EXPECT_NE(lab.said().find("mm above them, or printed"), std::string::npos) << lab.said();
  // Controls: on the floor it is not, and nobody knows where there is nothing to compare it with.
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}, {1, {-0.4, 0.3, 1.0}, 0.06}, {2, {-0.2, -0.5, 2.0}, 0.06}});
  EXPECT_NE(lab.diagnosis().why, NotSeen::lifted);
  lab.show({lifted});
  EXPECT_NE(lab.diagnosis().why, NotSeen::lifted);
}

/// Printers scale: one picture cannot tell such a tag from one that is nearer to the camera, so that both are said.
TEST(Diagnosis, ATagThatIsPrintedLargerThanTheOthers) {
  DiagnosisLab lab;
  lab.show({{3, {0.3, -0.2, 0.4}, 0.0624}, {1, {-0.4, 0.3, 1.0}, 0.06}, {2, {-0.2, -0.5, 2.0}, 0.06}});
  const TagDiagnosis found = lab.diagnosis();
  ASSERT_EQ(found.why, NotSeen::lifted) << lab.said();
  EXPECT_NEAR(found.printed, 0.0624, 0.0006);
  EXPECT_NE(lab.said().find("or printed about 4 % too large."), std::string::npos) << lab.said();
}

TEST(Diagnosis, TwoRobotsWithOneTag) {
  DiagnosisLab lab;
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}, {3, {-0.5, 0.1, 2.0}, 0.06}});
  ASSERT_FALSE(lab.tracked());
  EXPECT_EQ(lab.diagnosis().why, NotSeen::doubled);
  EXPECT_NE(lab.said().find("twice"), std::string::npos) << lab.said();
  EXPECT_NE(lab.said().find("(0.30, -0.20) m"), std::string::npos) << lab.said();
  EXPECT_NE(lab.said().find("(-0.50, 0.10) m"), std::string::npos) << lab.said();
}

TEST(Diagnosis, MirroredFrames) {
  DiagnosisLab lab;
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}});
  for (int v = 0; v < lab.frame.height; ++v) std::reverse(lab.frame.row(v), lab.frame.row(v) + lab.frame.width);
  ASSERT_FALSE(lab.tracked());
  EXPECT_EQ(lab.diagnosis().why, NotSeen::mirrored);
  EXPECT_EQ(why_no_tag(lab.frame), "tag 3 is mirrored: switch the camera's mirror off");
}

TEST(Diagnosis, TagThatTheBorderCuts) {
  DiagnosisLab lab;
  lab.show({});
  const core::Pose out = {-1.02, 0.0, 0.0};
  const auto at = pixel_from_world(lab.calibration, {out.x, out.y, lab.calibration.tag_height});
  ASSERT_LT(at->x(), 60.0);
  EXPECT_EQ(lab.diagnosis({3, out}).why, NotSeen::at_border);
  EXPECT_EQ(lab.diagnosis({3, core::Pose{0.0, 0.0, 0.0}}).why, NotSeen::not_found);
}

TEST(Diagnosis, ATagThatTheBorderCutsIsKnownThoughNobodyHasSeenItBefore) {
  DiagnosisLab lab;
  const double bottom = lab.calibration.height - 1.0;
  const auto at = world_from_pixel(lab.calibration, {400.0, bottom - 4.0}, lab.calibration.tag_height);
  lab.show({{3, {at->x(), at->y(), 0.4}, 0.06}, {4, {0.2, 0.1, 0.5}, 0.06}});
  ASSERT_FALSE(lab.tracked());
  const std::vector<TagDiagnosis> found =
      diagnose(lab.frame, lab.calibration, std::vector{MissingTag{3, {}}, MissingTag{5, {}}});
  EXPECT_EQ(sentence(found[0], lab.calibration), "the border of the picture cuts tag 3: move the robot inwards");
  ASSERT_EQ(found[0].places.size(), 1U);
  EXPECT_LT((found[0].places[0] - *at).norm(), 0.002);
  const Frame part = picture_of(lab.frame, found[0]);
  EXPECT_GT(part.width, 0);
  EXPECT_LT(part.height, part.width) << "what is left of it";
  EXPECT_EQ(found[1].why, NotSeen::not_found) << "another one is not there";
}

TEST(Diagnosis, TooLittleAndTooMuchLight) {
  DiagnosisLab lab;
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}}, {.noise_sigma = 1.0, .brightness = 0.02});
  ASSERT_FALSE(lab.tracked());
  EXPECT_EQ(lab.diagnosis().why, NotSeen::in_shadow);
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}}, {.brightness = 20.0});
  ASSERT_FALSE(lab.tracked());
  EXPECT_EQ(lab.diagnosis().why, NotSeen::too_bright);
}

/// White that spills over the ink's edges makes a tag smaller, which is no fault of its print.
TEST(Diagnosis, ATagThatTheLightMakesSmallerIsNotOfAnotherSize) {
  DiagnosisLab lab;
  int smaller = 0;
  for (const double brightness : {2.0, 3.0, 4.0, 6.0, 8.0, 12.0}) {
    lab.show({{3, {0.3, -0.2, 0.4}, 0.06}}, {.blur_px = 1.5, .brightness = brightness});
    if (lab.tracked()) continue;
    const TagDiagnosis found = lab.diagnosis();
    smaller += found.size > 0.0 && found.size < 0.97 * lab.calibration.tag_size ? 1 : 0;
    EXPECT_EQ(found.why, NotSeen::too_bright) << brightness << ": " << lab.said();
  }
  EXPECT_GE(smaller, 1);
  // The control: it is, in the same light.
  lab.show({{3, {0.3, -0.2, 0.4}, 0.08}}, {.brightness = 3.0});
  EXPECT_EQ(lab.diagnosis().why, NotSeen::wrong_size) << lab.said();
}

TEST(Diagnosis, TagsWithTooFewPixels) {
  DiagnosisLab lab;
  lab.calibration.tag_size = 0.012;
  lab.show({{3, {0.3, -0.2, 0.4}, 0.012}});
  ASSERT_FALSE(lab.tracked());
  EXPECT_EQ(lab.diagnosis().why, NotSeen::too_small);
  EXPECT_NE(lab.said().find("12 mm has 7."), std::string::npos) << lab.said();
}

TEST(Diagnosis, TagOfAnotherFamily) {
  DiagnosisLab lab;
  lab.show({});
  apriltag_family_t* family = tag25h9_create();
  image_u8_t* picture = apriltag_to_image(family, 3);
  constexpr int cell = 5;  // [px]
  for (int v = 0; v < picture->height * cell; ++v)
    for (int u = 0; u < picture->width * cell; ++u)
      lab.frame.row(400 + v)[600 + u] = picture->buf[v / cell * picture->stride + u / cell] > 127 ? 220 : 30;
  std::free(picture->buf);  // image_u8_destroy, which Debian's library does not export
  std::free(picture);
  tag25h9_destroy(family);
  ASSERT_FALSE(lab.tracked());
  EXPECT_EQ(lab.diagnosis().why, NotSeen::other_family);
  EXPECT_EQ(lab.said(), "tag 3 looks like 3 of the family 25h9: print it anew in 36h11");
  EXPECT_EQ(why_no_tag(lab.frame), "no tag is of the family 36h11, but 1 looks like 25h9 (3): print it anew in 36h11");
  lab.show({});
  EXPECT_EQ(why_no_tag(lab.frame), "") << "the control: a floor with clutter";
}

TEST(Diagnosis, TagsOfAprilTagsNewerFamilies) {
  const std::initializer_list<std::tuple<apriltag_family_t* (*)(), void (*)(apriltag_family_t*), std::string>> newer = {
      {tagStandard52h13_create, tagStandard52h13_destroy, "Standard52h13"},
      {tagCircle21h7_create, tagCircle21h7_destroy, "Circle21h7"},
      {tagCircle49h12_create, tagCircle49h12_destroy, "Circle49h12"},
      {tagCustom48h12_create, tagCustom48h12_destroy, "Custom48h12"}};
  for (const auto& [create, destroy, name] : newer) {
    DiagnosisLab lab;
    lab.show({});
    apriltag_family_t* family = create();
    image_u8_t* picture = apriltag_to_image(family, 3);
    constexpr int cell = 8;  // [px]
    for (int v = 0; v < picture->height * cell; ++v)
      for (int u = 0; u < picture->width * cell; ++u)
        lab.frame.row(400 + v)[600 + u] = picture->buf[v / cell * picture->stride + u / cell] > 127 ? 220 : 30;
    std::free(picture->buf);
    std::free(picture);
    destroy(family);
    EXPECT_EQ(lab.said(), "tag 3 looks like 3 of the family " + name + ": print it anew in 36h11");
  }
}

TEST(Diagnosis, MarkersOfArUco) {
  const auto module = boards();
  ASSERT_TRUE(module) << module.error();
  for (const int bits : {4, 5, 6, 7}) {
    DiagnosisLab lab;
    const auto print = [&](int id, int left) {
      constexpr int cell = 6, top = 400;  // [px]
      const std::vector<bool> ink = (*module)->marker(bits, id);
      const int cells = bits + 2, border = cell;
      for (int v = -border; v < cells * cell + border; ++v)
        for (int u = -border; u < cells * cell + border; ++u) {
          const bool on_paper = v < 0 || u < 0 || v >= cells * cell || u >= cells * cell;
          const int row = v / cell, column = u / cell, place = row * cells + column;
          const bool black = !on_paper && ink[static_cast<std::size_t>(place)];
          lab.frame.row(top + v)[left + u] = black ? 30 : 220;
        }
    };
    lab.show({});
    print(3, 600);
    const std::string name = fmt::format("ArUco {0}x{0}", bits);
    EXPECT_EQ(why_no_tag(lab.frame),
              "no tag is of the family 36h11, but 1 looks like " + name + " (3): print it anew in 36h11");
    print(17, 300);
    EXPECT_EQ(why_no_tag(lab.frame),
              "no tag is of the family 36h11, but 2 look like " + name + " (3, 17): print them anew in 36h11");
    EXPECT_EQ(lab.said(), "tag 3 looks like 3 of the family " + name + ": print it anew in 36h11");
    EXPECT_NEAR(picture_of(lab.frame, lab.diagnosis()).width, 2 * (bits + 2) * 6, 6) << "twice the marker's edge [px]";
    // Controls: not where a run has seen the tag, and not beside a tag of 36h11.
    EXPECT_EQ(lab.diagnosis({3, core::Pose{0.0, 0.0, 0.0}}).why, NotSeen::not_found);
    lab.show({{1, {-0.4, 0.3, 1.0}, 0.06}});
    print(3, 600);
    EXPECT_EQ(lab.diagnosis().why, NotSeen::not_found);
  }
}

TEST(Diagnosis, ATagInADarkOrOverexposedPictureLacksLight) {
  DiagnosisLab lab;
  // AprilTag reads the tag, but the tracker does not accept it.
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}}, {.noise_sigma = 1.0, .brightness = 0.06});
  ASSERT_FALSE(lab.tracked());
  EXPECT_EQ(lab.diagnosis().why, NotSeen::in_shadow);
  EXPECT_EQ(lab.said(), "tag 3 is there, but the picture is dark: raise the exposure");
  // The control: in a picture that has light enough, a tag that is not accepted is covered.
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}});
  const auto middle = pixel_from_world(lab.calibration, {0.3, -0.2, lab.calibration.tag_height});
  for (int v = 0; v < lab.frame.height; ++v)
    for (int u = 0; u < lab.frame.width; ++u)
      if (std::hypot(u - middle->x(), v - middle->y()) < 9.0) lab.frame.row(v)[u] = 128;
  EXPECT_NE(lab.diagnosis().why, NotSeen::in_shadow);
}

TEST(Diagnosis, ATagInNegative) {
  DiagnosisLab lab;
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}});
  for (std::uint8_t& grey : lab.frame.grey) grey = static_cast<std::uint8_t>(255 - grey);
  ASSERT_FALSE(lab.tracked());
  EXPECT_EQ(lab.diagnosis().why, NotSeen::other_family);
  EXPECT_NE(lab.said().find("tag 3 is there, but in negative"), std::string::npos) << lab.said();
  EXPECT_NEAR(lab.diagnosis().places.front().x(), 0.3, 0.003);
  EXPECT_EQ(why_no_tag(lab.frame),
            "tag 3 is in negative, black and white exchanged: switch the camera's negative effect off, or print "
            "anew");
}

TEST(Diagnosis, ABlurredPicture) {
  DiagnosisLab lab;
  for (const double noise : {1.0, 8.0}) {
    lab.show({{3, {0.3, -0.2, 0.4}, 0.06}}, {.noise_sigma = noise, .blur_px = 4.0});
    ASSERT_FALSE(lab.tracked());
    EXPECT_EQ(lab.diagnosis().why, NotSeen::blurred) << noise;
    // The control: the same floor in focus, without the tag.
    lab.show({}, {.noise_sigma = noise});
    EXPECT_EQ(lab.diagnosis().why, NotSeen::not_found) << noise;
  }
  lab.show({{3, {0.3, -0.2, 0.4}, 0.06}}, {.blur_px = 4.0});
  EXPECT_EQ(lab.said(),
            "no tag 3 is found, and the picture is blurred (its edges are 6.9 px wide, those of a sharp one 2 to 3): "
            "turn the lens's focus, or shorten the exposure");
  EXPECT_TRUE(why_no_tag(lab.frame).starts_with("the picture is blurred")) << why_no_tag(lab.frame);
}

/// AprilTag finds no square where a part of the black one is hidden. Nobody has seen these tags before.
TEST(Diagnosis, ATagOfWhichHalfIsCoveredIsThere) {
  DiagnosisLab lab;
  int covered = 0, asked = 0;
  const int last = test::sanitized ? 5 : 9;
  for (int id = 4; id <= last; ++id) {
    const core::Pose at{0.1 * id - 0.6, 0.3 - 0.1 * id, 1.1 * id};
    const double beside = at.theta + (id % 4) * 0.5 * core::pi;
    lab.show({{id, at, 0.06}, {1, {0.7, 0.5, 1.0}, 0.06}}, {.noise_sigma = 2.0});
    ASSERT_EQ(lab.diagnosis({3, {}}).why, NotSeen::not_found) << "the control: another tag is nowhere";
    // An arm over the tag, with an edge that runs through its middle.
    for (int v = 0; v < lab.frame.height; ++v)
      for (int u = 0; u < lab.frame.width; ++u) {
        const auto world = world_from_pixel(lab.calibration, {1.0 * u, 1.0 * v}, lab.calibration.tag_height);
        const double x = world->x() - at.x, y = world->y() - at.y;
        const double across = x * std::cos(beside) + y * std::sin(beside);
        if (across > 0.002 && std::hypot(x, y) < 0.08) lab.frame.row(v)[u] = 90;
      }
    ASSERT_TRUE(TagTracker(lab.calibration, {.tags = {id}}).process(lab.frame).empty());
    const TagDiagnosis found = lab.diagnosis({id, {}});
    const core::Pose before{at.x - 0.06, at.y + 0.04, at.theta};
    EXPECT_EQ(lab.diagnosis({id, before}).why, found.why) << "of a robot that was seen, it is looked for near there";
    ++asked;
    if (found.why != NotSeen::covered) continue;
    ++covered;
    EXPECT_EQ(sentence(found, lab.calibration),
              fmt::format("tag {} is there, but part of it is covered or blurred", id));
    EXPECT_LT((found.places.at(0) - Eigen::Vector2d(at.x, at.y)).norm(), 0.003);
    EXPECT_EQ(lab.diagnosis({3, {}}).why, NotSeen::not_found) << "the control: another tag is nowhere";
  }
  EXPECT_GE(covered, asked - 1);
}

TEST(Diagnosis, ATagOfWhichHalfIsInGlareIsThere) {
  DiagnosisLab lab;
  for (const double theta : {0.4, 2.0, 4.0}) {
    lab.show({{3, {0.3, -0.2, theta}, 0.06}, {1, {0.7, 0.5, 1.0}, 0.06}}, {.noise_sigma = 2.0});
    for (int v = 0; v < lab.frame.height; ++v)
      for (int u = 0; u < lab.frame.width; ++u) {
        const auto world = world_from_pixel(lab.calibration, {1.0 * u, 1.0 * v}, lab.calibration.tag_height);
        const double x = world->x() - 0.3, y = world->y() + 0.2;
        const double across = x * std::cos(theta) + y * std::sin(theta);
        if (across > 0.002 && std::hypot(x, y) < 0.08) lab.frame.row(v)[u] = 255;
      }
    ASSERT_FALSE(lab.tracked());
    EXPECT_EQ(lab.said(),
              "tag 3 is there, but the reflection of a lamp lies on a part of it: move the lamp, or print the tag on "
              "matt paper");
  }
}

/// Of tags that were never seen, the search takes longest: nobody waits with them for what is known at once.
TEST(Diagnosis, WhatIsKnownAtOnceIsGivenBeforeTagsAreLookedForEverywhere) {
  DiagnosisLab lab;
  const core::Pose at{0.3, -0.2, 0.4};
  lab.show({{3, at, 0.04}, {5, {-0.3, 0.2, 0.0}, 0.06}, {1, {0.7, 0.5, 1.0}, 0.06}}, {.noise_sigma = 2.0});
  for (int v = 0; v < lab.frame.height; ++v)
    for (int u = 0; u < lab.frame.width; ++u) {
      const auto world = world_from_pixel(lab.calibration, {1.0 * u, 1.0 * v}, lab.calibration.tag_height);
      if (world->x() > -0.298 && std::hypot(world->x() + 0.3, world->y() - 0.2) < 0.08) lab.frame.row(v)[u] = 90;
    }
  std::vector<std::vector<NotSeen>> given;
  const auto why = [](const std::vector<TagDiagnosis>& tags) {
    std::vector<NotSeen> all;
    for (const TagDiagnosis& tag : tags) all.push_back(tag.why);
    return all;
  };
  const auto so_far = [&](const std::vector<TagDiagnosis>& tags) { given.push_back(why(tags)); };
  const auto all = diagnose(lab.frame, lab.calibration, std::array<MissingTag, 2>{{{3}, {5}}}, so_far);
  EXPECT_EQ(why(all), (std::vector{NotSeen::wrong_size, NotSeen::covered}));
  EXPECT_EQ(given, (std::vector<std::vector<NotSeen>>{{NotSeen::wrong_size, NotSeen::not_found}})) << "once";
  std::stop_source ended;
  ended.request_stop();
  EXPECT_EQ(why(diagnose(lab.frame, lab.calibration, std::array<MissingTag, 2>{{{3}, {5}}}, {}, ended.get_token())),
            given[0])
      << "the end of a run does not wait for it";
  given.clear();
  diagnose(lab.frame, lab.calibration, std::array<MissingTag, 1>{{{3}}}, so_far);
  EXPECT_TRUE(given.empty()) << "the control: nothing is looked for everywhere";
}

TEST(Diagnosis, EmptyFloorHasNoTag) {
  DiagnosisLab lab;
  lab.show({});
  EXPECT_EQ(lab.diagnosis().why, NotSeen::not_found);
  EXPECT_EQ(lab.said(), "no tag 3 is in the picture");
}

}  // namespace
}  // namespace skein::vision
