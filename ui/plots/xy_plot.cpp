#include "ui/plots/xy_plot.h"

#include <algorithm>
#include <cmath>

#include "ui/base/told.h"

namespace skein::ui {
namespace {

constexpr std::size_t most_points = 2000;  // of a curve
constexpr double room = 0.05;              // of the axes beyond the curves, as a share

}  // namespace

XyPlot::XyPlot(QWidget* parent) : QCustomPlot(parent) {
  setObjectName(QStringLiteral("xy_plot"));
  tell(this, QAccessible::Chart);
  setFocusPolicy(Qt::NoFocus);
  plotLayout()->setMargins(QMargins(0, 5, 8, 3));
  for (QCPAxis* axis : {xAxis, yAxis}) axis->ticker()->setTickCount(4);
}

void XyPlot::set_rows(const PlotRow& x, const PlotRow& y, const Colours& colours) {
  first_x_ = x.first;
  first_y_ = y.first;
  clearPlottables();
  curves_.clear();
  newest_.clear();
  const QString title = tr("%1 over %2").arg(y.title(), x.title());
  setAccessibleName(title);
  setToolTip(title);
  xAxis->setLabel(x.title() + QLatin1Char(' ') + x.unit);
  yAxis->setLabel(y.title() + QLatin1Char(' ') + y.unit);
  setBackground(colours.panel);
  axisRect()->setBackground(colours.plot);
  for (QCPAxis* axis : {xAxis, yAxis}) {
    axis->setLabelColor(colours.text);
    axis->setTickLabelColor(colours.text);
    axis->setLabelFont(font());
    axis->setTickLabelFont(font());
    for (auto set : {&QCPAxis::setBasePen, &QCPAxis::setTickPen, &QCPAxis::setSubTickPen})
      (axis->*set)(QPen(colours.axis));
    axis->grid()->setPen(QPen(colours.plot_grid));
    axis->grid()->setZeroLinePen(QPen(colours.axis));
  }
  for (std::size_t c = 0; c < y.curves.size(); ++c) {
    const QColor colour = colour_of(y.of, c, colours);
    auto* curve = new QCPCurve(xAxis, yAxis);
    curve->setPen(QPen(colour, 1.5));
    curves_.push_back(curve);
    auto* newest = addGraph();
    newest->setLineStyle(QCPGraph::lsNone);
    newest->setScatterStyle(QCPScatterStyle(QCPScatterStyle::ssDisc, colour, 7));
    newest_.push_back(newest);
  }
}

void XyPlot::draw_history(const PlotHistory& history, double from, double to, const std::vector<bool>& drawn) {
  std::size_t samples = 0;
  history.each(from, to, [&](double, const std::function<double(std::size_t)>&) { ++samples; });
  const std::size_t every = std::max<std::size_t>(1, samples / most_points);
  std::vector<QVector<QCPCurveData>> points(curves_.size());
  std::size_t k = 0;
  history.each(from, to, [&](double t, const std::function<double(std::size_t)>& value) {
    ++k;
    if (k % every != 0 && k != samples) return;
    for (std::size_t c = 0; c < points.size(); ++c)
      if (drawn[c]) points[c].push_back({t, value(first_x_ + c), value(first_y_ + c)});
  });
  for (std::size_t c = 0; c < points.size(); ++c) {
    QVector<QCPGraphData> newest;
    if (!points[c].isEmpty() && std::isfinite(points[c].back().key + points[c].back().value))
      newest.push_back({points[c].back().key, points[c].back().value});
    newest_[c]->data()->set(newest, true);
    curves_[c]->data()->set(points[c], true);
  }
  fit();
  replot(QCustomPlot::rpQueuedRefresh);
}

void XyPlot::fit() {
  QCPRange x, y;
  bool any_x = false, any_y = false;
  for (QCPCurve* curve : curves_) {
    bool found = false;
    if (const QCPRange range = curve->getKeyRange(found); found) {
      x = any_x ? x.expanded(range) : range;
      any_x = true;
    }
    if (const QCPRange range = curve->getValueRange(found); found) {
      y = any_y ? y.expanded(range) : range;
      any_y = true;
    }
  }
  const auto with_room = [](const QCPRange& range) {
    const double more = std::max(room * range.size(), 1e-6);
    return QCPRange(range.lower - more, range.upper + more);
  };
  if (any_x) xAxis->setRange(with_room(x));
  if (any_y) yAxis->setRange(with_room(y));
}

}  // namespace skein::ui
