// The world frame from marks on the floor, through the synthetic camera.
#include "vision/calibrate/floor_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include "tests/vision/support.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::vision {
namespace {

/// A source of a few frames that somebody drew.
class Drawn final : public FrameSource {
 public:
  explicit Drawn(std::vector<Frame> frames) : frames_(std::move(frames)) {}
  tl::expected<bool, std::string> read(Frame& frame) override {
    if (next_ == frames_.size()) return false;
    frame = frames_[next_++];
    return true;
  }
  TimeStamps stamps() const override { return TimeStamps::nominal; }
  std::string describe() const override { return "drawn"; }

 private:
  std::vector<Frame> frames_;
  std::size_t next_ = 0;
};

/// A camera over the arena, and tags that lie on its floor.
struct Lab {
  Calibration truth = overhead_calibration(2.0, 1.5);
  std::vector<FloorMark> marks;
  std::vector<SyntheticTag> tags;

  Lab() {
    truth.tag_height = 0.0;
    truth.tag_size = 0.08;
    int id = 0;
    for (const double x : {-0.8, 0.0, 0.8})
      for (const double y : {-0.6, 0.05, 0.6}) {
        tags.push_back({id, {x, y, 0.3 * id}, truth.tag_size});
        FloorMark mark;
        mark.name = "tag " + std::to_string(id);
        mark.tag = id++;
        mark.x = x;
        mark.y = y;
        marks.push_back(mark);
      }
  }
  Drawn film(int frames) const {
    SyntheticCamera camera(truth, {.body_radius = 0.0}, 5);
    std::vector<Frame> drawn(static_cast<std::size_t>(frames));
    for (Frame& frame : drawn) camera.render(tags, 0.0, frame);
    return Drawn(std::move(drawn));
  }
  Calibration intrinsics() const {
    Calibration c = truth;
    c.world_from_camera.reset();
    return c;
  }
};

TEST(FloorCalibration, FindsWhereTheCameraHangs) {
  Lab lab;
  Drawn film = lab.film(3);
  const auto sight = look_at_floor(film, lab.intrinsics(), 10);
  ASSERT_TRUE(sight) << sight.error();
  EXPECT_EQ(sight->frames, 3);
  enter(*sight, lab.marks);
  for (const FloorMark& mark : lab.marks) EXPECT_TRUE(mark.seen) << mark.name;
  const auto solved = solve_floor(lab.intrinsics(), lab.marks);
  ASSERT_TRUE(solved) << solved.error();
  const CameraPose& pose = *solved->world_from_camera;
  EXPECT_LT((pose.position - lab.truth.world_from_camera->position).norm(), 2e-3);
  EXPECT_LT((pose.rotation - lab.truth.world_from_camera->rotation).norm(), 2e-3);
  const auto check = check_floor(*solved, lab.marks);
  ASSERT_TRUE(check) << check.error();
  EXPECT_EQ(check->residuals.size(), 9U);
  EXPECT_LT(check->rms, 0.1e-3);
  EXPECT_EQ(suspect(lab.intrinsics(), lab.marks), nullptr);
}

TEST(FloorCalibration, SaysWhyNoTagIsSeen) {
  const Lab lab;
  Frame frame;
  SyntheticCamera(lab.truth).render(lab.tags, 0.0, frame);
  Drawn upright({frame});
  EXPECT_EQ(look_at_floor(upright, lab.intrinsics(), 1).value().why_no_tag, "") << "the control";
  for (int v = 0; v < frame.height; ++v)
    std::reverse(frame.grey.begin() + v * frame.width, frame.grey.begin() + (v + 1) * frame.width);
  Drawn mirrored({frame});
  const auto sight = look_at_floor(mirrored, lab.intrinsics(), 1);
  ASSERT_TRUE(sight) << sight.error();
  EXPECT_TRUE(sight->why_no_tag.ends_with("are mirrored: switch the camera's mirror off")) << sight->why_no_tag;
}

TEST(FloorCalibration, NamesTheMarkThatWasMeasuredWrongly) {
  Lab lab;
  Drawn film = lab.film(1);
  enter(look_at_floor(film, lab.intrinsics(), 1).value(), lab.marks);
  lab.marks[4].x += 0.02;
  const FloorMark* odd = suspect(lab.intrinsics(), lab.marks);
  ASSERT_NE(odd, nullptr);
  EXPECT_EQ(odd->name, "tag 4");
}

TEST(FloorCalibration, LeavesAWrongMarkOut) {
  Lab lab;
  Drawn film = lab.film(1);
  enter(look_at_floor(film, lab.intrinsics(), 1).value(), lab.marks);
  const auto right = solve_trusted_floor(lab.intrinsics(), lab.marks);
  ASSERT_TRUE(right) << right.error();
  EXPECT_EQ(right->left_out, nullptr);
  lab.marks[0].x += 0.03;
  const Eigen::Vector3d truth = lab.truth.world_from_camera->position;
  const auto spoilt = solve_floor(lab.intrinsics(), lab.marks);
  ASSERT_TRUE(spoilt);
  EXPECT_GT((spoilt->world_from_camera->position - truth).norm(), 5e-3) << "the control: with the wrong mark";
  const auto solved = solve_trusted_floor(lab.intrinsics(), lab.marks);
  ASSERT_TRUE(solved) << solved.error();
  ASSERT_NE(solved->left_out, nullptr);
  EXPECT_EQ(solved->left_out->name, "tag 0");
  EXPECT_NEAR(solved->off, 0.03, 1e-3);
  EXPECT_LT((solved->calibration.world_from_camera->position - truth).norm(), 2e-3);
  const auto with_all = check_floor(solved->calibration, lab.marks);
  const auto check = check_floor(solved->calibration, lab.marks, solved->left_out);
  ASSERT_TRUE(with_all && check);
  EXPECT_GT(with_all->worst, 0.029) << "the control";
  EXPECT_EQ(check->residuals.size(), lab.marks.size());
  EXPECT_EQ(check->marks, lab.marks.size() - 1);
  EXPECT_LT(check->worst, 2e-3);
  EXPECT_LE(check->rms, check->worst);
}

TEST(FloorCalibration, KeepsTheMarksThatItWentByWithTheirSizes) {
  Lab lab;
  Drawn film = lab.film(2);
  const FloorSight sight = look_at_floor(film, lab.intrinsics(), 2).value();
  enter(sight, lab.marks);
  lab.marks[0].x += 0.03;
  const auto solved = solve_trusted_floor(lab.intrinsics(), lab.marks);
  ASSERT_TRUE(solved) << solved.error();
  const std::vector<FloorMark> kept = kept_marks(*solved, lab.marks, sight);
  ASSERT_EQ(kept.size(), 8U);
  EXPECT_EQ(kept.front().tag, 1) << "without the wrong one";
  for (const FloorMark& mark : kept) {
    EXPECT_TRUE(mark.seen);
    EXPECT_NEAR(mark.size, 0.08, 0.5e-3);
  }
}

TEST(FloorCalibration, SaysHowFarPosesMove) {
  Lab lab;
  Calibration after = tilted(lab.truth, 1.0);
  after.marks = lab.marks;
  EXPECT_FALSE(pose_shift(lab.intrinsics(), after)) << "there was nothing before";
  const auto shift = pose_shift(lab.truth, after);
  ASSERT_TRUE(shift);
  EXPECT_STREQ(shift->places[0].name, "centre");
  EXPECT_NEAR(shift->places[0].x, 0.0, 1e-12);
  EXPECT_NEAR(shift->places[3].x, -0.8, 1e-12);
  EXPECT_NEAR(shift->places[3].y, 0.6, 1e-12);
  const double way = lab.truth.world_from_camera->position.z() * std::tan(std::numbers::pi / 180.0);
  EXPECT_NEAR(std::hypot(shift->places[0].dx, shift->places[0].dy), way, 0.02 * way);
  EXPECT_NEAR(shift->rms, way, 0.1 * way);
  Calibration same = lab.truth;
  same.marks = lab.marks;
  EXPECT_LT(pose_shift(lab.truth, same)->rms, 1e-9);
}

TEST(FloorCalibration, RefusesMarksThatDisagree) {
  Lab lab;
  Drawn film = lab.film(1);
  enter(look_at_floor(film, lab.intrinsics(), 1).value(), lab.marks);
  for (const std::size_t i : {1U, 4U, 6U}) lab.marks[i].y += i == 4U ? -0.05 : 0.05;
  const auto solved = solve_trusted_floor(lab.intrinsics(), lab.marks);
  ASSERT_FALSE(solved);
  EXPECT_NE(solved.error().find("the marks disagree by up to"), std::string::npos) << solved.error();
}

/// Two tags laid in one another's place, or their numbers typed in the wrong order: only "off by 6103 mm" was said.
TEST(FloorCalibration, NamesTwoMarksThatAreSwapped) {
  Lab lab;
  Drawn film = lab.film(1);
  enter(look_at_floor(film, lab.intrinsics(), 1).value(), lab.marks);
  for (const auto& [few, i, j] : {std::tuple{std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8}, 2, 5},
                                  {std::vector<std::size_t>{0, 2, 4, 6, 7, 8}, 0, 2},
                                  {std::vector<std::size_t>{0, 2, 6, 8, 4}, 1, 2},
                                  {std::vector<std::size_t>{0, 2, 6, 8}, 0, 3}}) {
    std::vector<FloorMark> marks;
    for (const std::size_t mark : few) marks.push_back(lab.marks[mark]);
    FloorMark &one = marks[static_cast<std::size_t>(i)], &other = marks[static_cast<std::size_t>(j)];
    std::swap(one.x, other.x);
    std::swap(one.y, other.y);
    const auto solved = solve_trusted_floor(lab.intrinsics(), marks);
    ASSERT_FALSE(solved) << few.size();
    const std::string hint =
        fmt::format("; with the places of {} and {} exchanged they agree to 0.", one.name, other.name);
    EXPECT_NE(solved.error().find(hint), std::string::npos) << few.size() << ": " << solved.error();
  }
  // The control: marks that disagree in another way are not said to be swapped.
  for (const std::size_t i : {1U, 4U, 6U}) lab.marks[i].y += i == 4U ? -0.05 : 0.05;
  EXPECT_EQ(solve_trusted_floor(lab.intrinsics(), lab.marks).error().find("exchanged"), std::string::npos);
}

