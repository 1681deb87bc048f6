#include "ui/base/eliding_label.h"

#include <QPainter>
#include <algorithm>

namespace skein::ui {

ElidingLabel::ElidingLabel(QWidget* parent) : QLabel(parent) {
  setTextFormat(Qt::PlainText);
}

void ElidingLabel::set_ink(const QColor& ink) {
  if (ink == ink_) return;
  ink_ = ink;
  update();
}

/// Some letters, which say something.
QSize ElidingLabel::minimumSizeHint() const {
  constexpr int letters = 5;
  const QSize whole = QLabel::minimumSizeHint();
  return {std::min(whole.width(), letters * fontMetrics().averageCharWidth()), whole.height()};
}

void ElidingLabel::paintEvent(QPaintEvent*) {
  QPainter p(this);
  p.setPen(ink_.isValid() ? ink_ : palette().color(foregroundRole()));
  p.drawText(rect(), static_cast<int>(alignment()), fontMetrics().elidedText(text(), Qt::ElideRight, width()));
}

}  // namespace skein::ui
