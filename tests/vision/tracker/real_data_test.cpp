// Real pictures and films, against what is known of them (see the README of each folder of the data). They are not part
// of the project: SKEIN_REAL_DATA says where they are, by default ../shared/data beside the project's root.
#include <Eigen/Dense>
#include <algorithm>
#include <set>
#include <sstream>

#include "tests/files.h"
#include "tests/vision/support.h"
#include "vision/detector/detector.h"
#include "vision/fit/photometric_fit.h"
#include "vision/modules/media_loader.h"
#include "vision/sources/open_source.h"
#include "vision/synthetic/random.h"
#include "vision/tags/tag_family.h"
#include "vision/track/track.h"
#include "vision/tracker/tracker.h"

namespace skein::vision {
namespace {

struct Seen {
  std::int64_t frame;
  std::string source;
  int tag;
  std::array<Eigen::Vector2d, 4> corners;

  /// Where the diagonals cross: the middle of the print, also from aside. [px]
  Eigen::Vector2d centre() const {
    const Eigen::Vector2d a = corners[2] - corners[0];
    const Eigen::Vector2d b = corners[3] - corners[1];
    Eigen::Matrix2d system;
    system << a, -b;
    return corners[0] + a * system.inverse().row(0).dot(corners[1] - corners[0]);
  }
};

std::array<Eigen::Vector2d, 4> as_points(const Corners& corners) {
  std::array<Eigen::Vector2d, 4> points;
  for (std::size_t k = 0; k < 4; ++k) points[k] = {corners[k][0], corners[k][1]};
  return points;
}

/// From a tag's own frame (modules) to the picture: the one homography that its four corners agree with.
Eigen::Matrix3d homography_of(const Corners& corners) {
  constexpr double model[4][2] = {{-4, -4}, {4, -4}, {4, 4}, {-4, 4}};
  Eigen::Matrix<double, 8, 8> equations;
  Eigen::Matrix<double, 8, 1> right;
  for (int i = 0; i < 4; ++i) {
    const double x = model[i][0];
    const double y = model[i][1];
    const auto [u, v] = corners[static_cast<std::size_t>(i)];
    equations.row(2 * i) << x, y, 1, 0, 0, 0, -u * x, -u * y;
    equations.row(2 * i + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y;
    right[2 * i] = u;
    right[2 * i + 1] = v;
  }
  const Eigen::Matrix<double, 8, 1> h = equations.fullPivLu().solve(right);
  Eigen::Matrix3d homography;
  homography << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0;
  return homography;
}

class RealData : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = test::real_data();
    if (!std::filesystem::is_directory(root_)) {
      GTEST_SKIP() << "no real pictures at " << root_ << ": set SKEIN_REAL_DATA to their folder";
    }
  }

  /// What `skein track` says of "images:" or "video:" and a path below the data's folder.
  std::vector<Seen> look(const std::string& kind, const std::string& path, std::int64_t frames_expected,
                         std::int64_t max_frames = 0) {
    std::ostringstream csv;
    const auto summary = track({.source = kind + root_ + "/" + path, .csv = &csv, .max_frames = max_frames});
    EXPECT_TRUE(summary) << summary.error();
    if (!summary) return {};
    EXPECT_EQ(summary->frames, frames_expected) << path;
    EXPECT_TRUE(summary->skipped.empty());
    std::vector<Seen> all;
    for (const auto& row : test::read_csv(csv.str())) {
      const auto number = [&](const char* column) { return std::stod(row.at(column)); };
      all.push_back({std::stoll(row.at("frame")),
                     row.at("source"),
                     std::stoi(row.at("tag")),
                     {Eigen::Vector2d{number("u1"), number("v1")}, Eigen::Vector2d{number("u2"), number("v2")},
                      Eigen::Vector2d{number("u3"), number("v3")}, Eigen::Vector2d{number("u4"), number("v4")}}});
    }
    return all;
  }

  static std::vector<int> ids(const std::vector<Seen>& all) {
    std::vector<int> result;
    for (const Seen& seen : all) result.push_back(seen.tag);
    return result;
  }

