#include "vision/calibrate/joint_calibration.h"

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace skein::vision {
namespace {

constexpr std::size_t least_places = 20;
constexpr double least_spread = 0.02;        // of the places, across the line that fits them best, rms [m]
constexpr double most_apart = 5e-3;          // of poses that are corrected, rms [m]
constexpr double next_place = 5e-3;          // a robot that stands is at one place, not at hundreds [m]
constexpr double longest_gap = 0.1;          // between two poses of a camera, to know one in between [s]
constexpr double fastest = 1.0;              // a robot; what moves quicker has been carried, or is another [m/s]
constexpr double sigma_xy = 1e-3;            // of the cells below: what lenses leave, more than noise [m]
constexpr double sigma_heading = 2e-3;       // [rad]
constexpr double cell = 0.1;                 // places so near to one another share the lenses' errors [m]
constexpr double tilt_sigma = 5e-3;          // of floor calibrations by marks [rad]
constexpr double height_sigma = 5e-3;        // [m]
constexpr double late_sigma = 10e-3;         // of stamps [s]
constexpr double huber = 2.0;                // from so many standard deviations on, residuals count linearly
constexpr Eigen::Index parameters_each = 7;  // tilt about x and y, turn about z, shift by x, y and z, lateness
using Parameters = Eigen::Matrix<double, parameters_each, 1>;

/// One robot at one time, by two cameras.
struct Place {
  std::size_t first, second;
  core::Pose by_first, by_second;  // by the calibrations given
  Eigen::Vector3d velocity;        // of place and heading [m/s, rad/s]
  double weight = 1.0;
};

/// Where a camera that hangs otherwise than was thought sees a point of the tags' plane.
Eigen::Vector2d seen_from(const CameraPose& thought, const CameraPose& now, double height, const Eigen::Vector2d& p) {
  const Eigen::Vector3d in_camera =
      thought.rotation.transpose() * (Eigen::Vector3d(p.x(), p.y(), height) - thought.position);
  const Eigen::Vector3d ray = now.rotation * in_camera;
  return (now.position + (height - now.position.z()) / ray.z() * ray).head<2>();
}

core::Pose seen_from(const CameraPose& thought, const CameraPose& now, double height, const core::Pose& pose) {
  constexpr double ahead = 0.01;  // [m]
  const Eigen::Vector2d p(pose.x, pose.y), heading(std::cos(pose.theta), std::sin(pose.theta));
  const Eigen::Vector2d at = seen_from(thought, now, height, p);
  const Eigen::Vector2d along = seen_from(thought, now, height, Eigen::Vector2d(p + ahead * heading)) - at;
  return {at.x(), at.y(), std::atan2(along.y(), along.x())};
}

CameraPose turned(const CameraPose& pose, double turn, const Eigen::Vector2d& shift) {
  const Eigen::Matrix3d about_z = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return {about_z * pose.rotation, about_z * pose.position + Eigen::Vector3d(shift.x(), shift.y(), 0.0)};
}

CameraPose corrected(const CameraPose& pose, const Parameters& by) {
  const Eigen::Vector3d turn = by.head<3>();
  const double angle = turn.norm();
  const Eigen::Matrix3d rotation =
      angle > 0.0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity().eval();
  return {rotation * pose.rotation, pose.position + by.segment<3>(3)};
}

/// The sights of one tag, in the order of their times.
using Track = std::vector<const TagPose*>;

/// A camera's pose of a tag at a time between two sights, and its velocity.
std::optional<std::pair<core::Pose, Eigen::Vector3d>> at_time(const Track& track, double t) {
  const auto after = std::lower_bound(track.begin(), track.end(), t,
                                      [](const TagPose* sight, double time) { return sight->captured_at < time; });
  if (after == track.end() || after == track.begin()) return {};
  const TagPose &a = **std::prev(after), &b = **after;
  const double gap = b.captured_at - a.captured_at;
  if (gap > longest_gap) return {};
  const Eigen::Vector2d way(b.pose.x - a.pose.x, b.pose.y - a.pose.y);
  if (way.norm() > fastest * gap) return {};
  const double share = (t - a.captured_at) / gap, turn = core::wrap_angle(b.pose.theta - a.pose.theta);
  const core::Pose pose{a.pose.x + share * way.x(), a.pose.y + share * way.y(),
                        core::wrap_angle(a.pose.theta + share * turn)};
  return std::pair(pose, Eigen::Vector3d(way.x() / gap, way.y() / gap, turn / gap));
}

std::vector<Place> common_places(const std::vector<std::vector<TagPose>>& sights) {
  std::vector<std::map<int, Track>> tracks(sights.size());
  for (std::size_t camera = 0; camera < sights.size(); ++camera)
    for (const TagPose& sight : sights[camera]) tracks[camera][sight.tag].push_back(&sight);
  std::vector<Place> places;
  for (std::size_t first = 0; first < sights.size(); ++first)
    for (std::size_t second = first + 1; second < sights.size(); ++second)
      for (const auto& [tag, track] : tracks[second]) {
        const auto other = tracks[first].find(tag);
        if (other == tracks[first].end()) continue;
        const TagPose* last = nullptr;
        for (const TagPose* const sight : track) {
          if (last && core::distance(last->pose, sight->pose) < next_place) continue;
          const auto by_first = at_time(other->second, sight->captured_at);
          if (!by_first) continue;
          places.push_back({first, second, by_first->first, sight->pose, by_first->second});
          last = sight;
        }
      }
  // A cell counts as one place, however often robots came through.
  const auto cell_of = [](const Place& place) {
    return std::tuple(place.first, place.second, std::lround(place.by_second.x / cell),
                      std::lround(place.by_second.y / cell));
  };
  std::map<decltype(cell_of(places.front())), int> in_cell;
  for (const Place& place : places) ++in_cell[cell_of(place)];
  for (Place& place : places) place.weight = 1.0 / std::sqrt(in_cell[cell_of(place)]);
  return places;
}

/// The places that two cameras have in common.
std::vector<const Place*> between(const std::vector<Place>& places, std::size_t a, std::size_t b) {
  std::vector<const Place*> common;
  for (const Place& place : places)
    if (std::minmax(a, b) == std::minmax(place.first, place.second)) common.push_back(&place);
  return common;
}

/// The places' rms distance from the line that fits them best.
double spread(const std::vector<const Place*>& places) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  const auto at = [](const Place* place) { return Eigen::Vector2d(place->by_second.x, place->by_second.y); };
  const double n = static_cast<double>(places.size());
  for (const Place* place : places) mean += at(place) / n;
  Eigen::Matrix2d moment = Eigen::Matrix2d::Zero();
  for (const Place* place : places) moment += (at(place) - mean) * (at(place) - mean).transpose() / n;
  const double half = 0.5 * moment.trace();
  return std::sqrt(std::max(0.0, half - std::sqrt(std::max(0.0, half * half - moment.determinant()))));
}

/// All cameras, their places, and what the least squares ask of them.
class Cameras {
 public:
  Cameras(const std::vector<Calibration>& calibrations, const std::vector<Place>& places, std::size_t reference)
      : calibrations_(calibrations), places_(places), reference_(reference), height_(calibrations[0].tag_height) {
    for (const Calibration& calibration : calibrations) start_.push_back(*calibration.world_from_camera);
  }

  /// Turns and shifts camera after camera to where those that are tied to the reference already see the robots. The
  /// error: one cannot be tied.
  tl::expected<void, std::string> tie() {
    std::vector<bool> tied(start_.size());
    tied[reference_] = true;
    for (std::size_t round = 1; round < start_.size(); ++round) {
      std::string why;
      bool found = false;
      for (std::size_t to = 0; to < start_.size() && !found; ++to)
        for (std::size_t from = 0; from < start_.size() && !found; ++from) {
          if (tied[to] || !tied[from]) continue;
          const auto link = between(places_, from, to);
          const std::string untied = doubt(from, to, link);
          if (why.empty() || !link.empty()) why = untied.empty() ? why : untied;
          if (!untied.empty()) continue;
          lay(to, from, link);
          found = tied[to] = true;
        }
      if (!found) return tl::unexpected(why);
    }
    return {};
  }

  Eigen::Index parameters() const { return parameters_each * static_cast<Eigen::Index>(start_.size() - 1); }
  Eigen::Index residuals() const { return 3 * static_cast<Eigen::Index>(places_.size()) + 4 * (parameters() / 7); }

  CameraPose pose(std::size_t camera, const Eigen::VectorXd& x) const {
    return camera == reference_ ? start_[camera] : corrected(start_[camera], part(camera, x));
  }
  double late(std::size_t camera, const Eigen::VectorXd& x) const {
    return camera == reference_ ? 0.0 : part(camera, x)[6];
  }
  /// A place by one of its cameras.
  core::Pose seen(std::size_t camera, const core::Pose& pose_given, const CameraPose& now) const {
    return seen_from(*calibrations_[camera].world_from_camera, now, height_, pose_given);
  }

  void residuals(const Eigen::VectorXd& x, Eigen::VectorXd& out) const {
    std::vector<CameraPose> poses;
    for (std::size_t camera = 0; camera < start_.size(); ++camera) poses.push_back(pose(camera, x));
    Eigen::Index row = 0;
    for (const Place& place : places_) {
      const core::Pose a = seen(place.first, place.by_first, poses[place.first]);
      const core::Pose b = seen(place.second, place.by_second, poses[place.second]);
      const double late_by = late(place.second, x) - late(place.first, x);
      Eigen::Vector3d off;
      off.head<2>() = (Eigen::Vector2d(b.x - a.x, b.y - a.y) + late_by * place.velocity.head<2>()) / sigma_xy;
      off[2] = core::wrap_angle(b.theta - a.theta + late_by * place.velocity[2]) / sigma_heading;
      const double size = off.norm();
      const double loss = size > huber ? std::sqrt(2.0 * huber * size - huber * huber) / size : 1.0;
      out.segment<3>(row) = place.weight * loss * off;
      row += 3;
    }
    for (std::size_t camera = 0; camera < start_.size(); ++camera) {
      if (camera == reference_) continue;
      const Parameters by = part(camera, x);
      out[row++] = by[0] / tilt_sigma;
      out[row++] = by[1] / tilt_sigma;
      out[row++] = by[5] / height_sigma;
      out[row++] = by[6] / late_sigma;
    }
  }

  Eigen::Index first_of(std::size_t camera) const {
    return parameters_each * static_cast<Eigen::Index>(camera > reference_ ? camera - 1 : camera);
  }

 private:
  Parameters part(std::size_t camera, const Eigen::VectorXd& x) const {
    return x.segment<parameters_each>(first_of(camera));
  }

  static std::string doubt(std::size_t from, std::size_t to, const std::vector<const Place*>& link) {
    if (link.size() < least_places)
      return fmt::format(
          "cameras {} and {} saw a robot at one time at {} places; needed: {} or more: let robots drive "
          "where both see them",
          from + 1, to + 1, link.size(), least_places);
    if (const double across = spread(link); across < least_spread)
      return fmt::format(
          "the robots that cameras {} and {} both saw drove on one line (off it by {:.0f} mm, rms); "
          "needed: {:.0f} mm or more: let them drive along the seam as well as across",
          from + 1, to + 1, 1e3 * across, 1e3 * least_spread);
    return {};
  }

  /// The turn and shift of `to` that lays its places on those of `from`.
  void lay(std::size_t to, std::size_t from, const std::vector<const Place*>& link) {
    const auto n = static_cast<Eigen::Index>(link.size());
    Eigen::Matrix2Xd given(2, n), wanted(2, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Place& place = *link[static_cast<std::size_t>(k)];
      const core::Pose mine = place.first == to ? place.by_first : place.by_second;
      const core::Pose other = seen(from, place.first == to ? place.by_second : place.by_first, start_[from]);
      given.col(k) = Eigen::Vector2d(mine.x, mine.y);
      wanted.col(k) = Eigen::Vector2d(other.x, other.y);
    }
    const Eigen::Matrix3d rigid = Eigen::umeyama(given, wanted, /*with_scaling=*/false);
    start_[to] = turned(start_[to], std::atan2(rigid(1, 0), rigid(0, 0)), rigid.topRightCorner<2, 1>());
  }

  const std::vector<Calibration>& calibrations_;
  const std::vector<Place>& places_;
  const std::size_t reference_;
  const double height_;            // of the tags
  std::vector<CameraPose> start_;  // where the search begins
};

/// As Eigen's Levenberg-Marquardt wants it.
struct Problem {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };
  const Cameras& cameras;

  int inputs() const { return static_cast<int>(cameras.parameters()); }
  int values() const { return static_cast<int>(cameras.residuals()); }
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& out) const {
    cameras.residuals(x, out);
    return 0;
  }
};

