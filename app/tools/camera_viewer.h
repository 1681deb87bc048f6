#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/status.h"
#include "vision/frames/camera_setting.h"

namespace skein::app {

using CameraSetting = vision::CameraSetting;

/// The camera to look through.
struct WatchedCamera {
  std::string source;         ///< as for vision::open_source
  std::string calibration{};  ///< file; empty: none, and tags are not judged
  /// A run reads this camera, and its pictures are handed over; `calibration` is the run's own then.
  bool of_run = false;
  std::vector<std::pair<std::string, double>> settings{};  ///< of a camera, as of its opening
  std::string trigger{};                                   ///< likewise
};

/// A tag in the newest picture, or a robot's tag that is not in it.
struct WatchedTag {
  enum class State {
    taken,     ///< a robot's, and its pose is known
    refused,   ///< a robot's, and `why` it has no pose
    unjudged,  ///< a robot's; no calibration tells where it is
    nobodys,   ///< of no robot of the experiment
  };
  int tag = 0;
  int robot = -1;  ///< from 0; -1: no robot's
  State state = State::nobodys;
  bool seen = false;                               ///< it is in the picture
  std::array<std::array<double, 2>, 4> corners{};  ///< [px], (0, 0) is the centre of the top-left pixel
  double edge_px = none;
  double edge = none;  ///< on the plane of the tags [m]; none: no calibration, or not seen
  std::string why{};   ///< a sentence without a full stop; empty: taken
};

/// What a camera shows, and how it is set.
struct CameraView {
  Picture picture;               ///< the newest that was searched for tags; width 0: none has come
  std::vector<WatchedTag> tags;  ///< in it: by robot, then those of no robot
  double tag_size = none;        ///< of the calibration [m]
  double rate = none;            ///< of all frames over the last two seconds [frames/s]
  std::string camera;            ///< a description of what is being read
  std::string note;              ///< why tags are not judged; empty: they are
  std::string problem;           ///< why there are no more pictures; empty: none
  bool over = false;             ///< there are no more
  std::vector<CameraSetting> settings;
  /// About the settings: another value than was asked for, or why one was refused. Of a film: how it is read.
  std::vector<std::string> notices;
};

/// Looks through a camera aside: reads its frames, searches them for tags as often as that takes no more than half of a
/// thread, reports why robots' tags are not taken, and sets its controls. Neither a call nor the destructor waits for
/// the camera. All calls from one thread.
class CameraViewer {
 public:
  CameraViewer(const Experiment& experiment, const WatchedCamera& camera);
  ~CameraViewer();
  CameraViewer(const CameraViewer&) = delete;
  CameraViewer& operator=(const CameraViewer&) = delete;

  /// A picture of the run that reads this camera.
  void hand(const Picture& picture);
  /// Sets "exposure" [s] (0: automatic), "gain" or "focus"; a later view has the value that the camera took.
  void set(const std::string& name, double value);
  /// The present view, if it is newer than the last one returned.
  bool view(CameraView& out);

 private:
  struct Work;
  std::shared_ptr<Work> work_;  // the thread's, too
};

/// Whether the controls of a run's camera can be set while the run reads it.
bool settable_during_run(const std::string& source);

}  // namespace skein::app
