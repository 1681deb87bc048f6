#include "ui/status/alert_strip.h"

#include <QPainter>
#include <algorithm>
#include <cmath>

namespace skein::ui {
namespace {

constexpr qint64 fade_ms = 12000;
constexpr qint64 read_ms =
    3000;  // so long a warning stays before lesser news may take its place, or a state comes back

QString reason(core::NotSeen why) {
  switch (why) {
    case core::NotSeen::not_found:
      return AlertStrip::tr("its tag is nowhere in the picture");
    case core::NotSeen::wrong_size:
      return AlertStrip::tr("its tag has another size than the calibration says");
    case core::NotSeen::lifted:
      return AlertStrip::tr("it is held up, its tag is nearer to the camera than the others");
    case core::NotSeen::tilted:
      return AlertStrip::tr("its tag does not lie flat");
    case core::NotSeen::doubled:
      return AlertStrip::tr("its tag is there twice");
    case core::NotSeen::covered:
      return AlertStrip::tr("part of its tag is covered or blurred");
    case core::NotSeen::at_border:
      return AlertStrip::tr("the border of the picture cuts its tag");
    case core::NotSeen::too_small:
      return AlertStrip::tr("its tag has too few pixels");
    case core::NotSeen::too_bright:
      return AlertStrip::tr("the picture is too bright");
    case core::NotSeen::in_shadow:
      return AlertStrip::tr("its tag lies in shadow");
    case core::NotSeen::mirrored:
      return AlertStrip::tr("the camera mirrors the picture");
    case core::NotSeen::other_family:
      return AlertStrip::tr("a tag with its number, but of a family other than 36h11, is in the picture");
  }
  return {};
}

/// The events that the strip shows, in words for people; the log has all of them in those of the CSV.
QString sentence(const app::Event& event, double t) {
  using namespace app::events;
  using app::one_of;
  const auto tr = [](const char* text, int n = -1) { return AlertStrip::tr(text, nullptr, n); };
  const QString said = std::visit(
      app::Overloaded{
          [&](const DeadlineMissed& e) {
            return tr(
                "%n tick(s) too late: the machine was busy; they were skipped, and the robots drove on with their "
                "last commands",
                e.ticks);
          },
          [&](const GainHeld& e) {
            return tr("%1 is held at %2, its limit: (18) allows no more")
                .arg(QLatin1String(core::word(e.gain).data()))
                .arg(e.held, 0, 'g', 4);
          },
          [&](const PairGainHeld& e) {
            return tr("%1 of robots %2 and %3 is held at %4, its limit: (18) allows no more")
                .arg(QLatin1String(core::word(e.gain).data()))
                .arg(e.i + 1)
                .arg(e.j + 1)
                .arg(e.held, 0, 'g', 4);
          },
          [&](const Couple& e) { return tr("Robots %1 and %2 are coupled again").arg(e.i + 1).arg(e.j + 1); },
          [&](const Uncouple& e) { return tr("Robots %1 and %2 are no longer coupled").arg(e.i + 1).arg(e.j + 1); },
          [&](const CameraMoved& e) {
            return tr("The camera moved, or the floor under it: all %1 tags moved by %2 mm at once. Poses are wrong "
                      "until the camera is calibrated again")
                .arg(e.tags)
                .arg(1000.0 * e.by, 0, 'f', 0);
          },
          [&](const app::events::NotSeen& e) {
            return tr("The camera does not see robot %1: %2").arg(e.robot + 1).arg(reason(e.why));
          },
          [&](const FilmBroken&) {
            return tr("The film broke off (is the disk full?): no more frames are recorded, the run goes on");
          },
          [&](const app::events::Link& e) {
            return (e.state == app::LinkState::up
                        ? tr("The link of robot %1 is up again; release the robot when it may drive")
                        : tr("The link of robot %1 is lost: it was told to stop"))
                .arg(e.robot + 1);
          },
          [&](const Perturb& e) { return tr("Robot %1 was moved by the experiment").arg(e.robot + 1); },
          [&](const Move& e) { return tr("Robot %1 was moved by hand").arg(e.robot + 1); },
          [&](const Kidnap& e) {
            return tr("Robot %1 is not where it drove: it was carried or pushed").arg(e.robot + 1);
          },
          [&](const Hold& e) { return tr("Robot %1 is held: it stands, the others drive on").arg(e.robot + 1); },
          [&](const Release& e) { return tr("Robot %1 drives again").arg(e.robot + 1); },
          [&](const Kick& e) {
            return tr("Robot %1 was kicked, %2 m/s").arg(e.robot + 1).arg(std::hypot(e.vx, e.vy), 0, 'f', 2);
          },
          [&](const PutObstacle& e) {
            return e.obstacle.radius > 0.0 ? tr("Obstacle %1 stands at x %2 m, y %3 m")
                                                 .arg(e.number + 1)
                                                 .arg(e.obstacle.x, 0, 'f', 2)
                                                 .arg(e.obstacle.y, 0, 'f', 2)
                                           : tr("Obstacle %1 was removed").arg(e.number + 1);
          },
          [&](const NoWay& e) { return tr("Robot %1 stands: there is no route to its place").arg(e.robot + 1); },
          [&](const NoProgress& e) {
            return tr("Robot %1 has made no progress to its place for 3 s, %2 m away (%3)")
                .arg(e.robot + 1)
                .arg(e.distance, 0, 'f', 2)
                .arg(QString::fromUtf8(word(e.hindrance).data()));
          },
          [&](const Outside& e) { return tr("Robot %1 is over the edge of the arena").arg(e.robot + 1); },
          [&](const Controller& e) {
            switch (e.state) {
              case app::ControllerState::answered:
                return tr("The controller answers in time again");
              case app::ControllerState::late:
                return tr("The controller is late: its robots stand, or the built-in law drives");
              case app::ControllerState::ended:
                break;
            }
            return tr("The controller has ended");
          },
          [&](const NoNumber& e) {
            return tr("Robot %1 stands: the law's output for it is not a number").arg(e.robot + 1);
          },
          // Said elsewhere in the window: the run bar, the sliders, the state of the strip.
          [](const one_of<Start, Pause, Resume, Stop, Gain, Schedule, PairGain, Lost, Found, Avoid, Clear,
                          app::events::Stage, Staged, Deadlock, VRise> auto&) { return QString(); },
      },
      event);
  return said.isEmpty() ? said : AlertStrip::tr("%1 s: ").arg(t, 0, 'f', 1) + said;
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
  const std::map<int, QString> before = lost_;
  for (const app::Event& event : record.events) {
    if (const auto* const lost = std::get_if<app::events::Lost>(&event))
      lost_.try_emplace(static_cast<int>(lost->robot) + 1);
    if (const auto* const unseen = std::get_if<app::events::NotSeen>(&event))
      if (const auto robot = lost_.find(static_cast<int>(unseen->robot) + 1); robot != lost_.end())
        robot->second = reason(unseen->why);
    if (const auto* const found = std::get_if<app::events::Found>(&event))
      lost_.erase(static_cast<int>(found->robot) + 1);
    if (app::is<app::events::VRise>(event)) v_rose_at_ = record.t;
    const QString text = sentence(event, record.t);
    if (!text.isEmpty()) say(text, ui::severity(event));
  }
  watch(record);
  if (lost_ == before) return;
  if (lost_.empty()) {
    stand(State::lost, {}, Severity::note);
    say(tr("All robots are seen"), Severity::good);
  } else if (record.phase == app::Phase::ready) {
    stand(State::lost, tr("No tag seen of robot %1").arg(lost_robots()), Severity::warning);
  } else {
    QStringList robots;  // with the reason, where it is known
    for (const auto& [robot, why] : lost_)
      robots << (why.isEmpty() ? QString::number(robot) : QStringLiteral("%1 (%2)").arg(robot).arg(why));
    stand(State::lost, tr("LOST: robot %1 – no tag seen, it stands").arg(robots.join(QStringLiteral(", "))),
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

QString AlertStrip::lost_robots() const {
  QStringList numbers;
  for (const auto& [robot, why] : lost_) numbers << QString::number(robot);
  return numbers.join(QStringLiteral(", "));
}

void AlertStrip::stand(State state, const QString& text, Severity severity) {
  const auto known = states_.find(state);
  if (known == states_.end() ? text.isEmpty() : known->second.text == text) return;
  if (text.isEmpty())
    states_.erase(state);
  else
    states_[state] = {text, severity};
  if (!text.isEmpty() && news_.severity < severity) since_.invalidate();  // "all are seen" is no longer so
  choose();
}

void AlertStrip::say(const QString& text, Severity severity) {
  const bool graver_one_is_fresh = since_.isValid() && since_.elapsed() < read_ms &&
                                   news_.severity >= Severity::warning && news_.severity > severity;
  if (held_ || graver_one_is_fresh) return;
  news_ = {text, severity};
  since_.start();
  choose();
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
  v_rose_at_ = app::none;
  states_.clear();
  since_.invalidate();
  choose();
}

/// News are read for a moment, unless an alarm lasts; then the states are back, the gravest first.
void AlertStrip::choose() {
  if (held_) return;
  Said shown;
  for (const Severity grave : {Severity::alarm, Severity::warning})
    for (const auto& [state, said] : states_) {
      if (said.severity != grave) continue;
      shown.text += (shown.text.isEmpty() ? QString() : QStringLiteral("   ·   ")) + said.text;
      shown.severity = std::max(shown.severity, grave);
    }
  const qint64 age = since_.isValid() ? since_.elapsed() : fade_ms + 1;
  const bool fresh = age <= (shown.text.isEmpty() ? fade_ms : read_ms);
  const bool outranked = shown.severity == Severity::alarm && news_.severity < Severity::alarm;
  if (fresh && !outranked) shown = news_;
  if (shown.text == text_ && shown.severity == severity_) return;
  text_ = shown.text;
  severity_ = shown.severity;
  show_text();
}

void AlertStrip::refresh() {
  choose();
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
