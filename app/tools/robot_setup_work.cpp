#include "app/tools/robot_setup_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>

#include "app/run/interrupted.h"
#include "app/tools/aside.h"
#include "app/tools/driven_plant.h"
#include "app/tools/robot_ping.h"

namespace skein::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double scan_time = 12.0;                 // an inquiry takes 10.24 s [s]
constexpr double ping_time = 4.0;                  // at 25 Hz 100 questions [s]
constexpr std::chrono::seconds window_silence(3);  // as in a run

/// A robot that is in no formation, before the experiment's cameras.
Experiment around(const Experiment& experiment, const RobotSpec& robot) {
  Experiment alone;
  alone.name = experiment.name;
  alone.rate = experiment.rate;
  alone.arena_width = experiment.arena_width;
  alone.arena_height = experiment.arena_height;
  alone.camera = experiment.camera;
  alone.links = experiment.links;
  alone.directory = experiment.directory;
  alone.robots = {robot};
  return alone;
}

}  // namespace

struct SetupWork::Work {
  explicit Work(SetupTask of) : task(std::move(of)) {}

  void run() {
    std::string problem;
    try {
      problem = carry_out();
    } catch (const std::exception& error) {
      problem = error.what();
    }
    const std::lock_guard lock(mutex);
    newest.problem = std::move(problem);
    newest.over = over = true;
    changed.notify_all();
  }

  std::string carry_out() {
    switch (task.kind) {
      case SetupTask::Kind::scan:
        return scan();
      case SetupTask::Kind::pair:
        return pair();
      case SetupTask::Kind::ping:
        return ping();
      case SetupTask::Kind::test:
        return test();
    }
    return {};
  }

  std::string scan() {
    if (const auto checked = comms::check_adapter(task.adapter); !checked) return checked.error();
    say(fmt::format("Searching for robots by Bluetooth, {:g} s …", scan_time));
    auto found = comms::scan_robots({task.adapter, scan_time, [this] { return !ended(); }});
    if (!found) return found.error();
    const bool any = !found->empty();
    const std::lock_guard lock(mutex);
    newest.found = std::move(*found);
    return any || ends ? std::string()
                       : "no robot found. Is it switched on and in range? An e-puck2 is discoverable only when its "
                         "button is held while it is switched on";
  }

  std::string pair() {
    if (const auto checked = comms::check_adapter(task.adapter); !checked) return checked.error();
    std::string problem;
    for (auto& [row, robot] : task.robots) {
      if (ended()) break;
      say(fmt::format("Pairing with {} …", robot.name));
      const auto address = comms::parse_link_address(robot.spec.address);
      const auto paired = comms::pair_robot({.robot = address ? address->device : robot.spec.name,
                                             .adapter = task.adapter.empty() ? robot.spec.adapter : task.adapter,
                                             .keep_on = [this] { return !ended(); }});
      if (!paired) {
        problem += fmt::format("{}{}: {}", problem.empty() ? "" : "; ", robot.name, paired.error());
        continue;
      }
      robot.paired = paired->paired;
      if (robot.number < 0) robot.spec.adapter = paired->adapter;
      tell(row, robot);
    }
    return problem;
  }

  std::string ping() {
    say(fmt::format("Asking {} for {:g} s; no robot drives …", names(), ping_time));
    Experiment experiment = task.experiment;
    std::vector<std::size_t> places;  // in `experiment`, of task.robots
    for (const auto& [row, robot] : task.robots) {
      if (robot.number < 0) experiment.robots.push_back(robot.spec);
      places.push_back(robot.number < 0 ? experiment.robots.size() - 1 : static_cast<std::size_t>(robot.number));
    }
    const auto ping = ping_robots(with_links_of(std::move(experiment), places),
                                  {.seconds = ping_time,
                                   .all = false,
                                   .keep_on = [this] { return !ended() && !interrupted(); },
                                   .warn = [this](const std::string& sentence) { warn(sentence); }});
    if (!ping) return ping.error();
    for (std::size_t k = 0; k < task.robots.size(); ++k)
      for (const RobotPing::Robot& answer : ping->robots)
        if (answer.robot == places[k]) take(answer, k, ping->seconds);
    return {};
  }

  void take(const RobotPing::Robot& answer, std::size_t k, double seconds) {
    auto& [row, robot] = task.robots[k];
    const bool cut_short = ended() && seconds < ping_time;
    if (cut_short && !answer.answered()) return;  // it had no chance
    robot.pinged = true;
    robot.answers = answer.answered();
    robot.silence = answer.status.reason.empty() ? "nothing came back" : answer.status.reason;
    robot.exchanges = answer.status.exchanges;
    robot.lost = answer.status.timeouts;
    robot.may_drive = answer.answered() && !answer.stop_acknowledged;
    if (robot.answers) {
      robot.round_trip = answer.times.quantile_since_start(0.5);
      robot.round_trip_p99 = answer.times.quantile_since_start(0.99);
      robot.battery = comms::to_text(answer.status.battery);
      robot.battery_low = answer.status.battery.low;
      robot.version = answer.status.version;
    }
    tell(row, robot);
  }

