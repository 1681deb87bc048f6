#include "ui/alert_strip.h"

#include <QPainter>
#include <cmath>

namespace skein::ui {
namespace {

constexpr qint64 fade_ms = 12000;

/// The events that the strip shows, in words for people; the log has all of them in those of the CSV.
QString words(const app::Event& event, double t) {
  using Kind = app::Event::Kind;
  const QString when = AlertStrip::tr("%1 s: ").arg(t, 0, 'f', 1);
  const QString robot = QString::number(event.robot + 1);
  switch (event.kind) {
    case Kind::deadline_missed:
      return when +
             AlertStrip::tr("%n tick(s) too late: the machine was busy", nullptr, static_cast<int>(event.values[0]));
    case Kind::gain_held:
      return when + AlertStrip::tr("%1 is held at %2, its border: (18) allows no more")
                        .arg(QLatin1String(app::name(event.gain)))
                        .arg(event.values[1], 0, 'g', 4);
    case Kind::v_rise:
      return when +
             AlertStrip::tr("V has risen, and nothing that is known explains it: a robot does not do as it is told");
    case Kind::link:
      return when + QString::fromStdString(app::describe(event));
    case Kind::perturb:
      return when + AlertStrip::tr("Robot %1 was moved by the experiment").arg(robot);
    case Kind::move:
      return when + AlertStrip::tr("Robot %1 was moved by hand").arg(robot);
    case Kind::kidnap:
      return when + AlertStrip::tr("Robot %1 is not where its wheels took it: it was carried or pushed").arg(robot);
    case Kind::hold:
      return when + AlertStrip::tr("Robot %1 is held: it stands, the others drive on").arg(robot);
    case Kind::release:
      return when + AlertStrip::tr("Robot %1 drives again").arg(robot);
    case Kind::kick:
      return when + AlertStrip::tr("Robot %1 was kicked, %2 m/s")
                        .arg(robot)
                        .arg(std::hypot(event.values[0], event.values[1]), 0, 'f', 2);
    case Kind::obstacle:
      return when + (event.values[2] > 0.0 ? AlertStrip::tr("Obstacle %1 stands at x %2 m, y %3 m")
                                                 .arg(robot)
                                                 .arg(event.values[0], 0, 'f', 2)
                                                 .arg(event.values[1], 0, 'f', 2)
                                           : AlertStrip::tr("Obstacle %1 was taken away").arg(robot));
    default:
      return {};
  }
}

}  // namespace

AlertStrip::AlertStrip(QWidget* parent) : QLabel(parent) {
  setObjectName(QStringLiteral("alert"));
  setAccessibleName(tr("Latest alert"));
  setTextFormat(Qt::PlainText);
  setContentsMargins(8, 2, 8, 2);
  setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  clear_alert();
}

void AlertStrip::take(const app::TickRecord& record) {
  const std::set<int> before = lost_;
  for (const app::Event& event : record.events) {
    if (event.kind == app::Event::Kind::lost) lost_.insert(event.robot + 1);
    if (event.kind == app::Event::Kind::found) lost_.erase(event.robot + 1);
    const QString text = words(event, record.t);
    if (!text.isEmpty()) say(text, severity(event));
  }
  watch(record);
  if (held_ || lost_ == before) return;
  since_.invalidate();
  if (lost_.empty())
    say(tr("All robots are seen"), Severity::good);
  else if (record.phase == app::Phase::ready)
    say(tr("No tag seen of robot %1").arg(lost_robots()), Severity::warning);
  else
    say(tr("LOST: robot %1 – no tag seen, it stands").arg(lost_robots()), Severity::alarm);
}

/// Limits that bite and a V that rises are said when they last, and unsaid when they are over.
void AlertStrip::watch(const app::TickRecord& record) {
  constexpr double lasts = 1.0;  // [s]: shorter ones are the everyday of a push
  const bool running = record.phase == app::Phase::running;
  const auto since = [&](double& begin, bool holds) {
    if (!holds || !running)
      begin = app::none;
    else if (std::isnan(begin))
      begin = record.t;
    return record.t - begin >= lasts;  // of NaN: no
  };
  limited_since_.resize(record.robots.size(), app::none);
  QStringList limited;
  for (std::size_t i = 0; i < record.robots.size(); ++i)
    if (since(limited_since_[i], record.robots[i].is(app::limited))) limited << QString::number(i + 1);
  const bool rises = since(rising_since_, record.V > last_V_);
  last_V_ = record.V;

  const QString before = condition_;
  condition_ = !limited.isEmpty() ? tr("Limits bite: robot %1 is asked for more than (14) or its wheels allow")
                                        .arg(limited.join(QStringLiteral(", ")))
               : rises ? tr("V rises: limits, shield or avoidance keep robots from what the law asks")
                       : QString();
  if (condition_ == before || held_ || !lost_.empty()) return;
  if (!condition_.isEmpty())
    say(condition_, Severity::warning);
  else if (text_ == before)
    clear_text();
}

QString AlertStrip::lost_robots() const {
  QStringList numbers;
  for (const int robot : lost_) numbers << QString::number(robot);
  return numbers.join(QStringLiteral(", "));
}

void AlertStrip::say(const QString& text, Severity severity) {
  const bool graver_one_is_fresh = since_.isValid() && since_.elapsed() < 3000 && severity_ > severity;
  if (held_ || graver_one_is_fresh || (!lost_.empty() && severity_ > severity)) return;
  text_ = text;
  severity_ = severity;
  since_.start();
  show_text();
}

void AlertStrip::hold(const QString& text, Severity severity) {
  if (held_ && text == text_) return;
  held_ = true;
  text_ = text;
  severity_ = severity;
  show_text();
}

void AlertStrip::clear_alert() {
  held_ = false;
  lost_.clear();
  limited_since_.clear();
  rising_since_ = last_V_ = app::none;
  condition_.clear();
  clear_text();
}

void AlertStrip::clear_text() {
  text_.clear();
  severity_ = Severity::note;
  since_.invalidate();
  show_text();
}

void AlertStrip::refresh() {
  const bool lasts = held_ || !lost_.empty() || (!condition_.isEmpty() && text_ == condition_);
  if (!lasts && since_.isValid() && since_.elapsed() > fade_ms) clear_text();
}

void AlertStrip::show_text() {
  const QString text = text_.isEmpty() ? tr("All well") : text_;
  setText(text);
  setToolTip(text);
  update();
}

// Drawn by hand: a palette of its own would not follow when the program changes from light to dark.
void AlertStrip::paintEvent(QPaintEvent*) {
  QPainter p(this);
  const Colours c = colours(palette());
  const bool loud = severity_ == Severity::alarm || severity_ == Severity::warning;
  const QColor background = severity_ == Severity::alarm ? c.alarm_fill : colour(severity_, c);
  if (loud) p.fillRect(rect(), background);
  p.setPen(loud ? ink_on(background) : text_.isEmpty() ? c.faint_text : background);
  const QRect room = rect().adjusted(8, 0, -8, 0);
  p.drawText(room, Qt::AlignVCenter, fontMetrics().elidedText(text(), Qt::ElideRight, room.width()));
}

}  // namespace skein::ui
