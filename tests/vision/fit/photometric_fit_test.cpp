#include "vision/fit/photometric_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "tests/property.h"
#include "tests/vision/support.h"
#include "vision/synthetic/random.h"
#include "vision/synthetic/synthetic_camera.h"
#include "vision/tags/tag_plane.h"

namespace skein::vision::detail {
namespace {

constexpr double tag_size = 0.06;
constexpr double module = tag_size / 8.0;
constexpr double degree = core::pi / 180.0;

Calibration with_tags(double size) {
  Calibration calibration = overhead_calibration(2.0, 1.5);
  calibration.tag_size = size;
  return calibration;
}

const std::vector<TagPattern>& patterns() {
  static const std::vector<TagPattern> all = tag_patterns();
  return all;
}

/// A frame full of tags with ids from `first` on, somewhere and turned anyhow.
struct FitScene {
  Calibration calibration = with_tags(tag_size);
  std::vector<SyntheticTag> tags;
  Frame frame;

  explicit FitScene(const SceneOptions& options = {}, int first = 0, std::uint64_t seed = 7) {
    Random random(seed);
    for (int i = 0; i < 12; ++i) {
      const int column = i % 4;
      const int row = i / 4;
      const core::Pose pose{-0.75 + 0.5 * column + random.between(-0.15, 0.15),
                            -0.5 + 0.5 * row + random.between(-0.15, 0.15), random.between(-3.1, 3.1)};
      tags.push_back({first + i, pose, tag_size});
    }
    SyntheticCamera(calibration, options, seed).render(tags, 0.0, frame);
  }
};

Fit fit(const FitScene& scene, int id, const core::Pose& from, bool exact = false,
        Instructions instructions = best_instructions()) {
  TagModel model(patterns()[static_cast<std::size_t>(id)]);
  PhotometricFit fitter(PlaneMap(scene.calibration), module, exact, {.instructions = instructions});
  return fitter.fit(scene.frame, model, from);
}

core::Pose moved(core::Pose pose, double px, double direction, double turn) {
  constexpr double metres_per_px = 1.0 / 600.0;
  pose.x += px * metres_per_px * std::cos(direction);
  pose.y += px * metres_per_px * std::sin(direction);
  pose.theta = core::wrap_angle(pose.theta + turn);
  return pose;
}

TEST(PlaneMap, AgreesWithTheCalibrationAndItsCubicToo) {
  const Calibration calibration = with_tags(tag_size);
  const PlaneMap map(calibration);
  for (int column = -4; column <= 4; ++column) {
    for (int row = -3; row <= 3; ++row) {
      const double x = 0.25 * column;
      const double y = 0.25 * row;
      EXPECT_LT((map.pixel(x, y) - *pixel_from_world(calibration, {x, y, calibration.tag_height})).norm(), 1e-9);
    }
  }
  EXPECT_LT(map.worst_error(calibration, 8.0 * module), 1e-3);
  EXPECT_GT(map.worst_error(calibration, 0.7), 1e-3) << "over a third of the arena a cubic is too simple";
}

TEST(PhotometricFit, ConvergesFromEverywhereWithinItsBasin) {
  const FitScene scene;
  test::holds("from 4 px and 20 degrees off", [&](std::uint64_t bits) {
    Random random(bits);
    const SyntheticTag& tag = scene.tags[random.below(scene.tags.size())];
    const core::Pose from =
        moved(tag.pose, random.between(0.0, 4.0), random.between(-3.14, 3.14), random.between(-20.0, 20.0) * degree);
    const Fit found = fit(scene, tag.tag, from);
    RC_ASSERT(found.verdict == FitVerdict::good);
    RC_ASSERT(core::distance(found.pose, tag.pose) < 1e-4);
    RC_ASSERT(std::abs(core::wrap_angle(found.pose.theta - tag.pose.theta)) < 0.2 * degree);
    RC_ASSERT(found.correlation > 0.99);
  });
}

TEST(PhotometricFit, SaysHowWellItKnows) {
  double xy = 0.0;
  double theta = 0.0;
  int count = 0;
  for (int k = 0; k < (test::sanitized ? 4 : 12); ++k) {
    const FitScene scene({}, 12 * k, 100 + static_cast<std::uint64_t>(k));
    for (const SyntheticTag& tag : scene.tags) {
      const Fit found = fit(scene, tag.tag, moved(tag.pose, 0.5, 1.0, 0.03));
      ASSERT_EQ(found.verdict, FitVerdict::good);
      const Eigen::Vector3d error(found.pose.x - tag.pose.x, found.pose.y - tag.pose.y,
                                  core::wrap_angle(found.pose.theta - tag.pose.theta));
      xy += 0.5 * (error.x() * error.x() / found.covariance(0, 0) + error.y() * error.y() / found.covariance(1, 1));
      theta += error.z() * error.z() / found.covariance(2, 2);
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(xy / count), 1.0, 0.35);
  EXPECT_NEAR(std::sqrt(theta / count), 1.0, 0.35);
}

TEST(PhotometricFit, FeltNoiseIsTheVarianceOfWhiteNoise) {
  const TagTemplate tag(patterns()[3], 0.86 / 4.7);
  using Inverse = Eigen::Matrix<float, TagTemplate::columns, TagTemplate::columns>;
  const TagTemplate::Full inverse = Inverse::Map(tag.full_inverse.data()).cast<double>();
  Random random(4);
  const auto normal = [&random] {  // nearly: the sum of twelve
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += random.unit();
    return sum;
  };
  for (const double sigma : {1.0, 5.0}) {
    double sum = 0.0;
    constexpr int draws = 200;
    for (int k = 0; k < draws; ++k) {
      Values values{};
      Eigen::Matrix<double, TagTemplate::columns, 1> seen = Eigen::Matrix<double, TagTemplate::columns, 1>::Zero();
      for (std::size_t i = 0; i < SampleGrid::points; ++i) {
        const auto row = tag.row(i);
        float& value = values[SampleGrid::place_of(i)];
        value = static_cast<float>(150.0 * row[TagTemplate::paper] - 90.0 + sigma * normal());
        seen += static_cast<double>(value) * row;
      }
      const Eigen::Matrix<double, TagTemplate::columns, 1> solved = inverse * seen;
      std::array<float, TagTemplate::columns> solution{};
      for (int i = 0; i < TagTemplate::columns; ++i)
        solution[static_cast<std::size_t>(i)] = static_cast<float>(solved[i]);
      const float felt = felt_noise(Instructions::baseline, tag, values, solution);
      EXPECT_EQ(felt, felt_noise(best_instructions(), tag, values, solution));
      sum += static_cast<double>(felt);
    }
    EXPECT_NEAR(sum / draws, sigma * sigma, 0.04 * sigma * sigma);
  }
}

TEST(PhotometricFit, LightThatFallsAcrossATagDoesNotMoveIt) {
  // A soft shadow's edge across each tag: by a fit without the light's gradient
  // they are 0.4 to 0.5 mm off.
  FitScene scene;
  std::vector<SyntheticDisc> shadows;
  shadows.reserve(scene.tags.size());
  for (const SyntheticTag& tag : scene.tags)
    shadows.push_back({tag.pose.x + 0.1, tag.pose.y, 0.16, scene.calibration.tag_height, 0.0, 0.12, 0.8});
  SyntheticCamera(scene.calibration, {}, 7).render(scene.tags, shadows, 0.0, scene.frame);
  for (const SyntheticTag& tag : scene.tags) {
    const Fit found = fit(scene, tag.tag, moved(tag.pose, 0.5, 1.0, 0.03));
    ASSERT_EQ(found.verdict, FitVerdict::good) << tag.tag;
    EXPECT_LT(core::distance(found.pose, tag.pose), 1e-4) << tag.tag;
  }
}

TEST(PhotometricFit, IsTheSameWithAndWithoutAvx2) {
  if (best_instructions() != Instructions::avx2) GTEST_SKIP() << "this machine has no AVX2";
  const FitScene scene;
  Random random(5);
  for (const SyntheticTag& tag : scene.tags) {
    const core::Pose from = moved(tag.pose, random.between(0.0, 4.0), random.between(-3.14, 3.14), 0.1);
    const Fit plain = fit(scene, tag.tag, from, false, Instructions::baseline);
    const Fit fast = fit(scene, tag.tag, from, false, Instructions::avx2);
    ASSERT_EQ(plain.verdict, FitVerdict::good);
    // 1e-3 px are asked for; the operations are the same, so are the bits.
    EXPECT_EQ(plain.pose, fast.pose);
    EXPECT_EQ(plain.corners, fast.corners);
    EXPECT_EQ(plain.covariance, fast.covariance);
  }
}

TEST(PhotometricFit, ProjectsEveryPointWhereACubicWouldNotDo) {
  const FitScene scene;
  for (const SyntheticTag& tag : scene.tags) {
    const core::Pose from = moved(tag.pose, 1.0, 0.5, 0.05);
    const Fit exact = fit(scene, tag.tag, from, true);
    const Fit cubic = fit(scene, tag.tag, from, false);
    ASSERT_EQ(exact.verdict, FitVerdict::good);
    EXPECT_LT(core::distance(exact.pose, cubic.pose), 1e-6) << "a thousandth of a pixel is 1.7e-6 m";
  }
}

TEST(PhotometricFit, RefusesOtherTagsAndOtherHeadings) {
  const FitScene scene;
  Random random(9);
  for (const SyntheticTag& tag : scene.tags) {
    for (int k = 0; k < 40; ++k) {
      const auto other = static_cast<int>(random.below(587));
      if (other == tag.tag) continue;
      const double turn = core::pi / 2.0 * static_cast<double>(random.below(4));
      EXPECT_NE(fit(scene, other, moved(tag.pose, 1.0, 0.0, turn)).verdict, FitVerdict::good) << other;
    }
    for (const double turn : {90.0, 180.0, 270.0}) {
      EXPECT_NE(fit(scene, tag.tag, moved(tag.pose, 1.0, 0.0, turn * degree)).verdict, FitVerdict::good) << turn;
    }
  }
}

TEST(PhotometricFit, OtherTagsAreLessAlikeThanAFitAsksFor) {
  // Over pairs of all tags, upright, at the sizes (px a module) of the whole picture and of the half: without noise.
  // A fit may light a tag as it likes, which must not make it another.
  using Row = Eigen::Matrix<double, 1, 3>;
  for (const double px : {4.7, 2.4}) {
    Eigen::MatrixXd looks(SampleGrid::points, 0);
    std::vector<Eigen::Matrix<double, SampleGrid::points, 3>> explained_by;
    for (std::size_t id = 0; id < patterns().size(); id += test::sanitized ? 16 : 2) {
      const TagTemplate tag(patterns()[id], 0.86 / px);
      Eigen::Matrix<double, SampleGrid::points, 3> columns;
      for (std::size_t i = 0; i < SampleGrid::points; ++i) {
        const auto row = tag.row(i);
        columns.row(static_cast<Eigen::Index>(i)) =
            Row(row[TagTemplate::paper], row[TagTemplate::light_x], row[TagTemplate::light_y]);
      }
      columns.rowwise() -= Row(columns.colwise().mean());
      looks.conservativeResize(Eigen::NoChange, looks.cols() + 1);
      looks.rightCols(1) = columns.col(0).normalized();
      const Eigen::Matrix3d root = (columns.transpose() * columns).eval().llt().matrixL();
      explained_by.push_back(columns * root.transpose().inverse());
    }
    double most = 0.0;
    for (std::size_t tag = 0; tag < explained_by.size(); ++tag) {
      const Eigen::Matrix<double, 3, Eigen::Dynamic> parts = explained_by[tag].transpose() * looks;
      for (Eigen::Index other = 0; other < looks.cols(); ++other)
        if (other != static_cast<Eigen::Index>(tag)) most = std::max(most, parts.col(other).norm());
    }
    EXPECT_LT(most, std::max(0.85, 0.83 + 0.33 * (0.86 / px - 0.18) + 0.02)) << px;
    EXPECT_GT(most, 0.8) << px << ": some tags are alike";
  }
}

TEST(PhotometricFit, RefusesTheFloor) {
  const FitScene scene;
  Random random(2);
  int refused = 0;
  for (int k = 0; k < 400; ++k) {
    const core::Pose somewhere{random.between(-1.0, 1.0), random.between(-0.75, 0.75), random.between(-3.1, 3.1)};
    const auto id = static_cast<int>(random.below(587));
    const bool near = std::any_of(scene.tags.begin(), scene.tags.end(), [&](const SyntheticTag& tag) {
      return tag.tag == id && core::distance(tag.pose, somewhere) < 0.05;
    });
    refused += near || fit(scene, id, somewhere).verdict != FitVerdict::good ? 1 : 0;
  }
  EXPECT_EQ(refused, 400);
}

TEST(PhotometricFit, SaysOfTagsOfAnotherSizeThatTheyAreMisshapen) {
  FitScene scene;
  for (SyntheticTag& tag : scene.tags) tag.size = 0.935 * tag_size;
  SyntheticCamera(scene.calibration, {}, 1).render(scene.tags, 0.0, scene.frame);
  int misshapen = 0;
  for (const SyntheticTag& tag : scene.tags) {
    const FitVerdict verdict = fit(scene, tag.tag, tag.pose).verdict;
    EXPECT_NE(verdict, FitVerdict::good) << tag.tag;
    misshapen += verdict == FitVerdict::misshapen ? 1 : 0;
  }
  EXPECT_GE(misshapen, 8) << "not merely unlike them";
}

TEST(PhotometricFit, RefusesATagFarFromWhereItBegan) {
  const FitScene scene;
  for (const SyntheticTag& tag : scene.tags)
    for (const double turn : {-0.65, -0.55, 0.55, 0.65}) {
      const Fit found = fit(scene, tag.tag, moved(tag.pose, 0.0, 0.0, turn));
      EXPECT_GT(found.correlation, 0.99) << "it found the tag";
      EXPECT_EQ(found.verdict, FitVerdict::unlike) << tag.tag << ", " << turn;
    }
}

TEST(PhotometricFit, RefusesATagTooBlurredToBeToldFromOthers) {
  for (const double blur : {1.5, 3.5}) {
    const FitScene scene({.blur_px = blur});
    for (const SyntheticTag& tag : scene.tags)
      EXPECT_EQ(fit(scene, tag.tag, tag.pose).verdict == FitVerdict::good, blur < 2.0) << tag.tag << ", " << blur;
  }
}

TEST(PhotometricFit, SeesThatATagIsHeldUp) {
  FitScene scene;
  SyntheticTag& tag = scene.tags[0];
  for (const double larger : {1.0, 1.02, 1.04, 1.08, 1.12}) {
    tag.size = larger * tag_size;
    SyntheticCamera(scene.calibration, {}, 1).render(scene.tags, 0.0, scene.frame);
    const Fit found = fit(scene, tag.tag, tag.pose);
    EXPECT_EQ(found.verdict == FitVerdict::good, larger < 1.05) << larger;
    if (larger < 1.05) {
      EXPECT_NEAR(found.stretch, larger - 1.0, 0.2 * (larger - 1.0) + 0.003);
    }
  }
}

TEST(PhotometricFit, TagsWhosePaperThePicturesBorderCutsAreFittedAsWell) {
  // Upright at all four borders, half of the paper cut off, and turned, so that a corner is.
  FitScene scene;
  Random random(3);
  double squared = 0.0;
  int count = 0;
  for (int k = 0; k < 8; ++k) {
    const auto at = [&](double u, double v) {
      const auto place = world_from_pixel(scene.calibration, {u, v}, scene.calibration.tag_height);
      return core::Pose{place->x(), place->y(), random.between(-0.06, 0.06)};
    };
    constexpr double near = 20.5;
    const double width = scene.calibration.width - 1, height = scene.calibration.height - 1;
    std::vector<core::Pose> poses = {at(near, random.between(200, 700)), at(width - near, random.between(200, 700)),
                                     at(random.between(200, 1000), near), at(random.between(200, 1000), height - near),
                                     at(near, near)};
    poses.push_back(at(27.0, random.between(80, 150)));
    poses.back().theta += core::pi / 4.0;
    scene.tags.clear();
    scene.tags.reserve(poses.size());
    for (std::size_t i = 0; i < poses.size(); ++i)
      scene.tags.push_back({10 * k + static_cast<int>(i), poses[i], tag_size});
    SyntheticCamera(scene.calibration, {}, 20 + static_cast<std::uint64_t>(k)).render(scene.tags, 0.0, scene.frame);
    for (const SyntheticTag& tag : scene.tags) {
      for (const bool exact : {false, true}) {
        const Fit found = fit(scene, tag.tag, moved(tag.pose, 0.5, 1.0, 0.03), exact);
        ASSERT_EQ(found.verdict, FitVerdict::good) << tag.tag << " of " << k;
        EXPECT_LT(core::distance(found.pose, tag.pose), 1e-4);
        const Eigen::Vector3d error(found.pose.x - tag.pose.x, found.pose.y - tag.pose.y,
                                    core::wrap_angle(found.pose.theta - tag.pose.theta));
        squared += error.dot(found.covariance.ldlt().solve(error)) / 3.0;
        ++count;
      }
      const int other = tag.tag == 0 ? 500 : 587 - tag.tag;
      EXPECT_NE(fit(scene, other, tag.pose).verdict, FitVerdict::good);
      core::Pose turned = tag.pose;
      turned.theta = core::wrap_angle(turned.theta + core::pi / 2.0);
      EXPECT_NE(fit(scene, tag.tag, turned).verdict, FitVerdict::good);
    }
  }
  EXPECT_NEAR(std::sqrt(squared / count), 1.0, 0.35);
}

TEST(PhotometricFit, AtThePicturesEdgeNothingIsReadBeyondIt) {
  const FitScene scene;
  for (const double x : {-1.2, -1.1, -1.06, 1.06, 1.1, 1.2}) {
    for (const double y : {-0.9, -0.82, 0.0, 0.82, 0.9}) {
      EXPECT_NE(fit(scene, 3, {x, y, 0.4}).verdict, FitVerdict::good);
    }
  }
  EXPECT_NE(fit(scene, 3, {50.0, 0.0, 0.0}).verdict, FitVerdict::good);
  EXPECT_NE(fit(scene, 3, {std::nan(""), 0.0, 0.0}).verdict, FitVerdict::good);
}

}  // namespace
}  // namespace skein::vision::detail
