#include "vision/fit/photometric_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace skein::vision::detail {
namespace {

// Of the smooth template: with less it converges from less far; with more the bits melt into one grey. [modules]
constexpr double smooth_sigma = 1.2;

// Sizes share a template within this ratio.
constexpr double level_ratio = 1.25;

// A step that moves no corner by more than this needs no successor: the next would be a tenth of it at most. [px]
constexpr double small_step_px = 0.1;

// Below this something is wrong that a clean tag's noise does not explain: a finger, a shadow, glare.
constexpr double clean_correlation = 0.98;

// Around the tag's middle, so that the map holds wherever the fit may wander. [modules]
constexpr double map_radius = 8.0;

// Further from where it began, a fit has found something else.
constexpr double longest_way = 1.6;  // [modules], or
constexpr double longest_way_px = 6.0;
constexpr double longest_turn = 0.5;  // [rad]

/// Points closer than two pixels share pixels, and with them noise: how much less they know together than they seem to.
/// The triangle that reads between pixels is a cubic B-spline when it is correlated with itself.
double shared_noise(double pitch_px) {
  const auto spline = [](double s) {
    s = std::abs(s);
    if (s < 1.0) return 2.0 / 3.0 - s * s + 0.5 * s * s * s;
    return s < 2.0 ? std::pow(2.0 - s, 3) / 6.0 : 0.0;
  };
  double sum = 0.0;
  for (int k = -8; k <= 8; ++k) sum += spline(k * pitch_px) / spline(0.0);
  return sum * sum;
}

// Of a pixel's noise, so much is left where a grey level is read between pixels, on average.
constexpr double between_pixels = 2.0 / 3.0;

/// How much an edge is blurred that differs by `bend` second derivatives from one blurred by sigma: the projection of
/// the one edge less the other onto the second derivative, turned around. Edges that lie close together hide a part of
/// a large blur. [modules]
double blur_of(double sigma, double bend) {
  const double left = std::max(0.1, 1.0 - 0.5 * bend / (sigma * sigma));
  return sigma * std::sqrt(std::max(0.0, 2.0 / (left * left) - 1.0));
}

double tukey(double residual, double scale) {
  const double z = residual / (4.685 * scale);
  return std::abs(z) < 1.0 ? (1.0 - z * z) * (1.0 - z * z) : 0.0;
}

}  // namespace

const TagTemplate& TagModel::sharp(double px_per_module) {
  const int level = static_cast<int>(std::lround(std::log(px_per_module) / std::log(level_ratio)));
  for (const auto& [known, tag] : sharp_)
    if (known == level) return *(last_sharp_ = tag.get());
  const double sigma = sharp_sigma_px / std::pow(level_ratio, level);
  sharp_.emplace_back(level, std::make_unique<TagTemplate>(pattern_, sigma));
  return *(last_sharp_ = sharp_.back().second.get());
}

void TagModel::fetch() const {
  constexpr std::size_t line = 64;
  if (last_sharp_ == nullptr) return;
  const auto* const bytes = reinterpret_cast<const char*>(last_sharp_);
  for (std::size_t at = 0; at < sizeof(TagTemplate); at += line) __builtin_prefetch(bytes + at);
}

const TagTemplate& TagModel::smooth() {
  if (!smooth_) smooth_ = std::make_unique<TagTemplate>(pattern_, smooth_sigma);
  return *smooth_;
}

/// What a look at the picture says.
struct PhotometricFit::Look {
  Sums sums;
  Eigen::Matrix<double, TagTemplate::rigid_columns, 1> solution;  // gain * (-dx, -dy, -dtheta), gain, offset, light
  double correlation = 0.0;
  double scatter = 0.0;  // sum of squares around the mean
  bool outside = false;  // not all of the tag is in the picture
  double gain() const { return solution[TagTemplate::paper]; }
  Eigen::Vector3d change() const { return -solution.head<3>() / gain(); }  // (dx, dy) in modules, dtheta
};

/// The same look, with the tag free to stretch, shear and blur.
struct PhotometricFit::Free {
  Eigen::Matrix<double, TagTemplate::columns, 1> solution;
  double residual = 0.0;   // sum of squares that it leaves
  double explained = 0.0;  // multiple correlation of grey levels and columns
};

PhotometricFit::PhotometricFit(const PlaneMap& map, double module, bool exact, const FitOptions& options)
    : plane_(map), module_(module), exact_(exact), options_(options), sorted_(SampleGrid::points) {}