  std::string root_;
};

TEST_F(RealData, ArenaPhotosShowTheTagOfTheirName) {
  const auto all = look("images:", "arenaxr", 4);
  ASSERT_EQ(all.size(), 3U) << "one in each but no_tag.jpg";
  for (const Seen& seen : all) {
    EXPECT_NE(seen.source, "no_tag.jpg");
    EXPECT_TRUE(seen.source.starts_with("single_tag_" + std::to_string(seen.tag) + "_"))
        << seen.source << " " << seen.tag;
  }
}

TEST_F(RealData, SheetOfFortyTags) {
  std::vector<int> wanted;
  for (int id = 1; id <= 40; ++id) wanted.push_back(id);
  EXPECT_EQ(ids(look("images:", "julia/taggridphoto.jpg", 1)), wanted);
}

TEST_F(RealData, TagsWithKnownCentres) {
  // As published: AprilTag counts pixels from the corner of the first one, half a pixel before its centre.
  const std::map<int, Eigen::Vector2d> truth = {{5, {176.1, 404.5}}, {6, {216.1, 134.0}}, {9, {130.1, 412.0}}};
  const auto all = look("images:", "julia/tagtest.jpg", 1);
  EXPECT_EQ(ids(all), (std::vector{5, 6, 9}));
  for (const Seen& seen : all) {
    const Eigen::Vector2d published = seen.centre() + Eigen::Vector2d(0.5, 0.5);
    EXPECT_LT((published - truth.at(seen.tag)).cwiseAbs().maxCoeff(), 0.2) << seen.tag << ": " << published.transpose();
  }
}

TEST_F(RealData, ATagOfSixteenPixels) {
  EXPECT_EQ(ids(look("images:", "julia/colortag.jpg", 1)), (std::vector{495}));
}

TEST_F(RealData, BoardsAreRegularGrids) {
  const auto all = look("images:", "swatbotics/clipboard", 6);
  EXPECT_GE(all.size(), 154U);
  std::map<std::string, std::vector<Seen>> pictures;
  for (const Seen& seen : all) pictures[seen.source].push_back(seen);
  ASSERT_EQ(pictures.size(), 6U);
  for (const auto& [name, tags] : pictures) {
    // The homography from the board (columns and rows of tags) to the picture, by the direct linear transform.
    Eigen::MatrixXd equations(2 * static_cast<Eigen::Index>(tags.size()), 9);
    Eigen::Index row = 0;
    for (const Seen& seen : tags) {
      ASSERT_LT(seen.tag, 30);
      const Eigen::RowVector3d board(seen.tag % 5 - 2.0, seen.tag / 5 - 2.5, 1.0);
      const Eigen::Vector2d pixel = (seen.centre() - Eigen::Vector2d(160.0, 120.0)) / 100.0;  // well-conditioned
      equations.row(row++) << board, Eigen::RowVector3d::Zero(), -pixel.x() * board;
      equations.row(row++) << Eigen::RowVector3d::Zero(), board, -pixel.y() * board;
    }
    const Eigen::VectorXd h = equations.jacobiSvd(Eigen::ComputeFullV).matrixV().col(8);
    Eigen::Matrix3d homography;
    homography << h.segment<3>(0).transpose(), h.segment<3>(3).transpose(), h.segment<3>(6).transpose();
    double squares = 0.0;
    for (const Seen& seen : tags) {
      const Eigen::Vector3d at = homography * Eigen::Vector3d(seen.tag % 5 - 2.0, seen.tag / 5 - 2.5, 1.0);
      squares += (100.0 * at.head<2>() / at.z() + Eigen::Vector2d(160.0, 120.0) - seen.centre()).squaredNorm();
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(tags.size())), 0.5) << name << ", " << tags.size() << " tags";
  }
}

