#include "ui/base/flow_layout.h"

#include <algorithm>

namespace skein::ui {

FlowLayout::~FlowLayout() {
  for (QLayoutItem* item : items_) delete item;
}

QLayoutItem* FlowLayout::takeAt(int index) {
  return index >= 0 && index < items_.size() ? items_.takeAt(index) : nullptr;
}

QSize FlowLayout::minimumSize() const {
  QSize widest;
  for (const QLayoutItem* item : items_) widest = widest.expandedTo(item->minimumSize());
  const QMargins around = contentsMargins();
  return widest + QSize(around.left() + around.right(), around.top() + around.bottom());
}

void FlowLayout::setGeometry(const QRect& place) {
  QLayout::setGeometry(place);
  lines(place, true);
}

int FlowLayout::lines(const QRect& place, bool moves) const {
  const QMargins around = contentsMargins();
  const QRect inside = place.marginsRemoved(around);
  int x = inside.x(), y = inside.y(), line_height = 0;
  for (QLayoutItem* item : items_) {
    const QSize size = item->sizeHint();
    if (line_height > 0 && x + size.width() > inside.x() + inside.width()) {
      x = inside.x();
      y += line_height + spacing();
      line_height = 0;
    }
    if (moves) item->setGeometry(QRect(QPoint(x, y), size));
    x += size.width() + spacing();
    line_height = std::max(line_height, size.height());
  }
  return y + line_height - place.y() + around.bottom();
}

}  // namespace skein::ui
