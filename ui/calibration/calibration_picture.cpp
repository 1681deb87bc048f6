#include "ui/calibration/calibration_picture.h"

#include <QPainter>
#include <algorithm>
#include <array>

#include "ui/base/palette.h"
#include "ui/base/picture.h"

namespace skein::ui {

using Progress = app::CalibrationProgress;

QString next_place(const Progress& progress) {
  static constexpr std::array places{QT_TRANSLATE_NOOP("CalibrationPicture", "at the top left"),
                                     QT_TRANSLATE_NOOP("CalibrationPicture", "at the top"),
                                     QT_TRANSLATE_NOOP("CalibrationPicture", "at the top right"),
                                     QT_TRANSLATE_NOOP("CalibrationPicture", "at the left"),
                                     QT_TRANSLATE_NOOP("CalibrationPicture", "in the middle"),
                                     QT_TRANSLATE_NOOP("CalibrationPicture", "at the right"),
                                     QT_TRANSLATE_NOOP("CalibrationPicture", "at the bottom left"),
                                     QT_TRANSLATE_NOOP("CalibrationPicture", "at the bottom"),
                                     QT_TRANSLATE_NOOP("CalibrationPicture", "at the bottom right")};
  std::array<int, places.size()> empty{}, all{};
  for (int row = 0; row < Progress::rows; ++row)
    for (int column = 0; column < Progress::columns; ++column) {
      const int across = column * 3 / Progress::columns, down = row * 3 / Progress::rows;
      const auto ninth = static_cast<std::size_t>(down) * 3 + static_cast<std::size_t>(across);
      ++all[ninth];
      empty[ninth] += progress.seen(row, column) == 0;
    }
  std::size_t worst = 0;
  for (std::size_t k = 1; k < places.size(); ++k)
    if (empty[k] * all[worst] > empty[worst] * all[k]) worst = k;
  return empty[worst] == 0 ? QString() : CalibrationPicture::tr(places[worst]);
}

CalibrationPicture::CalibrationPicture(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("calibration_picture"));
  setAccessibleName(tr("The camera's image, and the part of it that a board has covered"));
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Expanding);
}

void CalibrationPicture::set_picture(const app::Picture& picture) {
  picture_ = image_of(picture);
  update();
}

void CalibrationPicture::show_progress(const Progress& progress) {
  progress_ = progress;
  update();
}

void CalibrationPicture::paintEvent(QPaintEvent*) {
  QPainter p(this);
  p.setRenderHints(QPainter::Antialiasing | QPainter::SmoothPixmapTransform);
  const Colours c = colours(palette());
  p.fillRect(rect(), c.surroundings);
  if (picture_.isNull()) {
    p.setPen(c.faint_text);
    p.drawText(rect().adjusted(12, 12, -12, -12), Qt::AlignCenter | Qt::TextWordWrap,
               tr("No picture yet: choose the camera and press Look"));
    return;
  }
  const QRectF sheet = sheet_of(picture_, size());
  p.drawImage(sheet, picture_);
  const double w = sheet.width() / Progress::columns, h = sheet.height() / Progress::rows;
  QColor shade = c.warning;
  for (int row = 0; row < Progress::rows; ++row)
    for (int column = 0; column < Progress::columns; ++column) {
      const int seen = progress_.seen(row, column);
      constexpr int plenty = 10;
      shade.setAlphaF(seen == 0 ? 0.45F : seen < plenty ? 0.18F : 0.0F);
      p.fillRect(QRectF(sheet.left() + column * w, sheet.top() + row * h, w, h).adjusted(0.5, 0.5, -0.5, -0.5), shade);
    }
  const double scale = sheet.width() / picture_.width();
  p.setBrush(Qt::NoBrush);
  p.setPen(QPen(QColor(0, 200, 80), 1.6));
  for (const auto& [u, v] : progress_.corners)
    p.drawEllipse(sheet.topLeft() + QPointF((u + 0.5) * scale, (v + 0.5) * scale), 4, 4);
}

}  // namespace skein::ui
