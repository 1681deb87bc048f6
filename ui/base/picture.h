#pragma once

#include <QBuffer>
#include <QImage>
#include <QPainter>
#include <QRectF>
#include <QSizeF>

#include "app/run/status.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// A camera's picture as Qt draws it.
inline QImage image_of(const app::Picture& picture) {
  return QImage(picture.grey.data(), picture.width, picture.height, picture.width, QImage::Format_Grayscale8).copy();
}

/// The picture of a tag that is not seen, so large that its cells can be told apart; null: there is none.
inline QImage image_of(const app::UnseenTag& tag, int height) {
  return tag.picture ? image_of(*tag.picture).scaledToHeight(height, Qt::SmoothTransformation) : QImage();
}

/// The picture and the sentence, for a tip; empty: nobody has looked yet.
inline QString html_of(const app::UnseenTag& tag) {
  if (tag.sentence.empty()) return {};
  QByteArray png;
  QBuffer buffer(&png);
  constexpr int tip_height = 160;
  if (const QImage image = image_of(tag, tip_height); !image.isNull()) image.save(&buffer, "PNG");
  const QString picture =
      png.isEmpty()
          ? QString()
          : QStringLiteral("<img src=\"data:image/png;base64,%1\"><br>").arg(QString::fromLatin1(png.toBase64()));
  return picture + QString::fromStdString(tag.sentence).toHtmlEscaped() + QStringLiteral("<br>");
}

/// Where it is drawn: in the middle of a widget, as large as fits.
inline QRectF sheet_of(const QImage& picture, QSizeF widget) {
  const QSizeF size = QSizeF(picture.size()).scaled(widget, Qt::KeepAspectRatio);
  return {QPointF((widget.width() - size.width()) / 2, (widget.height() - size.height()) / 2), size};
}

/// A text across the middle of a picture that does not show what there is now.
inline void paint_across(QPainter& p, const QRectF& sheet, const QString& text, const Colours& colours) {
  constexpr int flags = Qt::AlignCenter | Qt::TextWordWrap;
  QRectF band = sheet;
  band.setHeight(p.boundingRect(sheet, flags, text).height() + p.fontMetrics().height());
  band.moveCenter(sheet.center());
  p.fillRect(band, colours.alarm_fill);
  p.setPen(Qt::white);
  p.drawText(band, flags, text);
}

}  // namespace skein::ui
