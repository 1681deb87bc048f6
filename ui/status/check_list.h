#pragma once

#include <QLabel>
#include <QPushButton>
#include <QWidget>
#include <vector>

#include "app/session/readiness.h"

namespace skein::ui {

/// What has to hold before a start, each with its reason and a way to mend it; and the button that overrules what may
/// be overruled.
class CheckList final : public QWidget {
  Q_OBJECT

 public:
  explicit CheckList(QWidget* parent = nullptr);
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override { return {200, 60}; }
  void show_checks(const std::vector<app::Check>& checks);

 signals:
  void mend(skein::app::Check::What what);
  void start_anyway();

 protected:
  void changeEvent(QEvent*) override;

 private:
  struct Row {
    QLabel *mark, *title, *reason;
    QPushButton* mend;  // none: nothing to press
  };
  void dress();

  std::vector<app::Check> checks_;
  std::vector<Row> rows_;
  QPushButton* anyway_;
  QWidget* list_;  // scrolls where there is little room
};

}  // namespace skein::ui
