#pragma once

#include <qcustomplot.h>

#include <QStaticText>
#include <QString>
#include <array>

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
  struct Part {
    QFont font;
    QStaticText text;
    QPointF at;  // from the top left
  };
  void lay_out() const;

  QString symbol_, index_, unit_;
  QColor colour_;
  // Laid out once, not in every picture.
  mutable QFont laid_out_in_;
  mutable std::array<Part, 3> parts_;
  mutable QSize size_;
};

}  // namespace skein::ui
