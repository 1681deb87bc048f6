#include "ui/main/preview_controller.h"

#include <cmath>

#include "ui/arena/arena_view.h"
#include "ui/base/sentence.h"
#include "ui/gains/gains_panel.h"
#include "ui/plots/plots_panel.h"

namespace skein::ui {
namespace {

constexpr qint64 asks_again_ms = 1000;  // while the slider is held: the run has gone on meanwhile
constexpr std::size_t poses_every = 5;  // rows: a fifth of a second at 25 Hz

}  // namespace

PreviewController::PreviewController(const Runs& runs, GainsPanel* gains, ArenaView* arena, PlotsPanel* plots,
                                     QObject* parent)
    : QObject(parent), runs_(runs), gains_(gains), arena_(arena), plots_(plots) {
  connect(&runs.live(), &LiveRun::opened, this, [this] {
    let_go();
    look_ahead_.begin(runs_.live().experiment());
  });
  connect(&runs.live(), &LiveRun::row_added, this, [this](const app::TickRecord& record) {
    look_ahead_.follow(record);
    if (record.phase == app::Phase::stopped || record.phase == app::Phase::finished) let_go();
  });
  connect(&runs, &Runs::shown_changed, this, &PreviewController::let_go);
  connect(gains, &GainsPanel::held, this, &PreviewController::hold);
  connect(gains, &GainsPanel::let_go, this, &PreviewController::let_go);
  connect(&look_ahead_, &LookAhead::seen, this, &PreviewController::show);
}

void PreviewController::hold(core::GainName gain, double value) {
  const LiveRun& live = runs_.live();
  if (&runs_.shown() != &live || !live.is_open() || live.stop_asked()) return;
  held_ = app::commands::SetGain{gain, value, gains_->ramp()};
  if (const auto why = app::Forecast::impossible(live.experiment()))
    hint_ = tr("No preview: %1").arg(QString::fromStdString(*why));
  ask();
}

void PreviewController::ask() {
  since_asked_.start();
  look_ahead_.ask(*held_);
}

void PreviewController::let_go() {
  if (!held_) return;
  held_.reset();
  look_ahead_.cancel();
  shown_.reset();
  hint_.clear();
  arena_->set_foreseen({});
  plots_->foresee({});
}

void PreviewController::show(const LookAhead::Rows& rows, bool exact) {
  if (!held_) return;
  shown_ = rows;
  const QString what = tr("Pale: the next %1 s with %2 %3")
                           .arg(LookAhead::seconds)
                           .arg(gain_symbol(held_->gain))
                           .arg(held_->value, 0, 'f', 4);
  hint_ = exact ? what : tr("%1, robots as the model has them").arg(what);
  plots_->foresee(*rows);
  refresh();
}

void PreviewController::refresh() {
  if (!held_) return;
  if (runs_.live().stop_asked()) return let_go();
  if (since_asked_.hasExpired(asks_again_ms)) ask();
  if (!shown_) return;
  std::vector<std::vector<core::Pose>> ways(shown_->front().robots.size());
  for (std::size_t k = 0; k < shown_->size(); ++k) {
    const app::TickRecord& row = (*shown_)[k];
    if (row.t < runs_.live().t() || (k % poses_every != 0 && k + 1 < shown_->size())) continue;
    for (std::size_t i = 0; i < ways.size(); ++i)
      if (const core::Pose& pose = row.robots[i].truth; std::isfinite(pose.x)) ways[i].push_back(pose);
  }
  arena_->set_foreseen(std::move(ways));
}

}  // namespace skein::ui
