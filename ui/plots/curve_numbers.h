#pragma once

#include <qcustomplot.h>

#include <QStaticText>
#include <functional>
#include <vector>

namespace skein::ui {

/// The numbers of a plot's curves where there are more curves than colours: each on its curve, at a time of its own, so
/// that curves that run together still have their numbers side by side. A number that would cover another is left out.
class CurveNumbers final : public QCPLayerable {
  Q_OBJECT

 public:
  struct Number {
    int number = 0;
    QColor colour;
    double t = 0.0, value = 0.0;
    bool behind = false;  ///< the end of its curve, or behind others that stand there
  };

  explicit CurveNumbers(QCPAxisRect* rect);
  /// In the order of their importance.
  void show(std::vector<Number> numbers) { numbers_ = std::move(numbers); }
  void set_ground(const QColor& ground) { ground_ = ground; }

  struct Placed {
    int number;
    QColor colour;
    QRectF place;
  };
  const std::vector<Placed>& placed() const { return placed_; }  ///< in the last picture

 protected:
  void applyDefaultAntialiasingHint(QCPPainter* painter) const override { painter->setAntialiasing(false); }
  QRect clipRect() const override { return rect_->rect(); }
  void draw(QCPPainter* painter) override;

 private:
  const QStaticText& text_of(int number, const QFont& font);
  void move_behind(QRectF* place, double end) const;

  QCPAxisRect* rect_;
  QColor ground_;
  std::vector<Number> numbers_;
  std::vector<Placed> placed_;
  std::vector<QStaticText> texts_;
};

}  // namespace skein::ui