TEST(FloorCalibration, RefusesAWrongMarkAmongTooFewToNameIt) {
  Lab lab;
  Drawn film = lab.film(1);
  enter(look_at_floor(film, lab.intrinsics(), 1).value(), lab.marks);
  for (const std::vector<std::size_t>& few : {std::vector<std::size_t>{0, 2, 6, 8}, {0, 2, 4, 6, 8}})
    for (const std::size_t wrong : few)
      for (const auto& [dx, dy] : {std::pair{0.03, 0.0}, {0.0, 0.03}, {0.0, 0.0}}) {
        std::vector<FloorMark> marks;
        for (const std::size_t i : few) {
          marks.push_back(lab.marks[i]);
          // What a tape measure is off by, and, of one of them, a mistake in typing.
          marks.back().x += (i % 4 == 0 ? 1e-3 : -1e-3) + (i == wrong ? dx : 0.0);
          marks.back().y += i == wrong ? dy : 0.0;
        }
        const auto solved = solve_trusted_floor(lab.intrinsics(), marks);
        const bool right = dx == 0.0 && dy == 0.0;
        EXPECT_EQ(solved.has_value(), right) << few.size() << " marks, " << marks.front().name << " to "
                                             << marks.back().name << ", wrong: " << wrong << " by " << dx << ", " << dy;
        if (solved) continue;
        EXPECT_NE(solved.error().find(fmt::format("as if one of the {} were", few.size())), std::string::npos)
            << solved.error();
      }
}

