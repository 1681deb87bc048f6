#pragma once

#include <QPen>

namespace skein::ui {

inline QColor faded(QColor colour, double opacity) {
  colour.setAlphaF(static_cast<float>(opacity));
  return colour;
}

inline QPen cosmetic(const QColor& colour, double width, Qt::PenStyle style = Qt::SolidLine) {
  QPen pen(colour, width, style);
  pen.setCapStyle(Qt::RoundCap);
  pen.setJoinStyle(Qt::BevelJoin);  // curves are many short pieces: a round join at each costs more than the line
  return pen;
}

}  // namespace skein::ui