TEST_F(RealData, TagsInAHallwayAndOnWalls) {
  const auto hallway = look("images:", "swatbotics/hallway", 3);
  ASSERT_EQ(hallway.size(), 3U);
  for (std::int64_t i = 0; i < 3; ++i) EXPECT_EQ(hallway[static_cast<std::size_t>(i)].frame, i) << "one in each";

  const auto mapping = look("images:", "swatbotics/mapping", 15);
  EXPECT_GE(mapping.size(), 48U);
  std::set<std::string> pictures;
  for (const Seen& seen : mapping) {
    EXPECT_LE(seen.tag, 19) << seen.source;
    pictures.insert(seen.source);
  }
  EXPECT_EQ(pictures.size(), 15U);
}

TEST_F(RealData, ChessboardsAndOtherFamiliesAreNoTags) {
  EXPECT_EQ(ids(look("images:", "swatbotics/chessboard", 17)), (std::vector{0, 0, 0})) << "three show a real tag, too";
  EXPECT_TRUE(look("images:", "opencv_left", 13).empty());
  EXPECT_TRUE(look("images:", "moms_handheld_board", 8).empty()) << "36h10 is not 36h11";
}

TEST_F(RealData, FilmOfTwoTagsOnAWall) {
  EXPECT_EQ(ids(look("images:", "wpical/tag1_640_480.jpg", 1)), (std::vector{1}));
  EXPECT_EQ(ids(look("video:", "wpical/field_short.mp4", 3)), (std::vector{3, 4, 3, 4, 3, 4}));

  const std::int64_t frames = test::sanitized ? 20 : 159;
  const auto film = look("video:", "wpical/field_long.mp4", frames, test::sanitized ? frames : 0);
  ASSERT_EQ(film.size(), static_cast<std::size_t>(2 * frames));
  double least = 1e9;
  double most = 0.0;
  for (std::size_t i = 0; i < film.size(); i += 2) {
    EXPECT_EQ(film[i].frame, static_cast<std::int64_t>(i / 2));
    EXPECT_EQ(film[i].tag, 3);
    EXPECT_EQ(film[i + 1].tag, 4);
    // Both are fixed on one wall: how far apart they are, in edges of the tag, hardly changes while the camera moves.
    const double edge = 0.5 * ((film[i].corners[1] - film[i].corners[0]).norm() +
                               (film[i + 1].corners[1] - film[i + 1].corners[0]).norm());
    const double apart = (film[i].centre() - film[i + 1].centre()).norm() / edge;
    least = std::min(least, apart);
    most = std::max(most, apart);
  }
  EXPECT_LT(most / least, 1.05);
}

TEST_F(RealData, TheFitAgreesWithTheDetectorOnTheFilm) {
  // The film has no calibration, and its tags hang on a wall: each frame's own homography, from AprilTag's corners,
  // stands for one. From a pose up to 3 px and 10 degrees off, the fit comes back to what AprilTag says.
  auto source = open_source("video:" + root_ + "/wpical/field_long.mp4");
  ASSERT_TRUE(source) << source.error();
  const std::vector<detail::TagPattern> patterns = detail::tag_patterns();
  TagDetector detector({.decimate = 2.0});
  detail::Random random(4);
  Frame frame;
  const int frames = test::sanitized ? 5 : 60;
  for (int k = 0; k < frames; ++k) {
    ASSERT_TRUE((*source)->read(frame).value());
    const std::vector<Detection> detections = detector.detect(frame);
    ASSERT_EQ(detections.size(), 2U);
    for (const Detection& detection : detections) {
      const detail::PlaneMap map(homography_of(detection.corners));
      detail::PhotometricFit fitter(map, 1.0, /*exact=*/false, {});
      detail::TagModel model(patterns[static_cast<std::size_t>(detection.tag)]);
      const double px = 1.0 / map.around(0.0, 0.0, 8.0).px_per_metre();
      const core::Pose off{random.between(-2.0, 2.0) * px, random.between(-2.0, 2.0) * px, random.between(-0.17, 0.17)};
      const detail::Fit fit = fitter.fit(frame, model, off);
      EXPECT_EQ(fit.verdict, detail::FitVerdict::good) << "frame " << k << ", tag " << detection.tag << ": correlation "
                                                       << fit.correlation << ", strain " << fit.strain;
      const Eigen::Vector2d apart = map.pixel(fit.pose.x, fit.pose.y) - map.pixel(0.0, 0.0);
      EXPECT_LT(apart.norm(), 0.5) << "frame " << k << ", tag " << detection.tag;
      EXPECT_LT(std::abs(fit.pose.theta), 0.02);
      const detail::TagPattern& other = patterns[static_cast<std::size_t>(detection.tag == 3 ? 4 : 3)];
      detail::TagModel wrong(other);
      EXPECT_NE(fitter.fit(frame, wrong, off).verdict, detail::FitVerdict::good) << "and it is no other tag";
    }
  }
}

