#pragma once

#include <QDir>
#include <QImage>
#include <QPainter>
#include <QPolygonF>
#include <QString>
#include <QTransform>
#include <array>
#include <cmath>

/// Pictures of a chessboard that is shown to a camera, as its calibration needs them.
namespace skein::ui::test::board {

inline constexpr int width = 640, height = 480, columns = 10, rows = 7;  // squares
inline constexpr double focal = 600.0, square = 0.025;                   // [px], [m]

/// A chessboard as a camera without distortion sees it: tilted about its two axes, and shifted.
inline QImage seen(double tilt_x, double tilt_y, double x, double y, double z) {
  const double w = columns * square, h = rows * square;
  QPolygonF corners;
  for (const auto& [u, v] : {std::array{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
    const double px = u * w, py = v * h * std::cos(tilt_x), pz = v * h * std::sin(tilt_x);
    const double qx = px * std::cos(tilt_y) + pz * std::sin(tilt_y), qz = pz * std::cos(tilt_y) - px * std::sin(tilt_y);
    corners << QPointF(width / 2.0 + focal * (qx + x) / (qz + z), height / 2.0 + focal * (py + y) / (qz + z));
  }
  QTransform onto;
  const QPolygonF board{{QPointF(0, 0), QPointF(columns, 0), QPointF(columns, rows), QPointF(0, rows)}};
  QTransform::quadToQuad(board, corners, onto);
  QImage picture(2 * width, 2 * height, QImage::Format_Grayscale8);  // drawn finer, for soft edges
  picture.fill(230);
  QPainter p(&picture);
  p.scale(2, 2);
  p.setTransform(onto, true);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      p.fillRect(QRectF(column, row, 1, 1), (row + column) % 2 ? Qt::white : Qt::black);
  p.end();
  return picture.scaled(width, height, Qt::IgnoreAspectRatio, Qt::SmoothTransformation);
}

/// view0.png, view1.png ...; false: one could not be written.
inline bool save_views(const QDir& dir) {
  const std::array<std::array<double, 5>, 7> poses{{{0.0, 0.0, 0.0, 0.0, 0.5},
                                                    {0.5, 0.0, -0.08, 0.05, 0.55},
                                                    {-0.5, 0.1, 0.08, -0.05, 0.6},
                                                    {0.1, 0.6, 0.05, 0.05, 0.5},
                                                    {-0.1, -0.6, -0.05, -0.05, 0.55},
                                                    {0.4, 0.4, 0.0, 0.0, 0.6},
                                                    {-0.4, 0.5, 0.1, 0.04, 0.7}}};
  bool done = true;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const auto [tilt_x, tilt_y, x, y, z] = poses[k];
    done = seen(tilt_x, tilt_y, x, y, z).save(dir.filePath(QStringLiteral("view%1.png").arg(k))) && done;
  }
  return done;
}

}  // namespace skein::ui::test::board
