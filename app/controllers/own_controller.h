#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/controllers/bounded_process.h"
#include "app/controllers/skein_controller.h"
#include "app/experiment/experiment.h"
#include "app/run/event.h"
#include "core/controllers/controller.h"

namespace skein::app {

/// Statistics of a controller.
struct ControllerReport {
  std::int64_t asked = 0;     ///< questions
  std::int64_t late = 0;      ///< of them, not answered by the deadline, or never
  std::vector<double> waits;  ///< from question to answer, of those answered in time, the first million [s]
  double longest = 0.0;       ///< longest wait of the control thread, answered or not [s]
  double deadline = 0.0;      ///< [s]
};

/// How a process of a controller is started.
struct ControllerStart {
  std::string program{};  ///< hosts libraries; empty: this one
  /// A second process, beside that of the run: it has SKEIN_PREVIEW=1 in its environment, and each answer is waited for
  /// for two seconds.
  bool for_preview = false;
  bool prints = true;  ///< its output goes to stderr
  /// Called while it becomes ready; if it returns false, the start is given up.
  std::function<bool()> keep_on{};
};

/// A controller of the user's own: a process that shares memory with this one and is asked once per tick
/// (skein_controller.h, docs/controllers.md). A library runs in a process too: this program, which loads it there.
/// Whatever the process does, `ask` returns by the deadline, and its answer is checked on a copy.
class OwnController {
 public:
  /// Starts it and waits, at most 20 s, until it is ready. `waits`: the clock is virtual and waits for slow answers.
  /// The error is a sentence.
  static tl::expected<std::unique_ptr<OwnController>, std::string> start(const Experiment& experiment, bool waits,
                                                                         const ControllerStart& how = {});
  ~OwnController();

  /// How long before a question `wake` is best called: longer than an idle processor takes to wake up. [s]
  static constexpr double wake_lead = 5e-4;
  /// Announces a question: the process wakes up and watches for it, for 3 ms at most, so that the tick does not wait
  /// for an idle processor. Optional. Nothing happens unless the process has declared that it knows announcements: any
  /// other process would answer the previous question again, while its answer is read. Control thread only; one system
  /// call, on its own pipe.
  void wake() noexcept;
  /// Asks, and waits for the answer at most until the deadline. After 25 late answers in a row it is killed. Control
  /// thread only: no allocation, no lock; its only system calls are on its own pipes.
  void ask(const core::ControllerInput& input) noexcept;
  /// Takes new parameter values from a tick's events, for the next question. Control thread only.
  void heed(std::span<const Event> events) noexcept;
  /// The answer to the last question: unchecked numbers, none if there is no answer.
  std::span<const core::Twist> law() const noexcept { return law_; }
  std::span<const double> logged() const noexcept { return logged_; }
  ControllerState state() const noexcept { return state_.load(std::memory_order_acquire); }

  /// Ends it, and waits until it has ended. It must not be asked any more.
  void close() noexcept;
  /// Why it ended, as a sentence. Not for the control thread; waits up to a second for the process to end.
  std::string why_it_ended();
  /// The parameters that it declared, with the file's values.
  const std::vector<LawParameter>& parameters() const noexcept { return declared_; }
  /// May be called between two questions, or after the last.
  const ControllerReport& report() const noexcept { return report_; }

 private:
  struct Memory;
  struct Pipes;
  OwnController(const Experiment& experiment, bool waits, bool for_preview);
  tl::expected<void, std::string> become_ready(const Experiment& experiment, const std::function<bool()>& keep_on);
  tl::expected<void, std::string> take_declarations(const Experiment& experiment);
  tl::expected<void, std::string> take_parameters(const Experiment& experiment);
  bool wait_for(std::uint64_t answer, double seconds) noexcept;
  void write_question(const core::ControllerInput& input) noexcept;
  void end() noexcept;

  std::unique_ptr<Memory> memory_;
  std::unique_ptr<Pipes> pipes_;
  std::unique_ptr<BoundedProcess> process_;
  std::vector<core::Twist> law_;
  std::vector<double> logged_;
  std::vector<std::size_t> log_places_;  // in the memory, of each name that the file wants
  std::vector<LawParameter> declared_;
  struct Value {
    ParameterName name;
    double now;
  };
  std::vector<Value> values_;  // of `declared_`, written with every question
  std::uint64_t question_ = 0;
  int late_in_a_row_ = 0;
  std::atomic<ControllerState> state_{ControllerState::answered};
  bool ended_by_us_ = false;
  bool may_be_woken_ = false;
  const double watch_;  // how long to watch for an answer before sleeping until it comes [s]
  ControllerReport report_;
};

/// The default deadline of a controller on the wall clock. [s]
inline double default_deadline(const Experiment& experiment) noexcept {
  return 0.25 * experiment.period();
}

/// The words of a command, split as by a shell, without command substitution. The error is a sentence.
tl::expected<std::vector<std::string>, std::string> words_of(const std::string& command);

}  // namespace skein::app
