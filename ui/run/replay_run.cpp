#include "ui/run/replay_run.h"

#include <algorithm>

#include "app/session/readiness.h"
#include "ui/run/run_name.h"

namespace skein::ui {
namespace {

constexpr int replay_frame_ms = 33;

std::size_t rows_until(const app::RecordedRun& run, double t) {
  const auto after = std::partition_point(run.rows.begin(), run.rows.end(),
                                          [&](const app::TickRecord& row) { return row.t <= t + 1e-9; });
  return static_cast<std::size_t>(after - run.rows.begin());
}

}  // namespace

ReplayRun::ReplayRun(QObject* parent) : RunSource(parent) {
  timer_.setTimerType(Qt::PreciseTimer);
  connect(&timer_, &QTimer::timeout, this, &ReplayRun::advance);
}

void ReplayRun::load(Recording run) {
  pause();
  run_ = std::move(run);
  next_ = 0;
  uncoupled_.clear();
  links_.clear();
  t_ = run_ ? first_time() : 0.0;
  if (!run_) return;
  circumstances_ = Circumstances(experiment());
  parameters_ = app::declared_parameters(experiment().controller.law);
  demand_ = app::make_reference(experiment())->demand(experiment().controller.k_y);
  links_.resize(experiment().robots.size());
  take_links();
}

/// What the present row says of the robots' links.
void ReplayRun::take_links() {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const app::LinkRecord& recorded = row().robots[i].link;
    app::RobotStatus& link = links_[i];
    link.link = recorded.state.value_or(app::LinkState::recorded);
    link.round_trip = recorded.round_trip;
    link.battery = recorded.battery;
    link.battery_low = app::is_low(experiment().robots[i], recorded.battery);
    link.stop_acknowledged = true;
  }
}

void ReplayRun::begin() {
  for (const app::TickRecord& added : run_->rows) emit row_added(added);
  seek(first_time());
}

QString ReplayRun::title() const {
  return tr("%1 (replay)").arg(run_name(QString::fromStdString(run_->file)));
}

QStringList ReplayRun::verdict() const {
  const app::ReplayResult& check = run_->check;
  QStringList found;
  if (check.different == 0)
    found << tr("%1 commands are the same, bit for bit").arg(check.commands);
  else
    found << tr("%1 of %2 commands differ, first: %3")
                 .arg(check.different)
                 .arg(check.commands)
                 .arg(QString::fromStdString(check.first));
  for (const std::string& warning : check.warnings) found << QString::fromStdString(warning);
  return found;
}

RunState ReplayRun::state() const {
  RunState state;
  state.words = playing_ ? tr("Replay") : tr("Replay, paused");
  state.tone = Severity::notice;
  state.moves = playing_;
  state.t = t_;
  state.end = last_time();
  state.speed = speed_;
  state.go = playing_ ? RunState::Go::pause : RunState::Go::play;
  state.may_go = true;
  state.step = {!playing_, playing_ ? tr("One tick on (F6): pause first") : tr("One tick on, and pause (F6)")};
  state.change_speed = {true, tr("How much faster than real time it goes (Ctrl+Up, Ctrl+Down)")};
  state.new_run_text = tr("Leave replay");
  state.new_run = {true, tr("Back to the experiment, live (Ctrl+N)")};
  state.record = {false, tr("A replay is already recorded")};
  return state;
}

Notice ReplayRun::banner() const {
  const bool paused = row().phase == app::Phase::paused;
  return {paused ? tr("Replay – it was paused here") : tr("Replay")};
}

Notice ReplayRun::lasting_alert() const {
  return {verdict().join(QStringLiteral("; ")), came_out_the_same() ? Severity::good : Severity::warning};
}

std::vector<Notice> ReplayRun::findings() const {
  std::vector<Notice> found;
  for (const QString& line : verdict())
    found.push_back({line, came_out_the_same() ? Severity::good : Severity::warning});
  return found;
}

QString ReplayRun::why_fixed() const {
  return tr("A replay: nothing here can be changed. Back to the live experiment: Ctrl+N");
}

RunSource::Done ReplayRun::refusal() const {
  return tl::unexpected(why_fixed().toStdString());
}

RunHistory::Rows ReplayRun::rows() const {
  RunHistory::Rows rows;
  rows.reserve(run_->rows.size());
  for (const app::TickRecord& kept : run_->rows) rows.emplace_back(run_, &kept);
  return rows;
}

core::CouplingGains ReplayRun::gains_now() const {
  return {row().pair_gains[0], row().pair_gains[1], row().pair_gains[2]};
}

double ReplayRun::gain(core::GainName name, std::size_t i, std::size_t j) const {
  return row().pair_gain(name, i, j);
}

bool ReplayRun::coupled(std::size_t i, std::size_t j) const {
  return !uncoupled_.contains({std::min(i, j), std::max(i, j)});
}

double ReplayRun::gain_limit(core::GainName name) const {
  return core::gain_limit(name, app::make_gains(experiment()), gains_now(), demand_);
}

double ReplayRun::gain_limit(core::GainName name, std::size_t i, std::size_t j) const {
  return core::gain_limit(name, i, j, app::make_gains(experiment()), gains_now(), demand_);
}

RunSource::Done ReplayRun::go() {
  playing_ ? pause() : play();
  emit changed();
  return {};
}

void ReplayRun::play() {
  if (!run_) return;
  if (t_ >= last_time()) seek(first_time());
  playing_ = true;
  since_.start();
  timer_.start(replay_frame_ms);
}

void ReplayRun::pause() {
  playing_ = false;
  timer_.stop();
}

RunSource::Done ReplayRun::set_speed(double speed) {
  speed_ = speed;
  emit changed();
  return {};
}

void ReplayRun::advance() {
  t_ = std::min(last_time(), t_ + speed_ * 1e-3 * static_cast<double>(since_.restart()));
  show_until(rows_until(*run_, t_));
  if (t_ >= last_time()) pause();
  emit changed();
}

void ReplayRun::note_changes(const app::TickRecord& of) {
  circumstances_.note(of);
  note_parameters(of, parameters_);
  for (const app::Event& event : of.events) {
    if (const auto* const off = std::get_if<app::events::Uncouple>(&event))
      uncoupled_.insert({std::min(off->i, off->j), std::max(off->i, off->j)});
    if (const auto* const on = std::get_if<app::events::Couple>(&event))
      uncoupled_.erase({std::min(on->i, on->j), std::max(on->i, on->j)});
  }
}

void ReplayRun::show_until(std::size_t end) {
  for (; next_ < end; ++next_) {
    note_changes(run_->rows[next_]);
    emit record_shown(run_->rows[next_]);
  }
  take_links();
}

RunSource::Done ReplayRun::step() {
  pause();
  const auto last = static_cast<std::ptrdiff_t>(run_->rows.size()) - 1;
  const auto next_row = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(next_), 0, last);
  seek(run_->rows[static_cast<std::size_t>(next_row)].t);
  return {};
}

bool ReplayRun::seek(double t) {
  if (!run_) return false;
  t_ = std::clamp(t, first_time(), last_time());
  const std::size_t end = std::max<std::size_t>(1, rows_until(*run_, t_));
  next_ = std::min(end - 1, rows_until(*run_, t_ - memory));
  uncoupled_.clear();
  circumstances_ = Circumstances(experiment());
  parameters_ = app::declared_parameters(experiment().controller.law);
  for (std::size_t k = 0; k < next_; ++k) note_changes(run_->rows[k]);
  emit jumped(circumstances_);
  show_until(end);
  emit changed();
  return true;
}

}  // namespace skein::ui
