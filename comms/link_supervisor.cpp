#include "comms/link_supervisor.h"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "comms/crash_stop.h"
#include "comms/link.h"
#include "comms/watchdog.h"

namespace skein::comms {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_now() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// Goes on while the machine is suspended, as the robots do.
double boot_seconds() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

constexpr double longest_silence = 0.3, beat_period = 0.1;  // [s]
constexpr double page_time = 5.12;                          // of one robot, at most [s]

bool share_an_adapter(const LinkAddress& a, const LinkAddress& b) {
  return a.kind == LinkKind::rfcomm && b.kind == LinkKind::rfcomm && a.adapter == b.adapter;
}
std::size_t paged_by_the_same(const std::vector<LinkAddress>& robots, std::size_t robot) {
  return static_cast<std::size_t>(std::count_if(
      robots.begin(), robots.end(), [&](const LinkAddress& other) { return share_an_adapter(robots[robot], other); }));
}

Clock::time_point in(double seconds) {
  // Bounded: "wait for ever" given as infinity must not overflow the clock.
  const double bounded = std::clamp(seconds, 0.0, 1e6);
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(bounded));
}

}  // namespace

/// The thread and what it shares. The links belong to the thread, except for their slots; others look at them only with
/// `mutex_` held, which the thread lets go of whenever it waits.
class LinkSupervisor::Loop {
 public:
  Loop(std::vector<LinkAddress> robots, LinkOptions options) : options_(options) {
    for (std::size_t i = 0; i < robots.size(); ++i) {
      const auto resolved = resolve(robots[i]);
      LinkOptions own = options;
      own.connect_timeout = connect_patience(robots, i, options.connect_timeout);
      options_.connect_timeout = std::max(options_.connect_timeout, own.connect_timeout);
      links_.emplace_back(resolved ? *resolved : robots[i], own);
      if (!resolved) links_.back().fail(resolved.error(), seconds_now());
    }
    polled_.reserve(links_.size() + 1);  // the thread never allocates for it
    wake_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  }
  ~Loop() {
    close(options_.close_timeout);
    if (wake_ >= 0) ::close(wake_);
  }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  tl::expected<void, std::string> start(double timeout_s, bool all, const std::function<bool()>& keep_on);
  void command(std::size_t robot, int left, int right) noexcept;
  void emergency_stop() noexcept;
  void release_stop() noexcept;
  bool stopped() const noexcept { return (emergency_.load() & 1u) != 0; }
  double stood_still() const noexcept { return stood_still_.load(); }
  bool wait_acknowledged(double timeout_s);
  void hush(std::size_t robot, double seconds) {
    const std::lock_guard lock(mutex_);
    if (robot < links_.size()) links_[robot].hush(seconds_now() + seconds);
  }
  CommandTimes times(std::size_t robot) const noexcept { return links_[robot].times(); }
  std::vector<LinkStatus> status() const;
  RoundTrips round_trips(std::size_t robot) const {
    const std::lock_guard lock(mutex_);
    return links_[robot].round_trips();
  }
  std::vector<LinkStatus> close(double timeout_s);
  std::size_t size() const noexcept { return links_.size(); }

 private:
  std::string sentence_about(const Link& link, double waited) const;
  void run() noexcept;
  void wait();
  void look_at_the_clock() noexcept;
  void turn(double now);
  double end_by() const;
  bool finished(double now) const;
  void wake() noexcept;
  void ring() noexcept;

  LinkOptions options_;
  std::deque<Link> links_;  // a deque: a link with its atomic slot cannot move
  std::vector<pollfd> polled_;
  int wake_ = -1;  // eventfd
  std::thread thread_;

