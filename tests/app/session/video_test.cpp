// The film that a session keeps: it holds what the tracker saw, to the bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <sstream>
#include <thread>

#include "app/calibration/calibration_file.h"
#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/experiment_cameras.h"
#include "app/session/session.h"
#include "tests/app/film_copy.h"
#include "tests/app/folder.h"
#include "tests/app/rows.h"
#include "tests/vision/half_as_fine.h"
#include "vision/sources/open_source.h"
#include "vision/tracker/tracker.h"

namespace skein::app {
namespace {

using test::Rows;

Experiment short_film_run(const std::vector<std::string>& more = {}) {
  std::vector<std::string> sets{"camera.source=synthetic", "duration=0.4", "perturb=[]", "expect={}"};
  sets.insert(sets.end(), more.begin(), more.end());
  auto experiment = parse_experiment(paper_experiment().source, "platoon.toml", sets);
  EXPECT_TRUE(experiment) << (experiment ? "" : experiment.error().front().message());
  return *experiment;
}

/// The file of the calibration that a synthetic camera of such a run has, with half as many pixels a side.
std::string half_as_fine(const test::Folder& folder, const std::vector<std::string>& sets, std::size_t number) {
  std::string path = folder / ("camera-" + std::to_string(number) + ".toml");
  const auto camera = camera_calibration(short_film_run(sets), number);
  EXPECT_TRUE(save_calibration(test::half_as_fine(camera.value()), path));
  return path;
}

/// The run's CSV; with a film beside it.
std::string csv_of(const Experiment& experiment, const std::string& film = {}) {
  std::ostringstream csv;
  {
    CsvWriter file(csv, experiment);
    SessionOptions options;
    options.sinks = {&file};
    options.video = film;
    auto session = Session::open(experiment, Session::Clock::virtual_, options);
    EXPECT_TRUE(session) << session.error();
    EXPECT_EQ(session ? (*session)->run() : Phase::ready, Phase::finished);
  }
  return csv.str();
}

TEST(Video, GivesTheSamePosesAgain) {
  const auto path = std::filesystem::temp_directory_path() / ("skein_video_" + std::to_string(::getpid()) + ".mkv");
  const Experiment experiment = short_film_run();
  Rows sink;
  {
    SessionOptions options;
    options.sinks = {&sink};
    options.video = path.string();
    auto session = Session::open(experiment, Session::Clock::virtual_, options);
    ASSERT_TRUE(session) << session.error();
    EXPECT_EQ((*session)->run(), Phase::finished);
    (*session)->close();
    EXPECT_EQ((*session)->video().dropped, 0);
    EXPECT_EQ((*session)->video().problem, "");
    EXPECT_GE((*session)->video().frames, static_cast<std::int64_t>(sink.rows.size()));
  }
  auto film = vision::open_source("video:" + path.string());
  ASSERT_TRUE(film) << film.error();
  EXPECT_TRUE((*film)->recorded());
  EXPECT_EQ((*film)->notes().at("SOURCE"), "synthetic");
  EXPECT_EQ((*film)->notes().at("EXPERIMENT"), experiment.source);
  const auto calibration = parse_calibration((*film)->notes().at("CALIBRATION"), "CALIBRATION");
  ASSERT_TRUE(calibration) << calibration.error();

  vision::TagTracker tracker(*calibration, {.tags = {1, 2, 3, 4}});
  vision::Frame frame;
  std::size_t next = 0;
  std::size_t compared = 0;
  while ((*film)->read(frame).value()) {
    for (const vision::TagPose& pose : tracker.process(frame)) {
      while (next < sink.rows.size() && sink.rows[next].robots[0].measurement.captured_at < frame.captured_at) ++next;
      if (next == sink.rows.size()) break;
      const core::Measurement& measured = sink.rows[next].robots[static_cast<std::size_t>(pose.tag - 1)].measurement;
      EXPECT_EQ(measured.captured_at, frame.captured_at);
      EXPECT_EQ(measured.pose.x, pose.pose.x);
      EXPECT_EQ(measured.pose.y, pose.pose.y);
      EXPECT_EQ(measured.pose.theta, pose.pose.theta);
      ++compared;
    }
  }
  EXPECT_EQ(compared, 4 * sink.rows.size());
  std::filesystem::remove(path);
}

/// Film and CSV of a run, replayed: vision and tick say the same to the bit, and a changed pose is found.
TEST(Video, ReplaysWithItsLogBitForBit) {
  const auto path = std::filesystem::temp_directory_path() / ("skein_replay_" + std::to_string(::getpid()) + ".mkv");
  const Experiment experiment = short_film_run({"robot_defaults.model=epuck1"});
  const std::string csv = csv_of(experiment, path.string());
  std::istringstream in(csv);
  const auto result = replay(in, "run.csv", path.string());
  ASSERT_TRUE(result) << result.error();
  EXPECT_TRUE(result->filmed);
  EXPECT_EQ(result->poses, 4 * result->ticks);
  EXPECT_EQ(result->poses_different, 0) << result->first;
  EXPECT_EQ(result->different, 0) << result->first;
  EXPECT_EQ(result->missing_frames, 0);

  // Another run's film: the robots' starts are the same, what happens then is not.
  const Experiment other = short_film_run({"robot_defaults.model=epuck1", "seed=2"});
  const std::string other_csv = csv_of(other);
  std::istringstream other_in(other_csv);
  const auto wrong = replay(other_in, "other.csv", path.string());
  ASSERT_TRUE(wrong) << wrong.error();
  EXPECT_GT(wrong->poses_different, 0);
  EXPECT_NE(wrong->first.find("tick 0"), std::string::npos) << wrong->first;
  std::filesystem::remove(path);

  std::istringstream again(csv);
  const auto none = replay(again, "run.csv", path.string());
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().find(path.string()), std::string::npos) << none.error();
}

/// The film says which frames repeated a picture: no pose came from them.
TEST(Video, OfACameraThatFroze) {
  const auto path = std::filesystem::temp_directory_path() / ("skein_frozen_" + std::to_string(::getpid()) + ".mkv");
  const std::string csv =
      csv_of(short_film_run({"duration=1", "camera.freeze_at=0.3", "camera.freeze_for=0.4"}), path.string());
  std::istringstream in(csv);
  const auto result = replay(in, "run.csv", path.string());
  std::filesystem::remove(path);
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->poses_different, 0) << result->first;
  EXPECT_EQ(result->different, 0) << result->first;
  EXPECT_EQ(result->missing_frames, 0);
}

