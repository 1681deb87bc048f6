#pragma once

#include <QLayout>
#include <QList>

namespace skein::ui {

/// Widgets in lines, as many beside one another as have room; the others follow below.
class FlowLayout final : public QLayout {
 public:
  explicit FlowLayout(QWidget* parent) : QLayout(parent) {}
  ~FlowLayout() override;

  void addItem(QLayoutItem* item) override { items_.append(item); }
  int count() const override { return static_cast<int>(items_.size()); }
  QLayoutItem* itemAt(int index) const override { return items_.value(index); }
  QLayoutItem* takeAt(int index) override;
  Qt::Orientations expandingDirections() const override { return {}; }
  bool hasHeightForWidth() const override { return true; }
  int heightForWidth(int width) const override { return lines(QRect(0, 0, width, 0), false); }
  QSize minimumSize() const override;
  QSize sizeHint() const override { return minimumSize(); }
  void setGeometry(const QRect& place) override;

 private:
  /// The height of all lines in a place of this width; `moves`: puts the widgets there.
  int lines(const QRect& place, bool moves) const;

  QList<QLayoutItem*> items_;
};

}  // namespace skein::ui
