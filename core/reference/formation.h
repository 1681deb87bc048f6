#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "core/reference/curve.h"
#include "core/reference/reference.h"

namespace skein::core {

/// The robots' places in a formation, relative to its centre: x ahead along the path, y to its left. [m]
using Shape = std::vector<Point>;

/// Shapes by name; neighbours are `spacing` apart, and the mean of the places is the centre.
enum class ShapeName {
  line,     ///< side by side, robot 1 on the left
  column,   ///< one behind the other, robot 1 in front
  diamond,  ///< on the sides of a square standing on its corner: robot 1 in front, then counter-clockwise
  v,        ///< robot 1 in front, the even ones behind it to the left, the odd ones to the right
  circle,   ///< robot 1 in front, then counter-clockwise
};
/// As files call it (core/words.h).
constexpr std::string_view word(ShapeName name) noexcept {
  switch (name) {
    case ShapeName::line:
      return "line";
    case ShapeName::column:
      return "column";
    case ShapeName::diamond:
      return "diamond";
    case ShapeName::v:
      return "v";
    case ShapeName::circle:
      return "circle";
  }
  return {};
}

Shape make_shape(ShapeName name, std::size_t robots, double spacing);

/// From time t on, the shape turns into another one within `duration`: places, their velocities and accelerations are
/// continuous. [s]
struct ShapeChange {
  double t = 0.0;
  double duration = 0.0;
  Shape shape;
};

/// A shape about a centre that drives along a path at constant speed and turns with it, so that the robots on the
/// outside of a bend drive faster than those inside. v_ref and omega_ref are (3), derived from the motion of the centre
/// and the changes of the curvature and of the shape.
class Formation final : public Reference {
 public:
  /// `changes` in order of time, each ending before the next begins; requires path->smooth(). speed [m/s]; `start`: arc
  /// length at which the centre begins [m].
  Formation(std::shared_ptr<const Path> path, double speed, double start, Shape shape, std::vector<ShapeChange> changes)
      : path_(std::move(path)), speed_(speed), start_(start), shape_(std::move(shape)), changes_(std::move(changes)) {}

  std::size_t robots() const noexcept override { return shape_.size(); }
  bool smooth() const noexcept override { return path_->smooth(); }
  std::vector<std::vector<Pose>> lines() const override { return {sampled(*path_, line_parts)}; }

  ReferencePoint at(std::size_t i, double t) const noexcept override;
  void at(double t, std::span<ReferencePoint> points) const noexcept override;
  /// The largest of many samples (every shape along the whole path, and every change of shape), plus a thousandth.
  ReferenceDemand demand(double k_y) const noexcept override;

 private:
  /// A robot's place in the formation, its velocity and its acceleration.
  struct Place {
    Point place, velocity, acceleration;
  };
  Place place(std::size_t i, double t) const noexcept;
  ReferencePoint at(const PathPoint& centre, const Place& place) const noexcept;

  std::shared_ptr<const Path> path_;
  double speed_, start_;
  Shape shape_;
  std::vector<ShapeChange> changes_;
};

}  // namespace skein::core
