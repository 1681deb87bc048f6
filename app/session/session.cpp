// A session's life: opened, run, looked at, closed.
#include "app/session/session.h"

#include <fmt/format.h>

#include "app/experiment/at_start.h"
#include "app/session/readiness.h"
#include "app/session/session_wiring.h"

namespace skein::app {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t channel_capacity =
    500;  // 20 s at 25 Hz: a disk or a window may hang that long before rows are lost
/// Until marks on the floor that are hidden are seen, and until a busy machine has looked at them at all. [s]
constexpr double marks_patience = 5.0, look_patience = 60.0;
/// Until two cameras that see a robot apart both look for it, whatever their calibrations say: 25 frames. Whether they
/// go on to see it apart takes half a second more, and a slow camera or a busy machine takes longer for both.
constexpr double comparison = 2.5;  // at least [s]
constexpr std::int64_t compared_frames = 35;
constexpr double first_sight_timeout = 10.0;  // a camera needs a second or two to open and to settle its exposure [s]

/// What follows "is not seen".
std::string reasons(const Experiment& experiment, const std::vector<UnseenTag>& unseen) {
  std::string all;
  for (const UnseenTag& tag : unseen) all += (all.empty() ? ": " : "; ") + tag.text();
  if (const auto size = fitting_tag_size(experiment.robots.size(), unseen))
    all += fmt::format("; if the black edge of the tags measures {:g} mm: --set tags.size={:g}", 1e3 * *size, *size);
  return all;
}

}  // namespace

Session::Session(std::unique_ptr<SessionWiring> wiring) : wiring_(std::move(wiring)) {}
Session::~Session() {
  close();
}

tl::expected<std::unique_ptr<Session>, std::string> Session::open(const Experiment& experiment, Clock clock,
                                                                  SessionOptions options) {
  auto impl = std::make_unique<SessionWiring>(experiment, clock, std::move(options));
  SessionWiring& i = *impl;
  i.gains = make_gains(experiment);
  i.demand = make_reference(experiment)->demand(experiment.controller.k_y);

  if (experiment.controller.law.own()) {
    auto controller = OwnController::start(i.experiment, !i.clock.wall(),
                                           {.program = i.options.program, .keep_on = i.options.keep_on});
    if (!controller) return tl::unexpected(controller.error());
    i.controller = std::move(*controller);
  }
  i.law_parameters = i.controller ? i.controller->parameters() : declared_parameters(experiment.controller.law);
  if (i.options.guard && i.clock.wall()) {
    const auto robots = real_robots(i.experiment);
    if (!robots) return tl::unexpected(robots.error());
    i.net = SafetyNet::spread({i.experiment.name, *robots});
    if (!i.net && robots->empty()) i.net = SafetyNet();  // a simulation can do no harm
    if (!robots->empty()) i.sleep.emplace(i.experiment.name);
  }
  auto plant = Plant::open(i.experiment, i.clock, i.options);
  if (!plant) {
    if (i.net) i.net->done(std::vector<StopResult>{});  // those that were reached have been stopped
    return tl::unexpected(plant.error());
  }
  i.plant = std::move(*plant);
  i.unguarded = unguarded_calibrations(i.experiment);
  for (const UnguardedCalibration& one : i.unguarded) i.alarms.push_back(one.sentence);
  for (std::string& sentence : uneven_focal_lengths(i.experiment)) i.alarms.push_back(std::move(sentence));
  i.loop = std::make_unique<ControlLoop>(
      i.experiment, i.clock, *i.plant, [&i](const TickRecord& record) { i.publish(record); }, i.controller.get());
  if (i.options.paced && !i.real_time && !i.controller) i.loop->always_pace();
  if (i.clock.wall()) {
    i.recorder_channel = std::make_unique<RecordChannel>(channel_capacity, i.loop->prototype());
    i.window_channel = std::make_unique<RecordChannel>(channel_capacity, i.loop->prototype());
    i.recorder_thread = std::jthread([&i](const std::stop_token& token) { i.recorder(token); });
    i.loop->start_thread();
    i.supervisor_thread = std::jthread([&i](const std::stop_token& token) { i.supervise(token); });
    if (i.net)
      i.net->on_stop([&i](const std::string& why) { i.stop_from_outside(why); },
                     [&i] { return stop_results(i.experiment, i.plant->robots()); });
  }
  return std::unique_ptr<Session>(new Session(std::move(impl)));
}

const Experiment& Session::experiment() const noexcept {
  return wiring_->experiment;
}
std::size_t Session::drain(const std::function<void(const TickRecord&)>& take) {
  if (!wiring_->window_channel) return 0;
  wiring_->last_look.store(wiring_->clock.now());
  return wiring_->window_channel->drain(take);
}

