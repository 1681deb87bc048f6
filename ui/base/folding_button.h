#pragma once

#include <QPushButton>

namespace skein::ui {

/// A button that shows only its icon where there is no room for its text. Its tip and screen readers still have the
/// text.
class FoldingButton final : public QPushButton {
  Q_OBJECT

 public:
  using QPushButton::QPushButton;
  void set_folded(bool folded);
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override { return sizeHint(); }

 protected:
  void paintEvent(QPaintEvent*) override;

 private:
  bool folded_ = false;
};

}  // namespace skein::ui
