#include "ui/run/runs.h"

#include <utility>

namespace skein::ui {

Runs::Runs(QObject* parent) : QObject(parent) {
  for (const RunSource* run : {static_cast<RunSource*>(&live_), static_cast<RunSource*>(&replay_)}) {
    connect(run, &RunSource::row_added, this, &Runs::row_added);
    connect(run, &RunSource::record_shown, this, &Runs::record_shown);
    connect(run, &RunSource::changed, this, &Runs::changed);
  }
}

void Runs::show_live() {
  waiting_ = nullptr;
  shown_ = &live_;
  replay_.load(nullptr);
  emit shown_changed();
}

void Runs::show_recording(ReplayRun::Recording recording) {
  waiting_ = std::move(recording);
  refresh();
}

void Runs::refresh() {
  if (!waiting_ || live_.is_busy()) return;
  if (live_.is_open()) {
    emit session_ends();
    live_.end();
    return;
  }
  replay_.load(std::exchange(waiting_, nullptr));
  shown_ = &replay_;
  emit shown_changed();
  replay_.begin();
  replay_.play();
}

}  // namespace skein::ui
