#pragma once

#include <QImage>
#include <QRectF>
#include <QSizeF>

#include "app/run/status.h"

namespace skein::ui {

/// A camera's picture as Qt draws it.
inline QImage image_of(const app::Picture& picture) {
  return QImage(picture.grey.data(), picture.width, picture.height, picture.width, QImage::Format_Grayscale8).copy();
}

/// Where it is drawn: in the middle of a widget, as large as fits.
inline QRectF sheet_of(const QImage& picture, QSizeF widget) {
  const QSizeF size = QSizeF(picture.size()).scaled(widget, Qt::KeepAspectRatio);
  return {QPointF((widget.width() - size.width()) / 2, (widget.height() - size.height()) / 2), size};
}

}  // namespace skein::ui
