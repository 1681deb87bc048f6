#include "app/controllers/own_controller.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>
#include <wordexp.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <thread>

#include "app/run/clocks.h"
#include "app/run/resources.h"

namespace skein::app {
namespace {

constexpr double start_patience = 20.0;   // an interpreter and its libraries come from a cold disk [s]
constexpr double waiting_deadline = 0.5;  // where no clock runs by itself [s]
constexpr double preview_deadline = 2.0;  // of a process that has the lowest priority [s]
constexpr int late_too_often = 25;        // in a row
constexpr double watch_seconds = 2e-4;    // an answer that comes sooner costs no sleep and no waking up [s]
constexpr std::size_t most_samples = 1'000'000;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

template <std::size_t N>
std::string text_of(const char (&field)[N]) {
  return {field, ::strnlen(field, N)};
}
template <std::size_t N>
void put_text(char (&field)[N], std::string_view text) {
  std::memset(field, 0, N);
  std::memcpy(field, text.data(), std::min(text.size(), N - 1));
}

/// Python finds its package `skein` wherever Skein is.
std::string python_path() {
  std::string path = resource_folder("python");
  if (const char* const given = std::getenv("PYTHONPATH"); given && *given)
    path += (path.empty() ? "" : ":") + std::string(given);
  return "PYTHONPATH=" + path;
}

void put_point(double (&field)[5], const core::ReferencePoint& point) noexcept {
  field[0] = point.pose.x, field[1] = point.pose.y, field[2] = point.pose.theta;
  field[3] = point.twist.v, field[4] = point.twist.omega;
}

}  // namespace

/// The shared memory. Sealed, so that neither process can shrink it under the other.
struct OwnController::Memory {
  int file = -1;
  skein_memory* at = nullptr;

