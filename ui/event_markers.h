#pragma once

#include <QColor>
#include <QString>
#include <deque>
#include <vector>

class QCPItemStraightLine;
class QCustomPlot;

namespace skein::ui {

/// Vertical lines through all plots at the times when something happened.
class EventMarkers {
 public:
  explicit EventMarkers(QCustomPlot* plot) : plot_(plot) {}

  void add(double t, const QString& text, const QColor& colour);
  void clear() { remove_before(1e300); }
  void remove_before(double t);
  /// The texts of the lines within some pixels of this x; empty: none.
  QString text_at(double pixel) const;

 private:
  struct Marker {
    double t;
    QString text;
    std::vector<QCPItemStraightLine*> lines;  // the plot's
  };
  QCustomPlot* plot_;
  std::deque<Marker> markers_;
};

}  // namespace skein::ui