/// false: not all of the tag is in the picture, or there is nothing to be seen.
bool PhotometricFit::look(const Frame& frame, const TagTemplate& tag, const core::Pose& pose, Look& look) {
  const double c = std::cos(pose.theta) * module_;
  const double s = std::sin(pose.theta) * module_;
  Eigen::Vector2d least(1e9, 1e9);
  Eigen::Vector2d most(-1e9, -1e9);
  for (const double y : {-1.0, 1.0}) {
    for (const double x : {-1.0, 1.0}) {
      constexpr double reach = static_cast<double>(SampleGrid::reach);
      const Eigen::Vector2d corner = map_.pixel(pose.x + reach * (c * x - s * y), pose.y + reach * (s * x + c * y));
      least = least.cwiseMin(corner);
      most = most.cwiseMax(corner);
    }
  }
  // One pixel to spare for sides that the lens bends, and four bytes are read from every place on.
  look.outside = !(least.minCoeff() >= 1.0 && most.x() + 5.0 < frame.width && most.y() + 3.0 < frame.height);
  if (look.outside) return false;
  const int left = static_cast<int>(least.x()) - 1;
  const int top = static_cast<int>(least.y()) - 1;

  if (exact_) {
    for (std::size_t i = 0; i < SampleGrid::count; ++i) {
      const auto x = static_cast<double>(sample_grid.x[i]);
      const auto y = static_cast<double>(sample_grid.y[i]);
      const Eigen::Vector2d at = plane_.pixel(pose.x + c * x - s * y, pose.y + s * x + c * y);
      places_.u[i] = static_cast<float>(std::clamp(at.x() - left, 0.0, frame.width - 5.0 - left));
      places_.v[i] = static_cast<float>(std::clamp(at.y() - top, 0.0, frame.height - 3.0 - top));
    }
  } else {
    FloatMap map;
    for (std::size_t i = 0; i < LocalMap::terms; ++i) {
      map.u[i] = static_cast<float>(map_.u[i] - (i == 0 ? left : 0));
      map.v[i] = static_cast<float>(map_.v[i] - (i == 0 ? top : 0));
    }
    map.most_u = static_cast<float>(frame.width - 5 - left);
    map.most_v = static_cast<float>(frame.height - 3 - top);
    const double scale = 1.0 / map_.radius;
    const Turn turn{static_cast<float>(c * scale), static_cast<float>(s * scale),
                    static_cast<float>((pose.x - map_.x) * scale), static_cast<float>((pose.y - map_.y) * scale)};
    place_points(options_.instructions, map, turn, places_);
  }
  look_at_points(options_.instructions, {frame.row(top) + left, frame.width}, places_, tag, values_, look.sums);

  const auto& sum = look.sums.sum;
  Eigen::Matrix<double, TagTemplate::rigid_columns, 1> seen;
  seen << sum[Sums::along_x], sum[Sums::along_y], sum[Sums::turn], sum[Sums::paper], sum[Sums::constant],
      sum[Sums::light_x], sum[Sums::light_y];
  look.solution = tag.rigid_inverse * seen;
  const double residual = std::max(0.0, sum[Sums::square] - look.solution.dot(seen));
  look.scatter =
      sum[Sums::square] - sum[Sums::constant] * sum[Sums::constant] / static_cast<double>(SampleGrid::points);
  look.correlation = std::sqrt(std::max(0.0, 1.0 - residual / (look.scatter + 1e-9)));
  return look.gain() >= options_.least_contrast;
}

PhotometricFit::Free PhotometricFit::explain(const TagTemplate& tag, const Look& look) const {
  FreeSums free_sums;
  sum_free_columns(options_.instructions, tag, values_, free_sums);
  const auto& sum = look.sums.sum;
  const auto& more = free_sums.sum;
  Eigen::Matrix<double, TagTemplate::columns, 1> seen;
  seen << sum[Sums::along_x], sum[Sums::along_y], sum[Sums::turn], sum[Sums::paper], sum[Sums::constant],
      sum[Sums::light_x], sum[Sums::light_y], more[FreeSums::stretch_x], more[FreeSums::stretch_y],
      more[FreeSums::shear], more[FreeSums::blur_x], more[FreeSums::blur_y];
  Free free;
  free.solution = tag.full_inverse * seen;
  free.residual = std::max(0.0, sum[Sums::square] - free.solution.dot(seen));
  free.explained = std::sqrt(std::max(0.0, 1.0 - free.residual / (look.scatter + 1e-9)));
  return free;
}