/// A place as two cameras see it with calibrations that may have been corrected.
std::pair<core::Pose, core::Pose> seen_by_both(const Place& place, const std::vector<Calibration>& given,
                                               const std::vector<Calibration>& now) {
  const auto by = [&](std::size_t camera, const core::Pose& pose) {
    return seen_from(*given[camera].world_from_camera, *now[camera].world_from_camera, given[camera].tag_height, pose);
  };
  return {by(place.first, place.by_first), by(place.second, place.by_second)};
}

/// The places at which both cameras agree when corrected about as well as at most others.
std::vector<const Place*> fitting(const std::vector<const Place*>& places, const std::vector<Calibration>& given,
                                  const std::vector<Calibration>& now) {
  constexpr double usual = 4.0, lens = 1e-3;  // times the median; more than that [m]
  std::vector<double> all;
  const auto apart = [&](const Place& place) {
    const auto [a, b] = seen_by_both(place, given, now);
    return core::distance(a, b);
  };
  all.reserve(places.size());
  for (const Place* place : places) all.push_back(apart(*place));
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  std::vector<const Place*> fit;
  for (const Place* place : places)
    if (apart(*place) <= usual * *middle + lens) fit.push_back(place);
  return fit;
}

/// How far the poses of two cameras are apart at their places.
JointPair::Apart apart(const std::vector<const Place*>& places, const std::vector<Calibration>& given,
                       const std::vector<Calibration>& now) {
  JointPair::Apart result;
  double squares = 0.0, turns = 0.0;
  for (const Place* place : places) {
    const auto [a, b] = seen_by_both(*place, given, now);
    const double off = core::distance(a, b), turn = core::wrap_angle(b.theta - a.theta);
    squares += off * off;
    turns += turn * turn;
    result.worst = std::max(result.worst, off);
  }
  const double n = static_cast<double>(places.size());
  result.rms = std::sqrt(squares / n);
  result.heading = std::sqrt(turns / n);
  return result;
}

