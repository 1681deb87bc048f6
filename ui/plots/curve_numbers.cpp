#include "ui/plots/curve_numbers.h"

#include <algorithm>
#include <cmath>

namespace skein::ui {

CurveNumbers::CurveNumbers(QCPAxisRect* rect)
    : QCPLayerable(rect->parentPlot(), QStringLiteral("axes"), rect), rect_(rect) {}

/// Laid out once: there are many, in every picture.
const QStaticText& CurveNumbers::text_of(int number, const QFont& font) {
  const auto k = static_cast<std::size_t>(number);
  if (texts_.size() <= k) texts_.resize(k + 1);
  QStaticText& text = texts_[k];
  if (text.text().isEmpty()) {
    text.setTextFormat(Qt::PlainText);
    text.setPerformanceHint(QStaticText::AggressiveCaching);
    text.setText(QString::number(number));
    text.prepare({}, font);
  }
  return text;
}

/// From the end of the curve on to where no other number is.
void CurveNumbers::move_behind(QRectF* place, double end) const {
  constexpr double gap = 3.0;
  place->moveLeft(end + gap);
  const auto in_the_way = [&] {
    return std::find_if(placed_.begin(), placed_.end(),
                        [&](const Placed& other) { return other.place.intersects(*place); });
  };
  for (auto other = in_the_way(); other != placed_.end(); other = in_the_way())
    place->moveLeft(other->place.right() + gap);
}

void CurveNumbers::draw(QCPPainter* painter) {
  placed_.clear();
  const QCPAxis* time = rect_->axis(QCPAxis::atBottom);
  const QCPAxis* value = rect_->axis(QCPAxis::atLeft);
  QFont font = mParentPlot->font();
  font.setPointSizeF(std::max(7.0, font.pointSizeF() - 1.0));
  painter->setFont(font);
  for (const Number& one : numbers_) {
    if (!std::isfinite(one.value)) continue;
    const QStaticText& text = text_of(one.number, font);
    QRectF place(QPointF(), text.size());
    place.moveCenter({time->coordToPixel(one.t), value->coordToPixel(one.value)});
    if (one.behind) move_behind(&place, time->coordToPixel(one.t));
    if (!QRectF(rect_->rect()).contains(place.center())) continue;
    const bool hidden =
        std::any_of(placed_.begin(), placed_.end(), [&](const Placed& other) { return other.place.intersects(place); });
    if (hidden) continue;
    painter->fillRect(place, ground_);
    painter->setPen(one.colour);
    painter->drawStaticText(place.topLeft(), text);
    placed_.push_back({one.number, one.colour, place});
  }
}

}  // namespace skein::ui