void PhotometricFit::step(const Eigen::Vector3d& change, core::Pose& pose) const {
  const double c = std::cos(pose.theta);
  const double s = std::sin(pose.theta);
  pose.x += module_ * (c * change.x() - s * change.y());
  pose.y += module_ * (s * change.x() + c * change.y());
  pose.theta = core::wrap_angle(pose.theta + change.z());
}

/// How far a step moves the corners of the black square, four modules away.
double PhotometricFit::in_pixels(const Eigen::Vector3d& change) const {
  return px_per_module_ * (change.head<2>().norm() + 4.0 * std::abs(change.z()));
}

/// Gauss and Newton. false: no step became small.
bool PhotometricFit::descend(const Frame& frame, const TagTemplate& tag, int most_looks, core::Pose& pose, Look& seen,
                             int& looks) {
  for (int i = 0; i < most_looks; ++i) {
    ++looks;
    if (!look(frame, tag, pose, seen)) return false;
    Eigen::Vector3d change = seen.change();
    const double length = in_pixels(change);
    // The linear picture ends about a module away.
    change *= std::min(1.0, 1.2 * px_per_module_ / std::max(length, 1e-9));
    step(change, pose);
    if (length < small_step_px) return true;
  }
  return false;
}

/// Part of the tag is hidden or shines: the same fit, with less weight for points the further off they are, and none
/// for the worst. false: too few are left.
bool PhotometricFit::trim(const Frame& frame, const TagTemplate& tag, core::Pose& pose, Look& seen,
                          Eigen::Matrix3d& covariance, int& looks) {
  using Vector = Eigen::Matrix<double, TagTemplate::rigid_columns, 1>;
  constexpr int rounds = 4;
  Vector solution = seen.solution;
  for (int round = 0; round < rounds; ++round) {
    ++looks;
    if (!look(frame, tag, pose, seen)) return false;
    if (round > 0) solution.head<3>().setZero();  // the step has been made
    const auto residual = [&](std::size_t i) {
      return static_cast<double>(values_[i]) - solution.dot(tag.row(i).head<TagTemplate::rigid_columns>());
    };
    for (std::size_t i = 0; i < SampleGrid::points; ++i) sorted_[i] = static_cast<float>(std::abs(residual(i)));
    std::nth_element(sorted_.begin(), sorted_.begin() + SampleGrid::points / 2, sorted_.end());
    const double scale = std::max(1.0, 1.4826 * static_cast<double>(sorted_[SampleGrid::points / 2]));

    TagTemplate::Rigid normal = TagTemplate::Rigid::Zero();
    Vector seen_columns = Vector::Zero();
    double weights = 0.0;
    for (std::size_t i = 0; i < SampleGrid::points; ++i) {
      const double weight = tukey(residual(i), scale);
      const Vector row = tag.row(i).head<TagTemplate::rigid_columns>();
      normal += weight * row * row.transpose();
      seen_columns += weight * static_cast<double>(values_[i]) * row;
      weights += weight;
    }
    // More than two modules of ten hidden: what is left may not be enough to tell this tag from another.
    if (weights < 0.7 * static_cast<double>(SampleGrid::points)) return false;
    const TagTemplate::Rigid inverse = normal.inverse();
    solution = inverse * seen_columns;
    const double gain = solution[TagTemplate::paper];
    if (!(gain >= options_.least_contrast)) return false;
    const Eigen::Vector3d change = -solution.head<3>() / gain;
    if (in_pixels(change) > px_per_module_) return false;
    step(change, pose);
    covariance = inverse.topLeftCorner<3, 3>() * (scale * scale / (gain * gain));
    if (round > 0 && in_pixels(change) < small_step_px) return true;
  }
  return false;
}

/// From a step's (modules, in the tag's frame) to a pose's (metres, in the world).
Eigen::Matrix3d PhotometricFit::in_world(const Eigen::Matrix3d& of_step, const core::Pose& pose) const {
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  turned.topLeftCorner<2, 2>() << std::cos(pose.theta), -std::sin(pose.theta), std::sin(pose.theta),
      std::cos(pose.theta);
  turned.topLeftCorner<2, 2>() *= module_;
  return turned * of_step * turned.transpose();
}

double PhotometricFit::least_likeness(double px_per_module) const {
  return std::max(options_.least_correlation, likeness_of_others(sharp_sigma_px / px_per_module) + 0.02);
}