std::optional<Timing> Session::timing() const {
  return wiring_->clock.wall() && wiring_->closed ? std::optional(wiring_->loop->timing()) : std::nullopt;
}

std::optional<Timing> Session::timing_so_far() const {
  if (!wiring_->clock.wall() || wiring_->closed) return timing();
  return wiring_->loop->timing_so_far();
}

std::uint64_t Session::dropped_rows() const noexcept {
  return wiring_->recorder_channel ? wiring_->recorder_channel->dropped() : 0;
}

std::uint64_t Session::undrained_rows() const noexcept {
  return wiring_->window_channel ? wiring_->window_channel->dropped() : 0;
}

std::vector<UnseenTag> Session::why_not_seen() const {
  if (!has_camera() || wiring_->closed || !wiring_->clock.wall()) return {};
  return wiring_->plant->cameras()->why_not_seen();
}

bool Session::picture(Picture& out) {
  return has_camera() && !wiring_->closed && wiring_->plant->cameras()->picture(out);
}
bool Session::has_camera() const noexcept {
  return wiring_->experiment.camera.kind() != CameraKind::absent;
}

std::array<double, 2> Session::pixel(double x, double y) const {
  const Cameras* cameras = wiring_->plant->cameras();
  return cameras ? cameras->pixel(x, y) : std::array{none, none};
}

std::vector<RobotStatus> Session::robots() const {
  return wiring_->plant->robots();
}

vision::SourceStatus Session::camera() const {
  const Cameras* cameras = wiring_->plant->cameras();
  return cameras ? cameras->status() : vision::SourceStatus{};
}

CameraStatus Session::camera_status() const {
  const vision::SourceStatus source = camera();
  CameraStatus status{.down = source.up ? "" : source.reason, .marks = marks(), .automatics = source.automatics};
  if (const Cameras* cameras = wiring_->plant->cameras()) {
    status.partly = cameras->partly_down();
    status.why_lost = cameras->why_lost();
  }
  status.pairs = wiring_->loop->camera_pairs();
  for (const UnguardedCalibration& one : wiring_->unguarded) {
    const bool compared = std::any_of(status.pairs.begin(), status.pairs.end(), [&](const CameraPair& pair) {
      return pair.compared && (pair.first == one.camera || pair.second == one.camera);
    });
    if (!compared) status.unguarded.push_back(one.sentence);
  }
  return status;
}

MarksStatus Session::marks() const {
  return wiring_->plant->marks();
}

std::function<VideoStatus()> Session::end_film() {
  Cameras* cameras = wiring_->plant->cameras();
  return cameras ? cameras->end_film() : nullptr;
}

VideoStatus Session::video() const {
  const Cameras* cameras = wiring_->plant->cameras();
  return cameras ? cameras->video() : VideoStatus{};
}

const OwnController* Session::controller() const noexcept {
  return wiring_->controller.get();
}

std::optional<std::string> Session::unguarded() const {
  return wiring_->net ? std::nullopt : std::optional(wiring_->net.error());
}

std::vector<std::string> Session::alarms() {
  std::vector<std::string> all;
  {
    const std::lock_guard lock(wiring_->failure_mutex);
    all.swap(wiring_->alarms);
  }
  if (has_camera())
    for (std::string& sentence : wiring_->plant->cameras()->alarms()) all.push_back(std::move(sentence));
  if (wiring_->net)
    for (std::string& sentence : wiring_->net->alarms()) all.push_back(std::move(sentence));
  if (wiring_->sleep)
    if (auto alarm = wiring_->sleep->alarm()) all.push_back(*std::move(alarm));
  return all;
}

std::optional<std::string> Session::failure() const {
  const std::lock_guard lock(wiring_->failure_mutex);
  return wiring_->failure;
}

