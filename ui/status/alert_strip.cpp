#include "ui/status/alert_strip.h"

#include <QAccessible>
#include <QPainter>
#include <algorithm>
#include <cmath>
#include <utility>

#include "ui/base/sentence.h"

namespace skein::ui {
namespace {

constexpr qint64 fade_ms = 12000;
constexpr qint64 read_ms = 3000;  // so long a warning stays beside what is said after it, and news before a state
const QString between = QStringLiteral("   ·   ");

/// Shown elsewhere in the window: by the run bar, the sliders, the states of the strip.
bool said_elsewhere(const app::Event& event) {
  using namespace app::events;
  return app::is<Start, Pause, Resume, Stop, Gain, Schedule, ScheduleTracking, PairGain, Lost, Found, Avoid, Clear,
                 app::events::Stage, Staged, Deadlock, VRise, NoWay>(event);
}

}  // namespace

AlertStrip::AlertStrip(QWidget* parent) : QLabel(parent) {
  setObjectName(QStringLiteral("alert"));
  setTextFormat(Qt::PlainText);
  setContentsMargins(8, 2, 8, 2);
  setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  clear_alert();
  show_text();  // also where nothing has been said yet
}

void AlertStrip::show_record(const app::TickRecord& record, const std::vector<app::RobotStatus>& robots) {
  const std::map<int, QString> before = lost_;
  for (const app::Event& event : record.events) {
    if (const auto* const lost = std::get_if<app::events::Lost>(&event))
      lost_.try_emplace(static_cast<int>(lost->robot) + 1);
    if (const auto* const unseen = std::get_if<app::events::NotSeen>(&event))
      if (const auto robot = lost_.find(static_cast<int>(unseen->robot) + 1); robot != lost_.end())
        robot->second = reason_text(unseen->why);
    if (const auto* const found = std::get_if<app::events::Found>(&event))
      lost_.erase(static_cast<int>(found->robot) + 1);
    if (app::is<app::events::VRise>(event)) v_rose_at_ = record.t;
    if (const auto* const no_way = std::get_if<app::events::NoWay>(&event))
      no_way_.insert_or_assign(static_cast<int>(no_way->robot) + 1, NoWay{sentence(event), record.t, record.t});
    if (!held_ && !said_elsewhere(event))
      say(tr("%1 s: ").arg(record.t, 0, 'f', 1) + sentence(event, robots), ui::severity(event));
  }
  watch(record);
  if (lost_ == before) return;
  if (lost_.empty()) {
    stand(State::lost, {}, Severity::note);
    if (!held_) say(tr("All robots are seen"), Severity::good);
  } else if (record.phase == app::Phase::ready) {
    stand(State::lost, tr("No tag seen of robot %1").arg(lost_robots()), Severity::warning, Also::in_banner);
  } else {
    QStringList who;  // with the reason, where it is known
    for (const auto& [robot, why] : lost_)
      who << (why.isEmpty() ? QString::number(robot) : QStringLiteral("%1 (%2)").arg(robot).arg(why));
    stand(State::lost, tr("LOST: robot %1 – no tag seen, it stands").arg(who.join(QStringLiteral(", "))),
          Severity::alarm);
  }
}

/// What is said as long as it lasts. Limits that bite for less than a second are the everyday of a push.
void AlertStrip::watch(const app::TickRecord& record) {
  constexpr double lasts = 1.0, v_rise_is_old = 5.0;  // [s]
  const bool running = record.phase == app::Phase::running;
  limited_since_.resize(record.robots.size(), app::none);
  QStringList limited, out;
  for (std::size_t i = 0; i < record.robots.size(); ++i) {
    const app::RobotRecord& robot = record.robots[i];
    double& since = limited_since_[i];
    if (!running || !robot.is(app::limited))
      since = app::none;
    else if (std::isnan(since))
      since = record.t;
    if (record.t - since >= lasts) limited << QString::number(i + 1);  // of NaN: no
    const bool over = record.phase == app::Phase::stopped || record.phase == app::Phase::finished;
    if (!over && robot.link.state && *robot.link.state != app::LinkState::up)
      out << tr("%1 (%2)").arg(i + 1).arg(QLatin1String(app::word(*robot.link.state).data()));
  }
  watch_ways(record);
  const auto join = [](const QStringList& robots) { return robots.join(QStringLiteral(", ")); };
  stand(State::limited,
        limited.isEmpty()
            ? QString()
            : tr("LIMITED: the law commands robot %1 more than (14) or its wheels allow; it drives at its limits")
                  .arg(join(limited)),
        Severity::warning);
  stand(State::link,
        out.isEmpty() ? QString() : tr("LINK DOWN: robot %1 – it is told to stop until it answers").arg(join(out)),
        Severity::alarm);
  if (!running || record.t < v_rose_at_ || record.t - v_rose_at_ > v_rise_is_old) v_rose_at_ = app::none;
  stand(State::v_rises,
        std::isnan(v_rose_at_) ? QString()
                               : tr("V RISES more than known causes explain: a robot does not execute its commands. "
                                    "The run goes on: look for the robot that leaves its place, and STOP if in doubt"),
        Severity::warning);
}

/// Until the robot drives: a route may have been found, or the shield alone may let it pass.
void AlertStrip::watch_ways(const app::TickRecord& record) {
  constexpr double drives = 0.01;             // [m/s]
  constexpr double lasts = 0.5;               // [s]
  constexpr double to_read = 1e-3 * read_ms;  // [s]
  const bool may_drive = record.phase == app::Phase::running || record.phase == app::Phase::staging ||
                         record.phase == app::Phase::paused;  // it still has no route after the pause
  const auto is_over = [&](int robot, NoWay& way) {
    const auto i = static_cast<std::size_t>(robot) - 1;
    if (!may_drive || i >= record.robots.size() || record.t < way.said_at) return true;
    if (std::abs(record.robots[i].command.v) < drives) way.stood_at = record.t;
    return record.t - way.stood_at > lasts && record.t - way.said_at > to_read;
  };
  for (auto way = no_way_.begin(); way != no_way_.end();)
    way = is_over(way->first, way->second) ? no_way_.erase(way) : std::next(way);
  QStringList robots;
  for (const auto& [robot, way] : no_way_) robots << QString::number(robot);
  stand(State::no_way,
        no_way_.empty()       ? QString()
        : no_way_.size() == 1 ? no_way_.begin()->second.sentence
                              : tr("Robots %1 stand: no route leads to their places (Events says why)")
                                    .arg(robots.join(QStringLiteral(", "))),
        Severity::warning);
}

QString AlertStrip::lost_robots() const {
  QStringList numbers;
  for (const auto& [robot, why] : lost_) numbers << QString::number(robot);
  return numbers.join(QStringLiteral(", "));
}

void AlertStrip::warn_batteries(const QStringList& robots) {
  const QString text = robots.isEmpty()
                           ? QString()
                           : tr("BATTERY LOW: robot %1 – change or charge it").arg(robots.join(QStringLiteral(", ")));
  stand(State::battery, text, Severity::warning);
}

void AlertStrip::stand(State state, const QString& text, Severity severity, Also also) {
  const auto known = states_.find(state);
  if (known == states_.end() ? text.isEmpty() : known->second.text == text) return;
  if (text.isEmpty())
    states_.erase(state);
  else
    states_[state] = {text, severity, also};
  const bool must_be_heard = severity == Severity::alarm || state == State::battery;
  if (must_be_heard && !text.isEmpty() && !held_) emit alarmed(text);
  if (!text.isEmpty() && news().severity < severity) since_.invalidate();  // "all are seen" is no longer so
  choose();
}

void AlertStrip::say(const QString& text, Severity severity, Also also) {
  news_ = {text, severity, also};
  since_.start();
  const bool grave_is_read = !grave_since_.isValid() || grave_since_.elapsed() >= read_ms;
  if (severity >= Severity::warning && (grave_is_read || severity >= grave_.severity)) {
    grave_ = news_;
    grave_since_.start();
  }
  if (severity == Severity::alarm && !held_) emit alarmed(text);
  choose();
}

void AlertStrip::hold(const QString& text, Severity severity) {
  if (held_ && text == held_->text) return;
  held_ = {text, severity};
  choose();
  if (severity == Severity::alarm) emit alarmed(text);
}

void AlertStrip::clear_alert() {
  held_.reset();
  lost_.clear();
  no_way_.clear();
  limited_since_.clear();
  v_rose_at_ = app::none;
  states_.clear();
  since_.invalidate();
  grave_since_.invalidate();
  choose();
}

/// An alarm is read first. Otherwise the newest is: it may answer the operator, and a narrow strip cuts off the end.
AlertStrip::Said AlertStrip::news() const {
  const bool grave_is_fresh = grave_since_.isValid() && grave_since_.elapsed() < read_ms;
  if (!grave_is_fresh || news_.severity >= grave_.severity) return news_;
  if (grave_.severity == Severity::alarm) return {grave_.text + between + news_.text, grave_.severity, grave_.also};
  return {news_.text + between + grave_.text, grave_.severity, grave_.also};
}

/// News are read for a moment, behind an alarm that lasts; then what is held, or the states, the gravest first, are
/// back.
void AlertStrip::choose() {
  if (held_) return choose_beside_held();
  Said shown;
  bool all_in_banner = true;
  for (const Severity grave : {Severity::alarm, Severity::warning})
    for (const auto& [state, said] : states_) {
      if (said.severity != grave) continue;
      shown.text += (shown.text.isEmpty() ? QString() : between) + said.text;
      shown.severity = std::max(shown.severity, grave);
      all_in_banner = all_in_banner && said.also == Also::in_banner;
    }
  if (all_in_banner && !shown.text.isEmpty()) shown.also = Also::in_banner;
  const qint64 age = since_.isValid() ? since_.elapsed() : fade_ms + 1;
  const bool fresh = age <= (shown.text.isEmpty() ? fade_ms : read_ms);
  const Said news = this->news();
  const bool outranked = shown.severity == Severity::alarm && news.severity < Severity::alarm;
  if (fresh && !outranked) shown = news;
  show(shown);
}

void AlertStrip::choose_beside_held() {
  const bool fresh = since_.isValid() && since_.elapsed() <= read_ms;
  if (!fresh) return show(*held_);
  show(held_->severity < Severity::alarm ? news() : Said{held_->text + between + news().text, held_->severity});
}

void AlertStrip::show(const Said& shown) {
  if (shown == shown_) return;
  shown_ = shown;
  show_text();
}

void AlertStrip::rest_on(const QString& text) {
  if (std::exchange(at_rest_, text) != text) show_text();
}

void AlertStrip::refresh() {
  choose();
}

void AlertStrip::show_text() {
  const QString text = shown_.text.isEmpty() ? at_rest_ : shown_.text;
  setText(text);
  setToolTip(text);
  setAccessibleName(tr("Latest alert: %1").arg(text));  // it would be read instead of the text
  if (shown_.severity >= Severity::warning) {
    QAccessibleEvent alert(this, QAccessible::Alert);
    QAccessible::updateAccessibility(&alert);
  }
  update();
}

QString AlertStrip::loud_beside_banner() const {
  switch (shown_.also) {
    case Also::nowhere:
      return loud();
    case Also::in_banner:
      break;
  }
  return {};
}

// Drawn by hand: a palette of its own would not follow when the program changes from light to dark.
void AlertStrip::paintEvent(QPaintEvent*) {
  QPainter p(this);
  const Colours c = colours(palette());
  const bool alarm = shown_.severity == Severity::alarm, loud = alarm || shown_.severity == Severity::warning;
  const QColor background = alarm ? c.alarm_fill : colour(shown_.severity, c);
  if (loud) p.fillRect(rect(), background);
  p.setPen(loud ? ink_on(background) : shown_.text.isEmpty() ? c.faint_text : background);
  const QRect room = rect().adjusted(8, 0, -8, 0);
  p.drawText(room, Qt::AlignVCenter, fontMetrics().elidedText(text(), Qt::ElideRight, room.width()));
}

}  // namespace skein::ui
