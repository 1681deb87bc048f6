#include "ui/camera/camera_picture.h"

#include <QPainter>
#include <algorithm>
#include <cmath>
#include <vector>

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
/// left of it, in the sheet; else below, or above.
QRectF beside_tag(const QRectF& tag, const QSizeF& size, const QRectF& sheet, const std::vector<QRectF>& others) {
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
  return below.bottom() > sheet.bottom() ? above : below;
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
  tags_.clear();
  why_ = why;
  update();
}

QString CameraPicture::told() const {
  if (picture_.isNull()) return why_;
  QStringList lines;
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
  constexpr double widest = 170.0;  // of a text [px]
  constexpr int edge = 3;
  std::vector<QRectF> drawn;  // outlines of the tags that are seen, then texts: not to be hidden
  for (const app::WatchedTag& tag : tags_) {
    if (!tag.seen) continue;
    QPolygonF outline;
    for (const auto& [u, v] : tag.corners) outline << sheet.topLeft() + QPointF((u + 0.5) * scale, (v + 0.5) * scale);
    p.setBrush(Qt::NoBrush);
    const bool taken = tag.state == State::taken;
    p.setPen(QPen(colour_of(tag.state, c), 2.5, taken ? Qt::SolidLine : Qt::DashLine));
    p.drawPolygon(outline);
    drawn.push_back(outline.boundingRect());
  }
  std::size_t number = 0;
  for (const app::WatchedTag& tag : tags_) {
    if (!tag.seen) continue;
    const QRectF around = drawn[number++];
    const QColor colour = colour_of(tag.state, c);
    const bool taken = tag.state == State::taken;
    QString text = tr("%1: %2").arg(tag.tag).arg(size_of(tag));
    if (tag.state == State::refused)
      text += QLatin1Char('\n') + fontMetrics().elidedText(verdict_on(tag), Qt::ElideRight, static_cast<int>(widest));
    QRectF box = fontMetrics().boundingRect(QRect(0, 0, width(), height()), Qt::AlignLeft, text);
    box.adjust(-edge, 0, edge, 0);
    box = beside_tag(around, box.size(), sheet, drawn);
    drawn.push_back(box);
    QColor ground = c.panel;
    ground.setAlphaF(0.85F);
    p.fillRect(box, ground);
    p.setPen(taken ? c.text : colour);
    p.drawText(box.adjusted(edge, 0, 0, 0), Qt::AlignLeft, text);
  }
}

}  // namespace skein::ui