  std::atomic<bool> woken_{false};           // the eventfd has been rung and not yet answered
  std::atomic<std::uint32_t> emergency_{0};  // odd: stopped; +1 at every stop and every release, so its value names the
                                             // epoch between two of them
  std::atomic<bool> closing_{false};
  std::atomic<double> stood_still_{0.0};
  double turned_at_ = 0.0, waited_for_ = 0.0;  // of the last turn, on the clock that is never suspended
  std::uint32_t stops_seen_ = 0;
  bool closing_seen_ = false;

  CrashThread crash_{[](void* loop) noexcept { static_cast<Loop*>(loop)->emergency_stop(); }, this};

  mutable std::mutex mutex_;
  std::condition_variable turned_;  // notified after every turn
  double close_by_ = 0.0;           // guarded by mutex_
  bool started_ = false;            // guarded by mutex_
  std::mutex close_mutex_;          // one close() at a time
};

// --- Any thread -----------------------------------------------------------------------------------------------------

/// Why a link is not up.
std::string LinkSupervisor::Loop::sentence_about(const Link& link, double waited) const {
  const LinkStatus status = link.status(seconds_now());
  const std::string& name = link.address().name;
  return fmt::format(
      "{} ({}): {}",
      name.empty() ? fmt::format("robot {}", std::find_if(links_.begin(), links_.end(),
                                                          [&](const Link& other) { return &other == &link; }) -
                                                 links_.begin() + 1)
                   : name,
      to_text(link.address()),
      status.reason.empty() ? fmt::format("still {} after {:g} s", word(status.state), waited) : status.reason);
}

tl::expected<void, std::string> LinkSupervisor::Loop::start(double timeout_s, bool all,
                                                            const std::function<bool()>& keep_on) {
  if (wake_ < 0) return tl::unexpected(std::string("the system has no file descriptor left for the links"));
  std::string failure;
  {
    std::unique_lock lock(mutex_);
    if (std::exchange(started_, true)) return tl::unexpected(std::string("the links are already started"));
    try {
      thread_ = std::thread([this] { run(); });
    } catch (const std::system_error& error) {
      return tl::unexpected(fmt::format("the link thread cannot be started: {}", error.what()));
    }
    const auto is_up = [](const Link& link) { return link.up(); };
    const auto is_failed = [](const Link& link) { return link.failed(); };
    const auto is_settled = [&](const Link& link) { return is_up(link) || is_failed(link); };
    const auto settled = [&] {
      return closing_.load() || std::all_of(links_.begin(), links_.end(), is_settled) ||
             (all && std::any_of(links_.begin(), links_.end(), is_failed));
    };
    constexpr double between_questions = 0.1;  // [s]
    const auto give_up = in(timeout_s);
    bool ended = false;
    while (!turned_.wait_until(lock, std::min(give_up, in(between_questions)), settled) && !ended &&
           in(0.0) < give_up) {
      lock.unlock();
      ended = keep_on && !keep_on();
      lock.lock();
    }
    if (ended) failure = "stopped";
    if (!ended && !all && !closing_.load()) return {};
    auto culprit = std::find_if(links_.begin(), links_.end(), is_failed);
    if (culprit == links_.end()) culprit = std::find_if_not(links_.begin(), links_.end(), is_up);
    if (culprit == links_.end() && !ended) return {};
    if (!ended) failure = sentence_about(*culprit, timeout_s);
  }
  close(options_.close_timeout);
  return tl::unexpected(failure);
}
void LinkSupervisor::Loop::command(std::size_t robot, int left, int right) noexcept {
  const std::uint32_t epoch = emergency_.load();
  if (robot >= links_.size() || (epoch & 1u) != 0) return;
  links_[robot].slot.put(links_[robot].clamped(left, right), static_cast<std::uint16_t>(epoch));
  wake();
}

void LinkSupervisor::Loop::emergency_stop() noexcept {
  emergency_.fetch_or(1u);
  // Not wake(): in a signal handler that interrupts a command() which has set the flag and not yet rung, the wake-up
  // would be lost.
  woken_.store(true);
  ring();
}

