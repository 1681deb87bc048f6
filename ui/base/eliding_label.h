#pragma once

#include <QLabel>

namespace skein::ui {

/// A line of plain text that ends in an ellipsis where it has too little room.
class ElidingLabel final : public QLabel {
  Q_OBJECT

 public:
  explicit ElidingLabel(QWidget* parent = nullptr);
  void set_ink(const QColor& ink);
  QSize minimumSizeHint() const override;

 protected:
  void paintEvent(QPaintEvent*) override;

 private:
  QColor ink_;  // not valid: the palette's
};

}  // namespace skein::ui
