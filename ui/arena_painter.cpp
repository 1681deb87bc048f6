#include "ui/arena_painter.h"

#include <QCoreApplication>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "ui/modes.h"

namespace skein::ui {
namespace {

QString tr(const char* text) {
  return QCoreApplication::translate("ArenaPainter", text);
}

QColor faded(QColor colour, double opacity) {
  colour.setAlphaF(static_cast<float>(opacity));
  return colour;
}

QPen cosmetic(const QColor& colour, double width, Qt::PenStyle style = Qt::SolidLine) {
  QPen pen(colour, width, style);
  pen.setCapStyle(Qt::RoundCap);
  pen.setJoinStyle(Qt::RoundJoin);
  return pen;
}

}  // namespace

void ArenaPainter::paint(const QRectF& widget) {
  p_.setRenderHint(QPainter::Antialiasing);
  floor(widget);
  bounds_and_path();
  obstacles();
  if (scene_.show_trails) trails();
  if (scene_.record) {
    if (scene_.show_regions && scene_.experiment.avoidance.enabled) regions();
    references();
    robots();
    ghost();
  }
  scale_bar(widget);
  legend(widget);
  banner_and_hint(widget);
}

void ArenaPainter::floor(const QRectF& widget) {
  p_.fillRect(widget, c_.surroundings);
  if (map_.shows_picture() && !scene_.picture.isNull()) {
    p_.setRenderHint(QPainter::SmoothPixmapTransform);
    p_.drawImage(map_.sheet(), scene_.picture);
    // Slightly back, so that what is drawn over it can be read.
    p_.fillRect(map_.sheet(), faded(c_.floor, c_.dark ? 0.35 : 0.25));
    return;
  }
  const double w = scene_.experiment.arena_width / 2, h = scene_.experiment.arena_height / 2;
  p_.fillRect(QRectF(at(-w, h), at(w, -h)), c_.floor);
  grid();
}

void ArenaPainter::grid() {
  const double w = scene_.experiment.arena_width / 2, h = scene_.experiment.arena_height / 2;
  constexpr double step = 0.1;
  p_.setRenderHint(QPainter::Antialiasing, false);  // straight along the pixels: sharper without
  const auto pen_of = [&](int k) { return QPen(k % 5 == 0 ? c_.grid.darker(c_.dark ? 80 : 108) : c_.grid, 1); };
  for (int k = static_cast<int>(std::ceil(-w / step)); k * step <= w; ++k) {
    p_.setPen(pen_of(k));
    p_.drawLine(at(k * step, -h), at(k * step, h));
  }
  for (int k = static_cast<int>(std::ceil(-h / step)); k * step <= h; ++k) {
    p_.setPen(pen_of(k));
    p_.drawLine(at(-w, k * step), at(w, k * step));
  }
  p_.setRenderHint(QPainter::Antialiasing);
  // The world's origin and axes, once.
  constexpr double arm = 0.07;
  p_.setPen(cosmetic(c_.faint_text, 1.2));
  p_.drawLine(at(0, 0), at(arm, 0));
  p_.drawLine(at(0, 0), at(0, arm));
  p_.drawText(at(arm, 0) + QPointF(3, 4), QStringLiteral("x"));
  p_.drawText(at(0, arm) + QPointF(-3, -3), QStringLiteral("y"));
}

void ArenaPainter::bounds_and_path() {
  const double w = scene_.experiment.arena_width / 2, h = scene_.experiment.arena_height / 2;
  const auto line = [&](const std::vector<QPointF>& corners) {
    QPolygonF polygon;  // along a lens, a straight line of the floor is a curve
    for (std::size_t k = 0; k + 1 < corners.size(); ++k)
      for (int j = 0; j <= 16; ++j) polygon << map_.to_screen(corners[k] + (corners[k + 1] - corners[k]) * (j / 16.0));
    return polygon;
  };
  p_.setBrush(Qt::NoBrush);
  p_.setPen(cosmetic(c_.bounds, 1.6));
  p_.drawPolyline(line({{-w, -h}, {w, -h}, {w, h}, {-w, h}, {-w, -h}}));

  p_.setPen(cosmetic(c_.path, 1.4));
  for (const std::vector<core::Pose>& poses : scene_.lines) {
    QPolygonF path;
    for (const core::Pose& pose : poses) path << at(pose.x, pose.y);
    p_.drawPolyline(path);
  }
}

void ArenaPainter::obstacles() {
  for (const core::Obstacle& o : scene_.experiment.obstacles) {
    p_.setPen(cosmetic(c_.bounds, 1.2));
    p_.setBrush(c_.obstacle);
    p_.drawPolygon(map_.outline({o.x, o.y}, o.radius, o.radius));
  }
}

void ArenaPainter::trails() {
  if (!scene_.record) return;
  constexpr int shades = 10;  // a fade in steps: one line a step instead of one a tick
  for (std::size_t i = 0; i < scene_.trails.size(); ++i) {
    std::array<QPolygonF, shades> lines;
    const auto draw = [&](int shade) {
      if (shade < 0) return;
      auto& line = lines[static_cast<std::size_t>(shade)];
      p_.setPen(cosmetic(faded(c_.robot(i), 0.06 + 0.84 * shade / (shades - 1)), 2.0));
      p_.drawPolyline(line);
      line.clear();
    };
    int shade = -1;
    std::optional<QPointF> before;
    for (const TrailPoint& point : scene_.trails[i]) {
      const double age = (scene_.record->t - point.t) / ArenaScene::trail_seconds;
      const int now = std::clamp(static_cast<int>((1.0 - age) * shades), 0, shades - 1);
      const QPointF here = at(point.x, point.y);
      if (now != shade || point.jump) {
        draw(shade);
        shade = now;
        if (!point.jump && before) lines[static_cast<std::size_t>(shade)] << *before;
      }
      lines[static_cast<std::size_t>(shade)] << here;
      before = here;
    }
    draw(shade);
  }
}

void ArenaPainter::regions() {
  const core::AvoidanceParameters& avoidance = scene_.experiment.avoidance;
  p_.setBrush(Qt::NoBrush);
  for (std::size_t i = 0; i < scene_.experiment.robots.size(); ++i) {
    const auto pose = scene_.pose(i);
    if (!pose) continue;
    const bool inside = scene_.record->robots[i].is(app::avoiding);
    p_.setPen(cosmetic(faded(inside ? c_.avoiding : c_.robot(i), inside ? 0.9 : 0.40), inside ? 1.6 : 1.0));
    p_.drawPolygon(map_.outline({pose->x, pose->y}, avoidance.alpha, avoidance.beta, avoidance.p));
  }
}

void ArenaPainter::references() {
  p_.setBrush(Qt::NoBrush);
  for (std::size_t i = 0; i < scene_.record->robots.size(); ++i) {
    const app::RobotRecord& robot = scene_.record->robots[i];
    const core::Pose& nominal = robot.nominal.pose;
    p_.setPen(cosmetic(faded(c_.robot(i), 0.85), 1.4));
    p_.drawPolygon(map_.outline({nominal.x, nominal.y}, robot_radius, robot_radius));
    const double c = std::cos(nominal.theta), s = std::sin(nominal.theta);
    p_.drawLine(at(nominal.x + robot_radius * c, nominal.y + robot_radius * s),
                at(nominal.x + 1.55 * robot_radius * c, nominal.y + 1.55 * robot_radius * s));
    if (robot.is(app::avoiding)) {  // where avoidance sends it meanwhile
      const QPointF there = at(robot.reference.pose.x, robot.reference.pose.y);
      p_.setPen(cosmetic(c_.robot(i), 1.8));
      p_.drawLine(there - QPointF(4, 4), there + QPointF(4, 4));
      p_.drawLine(there - QPointF(4, -4), there + QPointF(4, -4));
    }
  }
}

void ArenaPainter::robots() {
  for (std::size_t i = 0; i < scene_.experiment.robots.size(); ++i) {
    const auto pose = scene_.pose(i);
    if (!pose) continue;
    const std::uint8_t mode = scene_.record->robots[i].mode;
    const QPointF centre = at(pose->x, pose->y);
    const double radius = robot_radius * map_.scale_at({pose->x, pose->y});
    const bool dragged = scene_.ghost && scene_.ghost->robot == static_cast<int>(i);

    if (scene_.selected == static_cast<int>(i) || scene_.hovered == static_cast<int>(i)) {
      const bool selected = scene_.selected == static_cast<int>(i);
      p_.setBrush(Qt::NoBrush);
      p_.setPen(cosmetic(faded(c_.text, selected ? 0.9 : 0.4), selected ? 1.6 : 1.2));
      p_.drawEllipse(centre, radius + 6, radius + 6);
    }
    robot(*pose, i, mode & app::lost ? 0.35 : dragged ? 0.5 : 1.0);
    const ModeLook mode_look = look(mode, c_);
    if (!mode_look.symbol.isEmpty()) {
      p_.setBrush(Qt::NoBrush);
      p_.setPen(cosmetic(mode_look.colour, 2.6));
      p_.drawEllipse(centre, radius + 2.2, radius + 2.2);
      badge(centre + QPointF(0.8, -0.8) * (radius + 5), mode_look.symbol, mode_look.colour);
    }
  }
}

void ArenaPainter::robot(const core::Pose& pose, std::size_t i, double opacity) {
  p_.save();
  p_.setOpacity(opacity);
  const QColor body = c_.robot(i), ink = ink_on(body);
  const QPointF centre = at(pose.x, pose.y);
  p_.setPen(cosmetic(c_.dark ? QColor(0x101214) : QColor(Qt::white), 1.2));
  p_.setBrush(body);
  p_.drawPolygon(map_.outline({pose.x, pose.y}, robot_radius, robot_radius));

  // The notch: a wedge at the rim, where the robot looks to.
  const auto rim = [&](double radius, double turn) {
    return at(pose.x + radius * std::cos(pose.theta + turn), pose.y + radius * std::sin(pose.theta + turn));
  };
  p_.setPen(Qt::NoPen);
  p_.setBrush(ink);
  p_.drawPolygon(QPolygonF{{rim(robot_radius, 0.0), rim(0.62 * robot_radius, 0.75), rim(0.62 * robot_radius, -0.75)}});

  QFont font = p_.font();
  font.setBold(true);
  const double radius = robot_radius * map_.scale_at({pose.x, pose.y});
  font.setPointSizeF(std::max(font.pointSizeF(), 0.45 * radius));  // zoomed in, the number grows with its robot
  p_.setFont(font);
  p_.setPen(ink);
  const QPointF back = (centre - rim(robot_radius, 0.0)) * 0.16;  // the number stands clear of the notch
  p_.drawText(QRectF(centre + back - QPointF(radius, radius), 2 * QSizeF(radius, radius)),
              Qt::AlignCenter | Qt::TextDontClip, QString::number(i + 1));
  p_.restore();
}

void ArenaPainter::badge(QPointF centre, const QString& symbol, const QColor& colour) {
  p_.save();
  const double r = p_.fontMetrics().height() * 0.5;
  p_.setPen(cosmetic(c_.floor, 1.2));
  p_.setBrush(colour);
  p_.drawEllipse(centre, r, r);
  if (symbol == QStringLiteral("■")) {  // drawn: fonts do not agree on its size
    p_.fillRect(QRectF(centre - QPointF(r, r) * 0.42, QSizeF(r, r) * 0.84), ink_on(colour));
  } else {
    p_.setPen(ink_on(colour));
    QFont font = p_.font();
    font.setBold(true);
    p_.setFont(font);
    p_.drawText(QRectF(centre - QPointF(r, r), QSizeF(2 * r, 2 * r)), Qt::AlignCenter, symbol);
  }
  p_.restore();
}

void ArenaPainter::ghost() {
  if (!scene_.ghost) return;
  const auto& ghost = *scene_.ghost;
  if (const auto from = scene_.pose(static_cast<std::size_t>(ghost.robot))) {
    p_.setPen(cosmetic(c_.robot(static_cast<std::size_t>(ghost.robot)), 1.4, Qt::DashLine));
    p_.drawLine(at(from->x, from->y), at(ghost.pose.x, ghost.pose.y));
  }
  robot(ghost.pose, static_cast<std::size_t>(ghost.robot), 0.75);
}

void ArenaPainter::scale_bar(const QRectF& widget) {
  const double scale = map_.scale_at({0, 0});
  double metres = 0.01;  // 1, 2, 5, 10 ...: the longest that stays under 120 px
  for (const double step : {0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0})
    if (step * scale < 120) metres = step;
  const QString text = metres < 1 ? tr("%1 cm").arg(metres * 100) : tr("%1 m").arg(metres);
  const QFontMetricsF metrics(p_.font());
  const double length = metres * scale;
  const QRectF inside = map_.sheet() & widget;  // in the corner of what is shown, clear of the bounds
  const QRectF card(inside.left() + 10, inside.bottom() - metrics.height() - 24, length + 16, metrics.height() + 14);
  p_.setPen(Qt::NoPen);
  p_.setBrush(faded(c_.floor, 0.85));
  p_.drawRoundedRect(card, 4, 4);
  const QPointF left(card.left() + 8, card.bottom() - 6), right = left + QPointF(length, 0);
  p_.setPen(cosmetic(c_.text, 1.6));
  p_.drawLine(left, right);
  p_.drawLine(left + QPointF(0, -4), left);
  p_.drawLine(right + QPointF(0, -4), right);
  p_.drawText(QRectF(card.left(), card.top() + 1, card.width(), metrics.height()), Qt::AlignCenter, text);
}

void ArenaPainter::legend(const QRectF& widget) {
  if (!scene_.record) return;
  std::map<std::uint8_t, ModeLook> present;  // only what can be seen now needs words
  for (const app::RobotRecord& robot : scene_.record->robots) {
    const ModeLook mode_look = look(robot.mode, c_);
    if (!mode_look.symbol.isEmpty()) present.emplace(mode_look.mode, mode_look);
  }
  const QFontMetricsF metrics(p_.font());
  const QRectF inside = map_.sheet() & widget;
  double right = inside.right() - 20;
  const double middle = inside.bottom() - 18 - metrics.height() / 2;
  for (const auto& [mode, mode_look] : present) {
    const double width = metrics.horizontalAdvance(mode_look.name);
    p_.setPen(Qt::NoPen);
    p_.setBrush(faded(c_.floor, 0.85));
    const QRectF card(right - width - 30, middle - metrics.height() / 2 - 4, width + 36, metrics.height() + 8);
    p_.drawRoundedRect(card, 4, 4);
    p_.setPen(c_.text);
    p_.drawText(QPointF(right - width, middle + metrics.ascent() / 2 - 1), mode_look.name);
    badge({right - width - 14, middle}, mode_look.symbol, mode_look.colour);
    right -= width + 46;
  }
}

void ArenaPainter::chip(const QRectF& where, const QString& text, const QColor& background, const QColor& ink,
                        bool bold) {
  p_.save();
  QFont font = p_.font();
  font.setBold(bold);
  if (bold) font.setPointSizeF(font.pointSizeF() * 1.25);
  p_.setFont(font);
  const QFontMetricsF metrics(font);
  const double width = std::min(where.width(), metrics.horizontalAdvance(text) + 28);
  const QRectF card(where.center().x() - width / 2, where.top(), width, metrics.height() + 12);
  p_.setPen(Qt::NoPen);
  p_.setBrush(background);
  p_.drawRoundedRect(card, 6, 6);
  p_.setPen(ink);
  p_.drawText(card.adjusted(10, 0, -10, 0), Qt::AlignCenter, metrics.elidedText(text, Qt::ElideRight, width - 20));
  p_.restore();
}

void ArenaPainter::banner_and_hint(const QRectF& widget) {
  if (!scene_.banner.isEmpty())
    chip(QRectF(widget.left() + 20, widget.top() + 44, widget.width() - 40, 0), scene_.banner,
         scene_.banner_alarms ? c_.alarm_fill : faded(c_.text, 0.85),
         scene_.banner_alarms ? QColor(Qt::white) : c_.panel, true);
  if (!scene_.hint.isEmpty())
    chip(QRectF(widget.left() + 20, (map_.sheet() & widget).bottom() - 64, widget.width() - 40, 0), scene_.hint,
         faded(c_.notice, 0.92), ink_on(c_.notice), false);
}

}  // namespace skein::ui