Fit PhotometricFit::fit(const Frame& frame, TagModel& model, const core::Pose& from) {
  map_ = plane_.around(from.x, from.y, map_radius * module_);
  px_per_module_ = map_.px_per_metre() * module_;
  Fit result;
  if (!(px_per_module_ > 0.5 && px_per_module_ < 1e3)) return result;
  const TagTemplate& tag = model.sharp(px_per_module_);
  const double least = least_likeness(px_per_module_);

  // As a rule the prediction is good to a pixel. Where it is not, the smooth template leads the sharp one there.
  Look seen;
  result.pose = from;
  bool arrived = descend(frame, tag, 6, result.pose, seen, result.looks) && seen.correlation >= least;
  if (!arrived) {
    result.pose = from;
    descend(frame, model.smooth(), 6, result.pose, seen, result.looks);
    arrived = descend(frame, tag, 10, result.pose, seen, result.looks);
  }
  const double way = std::hypot(result.pose.x - from.x, result.pose.y - from.y) / module_;
  const bool strayed = way > std::max(longest_way, longest_way_px / px_per_module_) ||
                       std::abs(core::wrap_angle(result.pose.theta - from.theta)) > longest_turn;
  result.correlation = seen.correlation;
  if (seen.outside) result.verdict = FitVerdict::outside;
  if (!arrived || strayed || seen.correlation < least) return result;

  Free free = explain(tag, seen);
  if (free.explained < clean_correlation) {
    Eigen::Matrix3d of_step;
    if (!trim(frame, tag, result.pose, seen, of_step, result.looks)) return result;
    if (seen.correlation < least) return result;
    free = explain(tag, seen);
    const double shared = shared_noise(static_cast<double>(SampleGrid::pitch) * px_per_module_);
    result.covariance = in_world(shared * of_step, result.pose);
  } else {
    std::array<float, TagTemplate::columns> solution{};
    for (int i = 0; i < TagTemplate::columns; ++i)
      solution[static_cast<std::size_t>(i)] = static_cast<float>(free.solution[i]);
    const auto noise = static_cast<double>(felt_noise(options_.instructions, tag, values_, solution));
    result.covariance =
        in_world(noise / (seen.gain() * seen.gain()) * tag.rigid_inverse.topLeftCorner<3, 3>(), result.pose);
  }
  result.correlation = seen.correlation;
  result.contrast = seen.gain();
  result.noise = std::sqrt(free.residual / static_cast<double>(SampleGrid::points)) / between_pixels;
  result.edge_px = 8.0 * px_per_module_;

  const double sigma2 = free.residual / static_cast<double>(SampleGrid::points) / (seen.gain() * seen.gain());
  const Eigen::Vector3d stretch = -free.solution.segment<3>(TagTemplate::stretch_x) / free.solution[TagTemplate::paper];
  const auto& f = tag.full_inverse;
  constexpr int in_x = TagTemplate::stretch_x;
  constexpr int in_y = TagTemplate::stretch_y;
  result.stretch = 0.5 * (stretch[0] + stretch[1]);
  result.stretch_sigma = std::sqrt(0.25 * sigma2 * (f(in_x, in_x) + f(in_y, in_y) + 2.0 * f(in_x, in_y)));
  result.strain = std::abs(result.stretch) + std::hypot(0.5 * (stretch[0] - stretch[1]), stretch[2]);

  const double sharper = std::min(free.solution[TagTemplate::blur_x], free.solution[TagTemplate::blur_y]);
  result.blur_px = px_per_module_ * blur_of(tag.sigma, sharper / free.solution[TagTemplate::paper]);

  // In AprilTag's order.
  constexpr double corner[4][2] = {{-4, -4}, {4, -4}, {4, 4}, {-4, 4}};
  const double c = std::cos(result.pose.theta) * module_;
  const double s = std::sin(result.pose.theta) * module_;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d at = plane_.pixel(result.pose.x + c * corner[i][0] - s * corner[i][1],
                                            result.pose.y + s * corner[i][0] + c * corner[i][1]);
    result.corners[i] = {at.x(), at.y()};
  }
  const bool in_shape = result.strain <= options_.strain_tolerance + 4.0 * result.stretch_sigma;
  result.verdict = in_shape ? FitVerdict::good : FitVerdict::misshapen;
  return result;
}

}  // namespace skein::vision::detail
