#pragma once

#include <qcustomplot.h>

#include <vector>

#include "ui/base/palette.h"
#include "ui/plots/plot_history.h"
#include "ui/plots/plot_rows.h"

namespace skein::ui {

/// One row's curves over another's, for the time that the plots show: e_y over e_x, V over e. Each robot's newest point
/// is a disc.
class XyPlot final : public QCustomPlot {
  Q_OBJECT

 public:
  explicit XyPlot(QWidget* parent = nullptr);

  /// `x`, `y`: rows with as many curves.
  void set_rows(const PlotRow& x, const PlotRow& y, const Colours& colours);
  /// The samples between two times, thinned out if there are many; `drawn`: of each curve, whether it is.
  void draw_history(const PlotHistory& history, double from, double to, const std::vector<bool>& drawn);
  QSize sizeHint() const override { return {400, 260}; }
  QSize minimumSizeHint() const override { return {200, 160}; }

 private:
  void fit();

  std::size_t first_x_ = 0, first_y_ = 0;
  std::vector<QCPCurve*> curves_;
  std::vector<QCPGraph*> newest_;
};

}  // namespace skein::ui
