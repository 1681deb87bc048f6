#include "vision/fit/photometric_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/small_matrix.h"

namespace skein::vision::detail {
namespace {

// Of the smooth template: with less it converges from less far; with more the bits melt into one grey. [modules]
constexpr double smooth_sigma = 1.2;

// Sizes share a template within this ratio.
constexpr double level_ratio = 1.25;

// Blurs that differ by less than this ratio share a template as well: noise does not change it.
constexpr double focus_ratio = 1.15;

// The most blur of a template, unless a camera in focus blurs by more: from here on tags look more alike. [modules]
constexpr double most_blur = 0.18;

// A step that moves no corner by more than this needs no successor: the next would be a tenth of it at most. [px]
constexpr double small_step_px = 0.1;

// Below this something is wrong that a clean tag's noise does not explain: a finger, a shadow, glare.
constexpr double clean_correlation = 0.98;

// Further from where it began, a fit has found something else.
constexpr double longest_way = 1.6;  // [modules], or
constexpr double longest_way_px = 6.0;
constexpr double longest_turn = 0.5;  // [rad]

// The picture's border may cut the paper, and the black frame, which all tags have: what tells them apart is inside.
// [modules]
constexpr double bits_reach = 3.25;

// The grid's edge. [modules]
constexpr double reach = static_cast<double>(SampleGrid::reach);

// A map's terms, which count in grid's edges, per module.
constexpr std::array<double, LocalMap::terms> per_module = [] {
  constexpr double one = 1.0 / reach, two = one * one, three = two * one;
  return std::array{1.0, one, one, two, two, two, three, three, three, three};
}();

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

/// How much an edge is blurred that differs by `bend` columns of blur from one blurred by sigma: the projection of the
/// one edge less the other onto that column, turned around. The integral over two blurred steps less two sharp ones is
/// the square root of the sum of both variances, but for a constant: with q = TagTemplate::blur_step, an edge of r
/// sigma has
///
///     bend / ((q^2 - 1) sigma^2 / 2) = n(r) / n(q), n(r) = sqrt(r^2 + 1) - sqrt(r^2 + q^2) + sqrt(1 + q^2) - sqrt(2).
///
/// Edges that lie close together hide a part of a large blur. [modules]
double blur_of(double sigma, double bend) {
  constexpr double q = TagTemplate::blur_step, gap = q * q - 1.0;
  const double without = std::sqrt(1.0 + q * q) - std::numbers::sqrt2;
  const double of_step = 2.0 * std::sqrt(1.0 + q * q) - std::numbers::sqrt2 * (1.0 + q);
  // sqrt(r^2 + q^2) - sqrt(r^2 + 1): q - 1 without any blur, and less the more there is.
  const double less = std::clamp(without - of_step * bend / (0.5 * gap * sigma * sigma), 0.1 * without, q - 1.0);
  const double root = 0.5 * (gap / less - less);  // sqrt(r^2 + 1)
  return sigma * std::sqrt(std::max(0.0, root * root - 1.0));
}

double tukey(double residual, double scale) {
  const double z = residual / (4.685 * scale);
  return std::abs(z) < 1.0 ? (1.0 - z * z) * (1.0 - z * z) : 0.0;
}

}  // namespace

const TagTemplate& TagModel::sharp(double px_per_module) {
  const double size = px_per_module * sharp_sigma_px / blur_px_;  // at which a camera in focus sees as much
  if (size > last_from_ && size < last_to_) return *last_sharp_;
  const int level = static_cast<int>(std::lround(std::log(size) / std::log(level_ratio)));
  // For as good as all that are rounded to it.
  last_from_ = std::pow(level_ratio, level - 0.499);
  last_to_ = std::pow(level_ratio, level + 0.499);
  for (const auto& [known, tag] : sharp_)
    if (known == level) return *(last_sharp_ = tag.get());
  const double sigma = sharp_sigma_px / std::pow(level_ratio, level);
  sharp_.emplace_back(level, std::make_unique<TagTemplate>(pattern_, sigma));
  return *(last_sharp_ = sharp_.back().second.get());
}

bool TagModel::refocus(double blur_px, double px_per_module) {
  blur_px = std::clamp(blur_px, sharp_sigma_px, std::max(sharp_sigma_px, most_blur * px_per_module));
  const bool another = blur_px > focus_ratio * blur_px_ || blur_px_ > focus_ratio * blur_px;
  if (!another) return false;
  blur_px_ = blur_px;
  return true;
}

void TagModel::fetch() const {
  constexpr std::size_t line = 64;
  if (last_sharp_ == nullptr) return;
  const auto* const bytes = reinterpret_cast<const char*>(last_sharp_);
  const auto* const end = reinterpret_cast<const char*>(&last_sharp_->normal);  // seldom needed
  for (const char* at = bytes; at < end; at += line) __builtin_prefetch(at);
}

const TagTemplate& TagModel::smooth() {
  if (!smooth_) smooth_ = std::make_unique<TagTemplate>(pattern_, smooth_sigma);
  return *smooth_;
}

/// What a look at the picture says.
struct PhotometricFit::Look {
  Sums sums;
  std::array<double, TagTemplate::rigid_columns> solution;  // gain * (-dx, -dy, -dtheta), gain, offset, light
  double correlation = 0.0;
  double scatter = 0.0;  // sum of squares around the mean
  double points = 0.0;   // that were looked at
  bool outside = false;  // not all of the tag is in the picture
  bool cut = false;      // not all of its white border is
  double gain() const { return solution[TagTemplate::paper]; }
  Eigen::Vector3d change() const {  // (dx, dy) in modules, dtheta
    return Eigen::Vector3d(solution[0], solution[1], solution[2]) / -gain();
  }
};

/// The same look, with the tag free to stretch, shear, blur and change its tone.
struct PhotometricFit::Free {
  std::array<double, TagTemplate::columns> solution;
  double residual = 0.0;   // sum of squares that it leaves
  double explained = 0.0;  // multiple correlation of grey levels and columns
};

PhotometricFit::PhotometricFit(const PlaneMap& map, double module, bool exact, const FitOptions& options)
    : plane_(map), module_(module), exact_(exact), options_(options), sorted_(SampleGrid::points) {
  left_out_.reserve(SampleGrid::points);
}

/// Makes the map for looks at this pose.
void PhotometricFit::aim(const core::Pose& pose) {
  map_ = plane_.around(pose.x, pose.y, reach * module_, std::cos(pose.theta), std::sin(pose.theta));
}

/// false: not all of the tag is in the picture, or there is nothing to be seen.
bool PhotometricFit::look(const Frame& frame, const TagTemplate& tag, Look& look) {
  const LocalMap::Box box = map_.corners();
  // One pixel to spare for sides that the lens bends, and four bytes are read from every place on.
  look.cut = !(box.left >= 1.0 && box.top >= 1.0 && box.right + 5.0 < frame.width && box.bottom + 3.0 < frame.height);
  if (look.cut) {
    const LocalMap::Box bits = map_.corners(bits_reach / reach);
    look.outside =
        !(bits.left > 0.0 && bits.top > 0.0 && bits.right < frame.width - 1 && bits.bottom < frame.height - 1);
  }
  if (look.cut && look.outside) return false;
  look.outside = false;
  const int left = std::max(0, static_cast<int>(box.left) - 1);
  const int top = std::max(0, static_cast<int>(box.top) - 1);
  // At the border two bytes are read from a place, and by the baseline's instructions.
  const int most_u = frame.width - left - (look.cut ? 2 : 5);
  const int most_v = frame.height - top - (look.cut ? 2 : 3);
  const Instructions instructions = look.cut ? Instructions::baseline : options_.instructions;

  if (exact_) {
    const double c = map_.c * module_, s = map_.s * module_;
    for (std::size_t i = 0; i < SampleGrid::count; ++i) {
      const auto x = static_cast<double>(sample_grid.x[i % SampleGrid::across]);
      const auto y = static_cast<double>(sample_grid.y[i / SampleGrid::across]);
      const Eigen::Vector2d at = plane_.pixel(map_.x + c * x - s * y, map_.y + s * x + c * y);
      places_.u[i] = static_cast<float>(std::clamp(at.x() - left, 0.0, static_cast<double>(most_u)));
      places_.v[i] = static_cast<float>(std::clamp(at.y() - top, 0.0, static_cast<double>(most_v)));
    }
  } else {
    FloatMap map;
    for (std::size_t i = 0; i < LocalMap::terms; ++i) {
      map.u[i] = static_cast<float>((map_.u[i] - (i == 0 ? left : 0)) * per_module[i]);
      map.v[i] = static_cast<float>((map_.v[i] - (i == 0 ? top : 0)) * per_module[i]);
    }
    map.most_u = static_cast<float>(most_u);
    map.most_v = static_cast<float>(most_v);
    place_points(instructions, map, places_);
  }
  look_at_points(instructions, {frame.row(top) + left, frame.width}, places_, tag, values_, look.sums);

  const auto& sum = look.sums.sum;
  constexpr auto columns = static_cast<std::size_t>(TagTemplate::rigid_columns);
  look.solution = {};
  look.points = static_cast<double>(SampleGrid::points);
  if (look.cut) {
    if (!leave_out(tag, static_cast<float>(most_u), static_cast<float>(most_v), look)) return false;
  } else {
    for (std::size_t k = 0; k < columns; ++k)
      for (std::size_t i = 0; i < columns; ++i) look.solution[i] += tag.rigid_inverse[k * columns + i] * sum[k];
  }
  double residual = sum[Sums::square];
  for (std::size_t i = 0; i < columns; ++i) residual -= look.solution[i] * sum[i];
  look.scatter = sum[Sums::square] - sum[TagTemplate::constant] * sum[TagTemplate::constant] / look.points;
  look.correlation = std::sqrt(std::max(0.0, 1.0 - std::max(0.0, residual) / (look.scatter + 1e-9)));
  return look.gain() >= options_.least_contrast;
}

/// Points that the picture's border held back say nothing: the sums and the normal matrix without them, and the
/// solution. false: they are too many.
bool PhotometricFit::leave_out(const TagTemplate& tag, float most_u, float most_v, Look& look) {
  constexpr double least_points = 0.75;  // of all of them
  auto& sum = look.sums.sum;
  cut_normal_ = tag.normal;
  left_out_.clear();
  for (std::size_t i = 0; i < SampleGrid::points; ++i) {
    const std::size_t place = SampleGrid::place_of(i);
    const float u = places_.u[place], v = places_.v[place];
    if (u > 0.0F && v > 0.0F && u < most_u && v < most_v) continue;
    const auto row = tag.row(i);
    const auto value = static_cast<double>(values_[place]);
    for (std::size_t k = 0; k < Sums::square; ++k) sum[k] -= value * row[static_cast<Eigen::Index>(k)];
    sum[Sums::square] -= value * value;
    cut_normal_ -= row * row.transpose();
    left_out_.push_back(i);
  }
  look.points -= static_cast<double>(left_out_.size());
  if (look.points < least_points * static_cast<double>(SampleGrid::points)) return false;
  using Vector = Eigen::Matrix<double, TagTemplate::rigid_columns, 1>;
  const TagTemplate::Rigid rigid = cut_normal_.topLeftCorner<TagTemplate::rigid_columns, TagTemplate::rigid_columns>();
  Vector::Map(look.solution.data()) = rigid.llt().solve(Vector::Map(sum.data()));
  return true;
}

PhotometricFit::Free PhotometricFit::explain(const TagTemplate& tag, const Look& look) const {
  const auto& sum = look.sums.sum;
  constexpr auto columns = static_cast<std::size_t>(TagTemplate::columns);
  Free free;
  free.solution = {};
  for (std::size_t k = 0; k < columns; ++k)
    for (std::size_t i = 0; i < columns; ++i)
      free.solution[i] +=
          (look.cut ? cut_inverse_.data()[k * columns + i] : static_cast<double>(tag.full_inverse[k * columns + i])) *
          sum[k];
  free.residual = sum[Sums::square];
  for (std::size_t i = 0; i < columns; ++i) free.residual -= free.solution[i] * sum[i];
  free.residual = std::max(0.0, free.residual);
  free.explained = std::sqrt(std::max(0.0, 1.0 - free.residual / (look.scatter + 1e-9)));
  return free;
}

/// Moves the pose by a step from where the last look was aimed.
void PhotometricFit::step(const Eigen::Vector3d& change, core::Pose& pose) const {
  pose.x += module_ * (map_.c * change.x() - map_.s * change.y());
  pose.y += module_ * (map_.s * change.x() + map_.c * change.y());
  pose.theta = core::wrap_angle(pose.theta + change.z());
}

/// How far a step moves the corners of the black square, four modules away.
double PhotometricFit::in_pixels(const Eigen::Vector3d& change) const {
  return px_per_module_ * (change.head<2>().norm() + 4.0 * std::abs(change.z()));
}

/// Gauss and Newton, from a pose that was aimed at. false: no step became small.
bool PhotometricFit::descend(const Frame& frame, const TagTemplate& tag, int most_looks, core::Pose& pose, Look& seen,
                             int& looks) {
  for (int i = 0; i < most_looks; ++i) {
    ++looks;
    if (i > 0) aim(pose);
    if (!look(frame, tag, seen)) return false;
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
  using Vector = Eigen::Matrix<double, TagTemplate::optical_columns, 1>;
  constexpr int rounds = 4;
  Vector solution = Vector::Zero();
  solution.head<TagTemplate::rigid_columns>() =
      Eigen::Matrix<double, TagTemplate::rigid_columns, 1>::Map(seen.solution.data());
  for (int round = 0; round < rounds; ++round) {
    ++looks;
    aim(pose);
    if (!look(frame, tag, seen) || seen.cut) return false;
    if (round > 0) solution.head<3>().setZero();  // the step has been made
    const auto residual = [&](std::size_t i) {
      return static_cast<double>(values_[SampleGrid::place_of(i)]) -
             solution.dot(tag.row(i).head<TagTemplate::optical_columns>());
    };
    for (std::size_t i = 0; i < SampleGrid::points; ++i) sorted_[i] = static_cast<float>(std::abs(residual(i)));
    std::nth_element(sorted_.begin(), sorted_.begin() + SampleGrid::points / 2, sorted_.end());
    const double scale = std::max(1.0, 1.4826 * static_cast<double>(sorted_[SampleGrid::points / 2]));

    TagTemplate::Optical normal = TagTemplate::Optical::Zero();
    Vector seen_columns = Vector::Zero();
    double weights = 0.0;
    for (std::size_t i = 0; i < SampleGrid::points; ++i) {
      const double weight = tukey(residual(i), scale);
      const Vector row = tag.row(i).head<TagTemplate::optical_columns>();
      normal += weight * row * row.transpose();
      seen_columns += weight * static_cast<double>(values_[SampleGrid::place_of(i)]) * row;
      weights += weight;
    }
    // More than two modules of ten hidden: what is left may not be enough to tell this tag from another.
    if (weights < 0.7 * static_cast<double>(SampleGrid::points)) return false;
    const TagTemplate::Optical inverse = core::math::inverse(normal);
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

/// From a step's (modules, in the tag's frame) to a pose's (metres, in the world). c, s: of the heading.
Eigen::Matrix3d PhotometricFit::in_world(const Eigen::Matrix3d& of_step, double c, double s) const {
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  turned.topLeftCorner<2, 2>() << c, -s, s, c;
  turned.topLeftCorner<2, 2>() *= module_;
  return turned * of_step * turned.transpose();
}

double PhotometricFit::felt(const TagTemplate& tag, const Free& free) const {
  std::array<float, TagTemplate::columns> solution;
  for (std::size_t i = 0; i < solution.size(); ++i) solution[i] = static_cast<float>(free.solution[i]);
  return static_cast<double>(felt_noise(options_.instructions, tag, values_, solution));
}

/// Makes the look's step that of a tag free to blur and to change its tone. Returns its covariance.
Eigen::Matrix3d PhotometricFit::settle(const TagTemplate& tag, const TagTemplate::LastStep& last_step, const Free& free,
                                       const Look& seen, core::Pose& pose) const {
  using Vector = Eigen::Matrix<double, TagTemplate::optical_columns, 1>;
  const Eigen::Vector3d change = last_step.cast<double>() * Vector::Map(seen.sums.sum.data()) / -seen.gain();
  step(change - seen.change(), pose);
  return felt(tag, free) / (seen.gain() * seen.gain()) * last_step.leftCols<3>().cast<double>();
}

double PhotometricFit::least_likeness(double px_per_module) const {
  return std::max(options_.least_correlation, likeness_of_others(sharp_sigma_px / px_per_module) + 0.02);
}

Fit PhotometricFit::fit(const Frame& frame, TagModel& model, const core::Pose& from) {
  aim(from);
  px_per_module_ = map_.px_per_metre() * module_;
  Fit result;
  if (!(px_per_module_ > 0.5 && px_per_module_ < 1e3)) return result;
  const TagTemplate* sharp = &model.sharp(px_per_module_);
  const double least = least_likeness(px_per_module_);

  // As a rule the prediction is good to a pixel. Where it is not, the smooth template leads the sharp one there.
  Look seen;
  result.pose = from;
  bool arrived = descend(frame, *sharp, 6, result.pose, seen, result.looks) && seen.correlation >= least;
  if (!arrived) {
    result.pose = from;
    aim(from);
    descend(frame, model.smooth(), 6, result.pose, seen, result.looks);
    aim(result.pose);
    arrived = descend(frame, *sharp, 10, result.pose, seen, result.looks);
  }
  const double way = std::hypot(result.pose.x - from.x, result.pose.y - from.y) / module_;
  const bool strayed = way > std::max(longest_way, longest_way_px / px_per_module_) ||
                       std::abs(core::wrap_angle(result.pose.theta - from.theta)) > longest_turn;
  result.correlation = seen.correlation;
  if (seen.outside) result.verdict = FitVerdict::outside;
  if (!arrived || strayed || seen.correlation < least) return result;

  const auto explained = [&] {
    if (seen.cut) cut_inverse_ = core::math::inverse(cut_normal_);
    return explain(*sharp, seen);
  };
  Free free = explained();
  const auto blur = [&] {
    const double sharper = std::min(free.solution[TagTemplate::blur_x], free.solution[TagTemplate::blur_y]);
    return px_per_module_ * blur_of(sharp->sigma, sharper / free.solution[TagTemplate::paper]);
  };
  // In a picture of another sharpness, what the columns of blur leave of it moves the tag.
  if (model.refocus(blur(), px_per_module_)) {
    sharp = &model.sharp(px_per_module_);
    ++result.looks;
    aim(result.pose);
    if (!look(frame, *sharp, seen) || seen.correlation < least) return result;
    step(seen.change(), result.pose);
    free = explained();
  }
  const TagTemplate& tag = *sharp;
  const bool covered = free.explained < clean_correlation;
  Eigen::Matrix3d of_step;
  if (covered && seen.cut) {
    result.verdict = FitVerdict::outside;
    return result;
  }
  if (seen.cut) {
    // Of paper that is not seen, nothing is felt.
    for (const std::size_t i : left_out_)
      values_[SampleGrid::place_of(i)] =
          static_cast<float>(Eigen::Matrix<double, TagTemplate::columns, 1>::Map(free.solution.data()).dot(tag.row(i)));
    of_step = settle(tag, TagTemplate::last_step_of(cut_normal_), free, seen, result.pose);
  } else if (covered) {
    if (!trim(frame, tag, result.pose, seen, of_step, result.looks)) return result;
    if (seen.correlation < least) return result;
    free = explain(tag, seen);
    of_step *= shared_noise(static_cast<double>(SampleGrid::pitch) * px_per_module_);
  } else {
    of_step = settle(tag, tag.last_step, free, seen, result.pose);
  }
  const double cosine = std::cos(result.pose.theta);
  const double sine = std::sin(result.pose.theta);
  result.covariance = in_world(of_step, cosine, sine);
  result.correlation = seen.correlation;
  result.contrast = seen.gain();
  result.noise = std::sqrt(free.residual / seen.points) / between_pixels;
  result.edge_px = 8.0 * px_per_module_;

  const double sigma2 = free.residual / seen.points / (seen.gain() * seen.gain());
  const auto full = [&](int i, int k) { return seen.cut ? cut_inverse_(i, k) : static_cast<double>(tag.full(i, k)); };
  // Without tone, which would take a part of a stretch for its own: whoever asks compares stretches, and gamma is the
  // same in all.
  constexpr int tone = TagTemplate::tone;
  const auto f = [&](int i, int k) { return full(i, k) - full(i, tone) * full(k, tone) / full(tone, tone); };
  Eigen::Vector3d stretch;
  for (int i = 0; i < 3; ++i) {
    const int column = TagTemplate::stretch_x + i;
    const double shared = full(column, tone) / full(tone, tone) * free.solution[tone];
    stretch[i] = (free.solution[static_cast<std::size_t>(column)] - shared) / -free.solution[TagTemplate::paper];
  }
  constexpr int in_x = TagTemplate::stretch_x;
  constexpr int in_y = TagTemplate::stretch_y;
  result.stretch = 0.5 * (stretch[0] + stretch[1]);
  result.stretch_sigma = std::sqrt(0.25 * sigma2 * (f(in_x, in_x) + f(in_y, in_y) + 2.0 * f(in_x, in_y)));
  result.strain = std::abs(result.stretch) + std::hypot(0.5 * (stretch[0] - stretch[1]), stretch[2]);

  result.blur_px = blur();

  // In AprilTag's order.
  constexpr double corner[4][2] = {{-4, -4}, {4, -4}, {4, 4}, {-4, 4}};
  const double c = cosine * module_;
  const double s = sine * module_;
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
