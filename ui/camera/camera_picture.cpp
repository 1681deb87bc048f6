#include "ui/camera/camera_picture.h"

#include <QPainter>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "ui/base/picture.h"
#include "ui/base/told.h"

namespace skein::ui {

using State = app::WatchedTag::State;

QString verdict_on(const app::WatchedTag& tag) {
  switch (tag.state) {
    case State::taken:
      return CameraPicture::tr("robot %1").arg(tag.robot + 1);
    case State::unjudged:
      return CameraPicture::tr("robot %1's: no calibration says where it is").arg(tag.robot + 1);
    case State::refused:
    case State::nobodys:
      return QString::fromStdString(tag.why);
  }
  return {};
}

QString size_of(const app::WatchedTag& tag) {
  if (!tag.seen) return QStringLiteral("–");
  const QString px = CameraPicture::tr("%1 px").arg(tag.edge_px, 0, 'f', 0);
  return std::isnan(tag.edge) ? px : CameraPicture::tr("%1, %2 mm").arg(px).arg(1e3 * tag.edge, 0, 'f', 1);
}

QColor colour_of(State state, const Colours& colours) {
  switch (state) {
    case State::taken:
      return colours.good;
    case State::refused:
      return colours.alarm;
    case State::unjudged:
      return colours.notice;
    case State::nobodys:
      return colours.warning;
  }
  return colours.text;
}

namespace {

/// Where a text of this size lies beside its tag and over no other tag and text: below, above, to the right or to the
/// left of it, in the sheet. Empty: nowhere.
std::optional<QRectF> beside_tag(const QRectF& tag, const QSizeF& size, const QRectF& sheet,
                                 const std::vector<QRectF>& others) {
  constexpr double gap = 4.0;
  const double left = std::clamp(tag.center().x() - size.width() / 2, sheet.left(),
                                 std::max(sheet.left(), sheet.right() - size.width()));
  const double top = tag.center().y() - size.height() / 2;
  const QRectF below({left, tag.bottom() + gap}, size), above({left, tag.top() - gap - size.height()}, size);
  for (const QRectF& place :
       {below, above, QRectF({tag.right() + gap, top}, size), QRectF({tag.left() - gap - size.width(), top}, size)}) {
    const auto hidden = [&](const QRectF& other) { return place.intersects(other); };
    if (sheet.contains(place) && std::none_of(others.begin(), others.end(), hidden)) return place;
  }
  return std::nullopt;
}

}  // namespace

CameraPicture::CameraPicture(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("camera_picture"));
  tell(this, QAccessible::Graphic, [this] { return told(); });
  setAccessibleName(tr("The camera's picture with the tags in it"));
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Expanding);
}

void CameraPicture::show_view(const app::CameraView& view) {
  if (view.picture.width == 0) return;
  picture_ = image_of(view.picture);
  tags_ = view.tags;
  update();
}

void CameraPicture::clear(const QString& why) {
  picture_ = {};
  note_.clear();
  tags_.clear();
  why_ = why;
  update();
}

void CameraPicture::set_note(const QString& note) {
  if (note_ == note) return;
  note_ = note;
  update();
}

QString CameraPicture::told() const {
  if (picture_.isNull()) return why_;
  QStringList lines;
  if (!note_.isEmpty()) lines << note_;
  for (const app::WatchedTag& tag : tags_)
    if (tag.seen) lines << tr("tag %1, %2: %3").arg(tag.tag).arg(size_of(tag), verdict_on(tag));
  return lines.isEmpty() ? tr("no tag is seen") : lines.join(QStringLiteral("; "));
}

void CameraPicture::paintEvent(QPaintEvent*) {
  QPainter p(this);
  p.setRenderHints(QPainter::Antialiasing | QPainter::SmoothPixmapTransform);
  const Colours c = colours(palette());
  p.fillRect(rect(), c.surroundings);
  if (picture_.isNull()) {
    p.setPen(c.text);
    p.drawText(rect().adjusted(12, 12, -12, -12), Qt::AlignCenter | Qt::TextWordWrap, why_);
    return;
  }
  const QRectF sheet = sheet_of(picture_, size());
  p.drawImage(sheet, picture_);
  const double scale = sheet.width() / picture_.width();
  std::vector<const app::WatchedTag*> seen;
  std::vector<QRectF> drawn;  // outlines of the tags that are seen, then their texts: not to be hidden
  for (const app::WatchedTag& tag : tags_) {
    if (!tag.seen) continue;
    QPolygonF outline;
    for (const auto& [u, v] : tag.corners) outline << sheet.topLeft() + QPointF((u + 0.5) * scale, (v + 0.5) * scale);
    p.setBrush(Qt::NoBrush);
    const bool taken = tag.state == State::taken;
    p.setPen(QPen(colour_of(tag.state, c), 2.5, taken ? Qt::SolidLine : Qt::DashLine));
    p.drawPolygon(outline);
    seen.push_back(&tag);
    drawn.push_back(outline.boundingRect());
  }
  constexpr int edge = 3;
  std::vector<QString> written(seen.size());
  drawn.resize(2 * seen.size());
  const auto write = [&](std::size_t k, const QString& text) {
    QRectF& box = drawn[seen.size() + k];
    const QRectF before = std::exchange(box, QRectF());
    const QRect around = fontMetrics().boundingRect(QRect(0, 0, width(), height()), Qt::AlignLeft, text);
    const auto place = beside_tag(drawn[k], around.adjusted(-edge, 0, edge, 0).size(), sheet, drawn);
    box = place.value_or(before);
    if (place) written[k] = text;
    return place.has_value();
  };
  // Of each its number; then as much more as has room. The table has all of it.
  for (std::size_t k = 0; k < seen.size(); ++k) write(k, QString::number(seen[k]->tag));
  for (std::size_t k = 0; k < seen.size(); ++k) {
    constexpr int widest = 170;  // [px]
    const QString size = tr("%1: %2").arg(seen[k]->tag).arg(size_of(*seen[k]));
    const QString why = fontMetrics().elidedText(verdict_on(*seen[k]), Qt::ElideRight, widest);
    const bool explained = seen[k]->state == State::refused && write(k, size + QLatin1Char('\n') + why);
    if (!explained) write(k, size);
  }
  texts_.clear();
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (written[k].isEmpty()) continue;
    const QRectF& box = drawn[seen.size() + k];
    QColor ground = c.panel;
    ground.setAlphaF(0.85F);
    p.fillRect(box, ground);
    const bool is_well = seen[k]->state == State::taken;
    p.setPen(is_well ? c.text : colour_of(seen[k]->state, c));
    p.drawText(box.adjusted(edge, 0, 0, 0), Qt::AlignLeft, written[k]);
    texts_.push_back({seen[k]->tag, box});
  }
  if (!note_.isEmpty()) paint_across(p, sheet, note_, c);
}

}  // namespace skein::ui
