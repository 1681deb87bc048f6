#pragma once

#include <Eigen/Core>

#include <memory>
#include <utility>
#include <vector>

#include "core/geometry/pose.h"
#include "vision/fit/plane_map.h"
#include "vision/fit/sampling.h"
#include "vision/frames/frame.h"
#include "vision/tags/detection.h"
#include "vision/tags/tag_template.h"

namespace skein::vision::detail {

/// One tag's templates, for every size at which it has been seen. Not for two threads at once.
class TagModel {
 public:
  explicit TagModel(const TagPattern& pattern) : pattern_(pattern) {}
  /// The template for this module size [px], as blurred as the tag was when it was seen last: at first, and at least,
  /// as by a camera in focus.
  const TagTemplate& sharp(double px_per_module);
  /// Takes another blur (standard deviation) from now on. false: it is nearly the same as before.
  bool refocus(double blur_px, double px_per_module);
  /// Blurred by most of a module: a fit to it converges from further away.
  const TagTemplate& smooth();
  /// Prefetches the sharp template that was used last.
  void fetch() const;

 private:
  TagPattern pattern_;
  double blur_px_ = sharp_sigma_px;
  const TagTemplate* last_sharp_ = nullptr;
  double last_from_ = 0.0;  // last_sharp_ is valid above this and below last_to_ [px per module, in focus]
  double last_to_ = 0.0;
  std::vector<std::pair<int, std::unique_ptr<TagTemplate>>> sharp_;
  std::unique_ptr<TagTemplate> smooth_;
};

enum class FitVerdict {
  good,
  outside,    // too much of the tag is not in the picture: more than its paper and a part of its black frame
  unlike,     // does not look like this tag, or too much of it is hidden
  misshapen,  // looks like it, but is larger, smaller or tilted
};

struct Fit {
  FitVerdict verdict = FitVerdict::unlike;
  core::Pose pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of (x, y, theta) [m, rad], from the residual
  double correlation = 0.0;                              // normalised, with this tag's pattern
  double contrast = 0.0;                                 // between ink and paper [grey levels]
  double noise = 0.0;                                    // of a pixel, from the residual [grey levels]
  double stretch = 0.0;  // how much larger than its size on the plane it seems to be, as a part of it
  double stretch_sigma = 0.0;
  double strain = 0.0;   // the largest stretch in any direction
  double edge_px = 0.0;  // of the black square
  double blur_px = 0.0;  // standard deviation, along the sharper axis of the tag: the other may be blurred by motion
  Corners corners{};     // [px]
  int looks = 0;         // at the picture
};

struct FitOptions {
  double least_correlation = 0.85;  // more where modules are so small that blur makes tags alike
  double least_contrast = 6.0;      // [grey levels]
  double strain_tolerance = 0.06;   // as TrackerOptions::shape_tolerance
  Instructions instructions = best_instructions();
};

/// Direct alignment: turns and shifts a known tag on the plane until the picture's own grey levels fit it best. It
/// usually takes two looks of about 500 points each. It does not search, so the initial pose must be right to about 4
/// px and 20 degrees.
class PhotometricFit {
 public:
  /// module: an eighth of the tag's edge [m]. exact: project every point by itself, where the local cubic is too
  /// coarse.
  PhotometricFit(const PlaneMap& map, double module, bool exact, const FitOptions& options);

  Fit fit(const Frame& frame, TagModel& tag, const core::Pose& from);

  /// The least correlation that identifies a tag: higher where modules have so few pixels that blur makes tags alike.
  double least_likeness(double px_per_module) const;

 private:
  struct Look;
  struct Free;
  void aim(const core::Pose& pose);
  bool look(const Frame& frame, const TagTemplate& tag, Look& look);
  bool descend(const Frame& frame, const TagTemplate& tag, int most_looks, core::Pose& pose, Look& look, int& looks);
  bool trim(const Frame& frame, const TagTemplate& tag, core::Pose& pose, Look& look, Eigen::Matrix3d& covariance,
            int& looks);
  void step(const Eigen::Vector3d& change, core::Pose& pose) const;
  Free explain(const TagTemplate& tag, const Look& look) const;
  bool leave_out(const TagTemplate& tag, float most_u, float most_v, Look& look);
  double felt(const TagTemplate& tag, const Free& free) const;
  Eigen::Matrix3d settle(const TagTemplate& tag, const TagTemplate::LastStep& last_step, const Free& free,
                         const Look& seen, core::Pose& pose) const;
  double in_pixels(const Eigen::Vector3d& change) const;
  Eigen::Matrix3d in_world(const Eigen::Matrix3d& of_step, double c, double s) const;

  PlaneMap plane_;
  double module_;
  bool exact_;
  FitOptions options_;
  LocalMap map_;  // around the pose that is looked at, turned as it is
  double px_per_module_ = 1.0;
  Places places_;
  // The normal matrix and its inverse for the remaining points, where the picture's border cuts the grid.
  TagTemplate::Full cut_normal_;
  TagTemplate::Full cut_inverse_;
  std::vector<std::size_t> left_out_;  // points
  Values values_;
  std::vector<float> sorted_;
};

}  // namespace skein::vision::detail
