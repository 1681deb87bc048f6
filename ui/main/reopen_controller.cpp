#include "ui/main/reopen_controller.h"

#include "app/experiment/experiment_file.h"

namespace skein::ui {

ReopenController::ReopenController(const LiveRun& live, const Messages& messages, QObject* parent)
    : QObject(parent), live_(live), messages_(messages) {}

bool ReopenController::can_change() const {
  return live_.is_open() && live_.phase() == app::Phase::ready;
}

void ReopenController::reopen_with(const QString& set) {
  if (!can_change()) return;
  const app::Experiment& now = live_.experiment();
  from_ = now.source;
  preparing_.run([source = now.source, name = now.name, directory = now.directory,
                  set = set.toStdString()](const std::stop_token&) {
    auto changed = app::parse_experiment(source, name, {set});
    if (changed) changed->directory = directory;
    return changed;
  });
  constexpr std::chrono::milliseconds unnoticed{100};
  take(unnoticed);
}

void ReopenController::take(std::chrono::milliseconds patience) {
  const auto changed = preparing_.take(patience);
  if (!changed) return;
  if (!can_change() || live_.experiment().source != from_)
    return messages_.say(tr("The change came too late: the run is no longer ready to start"), Severity::notice);
  if (*changed) return emit experiment_wanted(**changed);
  messages_.problem(tr("This cannot run"), QString::fromStdString(changed->error().front().message()));
  emit refused();
}

}  // namespace skein::ui
