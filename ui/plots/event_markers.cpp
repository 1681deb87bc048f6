#include "ui/plots/event_markers.h"

#include <qcustomplot.h>

#include <cmath>

namespace skein::ui {
namespace {

constexpr std::size_t most_markers = 200;  // each is a line in every plot
constexpr double reach = 5.0;              // [px]

}  // namespace

void EventMarkers::add(double t, const QString& text, const QColor& colour) {
  if (!markers_.empty() && markers_.back().t == t) {
    markers_.back().text += QLatin1Char('\n') + text;
    return;
  }
  markers_.push_back({t, text, colour, {}});
  draw(markers_.back());
  while (markers_.size() > most_markers) remove_first();
}

void EventMarkers::draw(Marker& marker) {
  for (QCPAxisRect* rect : plot_->axisRects()) {
    auto* line = new QCPItemStraightLine(plot_);
    line->setClipAxisRect(rect);
    line->setLayer(QStringLiteral("grid"));
    for (QCPItemPosition* position : line->positions()) {
      position->setAxisRect(rect);
      position->setAxes(rect->axis(QCPAxis::atBottom), rect->axis(QCPAxis::atLeft));
      position->setTypeX(QCPItemPosition::ptPlotCoords);
      position->setTypeY(QCPItemPosition::ptAxisRectRatio);
    }
    line->point1->setCoords(marker.t, 0.0);
    line->point2->setCoords(marker.t, 1.0);
    line->setPen(QPen(marker.colour, 1, Qt::DashLine));
    line->setSelectable(false);
    marker.lines.push_back(line);
  }
}

void EventMarkers::remove_first() {
  for (QCPItemStraightLine* line : markers_.front().lines) plot_->removeItem(line);
  markers_.pop_front();
}

void EventMarkers::clear() {
  while (!markers_.empty()) remove_first();
}

void EventMarkers::remove_before(double t) {
  while (!markers_.empty() && markers_.front().t < t) remove_first();
}

void EventMarkers::drop_lines() {
  for (Marker& marker : markers_) {
    for (QCPItemStraightLine* line : marker.lines) plot_->removeItem(line);
    marker.lines.clear();
  }
}

void EventMarkers::draw_lines() {
  for (Marker& marker : markers_) draw(marker);
}

QString EventMarkers::text_at(double pixel) const {
  QStringList texts;
  if (plot_->axisRectCount() == 0) return {};
  const QCPAxis* time = plot_->axisRect(0)->axis(QCPAxis::atBottom);
  for (const Marker& marker : markers_)
    if (std::abs(time->coordToPixel(marker.t) - pixel) < reach)
      texts << QStringLiteral("%1 s: %2").arg(marker.t, 0, 'f', 2).arg(marker.text);
  return texts.join(QLatin1Char('\n'));
}

}  // namespace skein::ui