/// The largest standard deviation of a pose at the corners of the picture, by that of a camera's parameters.
double uncertainty(const Calibration& calibration, const Eigen::MatrixXd& covariance) {
  constexpr double step = 1e-5;
  double largest = 0.0;
  for (const double u : {0.0, calibration.width - 1.0})
    for (const double v : {0.0, calibration.height - 1.0}) {
      const auto corner = world_from_pixel(calibration, {u, v}, calibration.tag_height);
      if (!corner) continue;
      Eigen::Matrix<double, 2, parameters_each> slope;
      slope.setZero();
      for (Eigen::Index k = 0; k < 6; ++k) {
        const CameraPose& pose = *calibration.world_from_camera;
        const Parameters by = step * Parameters::Unit(k);
        slope.col(k) = (seen_from(pose, corrected(pose, by), calibration.tag_height, *corner) - *corner) / step;
      }
      largest = std::max(largest, std::sqrt((slope * covariance * slope.transpose()).trace()));
    }
  return largest;
}

/// A camera that hangs otherwise puts its marks elsewhere, too: they stay what shows that it has moved.
void correct(Calibration& calibration, const CameraPose& now) {
  const CameraPose thought = *calibration.world_from_camera;
  for (FloorMark& mark : calibration.marks) {
    const Eigen::Vector2d at = seen_from(thought, now, mark.z, Eigen::Vector2d(mark.x, mark.y));
    mark.x = at.x();
    mark.y = at.y();
  }
  calibration.world_from_camera = now;
}