  std::string test() {
    for (auto& [row, robot] : task.robots) {
      if (ended()) break;
      say(fmt::format("Testing {}: it drives …", robot.name));
      const bool inside = robot.number >= 0;
      const std::size_t number = inside ? static_cast<std::size_t>(robot.number) : 0;
      test(robot, inside ? with_links_of(task.experiment, {number}) : around(task.experiment, robot.spec), number);
      tell(row, robot);
      // Whatever ended it (STOP, a camera that is lost) concerns the next one, too.
      if (!robot.test_problem.empty()) return fmt::format("{}: {}", robot.name, robot.test_problem);
    }
    return {};
  }

  void test(RobotSetup& robot, Experiment experiment, std::size_t number) {
    SessionOptions options;
    options.every_tag = true;
    options.keep_on = [this] { return goes_on(); };
    robot.test_problem.clear();
    const std::string name = robot_name(experiment, number);
    const auto opened =
        DrivenPlant::open(std::move(experiment), options, [this](const std::string& sentence) { warn(sentence); });
    if (!opened) {
      if (ended()) return;                      // before anybody drove
      if (!opened.error().starts_with(name)) {  // its link's error would; this is a camera's
        robot.test_problem = opened.error();
        return;
      }
      robot.pinged = true;
      robot.answers = false;
      robot.silence = opened.error();
      return;
    }
    robot.pinged = robot.answers = true;
    DrivenPlant& driving = **opened;
    tl::expected<RobotTestResult, std::string> result;
    {
      const Reach reach(*this, driving);
      RobotTest test(driving.plant(), driving.clock(), driving.experiment(), [&] {
        if (!driving.keep_on()) stop();
        return goes_on();
      });
      result = test.test(number);
    }
    driving.close();
    robot.may_drive = !driving.plant().robots().at(number).stop_acknowledged;
    if (!result) {
      robot.test_problem = result.error();
      return;
    }
    const RobotStatus& status = result->status;
    if (std::isnan(robot.round_trip))
      robot.round_trip = status.round_trip, robot.round_trip_p99 = status.round_trip_p99;
    if (!status.version.empty()) robot.version = status.version;
    if (robot.battery.empty() || !std::isnan(status.battery)) {
      robot.battery = status.battery_text;
      robot.battery_low = status.battery_low;
    }
    robot.test = std::move(*result);
  }

  /// As long as this lives, stop() stops these robots.
  struct Reach {
    Reach(Work& of, DrivenPlant& driving) : work(of) {
      const std::lock_guard lock(work.mutex);
      work.driven = &driving;
    }
    ~Reach() {
      const std::lock_guard lock(work.mutex);
      work.driven = nullptr;
    }
    Reach(const Reach&) = delete;
    Reach& operator=(const Reach&) = delete;
    Work& work;
  };

  std::string names() const {
    if (task.robots.size() == 1) return task.robots.front().second.name;
    return fmt::format("{} robots", task.robots.size());
  }

  void say(std::string doing) {
    const std::lock_guard lock(mutex);
    newest.doing = std::move(doing);
  }
  void warn(const std::string& sentence) {
    const std::lock_guard lock(mutex);
    newest.warnings.push_back(sentence);
  }
  void tell(std::size_t row, const RobotSetup& robot) {
    const std::lock_guard lock(mutex);
    newest.robots.emplace_back(row, robot);
  }
  bool ended() const {
    const std::lock_guard lock(mutex);
    return ends;
  }
  /// It has not been ended, and the window still responds.
  bool goes_on() {
    if (interrupted()) return false;
    const std::lock_guard lock(mutex);
    if (Clock::now() - looked_at > window_silence) ends = true;
    return !ends;
  }
  void stop() noexcept {
    const std::lock_guard lock(mutex);
    ends = true;
    if (driven) driven->stop();
  }

  SetupTask task;            // the thread's
  mutable std::mutex mutex;  // of all that follows
  std::condition_variable changed;
  bool ends = false, over = false;
  DrivenPlant* driven = nullptr;  // that may be driving
  Clock::time_point looked_at = Clock::now();
  SetupNews newest;
};

SetupWork::SetupWork(SetupTask task) : work_(std::make_shared<Work>(std::move(task))) {
  run_aside([work = work_] { work->run(); }, Aside::beside);
}

SetupWork::~SetupWork() {
  stop();
}

void SetupWork::stop() noexcept {
  work_->stop();
}

SetupNews SetupWork::news() {
  const std::lock_guard lock(work_->mutex);
  work_->looked_at = Clock::now();
  SetupNews news = work_->newest;
  work_->newest.robots.clear();
  work_->newest.found.clear();
  work_->newest.warnings.clear();
  return news;
}

bool SetupWork::wait(double seconds) const {
  std::unique_lock lock(work_->mutex);
  return work_->changed.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return work_->over; });
}

}  // namespace skein::app
