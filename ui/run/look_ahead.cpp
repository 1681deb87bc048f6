#include "ui/run/look_ahead.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace skein::ui {
namespace {

constexpr std::size_t most_waiting = 500;  // records: what more come are left out, and the forecast knows it
constexpr int niceness =
    19;  // of the thread, and of processes that it starts: whatever drives robots or draws goes first

}  // namespace

LookAhead::LookAhead(QObject* parent) : QObject(parent), thread_([this](const std::stop_token& stop) { work(stop); }) {}

LookAhead::~LookAhead() {
  cancel();
  thread_.request_stop();
}

void LookAhead::begin(const app::Experiment& experiment) {
  cancel();
  const std::lock_guard lock(mutex_);
  inbox_.clear();
  inbox_.emplace_back(experiment);
  something_new_.notify_one();
}

void LookAhead::follow(const app::TickRecord& record) {
  const std::lock_guard lock(mutex_);
  if (inbox_.size() < most_waiting) inbox_.emplace_back(record);
  something_new_.notify_one();
}

void LookAhead::ask(const app::OperatorCommand& command) {
  const std::lock_guard lock(mutex_);
  ++question_;
  expects_ = true;
  asked_ = command;
  something_new_.notify_one();
}

void LookAhead::cancel() {
  const std::lock_guard lock(mutex_);
  ++question_;
  asked_.reset();
  ended_ = expects_.exchange(false) || ended_;
  something_new_.notify_one();
}

void LookAhead::work(const std::stop_token& stop) {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), niceness);  // of this thread alone
  while (!stop.stop_requested()) {
    decltype(inbox_) records;
    std::optional<app::OperatorCommand> command;
    std::uint64_t question = 0;
    bool ended = false;
    {
      std::unique_lock lock(mutex_);
      something_new_.wait(lock, stop, [this] { return !inbox_.empty() || asked_ || ended_; });
      records.swap(inbox_);
      command.swap(asked_);
      question = question_;
      ended = std::exchange(ended_, false);
    }
    if (ended && forecast_) forecast_->rest();
    for (const auto& entry : records) {
      if (stop.stop_requested()) return;
      if (const auto* const experiment = std::get_if<app::Experiment>(&entry)) {
        forecast_.reset();
        rate_ = experiment->rate;
        if (!app::Forecast::impossible(*experiment)) forecast_ = std::make_unique<app::Forecast>(*experiment);
      } else if (forecast_) {
        forecast_->follow(std::get<app::TickRecord>(entry));
      }
    }
    if (!command || !forecast_) continue;
    // Not for this question alone: while a slider moves there are many, and a process takes longer to start.
    const auto expects = [&] { return !stop.stop_requested() && expects_; };
    forecast_->prepare(expects);
    answer(*command, question, stop);
    if (forecast_->failure().empty()) forecast_->prepare(expects);
  }
}

void LookAhead::answer(const app::OperatorCommand& command, std::uint64_t question, const std::stop_token& stop) {
  const auto wanted = [&] { return !stop.stop_requested() && question_ == question; };
  const auto ticks = std::min(most_ticks, static_cast<std::size_t>(std::ceil(seconds * rate_)));
  auto rows = std::make_shared<const std::vector<app::TickRecord>>(forecast_->ahead(ticks, {&command, 1}, wanted));
  if (!wanted()) return;
  QMetaObject::invokeMethod(
      this,
      [this, question, rows = Rows(std::move(rows)), exact = forecast_->exact(),
       failure = QString::fromStdString(forecast_->failure())] {
        if (question_ != question) return;
        if (failure.isEmpty())
          emit seen(rows, exact);
        else
          emit failed(failure);
      },
      Qt::QueuedConnection);
}

}  // namespace skein::ui
