#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/experiment/robots_file.h"
#include "app/tools/camera_words.h"

namespace skein::app {

struct Machine;  // app/doctor/machine.h

/// The bodies of the subcommands; each returns an ExitStatus and reports errors on stderr.

/// An experiment as given on the command line.
struct ExperimentRequest {
  std::string file;               ///< empty: the paper's experiment
  std::vector<std::string> sets;  ///< --set, with --duration and --seed
  bool rehearse = false;          ///< without its hardware
};
/// Loads it, or prints every problem to stderr.
std::optional<Experiment> load(const ExperimentRequest& request);
/// Whether the calibrations of all its cameras can be read; what prevents it is on stderr.
bool can_read_calibrations(const Experiment& experiment);

struct RunRequest {
  ExperimentRequest experiment;
  std::string csv, report, video, speed;  ///< speed: "max", "realtime" or empty: max if nothing is real
  std::string crops;                      ///< folder for pictures of tags that are not seen, beside a kept run's own
  bool keep = false;                      ///< in a folder of its own below `runs_directory`
  std::string runs_directory;             ///< empty: runs_directory() says which
  std::vector<std::string> words;         ///< of the command line, for the record of a kept run
  std::string publish;                    ///< "udp:HOST:PORT"; empty: not published
  bool quiet = false, json = false;
  bool force = false;  ///< files of an older run may be overwritten
};
int run(const RunRequest& request);

struct DoctorRequest {
  std::vector<ExperimentRequest> experiments;  ///< to be run on this machine
  double seconds = 10.0;
  bool fix = false;
  bool window = false;  ///< the program was built with one
};
int doctor(const DoctorRequest& request);
/// The same on a given machine (a test's), instead of this one.
int doctor(const DoctorRequest& request, const Machine& machine);

/// `controller`: also tests the law over the whole experiment.
int check(const ExperimentRequest& request, bool controller);
/// `repaired`: first removes a torn last row from the file.
int replay(const std::string& csv, const std::string& film, bool repaired, bool controller);

struct TrackRequest {
  std::string source, camera, csv, record;
  std::string crops;  ///< folder for pictures of tags that the tracker does not take
  CameraWords words;
  bool tracker = false;  ///< with the tracker of a run instead of AprilTag
  std::string tags;      ///< for the tracker: "1-4,7"; empty: those of the first frame that shows any
  bool list_controls = false;
  bool quiet = false;
};
int track(const TrackRequest& request);

struct CameraDoctorRequest {
  std::string source;  ///< empty: the only camera there is
  std::string camera;  ///< calibration file
  CameraWords words;
  double seconds = 10.0;
};
/// Examines a camera by its frames, see camera_doctor.h; `expectation_failed` if something must be fixed.
int camera_doctor(const CameraDoctorRequest& request);

struct CameraLatencyRequest {
  ExperimentRequest experiment;
  std::vector<std::size_t> robots{1};  ///< from 1
  double seconds = 12.0;
  bool save = false;  ///< into the experiment file
};
/// Measures how late the cameras' time stamps are, with a robot that turns on the spot, see camera_latency.h;
/// `expectation_failed` if the data do not determine it.
int camera_latency(const CameraLatencyRequest& request);

/// Lists the modes and settings of a camera ("/dev/video0", "v4l2:/dev/video0", "aravis:NAME"); without one, all
/// cameras.
int list_cameras(const std::string& camera);

struct RobotsRequest {
  std::vector<std::string> words;       ///< which robots, see named_robots()
  std::string file;                     ///< of robots; empty: known_robots_file() says which
  std::string camera, calibration;      ///< source and calibration file; empty: that of the experiment, if there is one
  std::string adapter;                  ///< "hci1", or its address; empty: all
  double seconds = 12.0;                ///< how long to look for robots
  double minutes = 1.0;                 ///< how long to measure links
  std::optional<double> reply_timeout;  ///< of `test`, instead of the file's links.reply_timeout [s]
  bool save = false;                    ///< into the file of robots; of `ping`: into the experiment file
};

/// Robots by words of the command line, with errors on stderr: link addresses, names of the file of robots, files of
/// robots, experiment files.
struct NamedRobots {
  std::vector<RobotSpec> robots;
  std::optional<Experiment> experiment;  ///< if an experiment file is the only word
};
std::optional<NamedRobots> named_robots(const std::vector<std::string>& words, const std::string& file);

/// The robots of the file of robots, as a table.
int list_robots(const std::string& file);

/// Stops robots, whatever state they were left in; without words all known ones and those of every run that was killed.
/// `device_failed` when one has not acknowledged.
int stop_robots(const std::vector<std::string>& words, const std::string& file = {});

/// Searches for robots by Bluetooth and prints them as tables of a file of robots; `device_failed` if there is none.
int scan_robots(const RobotsRequest& request);

/// Pairs with robots, named by name or address; prints them likewise; `device_failed` if one was not paired.
int pair_robots(const RobotsRequest& request);

/// Measures the round trips of robots' links under the traffic of a run, while the robots stand, and proposes [links].
/// `device_failed` if one does not answer. See robot_ping.h.
int ping_robots(const RobotsRequest& request);

/// Reads the robots' versions, turns their wheels a little, and reports their faults; `device_failed` if there are any.
/// See robot_test.h.
int test_robots(const RobotsRequest& request);

/// Writes what was found about robots to the file of robots; reports robots that the file does not have:
/// expectation_failed if it has none of these.
int save_found(const std::string& file, const std::vector<FoundRobot>& robots);

/// Keys of an experiment file and their values as TOML text.
using KeyValues = std::vector<std::pair<std::string, std::string>>;
/// Writes these values, leaving the rest of the file unchanged.
int save_keys(const std::string& file, const KeyValues& values);
/// Whether they could be written, before they are measured; what prevents it is on stderr.
bool can_save_keys(const std::string& file, const KeyValues& values);

/// Reports on stderr the runs that ended without stopping their robots, if any, and offers to stop them if stdin is a
/// terminal.
void look_after_bad_ends();

}  // namespace skein::app
