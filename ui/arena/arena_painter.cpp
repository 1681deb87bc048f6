#include "ui/arena/arena_painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "ui/arena/arena_other.h"
#include "ui/arena/arena_pens.h"
#include "ui/base/modes.h"
#include "ui/base/picture.h"
#include "ui/base/tr.h"

namespace skein::ui {
namespace {

constexpr std::size_t many = 8;      // robots: of more, thin lines
constexpr double small_robot = 7.0;  // radius [px]: of a smaller one, number and badge are smaller as well

}  // namespace

void ArenaPainter::paint_ground(const QRectF& widget) {
  p_.setRenderHint(QPainter::Antialiasing);
  floor(widget);
  bounds_and_path();
}

void ArenaPainter::paint(const QRectF& widget) {
  p_.setRenderHint(QPainter::Antialiasing);
  obstacles();
  if (scene_.show_trails) trails();
  for (const OtherRun& other : scene_.compared) paint_other(p_, other, scene_, map_, c_);
  paint_foreseen(p_, scene_, map_, c_);
  if (scene_.record) {
    if (scene_.draws_couplings()) couplings();
    if (scene_.show_regions) regions();
    references();
  }
  scale_bar(widget);  // these two would hide robots
  legend(widget);
  if (scene_.record) {
    robots();
    ghost();
    kick();
  }
  ruler();
  messages(widget);
  keyboard(widget);
}

void ArenaPainter::floor(const QRectF& widget) {
  p_.fillRect(widget, c_.surroundings);
  if (map_.shows_picture() && !scene_.picture.isNull()) {
    p_.setRenderHint(QPainter::SmoothPixmapTransform);
    p_.drawImage(map_.sheet(), scene_.picture);
    // Slightly back, so that what is drawn over it can be read; an old one far.
    const QString old = scene_.old_picture();
    p_.fillRect(map_.sheet(), faded(c_.floor, !old.isEmpty() ? 0.7 : c_.dark ? 0.35 : 0.25));
    if (!old.isEmpty()) paint_across(p_, map_.sheet(), old, c_);
    return;
  }
  const double w = scene_.experiment.arena_width / 2, h = scene_.experiment.arena_height / 2;
  p_.fillRect(QRectF(at(-w, h), at(w, -h)), c_.floor);
  if (scene_.show_grid) grid();
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
  const auto draw = [this](const core::Obstacle& o, std::size_t number, const QColor& fill, const QColor& rim) {
    p_.setPen(cosmetic(rim, 1.2));
    p_.setBrush(fill);
    p_.drawPolygon(map_.outline({o.x, o.y}, o.radius, o.radius));
    p_.setPen(ink_on(c_.obstacle));
    p_.drawText(QRectF(at(o.x, o.y) - QPointF(20, 20), QSizeF(40, 40)), Qt::AlignCenter, tr("O%1").arg(number + 1));
  };
  const auto& ghost = scene_.ghost_obstacle;
  for (std::size_t k = 0; k < scene_.circumstances.obstacles.size(); ++k) {
    const bool dragged = ghost && ghost->number == static_cast<int>(k);
    const bool selected = scene_.selected_obstacle == static_cast<int>(k);
    if (scene_.circumstances.obstacles[k].radius > 0.0)
      draw(scene_.circumstances.obstacles[k], k, faded(c_.obstacle, dragged ? 0.3 : 1.0),
           selected ? c_.text : c_.bounds);
  }
  if (!ghost) return;
  const auto number =
      ghost->number < 0 ? scene_.circumstances.obstacles.size() : static_cast<std::size_t>(ghost->number);
  draw(ghost->obstacle, number, faded(ghost->leaves ? c_.alarm : c_.obstacle, ghost->leaves ? 0.25 : 0.7),
       ghost->leaves ? c_.alarm : c_.text);
}

void ArenaPainter::trails() {
  if (!scene_.record) return;
  constexpr int shades = 10;      // a fade in steps: one line a step instead of one a tick
  constexpr double finest = 2.0;  // [px]: points nearer to one another are not seen, but cost as much
  const bool crowd = scene_.trails.size() > many;
  for (std::size_t i = 0; i < scene_.trails.size(); ++i) {
    std::array<QPolygonF, shades> lines;
    const auto draw = [&](int shade) {
      if (shade < 0) return;
      auto& line = lines[static_cast<std::size_t>(shade)];
      p_.setPen(cosmetic(faded(c_.robot(i), 0.06 + 0.84 * shade / (shades - 1)), crowd ? 1.0 : 2.0));
      p_.drawPolyline(line);
      line.clear();
    };
    int shade = -1;
    std::optional<QPointF> before;
    for (const TrailPoint& point : scene_.trails[i]) {
      const double age = (scene_.record->t - point.t) / ArenaScene::trail_seconds;
      const int now = std::clamp(static_cast<int>((1.0 - age) * shades), 0, shades - 1);
      const QPointF here = at(point.x, point.y);
      const bool last = &point == &scene_.trails[i].back();
      if (now == shade && !point.jump && !last && before && (here - *before).manhattanLength() < finest) continue;
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

/// The couplings as lines: as wide as the gains are strong; one that is off is a dotted trace, which a click brings
/// back.
void ArenaPainter::couplings() {
  const std::size_t n = scene_.experiment.robots.size();
  // A crowd's web must not hide the crowd, nor cost a frame: thin lines, whose strength is how well they are seen. The
  // more there are, the paler; not those of the selected robot.
  const bool crowd = n > many;
  constexpr double pairs_of_20 = 190.0, palest = 0.25;
  const double share = std::clamp(2.0 * pairs_of_20 / static_cast<double>(n * n), palest, 1.0);
  const double scale = map_.scale_at({0.0, 0.0});
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      if (!scene_.draws_coupling(i, j)) continue;
      // Lost, or made to stand: out of the group until it drives again.
      const bool out = scene_.is_out_of_group(i) || scene_.is_out_of_group(j);
      const bool hovered = scene_.hovered_coupling == std::array{static_cast<int>(i), static_cast<int>(j)};
      const double strength = out ? 0.0 : scene_.couplings[i * n + j];
      constexpr double thinnest = 0.8, widest = 9.0;  // [px]
      const bool selected = scene_.selected == static_cast<int>(i) || scene_.selected == static_cast<int>(j);
      const double paler = selected ? 1.0 : share;
      const double opacity = crowd ? paler * std::clamp(0.15 + 0.5 * strength, 0.15, 0.5) : 0.55;
      QPen pen = strength > 0.0
                     ? cosmetic(faded(c_.coupling, hovered ? 0.9 : opacity),
                                crowd ? 1.0 : std::clamp(thinnest + widest * strength, thinnest, widest))
                     : cosmetic(faded(c_.faint_text, hovered ? 0.9 : 0.35 * paler), hovered ? 2.0 : 1.0, Qt::DotLine);
      pen.setCapStyle(Qt::FlatCap);
      p_.setBrush(Qt::NoBrush);
      p_.setPen(pen);
      QPolygonF line;
      for (const QPointF& point : scene_.coupling_line(i, j, scale)) line << map_.to_screen(point);
      p_.drawPolyline(line);
    }
}

/// Where robots are noticed (detection, |dx/alpha|^p + |dy/beta|^p = 1), and where the shield stops them: two of its
/// rings just touch.
void ArenaPainter::regions() {
  const core::ShieldParameters& shield = scene_.experiment.shield;
  p_.setBrush(Qt::NoBrush);
  for (std::size_t i = 0; i < scene_.experiment.robots.size(); ++i) {
    const auto pose = scene_.pose(i);
    if (!pose) continue;
    const app::RobotRecord& robot = scene_.record->robots[i];
    const double beyond = scene_.radius(i) - core::standard_radius;
    if (shield.enabled) {
      const bool acts = robot.is(app::shielded);
      p_.setPen(cosmetic(faded(acts ? c_.shielded : c_.robot(i), acts ? 0.9 : 0.6), acts ? 1.6 : 1.0, Qt::DashLine));
      const double half = shield.distance / 2 + beyond;  // and the other's half
      p_.drawPolygon(map_.outline({pose->x, pose->y}, half, half));
    }
    const core::AvoidanceParameters avoidance = core::wider(app::make_avoidance(scene_.experiment, i), beyond);
    if (!avoidance.enabled) continue;
    const bool inside = robot.is(app::avoiding);
    p_.setPen(cosmetic(faded(inside ? c_.avoiding : c_.robot(i), inside ? 0.9 : 0.40), inside ? 1.6 : 1.0));
    p_.drawPolygon(map_.outline({pose->x, pose->y}, avoidance.alpha, avoidance.beta, avoidance.p));
  }
}

void ArenaPainter::references() {
  p_.setBrush(Qt::NoBrush);
  for (std::size_t i = 0; i < scene_.record->robots.size(); ++i) {
    const app::RobotRecord& robot = scene_.record->robots[i];
    const core::Pose& nominal = robot.nominal.pose;
    const double body = scene_.radius(i);
    p_.setPen(cosmetic(faded(c_.robot(i), 0.85), 1.4));
    p_.drawPolygon(map_.outline({nominal.x, nominal.y}, body, body));
    const double c = std::cos(nominal.theta), s = std::sin(nominal.theta);
    p_.drawLine(at(nominal.x + body * c, nominal.y + body * s),
                at(nominal.x + 1.55 * body * c, nominal.y + 1.55 * body * s));
    if (robot.is(app::avoiding)) {  // where avoidance sends it meanwhile
      const QPointF there = at(robot.reference.pose.x, robot.reference.pose.y);
      p_.setPen(cosmetic(c_.robot(i), 1.8));
      p_.drawLine(there - QPointF(4, 4), there + QPointF(4, 4));
      p_.drawLine(there - QPointF(4, -4), there + QPointF(4, -4));
    }
  }
}

/// Bodies, then badges, then numbers: in a crowd no robot's number is hidden by its neighbours' bodies and badges, and
/// none is written over another.
void ArenaPainter::robots() {
  struct Seen {
    std::size_t i;
    core::Pose pose;
    double radius, opacity;
  };
  std::vector<Seen> seen;
  seen.reserve(scene_.experiment.robots.size());
  for (std::size_t i = 0; i < scene_.experiment.robots.size(); ++i)
    if (const auto pose = scene_.pose(i)) {
      const bool dragged = scene_.ghost && scene_.ghost->robot == static_cast<int>(i);
      const bool lost = scene_.record->robots[i].is(app::lost);
      seen.push_back({i, *pose, scene_.radius(i) * map_.scale_at({pose->x, pose->y}),
                      lost      ? 0.35
                      : dragged ? 0.5
                                : 1.0});
    }
  const auto selected = [this](const Seen& one) { return scene_.selected == static_cast<int>(one.i); };
  std::stable_partition(seen.begin(), seen.end(), [&](const Seen& one) { return !selected(one); });  // on top
  for (const Seen& one : seen) {
    const QPointF centre = at(one.pose.x, one.pose.y);
    if (selected(one) || scene_.hovered == static_cast<int>(one.i)) {
      p_.setBrush(Qt::NoBrush);
      p_.setPen(cosmetic(faded(c_.text, selected(one) ? 0.9 : 0.4), selected(one) ? 1.6 : 1.2));
      p_.drawEllipse(centre, one.radius + 6, one.radius + 6);
    }
    robot(one.pose, one.i, one.opacity);
    const ModeStyle style = scene_.style_of(one.i, c_);
    if (style.symbol.isEmpty()) continue;
    p_.setBrush(Qt::NoBrush);
    p_.setPen(cosmetic(style.colour, 2.6));
    p_.drawEllipse(centre, one.radius + 2.2, one.radius + 2.2);
  }
  for (const Seen& one : seen)
    if (const ModeStyle style = scene_.style_of(one.i, c_); !style.symbol.isEmpty())
      badge(badge_place(at(one.pose.x, one.pose.y), one.radius), style.symbol, style.colour, one.radius);
  // Where a crowd's numbers would overlap, the one of the selected robot comes first.
  std::vector<QRectF> numbers;
  const auto write = [&](const Seen& one) { number(one.pose, one.i, one.opacity, &numbers); };
  for (const Seen& one : seen)
    if (selected(one)) write(one);
  for (const Seen& one : seen)
    if (!selected(one)) write(one);
}

QPointF ArenaPainter::badge_place(QPointF centre, double robot) {
  return centre + QPointF(0.8, -0.8) * (robot + 5);
}

double ArenaPainter::badge_radius(double robot) const {
  return p_.fontMetrics().height() * (robot < small_robot ? 0.3 : 0.5);
}

/// A point of a robot: this far from its midpoint [m], at this angle from its heading.
QPointF ArenaPainter::rim(const core::Pose& pose, double radius, double turn) const {
  return at(pose.x + radius * std::cos(pose.theta + turn), pose.y + radius * std::sin(pose.theta + turn));
}

void ArenaPainter::robot(const core::Pose& pose, std::size_t i, double opacity) {
  const double body_radius = scene_.radius(i);
  p_.save();
  p_.setOpacity(opacity);
  const QColor body = c_.robot(i), ink = ink_on(body);
  p_.setPen(cosmetic(c_.dark ? QColor(0x101214) : QColor(Qt::white), 1.2));
  p_.setBrush(body);
  p_.drawPolygon(map_.outline({pose.x, pose.y}, body_radius, body_radius));
  // The notch: a wedge at the rim, where the robot looks to.
  p_.setPen(Qt::NoPen);
  p_.setBrush(ink);
  p_.drawPolygon(QPolygonF{
      {rim(pose, body_radius, 0.0), rim(pose, 0.62 * body_radius, 0.75), rim(pose, 0.62 * body_radius, -0.75)}});
  p_.restore();
}

/// `others`: numbers that are written already; this one is left out where it would lie over one of them.
void ArenaPainter::number(const core::Pose& pose, std::size_t i, double opacity, std::vector<QRectF>* others) {
  p_.save();
  p_.setOpacity(opacity);
  const QColor body = c_.robot(i);
  const QPointF centre = at(pose.x, pose.y);
  QFont font = p_.font();
  font.setBold(true);
  const double radius = scene_.radius(i) * map_.scale_at({pose.x, pose.y});
  // Zoomed in, the number grows with its robot; in a crowd seen from afar it leaves room for its neighbours'.
  font.setPointSizeF(std::max(font.pointSizeF() * (radius < small_robot ? 0.75 : 1.0), 0.45 * radius));
  p_.setFont(font);
  p_.setPen(ink_on(body));
  const QPointF back = (centre - rim(pose, scene_.radius(i), 0.0)) * 0.16;  // the number stands clear of the notch
  const QRectF room(centre + back - QPointF(radius, radius), 2 * QSizeF(radius, radius));
  const QString number = QString::number(i + 1);
  // What reaches over a small robot has its colour as ground: the ink would not be seen on the floor.
  QRectF reach = p_.boundingRect(room, Qt::AlignCenter | Qt::TextDontClip, number);
  const double spare = std::max(0.0, (reach.height() - QFontMetricsF(font).capHeight() - 3.0) / 2);  // around figures
  reach.adjust(0.0, spare, 0.0, -spare);
  if (others) {
    const auto lies_over = [&](const QRectF& other) { return other.intersects(reach); };
    if (std::any_of(others->begin(), others->end(), lies_over)) return p_.restore();
    others->push_back(reach);
  }
  if (reach.width() > 1.6 * radius || radius < small_robot) p_.fillRect(reach, body);
  p_.drawText(room, Qt::AlignCenter | Qt::TextDontClip, number);
  p_.restore();
}

/// `robot`: the radius of its robot [px]. Beside a small one it is smaller too, so that it hides no other's number.
void ArenaPainter::badge(QPointF centre, const QString& symbol, const QColor& colour, double robot) {
  p_.save();
  const bool small = robot < small_robot;
  const double r = badge_radius(robot);
  p_.setPen(cosmetic(c_.floor, 1.2));
  p_.setBrush(colour);
  p_.drawEllipse(centre, r, r);
  if (symbol == QStringLiteral("■")) {  // drawn: fonts do not agree on its size
    p_.fillRect(QRectF(centre - QPointF(r, r) * 0.42, QSizeF(r, r) * 0.84), ink_on(colour));
  } else {
    p_.setPen(ink_on(colour));
    QFont font = p_.font();
    font.setBold(true);
    if (small) font.setPointSizeF(0.6 * font.pointSizeF());
    p_.setFont(font);
    p_.drawText(QRectF(centre - QPointF(r, r), QSizeF(2 * r, 2 * r)), Qt::AlignCenter | Qt::TextDontClip, symbol);
  }
  p_.restore();
}

}  // namespace skein::ui
