#pragma once

#include <optional>
#include <span>
#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/detector/detector.h"
#include "vision/fit/photometric_fit.h"
#include "vision/frames/frame.h"
#include "vision/tags/detection.h"
#include "vision/tags/scale_change.h"
#include "vision/tags/tag_pose.h"
#include "vision/tracker/gate.h"
#include "vision/tracker/tracker_options.h"

namespace skein::vision {

/// A wanted tag: its state from previous frames and its result in this frame.
struct WantedTag {
  int tag = 0;
  detail::TagModel model;
  bool ever_seen = false;
  bool following = false;  // seen in the last frame, or so recently that it is worth a look near there
  bool ambiguous = false;  // two tags with its id were seen: ignored until a full search finds only one
  core::Pose last;         // where it was last seen
  double last_seen_at = 0.0;
  int missed = 0;              // frames since
  core::Pose velocity;         // per second, from the last two poses; zero where there are no two
  double velocity_over = 0.0;  // the time between these two [s]
  double edge_px = 0.0;
  double contrast = 0.0;       // between its ink and its paper [grey levels]
  double noise = 0.0;          // of a pixel on it [grey levels]
  double usual_stretch = 0.0;  // of its fits, a moving mean
  double usual_blur = 0.0;     // likewise, of fewer [px]
  int stretches = 0;           // number of fits in the first of these, limited
  int off_stretch = 0;         // frames in a row in which the stretch was unusual
  int unclipped = remembered;  // frames in which it was found since its paper was as bright as the camera can show,
                               // limited: until then its stretch is wrong, and so is the usual one

  // of this frame
  bool found = false;
  bool predicted = false;  // found where it was expected
  bool ghost = false;
  TagPose pose;
  std::optional<core::Pose> elsewhere;  // where another camera sees it
  std::optional<double> stretch;        // of its fit
  double stretch_sigma = 0.0;
  double blur_px = 0.0;
  bool off = false;  // its stretch is not the usual one: it is not reported

  WantedTag(int id, const detail::TagPattern& pattern) : tag(id), model(pattern) {}
  bool missing() const { return !found && !ghost && !elsewhere; }
  bool lifted(double tolerance) noexcept;
  bool has_usual() const { return stretches >= enough; }
  bool has_true_scale() const { return has_usual() && unclipped >= remembered; }
  // For the moving means [frames]: needed; in that of the stretch, at most; in that of the blur.
  static constexpr int enough = 25, remembered = 100, of_blur = 25;
};

/// The tracker's state and its stages.
struct TrackerParts {
  Calibration calibration;
  TrackerOptions options;
  detail::PhotometricFit fitter;
  TagDetector detector;
  double edge_px;  // of a tag in the middle of the picture
  double decimate;
  detail::Gate gate;
  std::vector<WantedTag> wanted;
  std::vector<TagPose> poses;
  TrackerCounters counters;
  StageTimes times{};
  std::int64_t last_search = 0;  // number of the frame last searched as a whole
  std::vector<Window> search_parts;
  std::optional<double> contrast;  // between ink and paper: the smallest of the tags last seen, except those in the
                                   // dark [grey levels]
  double noise = 0.0;              // of a pixel: the smallest of these tags, too [grey levels]

  /// A place that the gate reports and in which AprilTag finds no tag.
  struct Refuted {
    detail::Gate::Place place;
    std::int64_t looked_at = 0;  // number of the frame
  };
  std::vector<Refuted> refuted;
  std::vector<detail::Gate::Known> known;  // the tags found in this frame
  std::vector<double> stretches;
  std::vector<double> changes;  // of the stretches in this frame, against the usual ones
  std::optional<ScaleChange> scale_change;

  TrackerParts(Calibration c, TrackerOptions o);

  // The stages, as TrackerStage has them.
  void begin(std::span<const SeenElsewhere> elsewhere);
  void pass(TrackerStage stage, const Frame& frame);
  void follow(const Frame& frame);        // fits from the predicted poses
  void enter(const Frame& frame);         // fits, or AprilTag, where another camera sees them
  void look_nearby(const Frame& frame);   // AprilTag in windows around them
  void look_at_gate(const Frame& frame);  // the gate, and AprilTag where it points to
  void search(const Frame& frame);        // AprilTag over the full frame or a part of it, where it is due
  void audit(const Frame& frame);         // a strip of the gate, for second copies
  static void fetch(const Frame& frame, const WantedTag& tag);
  struct Strip {  // rows of the gate
    int first, last;
  };
  Strip audit_strip() const;
  void reject(std::int64_t& reason);
  void compare_shapes(const Frame& frame);
  void compare_scales();
  void conclude(const Frame& frame);

  // The median over those whose mean is known.
  std::optional<double> usual(double WantedTag::*mean, bool (WantedTag::*is_known)() const) const;
  double seen_at(const Frame& frame, const Corners& corners) const;
  core::Pose predict(const WantedTag& tag, double captured_at) const;
  bool missing() const;
  bool search_due() const;
  void search_part(const Frame& frame);
  int gate_threshold() const;
  int detector_threshold() const;
  void list_known();
  void accept(WantedTag& tag, const Frame& frame, const detail::Fit& fit);
  void consider(WantedTag& tag, const Frame& frame, const Detection& detection, bool predicted);
  void consider_all(const Frame& frame, const std::vector<Detection>& detections, bool whole_frame);
  bool check(const Frame& frame, const detail::Gate::Place& place);
  void check_places(const Frame& frame, const std::vector<detail::Gate::Place>& places, int most_new, int most_old);
};

}  // namespace skein::vision
