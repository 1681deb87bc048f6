#pragma once

#include <QPushButton>

namespace skein::ui {

/// A button that can do without its text where there is no room: it shows its icon then. Tip and screen reader say the
/// text all the same.
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
