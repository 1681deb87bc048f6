#pragma once

#include <QPersistentModelIndex>
#include <QTableView>

#include "ui/robots/robots_model.h"

namespace skein::ui {

/// The table of robots; a click selects the robot everywhere.
class RobotsPanel final : public QTableView {
  Q_OBJECT

 public:
  explicit RobotsPanel(QWidget* parent = nullptr);
  RobotsModel& robots() { return model_; }
  void select_robot(int robot);  ///< from 0; -1: none
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override { return {180, 60}; }

 signals:
  void picked(int robot);

 protected:
  void changeEvent(QEvent*) override;
  void resizeEvent(QResizeEvent*) override;
  bool viewportEvent(QEvent*) override;

 private:
  void follow_tip();
  void hide_empty_columns();
  void fit_mode();
  RobotsModel model_;
  struct Tip {
    QPersistentModelIndex of;
    QPoint where;  // on the screen
    QString said;
  };
  Tip tip_;  // that was shown last
};

}  // namespace skein::ui