/// What the places say of all cameras.
struct Solution {
  std::vector<Calibration> now;
  std::vector<double> known, late;  // see JointCamera
};
tl::expected<Solution, std::string> solve(const std::vector<Calibration>& calibrations,
                                          const std::vector<Place>& places, std::size_t reference) {
  Cameras cameras(calibrations, places, reference);
  if (const auto tied = cameras.tie(); !tied) return tl::unexpected(tied.error());
  Eigen::NumericalDiff<Problem, Eigen::Central> problem(Problem{cameras});
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Problem, Eigen::Central>> search(problem);
  const Eigen::Index n = cameras.parameters();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  search.minimize(x);
  Eigen::MatrixXd slopes(cameras.residuals(), n);
  problem.df(x, slopes);
  const Eigen::MatrixXd covariance = (slopes.transpose() * slopes).ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  Solution result{calibrations, std::vector<double>(calibrations.size()), std::vector<double>(calibrations.size())};
  for (std::size_t camera = 0; camera < calibrations.size(); ++camera) {
    if (camera == reference) continue;
    correct(result.now[camera], cameras.pose(camera, x));
    const Eigen::Index first = cameras.first_of(camera);
    result.known[camera] =
        uncertainty(result.now[camera], covariance.block<parameters_each, parameters_each>(first, first));
    result.late[camera] = cameras.late(camera, x);
  }
  return result;
}

