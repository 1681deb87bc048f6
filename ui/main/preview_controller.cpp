#include "ui/main/preview_controller.h"

#include <algorithm>
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
    const app::Experiment& experiment = runs_.live().experiment();
    look_ahead_.begin(experiment);
    gains_->set_no_preview(QString::fromStdString(app::Forecast::impossible(experiment).value_or(std::string())));
  });
  connect(&runs.live(), &LiveRun::row_added, this, [this](const app::TickRecord& record) {
    look_ahead_.follow(record);
    if (record.phase == app::Phase::stopped || record.phase == app::Phase::finished) let_go();
  });
  connect(&runs, &Runs::shown_changed, this, &PreviewController::let_go);
  connect(gains, &GainsPanel::held, this, &PreviewController::hold_gain);
  connect(gains, &GainsPanel::parameter_held, this, &PreviewController::hold_parameter);
  connect(gains, &GainsPanel::let_go, this, &PreviewController::let_go);
  connect(&look_ahead_, &LookAhead::seen, this, &PreviewController::show);
  connect(&look_ahead_, &LookAhead::failed, this, &PreviewController::fail);
}

void PreviewController::hold_gain(core::GainName gain, double wanted) {
  const double value = std::min(wanted, runs_.live().gain_limit(gain));  // where the run would hold it
  hold(app::commands::SetGain{gain, value, gains_->ramp()},
       QStringLiteral("%1 %2").arg(gain_symbol(gain)).arg(value, 0, 'f', 4));
}

void PreviewController::hold_parameter(const QString& name, double value) {
  const std::string word = name.toStdString();
  const std::vector<app::LawParameter>& all = runs_.live().parameters();
  const auto now = std::find_if(all.begin(), all.end(), [&](const app::LawParameter& p) { return p.name == word; });
  if (now == all.end()) return;
  hold(app::commands::SetParameter{app::ParameterName(word), now->value, value},
       QStringLiteral("%1 %2").arg(name).arg(value, 0, 'g', 4));
}

void PreviewController::hold(const app::OperatorCommand& wish, const QString& what) {
  const LiveRun& live = runs_.live();
  if (&runs_.shown() != &live || !live.is_open() || live.stop_asked()) return;
  held_ = wish;
  what_ = what;
  if (const auto why = app::Forecast::impossible(live.experiment()))
    hint_ = tr("No preview: %1").arg(QString::fromStdString(*why));
  // A second process of a controller cannot take back what it was asked: it is let finish, or it would be started anew
  // for every value of a moving slider.
  newer_ = waits_ && live.experiment().controller.law.own();
  if (!newer_) ask();
}

void PreviewController::ask() {
  since_asked_.start();
  asked_what_ = what_;
  waits_ = true;
  newer_ = false;
  look_ahead_.ask(*held_);
}

void PreviewController::let_go() {
  if (!held_) return;
  held_.reset();
  look_ahead_.cancel();
  waits_ = newer_ = false;
  shown_.reset();
  hint_.clear();
  arena_->set_foreseen({});
  plots_->foresee({});
}

void PreviewController::show(const LookAhead::Rows& rows, bool exact) {
  waits_ = false;
  if (!held_ || rows->empty()) return;
  shown_ = rows;
  hint_ = tr("Pale: the next %1 s with %2").arg(LookAhead::seconds).arg(asked_what_);
  if (!exact) hint_ = tr("%1, robots as the model has them").arg(hint_);
  if (runs_.live().experiment().controller.law.own())
    hint_ = tr("%1, by a second process of the controller, without the memory of the first").arg(hint_);
  plots_->foresee(*rows);
  refresh();
}

/// Nothing more is asked until something else is held, or another value.
void PreviewController::fail(const QString& why) {
  waits_ = false;
  since_asked_.invalidate();
  if (!held_) return;
  shown_.reset();
  arena_->set_foreseen({});
  plots_->foresee({});
  hint_ = tr("No preview: %1").arg(why);
}

void PreviewController::refresh() {
  if (!held_) return;
  if (runs_.live().stop_asked()) return let_go();
  const bool aged = since_asked_.isValid() && since_asked_.hasExpired(asks_again_ms);
  if (!waits_ && (newer_ || aged)) ask();
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