TEST_F(RealData, TheTrackerFollowsTheFilmAsTheDetectorSeesIt) {
  // The wall is the floor. The camera is held by hand: where it is, the tracker is told every tenth of a second; in
  // between the tags seem to drive.
  auto source = open_source("video:" + root_ + "/wpical/field_long.mp4");
  ASSERT_TRUE(source) << source.error();
  Frame frame;
  ASSERT_TRUE((*source)->read(frame).value());
  TagDetector detector({.decimate = 1.0});  // in half as many pixels its own errors are the larger ones
  std::vector<Detection> seen = detector.detect(frame);
  ASSERT_EQ(seen.size(), 2U);
  Calibration camera;
  camera.width = frame.width;
  camera.height = frame.height;
  camera.fx = camera.fy = 2103.9;  // of the film of the board, by the same camera
  camera.cx = 993.2;
  camera.cy = 541.9;
  camera.tag_height = 0.0;
  camera.tag_size = 0.1651;
  // Each tag spans a floor of its own: how the two lie to each other is not known.
  const auto module = boards();
  ASSERT_TRUE(module) << module.error();
  constexpr int told_every = 3;
  std::vector<TagTracker> trackers;
  const auto tell = [&] {
    trackers.clear();
    for (const Detection& tag : seen) {
      std::vector<Landmark> landmarks;
      constexpr double model[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
      for (std::size_t k = 0; k < 4; ++k)
        landmarks.push_back(
            {model[k][0] * camera.tag_size, model[k][1] * camera.tag_size, 0.0, tag.corners[k][0], tag.corners[k][1]});
      ASSERT_EQ((*module)->locate(landmarks, camera), "");
      trackers.emplace_back(camera, TrackerOptions{.tags = {tag.tag}});
    }
  };
  const int frames = test::sanitized ? 10 : 159;
  double worst = 0.0;
  std::int64_t fits = 0;
  for (int k = 0; k < frames; ++k) {
    if (k > 0) {
      ASSERT_TRUE((*source)->read(frame).value());
      seen = detector.detect(frame);
    }
    ASSERT_EQ(seen.size(), 2U);
    if (k % told_every == 0) tell();
    for (std::size_t i = 0; i < 2; ++i) {
      const std::vector<TagPose>& poses = trackers[i].process(frame);
      ASSERT_EQ(poses.size(), 1U) << "frame " << k << ", tag " << seen[i].tag;
      EXPECT_EQ(poses[0].tag, seen[i].tag);
      fits += poses[0].how == How::tracked ? 1 : 0;
      const Seen fitted{k, "", poses[0].tag, as_points(poses[0].corners)};
      const Seen detected{k, "", seen[i].tag, as_points(seen[i].corners)};
      worst = std::max(worst, (fitted.centre() - detected.centre()).norm());
    }
  }
  EXPECT_LT(worst, 0.5);
  EXPECT_EQ(fits, 2 * (frames - (frames + told_every - 1) / told_every)) << "followed, not found again";
}

TEST_F(RealData, TheTrackerReportsNothingWhereNothingIs) {
  // Whoever's tags are asked for, under a camera that might have taken the pictures.
  std::vector<int> every_tag;
  for (int id = 0; id < (test::sanitized ? 30 : largest_tag + 1); ++id) every_tag.push_back(id);
  int frames = 0;
  for (const char* pictures : {"images:opencv_left", "images:moms_handheld_board", "images:arenaxr/no_tag.jpg",
                               "video:wpical/testcalibration.mp4"}) {
    const std::string name(pictures);
    const std::size_t colon = name.find(':');
    auto source = open_source(name.substr(0, colon + 1) + root_ + "/" + name.substr(colon + 1));
    ASSERT_TRUE(source) << source.error();
    std::unique_ptr<TagTracker> tracker;
    Frame frame;
    for (int k = 0; k < (test::sanitized ? 3 : 20) && (*source)->read(frame).value(); ++k) {
      if (!tracker) {
        Calibration camera = overhead_calibration(2.0, 1.5);
        const double scale = static_cast<double>(frame.width) / camera.width;
        camera.width = frame.width;
        camera.height = frame.height;
        camera.fx = camera.fy = camera.fx * scale;
        camera.cx = 0.5 * (frame.width - 1);
        camera.cy = 0.5 * (frame.height - 1);
        tracker = std::make_unique<TagTracker>(camera, TrackerOptions{.tags = every_tag});
      }
      EXPECT_EQ(tracker->process(frame).size(), 0U) << name << ", frame " << k;
      ++frames;
    }
  }
  EXPECT_GE(frames, test::sanitized ? 10 : 42);
}

TEST_F(RealData, FilmOfAChessboard) {
  EXPECT_TRUE(look("video:", "wpical/testcalibration.mp4", 20, 20).empty()) << "ArUco markers are no 36h11 tags";
}

TEST_F(RealData, APhotoCutShortIsSkipped) {
  test::Folder folder;
  const std::string photo = test::read_file(root_ + "/arenaxr/single_tag_2_3.jpg");
  test::write_file(folder.file("half.jpg"), photo.substr(0, photo.size() / 2));
  test::write_file(folder.file("whole.jpg"), photo);
  auto source = open_source("images:" + folder.path());
  ASSERT_TRUE(source) << source.error();
  Frame frame;
  ASSERT_TRUE((*source)->read(frame).value());
  EXPECT_EQ(frame.source, "whole.jpg");
  EXPECT_EQ(frame.width, 1280);
  ASSERT_EQ((*source)->skipped().size(), 1U);
  EXPECT_EQ((*source)->skipped()[0], folder.file("half.jpg") + ": is cut short");
}

TEST_F(RealData, FramesOfAnMjpegCameraAreDecoded) {
  const auto module = media();
  ASSERT_TRUE(module) << module.error();
  const std::string photo = test::read_file(root_ + "/arenaxr/single_tag_2_3.jpg");
  const auto decode = [&](std::size_t size, Frame& frame) {
    return (*module)->decode_jpeg(reinterpret_cast<const std::uint8_t*>(photo.data()), size, frame);
  };
  Frame frame;
  EXPECT_EQ(decode(photo.size() / 2, frame), JpegState::damaged);
  EXPECT_EQ(decode(0, frame), JpegState::damaged);
  ASSERT_EQ(decode(photo.size(), frame), JpegState::whole);
  EXPECT_EQ(frame.width, 1280);
  EXPECT_EQ(frame.height, 720);
  TagDetector detector;
  ASSERT_EQ(detector.detect(frame).size(), 1U);
}

TEST_F(RealData, FilmTimesGoOn) {
  auto source = open_source("video:" + root_ + "/wpical/field_long.mp4");
  ASSERT_TRUE(source) << source.error();
  EXPECT_FALSE((*source)->stills());
  Frame frame;
  double last = -1.0;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE((*source)->read(frame).value());
    EXPECT_EQ(frame.index, i);
    EXPECT_EQ(frame.source, std::to_string(i));
    EXPECT_GT(frame.captured_at, last);
    EXPECT_LT(frame.captured_at, last + 1.2);
    last = frame.captured_at;
  }
  EXPECT_NEAR(last, 9.0 / 30.0, 0.05);
  EXPECT_EQ(frame.width, 1920);
  EXPECT_EQ(frame.height, 1080);
}

}  // namespace
}  // namespace skein::vision