/// The tracker had seen the frames that a film lacks: what it measures afterwards is not the same to the bit, and that
/// is no sign of a changed record. Up to there it is.
TEST(Video, WithoutSomeFramesProvesThePosesBeforeThemAndEveryCommand) {
  const test::Folder folder;
  const std::string calibration = "camera.calibration=" + half_as_fine(folder, {}, 0);
  const std::string csv = csv_of(short_film_run({"duration=1", calibration}), folder / "run.mkv");
  const auto replayed = [&](const std::vector<std::int64_t>& dropped) {
    test::copy_film(folder / "run.mkv", folder / "lacks.mkv", dropped);
    std::istringstream in(csv);
    auto result = replay(in, "run.csv", folder / "lacks.mkv");
    std::filesystem::remove(folder / "lacks.mkv");
    EXPECT_TRUE(result) << result.error();
    return result ? *result : ReplayResult{};
  };
  const ReplayResult whole = replayed({});
  EXPECT_EQ(whole.poses_different, 0) << whole.first;
  EXPECT_EQ(whole.poses_approximate, 0);
  const std::vector<std::int64_t> in_the_middle{10, 11}, at_the_end{whole.frames - 2, whole.frames - 1};
  for (const auto& dropped : {in_the_middle, at_the_end}) {
    const ReplayResult result = replayed(dropped);
    SCOPED_TRACE(dropped.front());
    EXPECT_EQ(result.different, 0) << result.first;
    EXPECT_EQ(result.poses_different, 0) << result.first;
    EXPECT_EQ(result.poses, 4 * result.ticks);
    EXPECT_GT(result.poses_approximate, 0);
    EXPECT_LT(result.poses_approximate, result.poses);
    EXPECT_GT(result.poses_missing, 0);
    EXPECT_LE(result.poses_missing, 12);
    EXPECT_LT(result.pose_error_max, 0.001);
    if (dropped == in_the_middle) {
      EXPECT_EQ(result.missing_frames, 2);
    }
  }
}

