#include "ui/base/folding_button.h"

#include <QStyleOptionButton>
#include <QStylePainter>
#include <algorithm>

namespace skein::ui {

void FoldingButton::set_folded(bool folded) {
  if (folded == folded_) return;
  folded_ = folded;
  updateGeometry();
  update();
}

QSize FoldingButton::sizeHint() const {
  const QSize full = QPushButton::sizeHint();
  return folded_ ? QSize(iconSize().width() + 18, full.height()) : full;
}

void FoldingButton::paintEvent(QPaintEvent*) {
  QStylePainter painter(this);
  QStyleOptionButton option;
  initStyleOption(&option);
  if (folded_) option.text.clear();
  painter.drawControl(QStyle::CE_PushButton, option);
}

}  // namespace skein::ui
