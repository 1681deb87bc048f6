#pragma once

#include <QObject>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

#include "app/session/forecast.h"

namespace skein::ui {

/// Computes the next seconds of a run on a thread of its own, for which nothing waits: a new question ends the previous
/// one at its next tick, and so does the end of the window. All calls from the window's thread.
class LookAhead final : public QObject {
  Q_OBJECT

 public:
  using Rows = std::shared_ptr<const std::vector<app::TickRecord>>;
  static constexpr double seconds = 10.0;  ///< the time that it looks ahead, in at most so many ticks:
  static constexpr std::size_t most_ticks = 1000;

  explicit LookAhead(QObject* parent = nullptr);
  ~LookAhead() override;

  void begin(const app::Experiment& experiment);  ///< a session of it; its records follow
  void follow(const app::TickRecord& record);     ///< every one, in order
  /// With this command now, and no other actions afterwards; `seen` or `failed` follows, unless another question comes
  /// first.
  void ask(const app::OperatorCommand& command);
  void cancel();  ///< and no question is expected soon: a second process of the user's controller is ended

 signals:
  /// `exact`: see app::Forecast::exact. No rows: nothing will be driven.
  void seen(const skein::ui::LookAhead::Rows& rows, bool exact);
  /// The second process of the user's controller failed: why, as a sentence.
  void failed(const QString& why);

 private:
  void work(const std::stop_token& stop);
  void answer(const app::OperatorCommand& command, std::uint64_t question, const std::stop_token& stop);

  std::mutex mutex_;  // of these four
  std::condition_variable_any something_new_;
  std::deque<std::variant<app::Experiment, app::TickRecord>> inbox_;
  std::optional<app::OperatorCommand> asked_;
  bool ended_ = false;                      // the questions, for now
  std::atomic<bool> expects_{false};        // more of them
  std::atomic<std::uint64_t> question_{0};  // the newest; earlier ones are not answered any more

  std::unique_ptr<app::Forecast> forecast_;  // the thread's; null: there is none of this experiment
  double rate_ = 25.0;                       // the thread's
  std::jthread thread_;                      // last: it uses all the others
};

}  // namespace skein::ui
