// What is written and drawn over the arena: what a gesture would do, ruler, scale, legend, banner.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "ui/arena/arena_painter.h"
#include "ui/arena/arena_pens.h"
#include "ui/base/modes.h"
#include "ui/base/number_text.h"
#include "ui/base/tr.h"

namespace skein::ui {
namespace {

constexpr double chip_beside = 10.0, chip_above = 6.0;  // between a message and its card's edges
constexpr double chip_highest = 1e4;
constexpr int chip_flags = Qt::AlignHCenter | Qt::TextWordWrap;

/// A message of this size, in the middle of its place's top.
QRectF card_in(const QRectF& place, const QSizeF& size) {
  return {QPointF(place.center().x() - size.width() / 2, place.top()), size};
}

QFont banner_font(QFont font) {
  font.setBold(true);
  font.setPointSizeF(font.pointSizeF() * 1.25);
  return font;
}

}  // namespace

void ArenaPainter::ghost() {
  if (!scene_.ghost) return;
  const auto& ghost = *scene_.ghost;
  if (const auto from = scene_.pose(static_cast<std::size_t>(ghost.robot))) {
    p_.setPen(cosmetic(c_.robot(static_cast<std::size_t>(ghost.robot)), 1.4, Qt::DashLine));
    p_.drawLine(at(from->x, from->y), at(ghost.pose.x, ghost.pose.y));
  }
  robot(ghost.pose, static_cast<std::size_t>(ghost.robot), 0.75);
  number(ghost.pose, static_cast<std::size_t>(ghost.robot), 0.75);
}

void ArenaPainter::kick() {
  if (!scene_.kick) return;
  const auto from = scene_.pose(static_cast<std::size_t>(scene_.kick->robot));
  if (!from) return;
  const QPointF root = at(from->x, from->y);
  const QPointF tip = map_.to_screen(QPointF(from->x, from->y) + scene_.kick->way);
  const QPointF way = tip - root;
  const double length = std::hypot(way.x(), way.y());
  if (length < 2.0) return;
  const QPointF along = way / length, across(-along.y(), along.x());
  const QColor colour = c_.text;
  p_.setPen(cosmetic(colour, 3.0));
  p_.drawLine(root, tip - along * 8);
  p_.setPen(Qt::NoPen);
  p_.setBrush(colour);
  p_.drawPolygon(QPolygonF{{tip, tip - along * 12 + across * 6, tip - along * 12 - across * 6}});
  note(tip + along * 16, tr("%1 m/s").arg(std::hypot(scene_.kick->velocity.x(), scene_.kick->velocity.y()), 0, 'f', 2));
}

/// A small card with a text, about a point of the screen.
void ArenaPainter::note(QPointF centre, const QString& text) {
  const QFontMetricsF metrics(p_.font());
  const QSizeF size(metrics.horizontalAdvance(text) + 12, metrics.height() + 6);
  const QRectF card(centre - QPointF(size.width() / 2, size.height() / 2), size);
  p_.setPen(Qt::NoPen);
  p_.setBrush(faded(c_.floor, 0.9));
  p_.drawRoundedRect(card, 4, 4);
  p_.setPen(c_.text);
  p_.drawText(card, Qt::AlignCenter, text);
  written_.push_back(card);
}

void ArenaPainter::ruler() {
  if (!scene_.ruler) return;
  const QPointF from = scene_.ruler->from, to = scene_.ruler->to, way = to - from;
  const QPointF a = map_.to_screen(from), b = map_.to_screen(to);
  p_.setBrush(Qt::NoBrush);
  p_.setPen(cosmetic(faded(c_.text, 0.35), 1.0, Qt::DashLine));
  p_.drawPolyline(QPolygonF{{a, map_.to_screen({to.x(), from.y()}), b}});
  p_.setPen(cosmetic(c_.notice, 2.0));
  p_.drawLine(a, b);
  p_.drawEllipse(a, 4, 4);
  p_.drawEllipse(b, 4, 4);
  const double degrees = std::atan2(way.y(), way.x()) * 180.0 / core::pi;
  const QPointF above((a.x() + b.x()) / 2, std::min(a.y(), b.y()) - 44);  // clear of robots at its ends
  note(above, tr("%1 cm   Δx %2   Δy %3   %4°")
                  .arg(fixed(100 * std::hypot(way.x(), way.y()), 1), fixed(100 * way.x(), 1), fixed(100 * way.y(), 1),
                       fixed(degrees, 0)));
}

/// That the keys come here, and where they point.
void ArenaPainter::keyboard(const QRectF& widget) {
  p_.setBrush(Qt::NoBrush);
  if (scene_.has_keys) {
    p_.setPen(QPen(c_.accent, 2));
    p_.drawRect(widget.adjusted(1, 1, -1, -1));
  }
  if (!scene_.cross) return;
  constexpr double inner = 5.0, outer = 14.0;  // [px]
  const QPointF floor = scene_.cross_at(), centre = at(floor.x(), floor.y());
  for (const auto& [colour, width] : {std::pair(c_.floor, 4.5), std::pair(c_.text, 2.0)}) {
    p_.setPen(cosmetic(colour, width));
    for (const QPointF way : {QPointF(1, 0), QPointF(-1, 0), QPointF(0, 1), QPointF(0, -1)})
      p_.drawLine(centre + inner * way, centre + outer * way);
  }
}

void ArenaPainter::scale_bar(const QRectF& widget) {
  const double scale = map_.scale_at({0, 0});
  const QRectF inside = map_.sheet() & widget;                 // in the corner of what is shown, clear of the bounds
  const double longest = std::min(120.0, inside.width() / 3);  // [px]: more would hide a small floor
  double metres = 0.01;                                        // 1, 2, 5, 10 ...
  for (const double step : {0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0})
    if (step * scale < longest) metres = step;
  const QString text = metres < 1 ? tr("%1 cm").arg(metres * 100) : tr("%1 m").arg(metres);
  const QFontMetricsF metrics(p_.font());
  const double length = metres * scale;
  const double width = std::max(length, metrics.horizontalAdvance(text)) + 16;
  const QRectF card(inside.left() + 10, inside.bottom() - metrics.height() - 24, width, metrics.height() + 14);
  scale_ = card;
  p_.setPen(Qt::NoPen);
  p_.setBrush(faded(c_.floor, 0.85));
  p_.drawRoundedRect(card, 4, 4);
  const QPointF left(card.center().x() - length / 2, card.bottom() - 6), right = left + QPointF(length, 0);
  p_.setPen(cosmetic(c_.text, 1.6));
  p_.drawLine(left, right);
  p_.drawLine(left + QPointF(0, -4), left);
  p_.drawLine(right + QPointF(0, -4), right);
  p_.drawText(QRectF(card.left(), card.top() + 1, card.width(), metrics.height()), Qt::AlignCenter, text);
}

/// From the right; above the scale where both have no room side by side.
void ArenaPainter::legend(const QRectF& widget) {
  if (!scene_.record) return;
  std::map<std::pair<std::uint8_t, QString>, ModeStyle> present;  // only what can be seen now needs words
  for (std::size_t i = 0; i < scene_.record->robots.size(); ++i) {
    const ModeStyle style = scene_.style_of(i, c_);
    if (!style.symbol.isEmpty()) present.emplace(std::pair(style.mode, style.name), style);
  }
  const QFontMetricsF metrics(p_.font());
  const QRectF inside = map_.sheet() & widget;
  const double rightmost = inside.right() - 20;
  double right = rightmost, middle = inside.bottom() - 18 - metrics.height() / 2;
  for (const auto& [key, style] : present) {
    const double width = metrics.horizontalAdvance(style.name);
    const auto card = [&] {
      return QRectF(right - width - 30, middle - metrics.height() / 2 - 4, width + 36, metrics.height() + 8);
    };
    if (card().intersects(scale_) || (card().left() < inside.left() && right < rightmost)) {
      right = rightmost;
      middle = std::min(middle - card().height(), scale_.top() - card().height() / 2);
    }
    p_.setPen(Qt::NoPen);
    p_.setBrush(faded(c_.floor, 0.85));
    p_.drawRoundedRect(card(), 4, 4);
    p_.setPen(c_.text);
    p_.drawText(QPointF(right - width, middle + metrics.ascent() / 2 - 1), style.name);
    badge({right - width - 14, middle}, style.symbol, style.colour, metrics.height());
    right -= width + 46;
  }
}

/// In as many lines as it takes, from the top of the place on; returns where it ends.
double ArenaPainter::chip(const QRectF& where, const QString& text, const QColor& background, const QColor& ink,
                          bool bold) {
  const QSizeF size = chip_size(text, where.width(), bold).boundedTo({where.width(), chip_highest});
  const QRectF card = card_in(where, size);
  p_.save();
  if (bold) p_.setFont(banner_font(p_.font()));
  p_.setPen(Qt::NoPen);
  p_.setBrush(background);
  p_.drawRoundedRect(card, 6, 6);
  p_.setPen(ink);
  p_.drawText(card.adjusted(chip_beside, chip_above, -chip_beside, 0), chip_flags, text);
  p_.restore();
  written_.push_back(card);
  return card.bottom();
}

/// In a place of this width; wider than that where a word is.
QSizeF ArenaPainter::chip_size(const QString& text, double width, bool bold) const {
  constexpr double more = 8.0;  // than the text has, so that it is not wrapped anew
  if (text.isEmpty()) return {0, 0};
  const QRectF room(0, 0, width - 2 * chip_beside - more, chip_highest);
  const QFontMetricsF metrics(bold ? banner_font(p_.font()) : p_.font());
  const QSizeF size = metrics.boundingRect(room, chip_flags, text).size();
  return {size.width() + 2 * chip_beside + more, size.height() + 2 * chip_above};
}

/// How much a message here would hide: a robot or its badge counts more than all obstacles, another text as everything
/// and more.
std::size_t ArenaPainter::hidden_by(const QRectF& card) const {
  const bool over_text =
      std::any_of(written_.begin(), written_.end(), [&](const QRectF& text) { return card.intersects(text); });
  std::size_t hidden = over_text ? 1 : 0;
  for (const Body& body : bodies_)
    if (over_text || card.adjusted(-body.radius, -body.radius, body.radius, body.radius).contains(body.centre))
      hidden += body.weight;
  return hidden;
}

/// Where a message hides no robot, no obstacle and no other message, or else fewest: as wide as it may be, high up or
/// low down, beside the floor where there is room; then elsewhere, and narrower, in more lines. `size_in`: in a place
/// of this width.
QRectF ArenaPainter::freest(const QRectF& widget, const std::function<QSizeF(double)>& size_in, bool low) const {
  constexpr double gap = 8.0, under_top = 44.0, over_scale = 50.0, beside = 20.0;
  const QRectF floor = map_.sheet() & widget, room = widget.adjusted(beside, gap, -beside, -gap);
  std::optional<QRectF> best;
  std::size_t fewest = 0;
  for (const double share : {1.0, 0.75, 0.5, 0.35}) {
    const double width = share * room.width();
    const QSizeF size = size_in(width);
    const double high = widget.top() + under_top, deep = floor.bottom() - over_scale - size.height();
    const double above = floor.top() - gap - size.height(), below = floor.bottom() + gap;
    const double centre = room.center().y() - size.height() / 2;
    const std::array tops =
        low ? std::array{below, deep, above, high, centre} : std::array{above, high, below, centre, deep};
    for (const double left : {room.center().x() - width / 2, room.left() - (width - size.width()) / 2,
                              room.right() - (width + size.width()) / 2})
      for (const double top : tops) {
        const QRectF place(left, top, width, size.height());
        const QRectF card = card_in(place, size);
        const bool usual = !best && top == (low ? deep : high);  // whatever else there is
        if (!usual && (size.width() > width || !room.contains(card))) continue;
        const std::size_t hidden = hidden_by(card);
        if (best && hidden >= fewest) continue;
        best = place;
        fewest = hidden;
        if (hidden == 0) return place;
      }
  }
  return best.value_or(room);
}

/// The banner with its alert high up and the hint low down, where they hide neither robots, their badges nor obstacles.
void ArenaPainter::messages(const QRectF& widget) {
  constexpr double gap = 8.0;
  constexpr std::size_t obstacle_weight = 1;
  const std::size_t robot_weight = scene_.circumstances.obstacles.size() + 1;
  for (std::size_t i = 0; i < scene_.experiment.robots.size(); ++i)
    if (const auto pose = scene_.pose(i)) {
      const QPointF centre = at(pose->x, pose->y);
      const double radius = scene_.radius(i) * map_.scale_at({pose->x, pose->y});
      bodies_.push_back({centre, radius, robot_weight});
      if (scene_.record && !scene_.style_of(i, c_).symbol.isEmpty())
        bodies_.push_back({badge_place(centre, radius), badge_radius(radius) + 1.0, robot_weight});
    }
  for (const core::Obstacle& obstacle : scene_.circumstances.obstacles)
    if (obstacle.radius > 0.0)
      bodies_.push_back(
          {at(obstacle.x, obstacle.y), obstacle.radius * map_.scale_at({obstacle.x, obstacle.y}), obstacle_weight});
  const auto said_in = [&](double width) {
    const QSizeF banner = chip_size(scene_.banner, width, true), alert = chip_size(scene_.alert, width, false);
    const double between = scene_.banner.isEmpty() || scene_.alert.isEmpty() ? 0.0 : gap;
    return QSizeF(std::max(banner.width(), alert.width()), banner.height() + between + alert.height());
  };
  if (!scene_.banner.isEmpty() || !scene_.alert.isEmpty()) {
    QRectF place = freest(widget, said_in, false);
    if (!scene_.banner.isEmpty()) {
      const double end = chip(place, scene_.banner, scene_.banner_alarms ? c_.alarm_fill : faded(c_.text, 0.85),
                              scene_.banner_alarms ? QColor(Qt::white) : c_.panel, true);
      place.setTop(end + gap);
    }
    if (!scene_.alert.isEmpty()) chip(place, scene_.alert, scene_.alert_colour, ink_on(scene_.alert_colour), false);
  }
  if (scene_.hint.isEmpty()) return;
  const auto hint_in = [&](double width) { return chip_size(scene_.hint, width, false); };
  const QRectF place = freest(widget, hint_in, true);
  if (!scene_.hint_gives_way || hidden_by(card_in(place, hint_in(place.width()))) == 0)
    chip(place, scene_.hint, faded(c_.notice, 0.92), ink_on(c_.notice), false);
}

}  // namespace skein::ui
