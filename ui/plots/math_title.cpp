#include "ui/plots/math_title.h"

namespace skein::ui {

MathTitle::MathTitle(QCustomPlot* plot, const QString& symbol, const QString& index, const QString& unit)
    : QCPLayoutElement(plot), symbol_(symbol), index_(index), unit_(unit) {
  setMinimumMargins(QMargins(0, 0, 0, 0));
}

QFont MathTitle::slanted() const {
  QFont font = mParentPlot->font();
  font.setItalic(true);
  font.setBold(true);
  font.setPointSizeF(font.pointSizeF() + 1.5);
  return font;
}

QFont MathTitle::lowered() const {
  QFont font = mParentPlot->font();
  font.setItalic(true);
  return font;
}

QSize MathTitle::minimumOuterSizeHint() const {
  const QFontMetrics big(slanted()), small(lowered()), plain(mParentPlot->font());
  return {big.horizontalAdvance(symbol_) + small.horizontalAdvance(index_) + plain.horizontalAdvance(unit_) + 13 +
              mMargins.left(),
          big.height() + 3};
}

void MathTitle::draw(QCPPainter* painter) {
  painter->setPen(colour_);
  const QFontMetricsF big(slanted()), small(lowered());
  QPointF at(mRect.left(), mRect.top() + big.ascent());
  painter->setFont(slanted());
  painter->drawText(at, symbol_);
  at.rx() += big.horizontalAdvance(symbol_) + 1;
  painter->setFont(lowered());
  painter->drawText(at + QPointF(0, big.ascent() * 0.25), index_);
  at.rx() += small.horizontalAdvance(index_) + 6;
  painter->setFont(mParentPlot->font());
  painter->drawText(at, unit_);
}

}  // namespace skein::ui