std::string unfit(const std::vector<Calibration>& calibrations, std::size_t reference) {
  if (calibrations.size() < 2) return "one camera has nothing to agree with; needed: two or more";
  if (reference >= calibrations.size())
    return fmt::format("reference {}; allowed: 1 to {}", reference + 1, calibrations.size());
  for (std::size_t camera = 0; camera < calibrations.size(); ++camera) {
    const Calibration& one = calibrations[camera];
    if (!one.world_from_camera)
      return fmt::format("camera {} has no world frame yet: skein calibrate floor", camera + 1);
    if (one.tag_height != calibrations[0].tag_height || one.tag_size != calibrations[0].tag_size)
      return fmt::format(
          "[tags] of camera 1: height {:.1f} mm, size {:.1f} mm; of camera {}: height {:.1f} mm, size {:.1f} mm; "
          "needed: the same, for they see the same robots",
          1e3 * calibrations[0].tag_height, 1e3 * calibrations[0].tag_size, camera + 1, 1e3 * one.tag_height,
          1e3 * one.tag_size);
  }
  return {};
}

}  // namespace

tl::expected<JointCalibration, std::string> solve_joint(const std::vector<Calibration>& calibrations,
                                                        const std::vector<std::vector<TagPose>>& sights,
                                                        std::size_t reference) {
  if (std::string why = unfit(calibrations, reference); !why.empty()) return tl::unexpected(std::move(why));
  std::vector<Place> places = common_places(sights);
  auto found = solve(calibrations, places, reference);
  if (!found) return tl::unexpected(found.error());

  // Huber's loss limits what a pose of another robot does to the solution; without it, it does nothing.
  JointCalibration result;
  std::vector<Place> fit;
  for (std::size_t first = 0; first < calibrations.size(); ++first)
    for (std::size_t second = first + 1; second < calibrations.size(); ++second) {
      const std::vector<const Place*> common = between(places, first, second);
      if (common.empty()) continue;
      const std::vector<const Place*> kept = fitting(common, calibrations, found->now);
      for (const Place* const place : kept) fit.push_back(*place);
      const JointPair& pair =
          result.pairs.emplace_back(JointPair{first, second, common.size(), common.size() - kept.size(), {}, {}});
      if (4 * pair.left_out > pair.places)
        return tl::unexpected(fmt::format(
            "{} of the {} places of cameras {} and {} fit no correction; allowed: a quarter: were robots carried, or a "
            "camera moved?",
            pair.left_out, pair.places, first + 1, second + 1));
    }
  found = solve(calibrations, fit, reference);
  if (!found) return tl::unexpected(found.error());

  for (JointPair& pair : result.pairs) {
    const std::vector<const Place*> common = between(fit, pair.first, pair.second);
    pair.before = apart(common, calibrations, calibrations);
    pair.after = apart(common, calibrations, found->now);
    if (pair.after.rms > most_apart)
      return tl::unexpected(fmt::format(
          "cameras {} and {} still differ by {:.1f} mm (rms) when corrected; allowed: {:.0f} mm: is the lens of each "
          "calibrated for this focus and size, are [tags] height and size right, has a camera been moved meanwhile?",
          pair.first + 1, pair.second + 1, 1e3 * pair.after.rms, 1e3 * most_apart));
  }
  for (std::size_t camera = 0; camera < calibrations.size(); ++camera) {
    JointCamera& one =
        result.cameras.emplace_back(JointCamera{found->now[camera], 0.0, found->known[camera], found->late[camera]});
    double squares = 0.0;
    std::size_t n = 0;
    for (const Place& place : fit) {
      if (place.first != camera && place.second != camera) continue;
      const core::Pose& given = place.first == camera ? place.by_first : place.by_second;
      const core::Pose now = seen_from(*calibrations[camera].world_from_camera, *one.calibration.world_from_camera,
                                       calibrations[camera].tag_height, given);
      const double way = core::distance(given, now);
      squares += way * way;
      ++n;
    }
    if (n > 0) one.moved = std::sqrt(squares / static_cast<double>(n));
  }
  return result;
}

}  // namespace skein::vision