Phase Session::run(const std::function<bool()>& keep_on) {
  SessionWiring& i = *wiring_;
  const auto over = [&] { return i.loop->phase() == Phase::stopped || i.loop->phase() == Phase::finished; };
  const auto ask = [&] {
    if (keep_on && !keep_on()) i.stop();
  };
  int turns = 0;
  const auto turn = [&] {
    constexpr int between_questions = 16;  // ticks: a fraction of a second even where a camera is rendered
    if (i.clock.wall() || turns++ % between_questions == 0) ask();
    if (i.clock.wall()) {
      std::this_thread::sleep_for(5ms);
    } else {
      i.loop->cycle_virtual();
      i.watch();
    }
  };
  const auto ask_or_fail = [&](const char* what, const Answer& answer) {
    if (!answer && !i.loop->stop_asked()) i.fail(fmt::format("{}: {}", what, answer.error()));
  };
  const auto drive_to_starts = [&] {
    ask_or_fail("staging", stage());
    const double give_up = i.clock.now() + i.experiment.staging.timeout;
    for (bool began = false; !i.loop->failed() && i.loop->phase() != Phase::stopped; turn()) {
      if (i.loop->phase() == Phase::staging)
        began = true;
      else if (began)
        return;
      if (i.clock.now() < give_up) continue;
      const ControlLoop::NotStaged behind = i.loop->not_staged();
      i.fail(behind.robot < 0 ? fmt::format("staging: the robots were not all at their starts within {} s",
                                            i.experiment.staging.timeout)
                              : fmt::format("staging: robot {} has not reached its start within {} s: {}",
                                            behind.robot + 1, i.experiment.staging.timeout,
                                            (behind.mode & lost) != 0
                                                ? std::string(has_camera() ? "its tag is not seen" : "it is not seen")
                                            : (behind.mode & stopped) != 0 ? std::string("it is held")
                                            : behind.distance > staged_tolerance.distance
                                                ? fmt::format("it is {:.3f} m away", behind.distance)
                                                : "it is there, but its heading is off"));
      while (!over() && !i.loop->failed()) turn();
    }
  };

  // False: it is still not so when the patience is over. True as well where the run is over. [s]
  const auto await = [&](const auto& is_so, double patience) {
    const double began = i.clock.now();
    for (; !is_so() && !over() && !i.loop->failed(); turn())
      if (i.clock.now() - began >= patience) return false;
    return true;
  };

  bool away = false;
  if (i.clock.wall()) {
    // No robot drives blind: every robot has to be seen before the start.
    int unseen = 0;
    if (!await([&] { return (unseen = i.loop->unseen()) < 0; }, first_sight_timeout))
      i.fail(fmt::format("robot {}: its tag {} is not seen{}", unseen + 1,
                         i.experiment.robots[static_cast<std::size_t>(unseen)].tag,
                         reasons(i.experiment, why_not_seen())));
    if (i.experiment.cameras() > 1) {
      const double seen_at = i.clock.now();
      const std::int64_t frames = i.plant->cameras()->fewest_frames();
      const auto compared = [&] {
        if (i.clock.now() - seen_at < comparison) return false;
        const std::vector<CameraPair> pairs = i.loop->camera_pairs();
        return i.plant->cameras()->fewest_frames() - frames >= compared_frames &&
               std::none_of(pairs.begin(), pairs.end(), [](const CameraPair& pair) { return pair.undecided; });
      };
      if (!await(compared, look_patience))
        i.fail(fmt::format("the cameras' pictures could not be compared within {:g} s: the machine is too busy",
                           look_patience));
    }
    away = i.loop->away();
  } else {  // simulated robots stand at their starts, unless the file puts them elsewhere
    away = std::any_of(i.experiment.robots.begin(), i.experiment.robots.end(),
                       [](const RobotSpec& robot) { return robot.start.has_value(); });
  }
  const double began = i.clock.now();
  const auto marks_known = [&] {
    const MarksStatus marks = i.plant->marks();
    return marks.known || !marks.exchanged.empty() ||
           (!marks.sentence.empty() && i.clock.now() - began >= marks_patience);
  };
  if (!await(marks_known, look_patience))
    i.fail(fmt::format("the marks on the floor could not be looked for within {:g} s: the machine is too busy",
                       look_patience));
  if (const Answer may = i.may_drive(); !may) i.fail(may.error());
  while (i.loop->stop_asked() && !over() && !i.loop->failed()) turn();
  if (away && i.experiment.staging.automatic && !over()) drive_to_starts();
  ask_or_fail("start", start());
  while (!over() && !i.loop->failed()) turn();
  if (i.experiment.staging.back && i.loop->phase() == Phase::finished) drive_to_starts();
  i.heed_camera();
  return i.loop->phase();
}

void Session::close() {
  SessionWiring& i = *wiring_;
  if (i.closed) return;
  i.closed = true;
  i.stop();
  i.ends_test = true;
  if (i.test.valid()) i.test.wait();
  if (i.net) i.net->on_stop({}, {});
  if (i.supervisor_thread.joinable()) {
    i.supervisor_thread.request_stop();
    i.supervisor_thread.join();
  }
  i.loop->end_thread();
  i.plant->close();
  if (i.controller) i.controller->close();
  if (i.net) i.net->done(stop_results(i.experiment, i.plant->robots()));
  i.sleep.reset();
  if (i.recorder_thread.joinable()) {
    i.recorder_thread.request_stop();
    i.recorder_thread.join();
  }
}

}  // namespace skein::app
