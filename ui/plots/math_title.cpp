#include "ui/plots/math_title.h"

#include <cmath>

namespace skein::ui {

MathTitle::MathTitle(QCustomPlot* plot, const QString& symbol, const QString& index, const QString& unit)
    : QCPLayoutElement(plot), symbol_(symbol), index_(index), unit_(unit) {
  setMinimumMargins(QMargins(0, 0, 0, 0));
}

void MathTitle::lay_out() const {
  const QFont plain = mParentPlot->font();
  if (!size_.isEmpty() && laid_out_in_ == plain) return;
  laid_out_in_ = plain;
  QFont slanted = plain;
  slanted.setItalic(true);
  slanted.setBold(true);
  slanted.setPointSizeF(plain.pointSizeF() + 1.5);
  QFont lowered = plain;
  lowered.setItalic(true);
  const QFontMetricsF big(slanted), small(lowered), upright(plain);
  const double base = big.ascent(), index = big.horizontalAdvance(symbol_) + 1;
  const double unit = index + small.horizontalAdvance(index_) + 6;
  const auto part = [](const QFont& font, const QString& text, double left, double top) {
    Part made{font, {}, {left, top}};
    made.text.setTextFormat(Qt::PlainText);
    made.text.setPerformanceHint(QStaticText::AggressiveCaching);
    made.text.setText(text);
    made.text.prepare({}, font);
    return made;
  };
  parts_ = {part(slanted, symbol_, 0.0, 0.0), part(lowered, index_, index, 1.25 * base - small.ascent()),
            part(plain, unit_, unit, base - upright.ascent())};
  size_ = {static_cast<int>(std::ceil(unit + upright.horizontalAdvance(unit_))) + 6,
           static_cast<int>(std::ceil(big.height())) + 3};
}

QSize MathTitle::minimumOuterSizeHint() const {
  lay_out();
  return size_ + QSize(mMargins.left(), 0);
}

void MathTitle::draw(QCPPainter* painter) {
  lay_out();
  painter->setPen(colour_);
  for (const Part& part : parts_) {
    painter->setFont(part.font);
    painter->drawStaticText(mRect.topLeft() + part.at, part.text);
  }
}

}  // namespace skein::ui
