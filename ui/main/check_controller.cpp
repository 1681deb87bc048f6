#include "ui/main/check_controller.h"

#include <algorithm>
#include <chrono>

#include "ui/gains/gains_panel.h"
#include "ui/status/check_list.h"

namespace skein::ui {

CheckController::CheckController(Runs& runs, const Messages& messages, CheckList* list, GainsPanel* gains,
                                 QObject* parent)
    : QObject(parent), runs_(runs), live_(runs.live()), messages_(messages), list_(list), gains_(gains) {
  connect(list_, &CheckList::start_anyway, this, [this] { start(true); });
}

void CheckController::begin() {
  certificate_.reset();
  gains_->show_delay_margin({});
  certifying_.run([experiment = live_.experiment()](const std::stop_token& stop) {
    return app::certify(experiment, stop);  // a long run of many robots takes longer than a frame
  });
}

const std::vector<app::Check>& CheckController::judge(std::chrono::milliseconds patience) {
  if (auto certificate = certifying_.take(patience)) certificate_ = std::move(certificate);
  show_delay();
  checks_ = app::readiness(live_.experiment(), certificate_ ? &*certificate_ : nullptr, live_.latest(), live_.robots(),
                           live_.camera());
  return checks_;
}

/// How much delay the loops bear, and how much there is: from a pose's capture to the moment the wheels obey.
void CheckController::show_delay() {
  if (!certificate_ || !certificate_->other_law.empty()) return;
  const core::DelayMargin& margin = certificate_->delay.margin;
  double measured = 0.0;
  if (const app::TickRecord* record = live_.latest())
    for (const app::RobotRecord& robot : record->robots)
      if (robot.pose_age <= old_pose)  // what is bridged is another matter
        measured = std::max(measured, robot.pose_age + robot.actuation_delay);
  const QString bears =
      (margin.unbounded ? tr("margin over %1 ms") : tr("margin %1 ms")).arg(1000 * margin.delay, 0, 'f', 0);
  QString text =
      live_.latest() ? tr("Delay %1 ms, %2").arg(1000 * measured, 0, 'f', 0).arg(bears) : tr("Delay %1").arg(bears);
  if (!margin.unbounded) text += tr(" (robot %1)").arg(certificate_->delay.robot + 1);
  gains_->show_delay_margin(text, !margin.unbounded && measured > margin.delay);
}

void CheckController::set_wanted(bool on) {
  wanted_ = on;
  refresh();
}

void CheckController::refresh() {
  const bool before_start = runs_.shown().is_before_start();
  if (before_start || wanted_ || !certificate_)
    judge();  // for the delay margin, also where nobody looks at the list
  else
    show_delay();
  const bool something_to_mend = std::any_of(
      checks_.begin(), checks_.end(), [](const app::Check& check) { return check.state == app::Check::State::fails; });
  list_->setVisible(wanted_ || (before_start && something_to_mend));
  if (list_->isVisible()) show_list();
}

/// The checks, and the tags that the camera does not see now.
void CheckController::show_list() {
  std::vector<app::UnseenTag> tags = live_.camera().why_lost, unseen;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const bool lost = live_.latest() && live_.latest()->robots[i].is(app::lost) && !tags[i].sentence.empty();
    if (lost)
      unseen.push_back(tags[i]);
    else
      tags[i] = {};
  }
  list_->show_checks(checks_, wanted_);
  list_->show_tags(tags, app::fitting_tag_size(live_.experiment().robots.size(), unseen));
}

/// What keeps the run from starting: first what nobody may overrule. Null: nothing does.
const app::Check* CheckController::first_amiss() const {
  for (const bool hard : {true, false})
    for (const app::Check& check : checks_)
      if (check.hard == hard && check.state != app::Check::State::holds) return &check;
  return nullptr;
}

QString CheckController::why_not() const {
  const app::Check* amiss = first_amiss();
  return amiss ? QString::fromStdString(amiss->reason) : QString();
}

Notice CheckController::banner() const {
  const app::Check* amiss = first_amiss();
  if (!amiss) return {tr("Ready – start with F5")};
  const QString reason = why_not();
  if (amiss->state == app::Check::State::waits) return {tr("Not ready yet: %1").arg(reason)};
  return {amiss->hard ? tr("Not ready: %1").arg(reason) : tr("Check failed: %1").arg(reason)};
}

void CheckController::start(bool overrule) {
  if (testing_) return messages_.say(tr("Not started: a robot is being tested"), Severity::warning);
  // It has had since the opening: often this is the last of it. The window must not hang for longer.
  constexpr std::chrono::seconds patience{1};
  const std::vector<app::Check>& checks = judge(patience);
  if (app::may_start(checks) && (overrule || app::all_hold(checks))) return messages_.tell(live_.start());
  show_list();
  list_->show();
  if (first_amiss()) messages_.say_beside_banner(tr("Not started: %1").arg(why_not()), Severity::warning);
}

}  // namespace skein::ui