void LinkSupervisor::Loop::release_stop() noexcept {
  std::uint32_t epoch = emergency_.load();
  if ((epoch & 1u) != 0) emergency_.compare_exchange_strong(epoch, epoch + 1);
}

void LinkSupervisor::Loop::wake() noexcept {
  if (!woken_.exchange(true)) ring();  // one write for the commands of a whole tick
}

void LinkSupervisor::Loop::ring() noexcept {
  const int kept = errno;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(wake_, &one, sizeof one);  // full means rung already
  errno = kept;
}

bool LinkSupervisor::Loop::wait_acknowledged(double timeout_s) {
  std::unique_lock lock(mutex_);
  return turned_.wait_until(lock, in(timeout_s), [&] {
    return std::all_of(links_.begin(), links_.end(), [](const Link& link) { return link.settled(); });
  });
}

std::vector<LinkStatus> LinkSupervisor::Loop::status() const {
  const std::lock_guard lock(mutex_);
  std::vector<LinkStatus> status;
  status.reserve(links_.size());
  const double now = seconds_now();
  for (const Link& link : links_) status.push_back(link.status(now));
  return status;
}

std::vector<LinkStatus> LinkSupervisor::Loop::close(double timeout_s) {
  const std::lock_guard only(close_mutex_);
  if (thread_.joinable()) {
    {
      const std::lock_guard lock(mutex_);
      close_by_ = seconds_now() + timeout_s;
    }
    closing_.store(true);
    woken_.store(true);
    ring();
    thread_.join();
  }
  return status();
}

// --- The link thread ------------------------------------------------------------------------------------------------

void LinkSupervisor::Loop::run() noexcept {
  crash_.runs_here();
  // Real-time priority where the system grants it, above the control thread's: a stop waits for no computation.
  sched_param priority{};
  priority.sched_priority = 21;
  ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
  Heart heart(std::max(longest_silence, options_.command_silence));
  turned_at_ = boot_seconds();
  std::unique_lock lock(mutex_);
  while (true) {
    heart.beat();
    look_at_the_clock();
    const double now = seconds_now();
    turn(now);
    turned_.notify_all();
    if (finished(now)) break;
    lock.unlock();
    wait();
    lock.lock();
  }
  for (Link& link : links_) link.end();
}

void LinkSupervisor::Loop::look_at_the_clock() noexcept {
  const double now = boot_seconds();
  const double gap = now - turned_at_ - waited_for_;
  turned_at_ = now;
  if (options_.standstill <= 0.0 || gap <= options_.standstill || stopped()) return;
  stood_still_.store(gap);
  emergency_stop();
}

void LinkSupervisor::Loop::turn(double now) {
  woken_.store(false);  // before the atomics are read: what is set from here on rings again
  const std::uint32_t emergency = emergency_.load();
  const bool close_now = closing_.load() && !std::exchange(closing_seen_, true);
  // Counted, so that a stop is carried out even if it was released before this thread came round.
  const std::uint32_t stops = emergency / 2 + (emergency & 1u);
  const bool stop_now = std::exchange(stops_seen_, stops) != stops;

  for (std::size_t i = 0; i < links_.size(); ++i) {
    Link& link = links_[i];
    try {
      if (stop_now) link.stop(now);
      if (close_now) link.begin_closing(now);
      link.turn(polled_.empty() ? short{0} : polled_[i].revents, emergency, now);
    } catch (const std::exception& error) {
      link.fail(fmt::format("internal error: {}", error.what()), now);
    }
  }
  const double written = seconds_now();
  for (Link& link : links_) link.note_times(now, written);
}

/// A robot that is being paged may still come, and then it is stopped: Bluetooth takes up to 5.12 s for that, and who
/// gave up earlier would leave it driving. Two that take turns must not keep this up for ever.
double LinkSupervisor::Loop::end_by() const {
  double end = close_by_;
  for (const Link& link : links_) end = std::max(end, link.worth_waiting_until());
  return std::min(end, close_by_ + options_.connect_timeout + 1.0);
}

