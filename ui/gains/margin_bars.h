#pragma once

#include <QWidget>
#include <cstddef>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// What (18f) and (18g) leave to tracking, robot by robot: k_x of v_max, k_theta of omega_max. The reference and the
/// couplings take the rest; if a bar is empty, the certificate no longer holds.
class MarginBars final : public QWidget {
  Q_OBJECT

 public:
  explicit MarginBars(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void show_record(const app::TickRecord& record);
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override { return sizeHint(); }

 protected:
  void paintEvent(QPaintEvent*) override;

 private:
  struct Bar {
    double left, of;  // [m/s] or [rad/s]
    bool holds;
  };
  QString spoken() const;
  void paint_bar(QPainter& p, const QRectF& where, const Bar& bar, const Colours& c) const;

  std::size_t robots_ = 0;
  std::vector<core::CommandLimits> limits_;  // of every robot
  std::vector<Bar> forward_, turning_;       // of every robot
};

}  // namespace skein::ui