/// Two cameras that tell each other where robots are, a film each: all poses and commands are the same to the bit. A
/// film that ends early is named.
TEST(Video, ReplaysTheFilmsOfTwoCamerasBitForBit) {
  const test::Folder folder;
  const std::vector<std::string> two{"camera.also=[{source=\"synthetic\"}]"};
  const auto run = [&, first = half_as_fine(folder, two, 0),
                    second = half_as_fine(folder, two, 1)](std::vector<std::string> sets) {
    sets.insert(sets.end(), {"camera.calibration=" + first, "reference.start=2.45",
                             "camera.also=[{source=\"synthetic\", calibration=\"" + second + "\"}]"});
    return short_film_run(sets);
  };
  const Experiment experiment = run({"duration=1.5"});
  const std::string csv = csv_of(experiment, folder / "run.mkv");
  std::istringstream in(csv);
  const auto result = replay(in, "run.csv", folder / "run.mkv");
  ASSERT_TRUE(result) << result.error();
  EXPECT_TRUE(result->filmed);
  EXPECT_EQ(result->poses, 8 * result->ticks);
  EXPECT_EQ(result->poses_different, 0) << result->first;
  EXPECT_EQ(result->different, 0) << result->first;
  EXPECT_THAT(result->warnings, testing::IsEmpty());
  bool told = false;
  auto film = vision::open_source("video:" + folder / "run-2.mkv");
  ASSERT_TRUE(film) << film.error();
  for (vision::Frame frame; (*film)->read(frame).value();) told = told || !frame.note.empty();
  EXPECT_TRUE(told) << "the film says what the tracker knew of the other camera";

  // Of another run, in the place of the second camera's.
  csv_of(run({"duration=1.5", "seed=2"}), folder / "other.mkv");
  std::filesystem::rename(folder / "other-2.mkv", folder / "run-2.mkv");
  std::istringstream with_other(csv);
  const auto wrong = replay(with_other, "run.csv", folder / "run.mkv");
  ASSERT_TRUE(wrong) << wrong.error();
  EXPECT_GT(wrong->poses_different, 0);
  EXPECT_THAT(wrong->first, testing::HasSubstr("_c2_"));

  // Of a shorter run.
  csv_of(run({"duration=0.4"}), folder / "short.mkv");
  std::filesystem::rename(folder / "short-2.mkv", folder / "run-2.mkv");
  std::istringstream again(csv);
  const auto early = replay(again, "run.csv", folder / "run.mkv");
  ASSERT_TRUE(early) << early.error();
  EXPECT_EQ(early->poses_different, 0) << early->first;
  EXPECT_EQ(early->different, 0) << early->first;
  EXPECT_GT(early->poses_missing, 0) << "of the second camera";
  EXPECT_THAT(early->warnings,
              testing::Contains(testing::HasSubstr("run-2.mkv ends 1.1 s before the poses of its camera")));
  std::filesystem::remove(folder / "run-2.mkv");
  std::istringstream once_more(csv);
  EXPECT_THAT(replay(once_more, "run.csv", folder / "run.mkv").error(), testing::HasSubstr("camera 2: "));
}

/// A synthetic camera with a rolling shutter shows robots as the tracker dates them: where they were when their rows
/// were read.
TEST(Video, ARollingShuttersPosesAreThoseOfTheirRows) {
  const auto path = std::filesystem::temp_directory_path() / ("skein_rows_" + std::to_string(::getpid()) + ".toml");
  vision::Calibration calibration = vision::overhead_calibration(2.0, 1.5);
  calibration.row_time = 30e-6;
  ASSERT_TRUE(save_calibration(calibration, path));
  const Experiment experiment = short_film_run({"duration=4", "camera.calibration=" + path.string()});
  Rows sink;
  {
    SessionOptions options;
    options.sinks = {&sink};
    auto session = Session::open(experiment, Session::Clock::virtual_, options);
    ASSERT_TRUE(session) << session.error();
    EXPECT_EQ((*session)->run(), Phase::finished);
  }
  std::filesystem::remove(path);
  double sum = 0.0;
  int count = 0;
  for (std::size_t row = 3; row < sink.rows.size(); ++row)
    for (std::size_t i = 0; i < 4; ++i) {
      const core::Measurement& seen = sink.rows[row].robots[i].measurement;
      std::size_t later = row;  // truth is known at the ticks
      while (sink.rows[later - 1].t > seen.captured_at && later > 1) --later;
      const TickRecord& a = sink.rows[later - 1];
      const TickRecord& b = sink.rows[later];
      const double share = (seen.captured_at - a.t) / (b.t - a.t);
      const core::Pose &from = a.robots[i].truth, &to = b.robots[i].truth;
      const double along = std::atan2(to.y - from.y, to.x - from.x);
      sum += std::cos(along) * (seen.pose.x - from.x - share * (to.x - from.x)) +
             std::sin(along) * (seen.pose.y - from.y - share * (to.y - from.y));
      ++count;
    }
  ASSERT_GT(count, 300);
  EXPECT_LT(std::abs(sum / count), 5e-5) << "0.06 m/s for 15 ms would be 0.9 mm";
}