bool LinkSupervisor::Loop::finished(double now) const {
  return closing_seen_ && (now >= end_by() ||
                           std::all_of(links_.begin(), links_.end(), [](const Link& link) { return link.may_end(); }));
}

void LinkSupervisor::Loop::wait() {
  double until = seconds_now() + beat_period;
  if (closing_seen_) until = std::min(until, end_by());
  polled_.clear();
  for (const Link& link : links_) {
    polled_.push_back(link.wanted());
    until = std::min(until, link.deadline());
  }
  polled_.push_back({.fd = wake_, .events = POLLIN, .revents = 0});
  const double seconds = waited_for_ = std::max(0.0, until - seconds_now());
  const timespec timeout{.tv_sec = static_cast<time_t>(seconds),
                         .tv_nsec = static_cast<long>((seconds - std::floor(seconds)) * 1e9)};
  if (::ppoll(polled_.data(), polled_.size(), &timeout, nullptr) < 0)
    for (pollfd& polled : polled_) polled.revents = 0;  // interrupted: a turn with no events does no harm
  std::uint64_t rings = 0;
  [[maybe_unused]] const auto read = ::read(wake_, &rings, sizeof rings);
}

// --- The interface --------------------------------------------------------------------------------------------------

LinkSupervisor::LinkSupervisor(std::vector<LinkAddress> robots, LinkOptions options)
    : loop_(std::make_unique<Loop>(std::move(robots), options)) {}
LinkSupervisor::~LinkSupervisor() = default;

tl::expected<void, std::string> LinkSupervisor::start(double timeout_s, const std::function<bool()>& keep_on) {
  return loop_->start(timeout_s, true, keep_on);
}
tl::expected<void, std::string> LinkSupervisor::start_who_answers(double timeout_s,
                                                                  const std::function<bool()>& keep_on) {
  return loop_->start(timeout_s, false, keep_on);
}
void LinkSupervisor::command(std::size_t robot, int left, int right) noexcept {
  loop_->command(robot, left, right);
}
void LinkSupervisor::emergency_stop() noexcept {
  loop_->emergency_stop();
}
void LinkSupervisor::release_stop() noexcept {
  loop_->release_stop();
}
bool LinkSupervisor::stopped() const noexcept {
  return loop_->stopped();
}
double LinkSupervisor::stood_still() const noexcept {
  return loop_->stood_still();
}
bool LinkSupervisor::wait_acknowledged(double timeout_s) {
  return loop_->wait_acknowledged(timeout_s);
}
void LinkSupervisor::hush(std::size_t robot, double seconds) {
  loop_->hush(robot, seconds);
}
CommandTimes LinkSupervisor::times(std::size_t robot) const noexcept {
  return loop_->times(robot);
}
std::vector<LinkStatus> LinkSupervisor::status() const {
  return loop_->status();
}
RoundTrips LinkSupervisor::round_trips(std::size_t robot) const {
  return loop_->round_trips(robot);
}
std::vector<LinkStatus> LinkSupervisor::close(double timeout_s) {
  return loop_->close(timeout_s);
}
std::size_t LinkSupervisor::size() const noexcept {
  return loop_->size();
}

double connect_patience(const std::vector<LinkAddress>& robots, std::size_t robot, double alone) {
  const std::size_t queue = paged_by_the_same(robots, robot);
  return queue > 1 ? alone + page_time * static_cast<double>(queue - 1) : alone;
}

double reach_patience(const std::vector<LinkAddress>& robots) {
  constexpr double one_robot = 15.0;  // a connection takes a few seconds, and a robot may have to be asked twice
  double longest = one_robot;
  for (std::size_t i = 0; i < robots.size(); ++i) longest = std::max(longest, connect_patience(robots, i, one_robot));
  return longest;
}

}  // namespace skein::comms
