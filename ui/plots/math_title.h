#pragma once

#include <qcustomplot.h>

#include <QString>

namespace skein::ui {

/// A plot's title as the paper writes it: the symbol slanted, its index lowered, the unit upright. Given the margin
/// group of the plot's left side, it begins where the plot does.
class MathTitle final : public QCPLayoutElement {
  Q_OBJECT

 public:
  MathTitle(QCustomPlot* plot, const QString& symbol, const QString& index, const QString& unit);
  void set_colour(const QColor& colour) { colour_ = colour; }

 protected:
  QSize minimumOuterSizeHint() const override;
  QSize maximumOuterSizeHint() const override { return minimumOuterSizeHint(); }
  void applyDefaultAntialiasingHint(QCPPainter* painter) const override { painter->setAntialiasing(true); }
  void draw(QCPPainter* painter) override;

 private:
  QFont slanted() const;
  QFont lowered() const;

  QString symbol_, index_, unit_;
  QColor colour_;
};

}  // namespace skein::ui