/// The film has the corrected times of capture, as the log has, and a replay corrects nothing again.
TEST(Video, ReplaysBitForBitWithALatencyOfTheCamera) {
  const auto path = std::filesystem::temp_directory_path() / ("skein_late_" + std::to_string(::getpid()) + ".mkv");
  const std::string csv = csv_of(short_film_run({"camera.stamps_late=0.03", "camera.latency=0.027"}), path.string());
  std::istringstream in(csv);
  const auto result = replay(in, "run.csv", path.string());
  auto film = vision::open_source("video:" + path.string());
  std::filesystem::remove(path);
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->poses, 4 * result->ticks);
  EXPECT_EQ(result->poses_different, 0) << result->first;
  EXPECT_EQ(result->different, 0) << result->first;
  ASSERT_TRUE(film) << film.error();
  vision::Frame frame;
  ASSERT_TRUE((*film)->read(frame).value());
  EXPECT_EQ(frame.captured_at, -0.027) << "of the frame that came at 0";
}

/// A film with losses takes a small part of the room; the replay says what they are in millimetres.
TEST(Video, ASmallFilmSaysWhatItLoses) {
  const auto folder = std::filesystem::temp_directory_path();
  std::uintmax_t lossless = 0;
  for (const std::string film : {"lossless", "small"}) {
    const auto path = folder / ("skein_" + film + "_" + std::to_string(::getpid()) + ".mkv");
    const Experiment experiment = short_film_run({"camera.film=" + film});
    const std::string csv = csv_of(experiment, path.string());
    const std::uintmax_t size = std::filesystem::file_size(path);
    std::istringstream in(csv);
    const auto result = replay(in, "run.csv", path.string());
    std::filesystem::remove(path);
    ASSERT_TRUE(result) << result.error();
    EXPECT_EQ(result->different, 0) << result->first;
    EXPECT_EQ(result->poses_different, 0) << "poses with losses are not compared to the bit";
    EXPECT_EQ(result->missing_frames, 0);
    if (film == "lossless") {
      lossless = size;
      EXPECT_TRUE(result->lossless);
      EXPECT_EQ(result->pose_error_max, 0.0);
      continue;
    }
    EXPECT_FALSE(result->lossless);
    EXPECT_LT(size, lossless / 8);
    EXPECT_EQ(result->poses, 4 * result->ticks);
    EXPECT_EQ(result->poses_missing, 0);
    EXPECT_GT(result->pose_error_rms, 0.0);
    EXPECT_LT(result->pose_error_rms, 0.0002);
    EXPECT_LT(result->pose_error_max, 0.001);
  }
}

TEST(Video, ADiskThatIsFullDoesNotStopTheRun) {
  // The sixth tick is not over before the recorder has met the disk's end: what holds few frames waits in its buffers.
  struct Patient final : RecordSink {
    void record(const TickRecord& record) override {
      for (int k = 0; rows.size() == 5 && k < 6000 && session->video().problem.empty(); ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      rows.push_back(record);
    }
    Session* session = nullptr;
    std::vector<TickRecord> rows;
  } sink;
  SessionOptions options;
  options.video = "/dev/full";
  options.sinks = {&sink};
  auto session = Session::open(short_film_run(), Session::Clock::virtual_, options);
  ASSERT_TRUE(session) << session.error();
  sink.session = session->get();
  EXPECT_EQ((*session)->run(), Phase::finished);
  int told = 0;
  for (const TickRecord& row : sink.rows) told += row.events.contains<events::FilmBroken>() ? 1 : 0;
  EXPECT_EQ(told, 1);
  ASSERT_FALSE(sink.rows.empty());
  for (const RobotRecord& robot : sink.rows.back().robots) EXPECT_LT(robot.pose_age, 0.1) << "tracking goes on";
  (*session)->close();
  EXPECT_FALSE((*session)->failure());
  EXPECT_EQ((*session)->video().problem, "/dev/full: cannot be written: No space left on device");
}

TEST(Video, NeedsACamera) {
  SessionOptions options;
  options.video = "run.mkv";
  const auto session = Session::open(short_film_run({"camera.source=none"}), Session::Clock::virtual_, options);
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error(), "run.mkv: there is no camera to record (camera.source = \"none\")");
}

}  // namespace
}  // namespace skein::app