TEST(FloorCalibration, MeasuresHowHighATagIsCarried) {
  Lab lab;
  Calibration robots = lab.truth;
  robots.tag_height = 0.063;
  robots.tag_size = 0.06;
  SyntheticCamera camera(robots, {}, 6);
  std::vector<Frame> frames(4);
  for (Frame& frame : frames) camera.render(std::vector<SyntheticTag>{{20, {0.1, -0.1, 0.5}, 0.06}}, 0.0, frame);
  Drawn film(std::move(frames));
  const auto sight = look_at_floor(film, robots, 4);
  ASSERT_TRUE(sight) << sight.error();
  ASSERT_EQ(sight->ids, std::vector{20});
  Calibration unknown = robots;
  unknown.tag_height = 0.0;
  const auto height = tag_height_of(unknown, sight->corners.front());
  ASSERT_TRUE(height);
  EXPECT_NEAR(*height, 0.063, 0.005);
  unknown.tag_size = 2.0;
  EXPECT_FALSE(tag_height_of(unknown, sight->corners.front())) << "no height makes it that large";
}

TEST(FloorCalibration, SaysWhatIsMissing) {
  Lab lab;
  EXPECT_EQ(solve_floor(lab.intrinsics(), lab.marks).error(), "0 of 9 marks are seen; needed: 4 or more");
  for (std::size_t i = 0; i < 9; ++i) {
    lab.marks[i].seen = true;
    lab.marks[i].y = 0.0;
  }
  EXPECT_EQ(solve_floor(lab.intrinsics(), lab.marks).error(),
            "the visible marks lie on one line; spread them over the arena");
  EXPECT_EQ(check_floor(lab.intrinsics(), lab.marks).error(), "the calibration has no world frame");
  Drawn small(std::vector<Frame>{test::uniform_frame(64, 48, 0)});
  EXPECT_EQ(look_at_floor(small, lab.truth, 1).error(), "frame  is 64x48 px, but the calibration holds for 1280x960");
}

}  // namespace
}  // namespace skein::vision