  tl::expected<void, std::string> open() {
    const auto failed = [] {
      return tl::unexpected(fmt::format("no memory to share with the controller: {}", std::strerror(errno)));
    };
    file = ::memfd_create("skein-controller", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (file < 0 || ::ftruncate(file, sizeof(skein_memory)) != 0 ||
        ::fcntl(file, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
      return failed();
    void* const mapped = ::mmap(nullptr, sizeof(skein_memory), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (mapped == MAP_FAILED) return failed();
    at = static_cast<skein_memory*>(mapped);
    return {};
  }
  ~Memory() {
    if (at) ::munmap(at, sizeof(skein_memory));
    if (file >= 0) ::close(file);
  }
};

/// A question rings at one pipe, an answer at the other. This side keeps both ends of the first: a controller that has
/// gone is no broken pipe.
struct OwnController::Pipes {
  int question[2] = {-1, -1}, answer[2] = {-1, -1};

  bool open() {
    return ::pipe2(question, O_CLOEXEC) == 0 && ::pipe2(answer, O_CLOEXEC) == 0 &&
           ::fcntl(question[1], F_SETFL, O_NONBLOCK) == 0 && ::fcntl(answer[0], F_SETFL, O_NONBLOCK) == 0;
  }
  void keep_ours() {  // so that the end of the controller is seen
    ::close(answer[1]);
    answer[1] = -1;
  }
  ~Pipes() {
    for (const int file : {question[0], question[1], answer[0], answer[1]})
      if (file >= 0) ::close(file);
  }
};

tl::expected<std::vector<std::string>, std::string> words_of(const std::string& command) {
  wordexp_t found{};
  const int error = ::wordexp(command.c_str(), &found, WRDE_NOCMD | WRDE_UNDEF);
  std::vector<std::string> words;
  if (error == 0) words.assign(found.we_wordv, found.we_wordv + found.we_wordc);
  if (error == 0 || error == WRDE_NOSPACE) ::wordfree(&found);
  if (error == 0 && !words.empty()) return words;
  return tl::unexpected(fmt::format(
      "controller.command: found \"{}\", allowed: a program and its arguments, quoted as for a shell, {}", command,
      error == WRDE_BADVAL   ? "with variables that are set"
      : error == WRDE_CMDSUB ? "without commands inside"
      : error == WRDE_SYNTAX ? "with every quote closed"
                             : "without | & ; < > ( ) { } outside quotes"));
}

OwnController::OwnController(const Experiment& experiment, bool waits, bool for_preview)
    : memory_(std::make_unique<Memory>()),
      pipes_(std::make_unique<Pipes>()),
      law_(experiment.robots.size(), core::Twist{none, none}),
      // Where the clock is virtual, nothing is won and the processor is wanted by others; a single one, by the process.
      watch_(waits || std::thread::hardware_concurrency() < 2 ? 0.0 : watch_seconds) {
  const LawSpec& law = experiment.controller.law;
  logged_.assign(experiment.robots.size() * law.log.size(), none);
  report_.deadline =
      for_preview ? preview_deadline : law.deadline.value_or(waits ? waiting_deadline : default_deadline(experiment));
  report_.waits.reserve(std::min(most_samples, static_cast<std::size_t>(experiment.ticks())));
}

OwnController::~OwnController() {
  process_.reset();  // killed, and waited for
}

tl::expected<std::unique_ptr<OwnController>, std::string> OwnController::start(const Experiment& experiment, bool waits,
                                                                               const ControllerStart& how) {
  const LawSpec& law = experiment.controller.law;
  std::unique_ptr<OwnController> own(new OwnController(experiment, waits, how.for_preview));
  if (auto opened = own->memory_->open(); !opened) return tl::unexpected(opened.error());
  if (!own->pipes_->open()) return tl::unexpected(fmt::format("no pipes to the controller: {}", std::strerror(errno)));

  skein_memory& memory = *own->memory_->at;
  memory.version = SKEIN_CONTROLLER_VERSION;
  memory.bytes = sizeof memory;
  memory.robots = static_cast<std::uint32_t>(experiment.robots.size());
  memory.period = experiment.period();
  memory.half_width = 0.5 * experiment.arena_width;
  memory.half_height = 0.5 * experiment.arena_height;
  memory.parameters = static_cast<std::uint32_t>(std::min<std::size_t>(law.own_parameters.size(), SKEIN_PARAMETERS));
  for (std::size_t k = 0; k < memory.parameters; ++k) {
    put_text(memory.parameter[k].name, law.own_parameters[k].first);
    memory.parameter[k].value = law.own_parameters[k].second;
  }
  std::memcpy(memory.magic, SKEIN_MAGIC, sizeof memory.magic);  // last: now it may be read

  BoundedProcess::Setup setup;
  if (!law.library.empty()) {
    const std::filesystem::path path =
        std::filesystem::absolute(std::filesystem::path(experiment.directory) / law.library);
    setup.words = {how.program.empty() ? "/proc/self/exe" : how.program, "controller-host", path.string()};
  } else {
    auto words = words_of(law.command);
    if (!words) return tl::unexpected(words.error());
    setup.words = std::move(*words);
  }
  setup.directory = experiment.directory;
  setup.environment = {python_path(), "PYTHONUNBUFFERED=1"};
  if (how.for_preview) setup.environment.emplace_back("SKEIN_PREVIEW=1");
  setup.prints = how.prints;
  for (const char* const threads : {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"})
    if (!std::getenv(threads)) setup.environment.push_back(std::string(threads) + "=1");
  setup.files = {own->memory_->file, own->pipes_->question[0], own->pipes_->answer[1]};
  setup.bounds.memory = law.memory;
  setup.bounds.processes = law.processes;
  setup.bounds.cpu_seconds = 60 + static_cast<std::int64_t>(2.0 * experiment.duration);
  auto process = BoundedProcess::start(setup);
  if (!process) return tl::unexpected(process.error());
  own->process_ = std::move(*process);
  own->pipes_->keep_ours();
  if (auto ready = own->become_ready(experiment, how.keep_on); !ready) return tl::unexpected(ready.error());
  return own;
}

tl::expected<void, std::string> OwnController::become_ready(const Experiment& experiment,
                                                            const std::function<bool()>& keep_on) {
  const double until = monotonic_seconds() + start_patience;
  char byte = 0;
  while (true) {
    pollfd ready{pipes_->answer[0], POLLIN, 0};
    ::poll(&ready, 1, 100);
    const ssize_t n = ::read(pipes_->answer[0], &byte, 1);
    if (n == 1) {
      may_be_woken_ = byte == 'w';
      break;
    }
    if (n == 0) {
      const std::string refusal = text_of(memory_->at->refusal);
      const std::string how = process_->how_it_ended(1.0);
      return tl::unexpected(fmt::format("the controller did not become ready: {}", !refusal.empty() ? refusal
                                                                                   : how.empty() ? "it closed its line"
                                                                                                 : how));
    }
    if (keep_on && !keep_on()) return tl::unexpected(std::string("the start was given up"));
    if (monotonic_seconds() > until)
      return tl::unexpected(
          fmt::format("the controller was not ready within {:g} s: it must attach to the memory and write a byte to "
                      "file {} (docs/controllers.md)",
                      start_patience, SKEIN_ANSWER_FD));
  }
  if (const std::string refusal = text_of(memory_->at->refusal); !refusal.empty())
    return tl::unexpected("the controller refuses: " + refusal);
  return take_declarations(experiment);
}

/// What it takes, on a copy: it may go on writing. The file's values and the file's changes have to be among it.
tl::expected<void, std::string> OwnController::take_parameters(const Experiment& experiment) {
  skein_memory& memory = *memory_->at;
  // The process may have written another number since this one was checked.
  const auto count = std::min<std::size_t>(memory.parameters, SKEIN_PARAMETERS);
  const bool ranges = memory.declared != 0;
  constexpr double any = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < count; ++k) {
    skein_parameter p;
    std::memcpy(&p, &memory.parameter[k], sizeof p);
    declared_.push_back(
        {text_of(p.name), text_of(p.unit), text_of(p.help), ranges ? p.low : -any, ranges ? p.high : any, p.value});
  }
  for (const LawParameter& p : declared_)
    if (!(p.low <= p.high))
      return tl::unexpected(fmt::format(
          "the controller's parameter {}: declared from {} to {}, allowed: low not above high", p.name, p.low, p.high));
  const auto given = [&](const LawParameter& p) {
    return std::any_of(experiment.controller.law.own_parameters.begin(), experiment.controller.law.own_parameters.end(),
                       [&](const auto& own) { return own.first == p.name; });
  };
  for (const LawParameter& p : declared_)
    if (!given(p) && !(p.low <= p.value && p.value <= p.high))
      return tl::unexpected(
          fmt::format("the controller's parameter {}: its default is {}, allowed: {} to {}, as declared", p.name,
                      p.value, p.low, p.high));
  for (const auto& [name, value] : experiment.controller.law.own_parameters) {
    const auto found = std::find_if(declared_.begin(), declared_.end(),
                                    [&name = name](const LawParameter& p) { return p.name == name; });
    if (const std::string allowed = wrong_parameter(declared_, name, value); !allowed.empty())
      return tl::unexpected(
          found == declared_.end()
              ? fmt::format("controller.parameters.{}: the controller knows no such parameter, allowed: {}", name,
                            declared_.empty() ? "none" : allowed)
              : fmt::format("controller.parameters.{}: found {}, allowed: {}", name, value, allowed));
    found->value = value;
  }
  for (std::size_t k = 0; k < experiment.actions.size(); ++k)
    if (const auto* const change = std::get_if<events::Parameter>(&experiment.actions[k].event))
      if (const std::string allowed = wrong_parameter(declared_, change->name.text(), change->to); !allowed.empty())
        return tl::unexpected(
            fmt::format("operator.{}.does: found \"{}\", allowed: {}", k + 1, describe(*change), allowed));
  for (std::size_t k = 0; k < count; ++k) {
    values_.push_back({ParameterName(declared_[k].name), declared_[k].value});
    memory.parameter[k].value = declared_[k].value;
  }
  return {};
}

tl::expected<void, std::string> OwnController::take_declarations(const Experiment& experiment) {
  if (memory_->at->parameters > SKEIN_PARAMETERS || memory_->at->logs > SKEIN_LOGS)
    return tl::unexpected(fmt::format("the controller declares {} parameters and {} logs, allowed: at most {} and {}",
                                      memory_->at->parameters, memory_->at->logs, SKEIN_PARAMETERS, SKEIN_LOGS));
  if (auto taken = take_parameters(experiment); !taken) return taken;
  const LawSpec& law = experiment.controller.law;
  const skein_memory& memory = *memory_->at;
  const auto logs = std::min<std::size_t>(memory.logs, SKEIN_LOGS);
  std::string names;
  for (std::size_t k = 0; k < logs; ++k) names += (k ? ", " : "") + text_of(memory.log_name[k]);
  for (const std::string& name : law.log) {
    std::size_t place = 0;
    while (place < logs && text_of(memory.log_name[place]) != name) ++place;
    if (place == logs)
      return tl::unexpected(fmt::format("controller.log: the controller logs no \"{}\", allowed: {}", name,
                                        names.empty() ? "none" : names));
    log_places_.push_back(place);
  }
  return {};
}

void OwnController::heed(std::span<const Event> events) noexcept {
  for (const Event& event : events)
    if (const auto* const change = std::get_if<events::Parameter>(&event))
      for (Value& value : values_)
        if (value.name == change->name) value.now = change->to;
}

void OwnController::write_question(const core::ControllerInput& input) noexcept {
  skein_memory& memory = *memory_->at;
  const std::size_t robots = std::min<std::size_t>(input.poses.size(), SKEIN_ROBOTS);
  for (std::size_t i = 0; i < robots; ++i) {
    skein_robot& robot = memory.robot[i];
    robot.x = input.poses[i].x, robot.y = input.poses[i].y, robot.theta = input.poses[i].theta;
    for (int k = 0; k < 9; ++k) robot.covariance[k] = input.covariance[i](k / 3, k % 3);
    robot.v = input.twists[i].v, robot.omega = input.twists[i].omega;
    put_point(robot.nominal, input.nominal[i]);
    put_point(robot.reference, input.reference[i]);
    robot.error[0] = input.errors[i].x, robot.error[1] = input.errors[i].y, robot.error[2] = input.errors[i].theta;
    robot.v_max = input.gains->v_max[i], robot.omega_max = input.gains->omega_max[i];
    robot.out = input.out[i] ? 1.0 : 0.0;
    memory.command[i] = {none, none};  // what is not written at this question is no command: the robot stands
    std::fill(std::begin(memory.log[i]), std::end(memory.log[i]), none);
  }
  const std::size_t obstacles = std::min<std::size_t>(input.obstacles.size(), SKEIN_OBSTACLES);
  for (std::size_t k = 0; k < obstacles; ++k)
    memory.obstacle[k] = {input.obstacles[k].x, input.obstacles[k].y, input.obstacles[k].radius};
  memory.obstacles = static_cast<std::uint32_t>(obstacles);
  for (std::size_t k = 0; k < values_.size(); ++k) memory.parameter[k].value = values_[k].now;
  memory.tick = input.tick;
  memory.t = input.t;
  memory.dt = input.dt;
}

/// Until the memory has this answer; false: not by then, or never.
bool OwnController::wait_for(std::uint64_t answer, double seconds) noexcept {
  const double began = monotonic_seconds(), until = began + seconds;
  std::array<char, 4096> bytes;  // a controller that floods the pipe is read as fast as it writes, until the deadline
  while (std::atomic_ref(memory_->at->answer).load(std::memory_order_acquire) != answer) {
    const double now = monotonic_seconds(), left = until - now;
    if (left <= 0.0) return false;
    if (now < began + watch_) continue;
    pollfd ready{pipes_->answer[0], POLLIN, 0};
    const auto nanoseconds = static_cast<long>(1e9 * std::min(left, 60.0));
    const timespec timeout{nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
    if (::ppoll(&ready, 1, &timeout, nullptr) <= 0) continue;
    if (::read(pipes_->answer[0], bytes.data(), bytes.size()) == 0) {
      state_.store(ControllerState::ended, std::memory_order_release);
      return false;
    }
  }
  return true;
}

void OwnController::wake() noexcept {
  if (may_be_woken_ && state() != ControllerState::ended) (void)!::write(pipes_->question[1], "w", 1);
}

void OwnController::ask(const core::ControllerInput& input) noexcept {
  std::fill(law_.begin(), law_.end(), core::Twist{none, none});
  std::fill(logged_.begin(), logged_.end(), none);
  ++report_.asked;
  if (state() == ControllerState::ended) {
    ++report_.late;
    return;
  }
  skein_memory& memory = *memory_->at;
  const double began = monotonic_seconds();
  write_question(input);
  std::atomic_ref(memory.question).store(++question_, std::memory_order_release);
  (void)!::write(pipes_->question[1], "q", 1);  // full: there are enough bytes in it that wake it up
  const bool answered = wait_for(question_, report_.deadline);
  const double waited = monotonic_seconds() - began;
  report_.longest = std::max(report_.longest, waited);
  if (answered) {
    for (std::size_t i = 0; i < law_.size(); ++i) {
      skein_command command;
      std::memcpy(&command, &memory.command[i], sizeof command);
      law_[i] = {command.v, command.omega};
      for (std::size_t k = 0; k < log_places_.size(); ++k) {
        double& value = logged_[i * log_places_.size() + k];
        std::memcpy(&value, &memory.log[i][log_places_[k]], sizeof value);
        if (!(std::abs(value) <= 1e9)) value = none;  // what a CSV can hold
      }
    }
    if (report_.waits.size() < report_.waits.capacity()) report_.waits.push_back(waited);
    late_in_a_row_ = 0;
    state_.store(ControllerState::answered, std::memory_order_release);
    return;
  }
  ++report_.late;
  if (state() == ControllerState::ended) return;
  state_.store(ControllerState::late, std::memory_order_release);
  if (++late_in_a_row_ >= late_too_often) end();
}

void OwnController::end() noexcept {
  ended_by_us_ = true;
  process_->end();
  state_.store(ControllerState::ended, std::memory_order_release);
}

void OwnController::close() noexcept {
  state_.store(ControllerState::ended, std::memory_order_release);
  process_.reset();
}

std::string OwnController::why_it_ended() {
  if (state() != ControllerState::ended) return {};
  if (!process_) return {};
  const std::string how = process_->how_it_ended(1.0);
  if (ended_by_us_)
    return fmt::format("the controller was late {} times in a row, {:g} s each, and was killed", late_too_often,
                       report_.deadline);
  return "the controller is gone: " + (how.empty() ? std::string("it closed its line") : how);
}

}  // namespace skein::app
