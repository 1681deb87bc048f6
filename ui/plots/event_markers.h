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
  void clear();
  void remove_before(double t);
  /// The texts of the lines within some pixels of this x; empty: none.
  QString text_at(double pixel) const;

  void drop_lines();  ///< the plots are about to change
  void draw_lines();  ///< they have: through all there are now

 private:
  struct Marker {
    double t;
    QString text;
    QColor colour;
    std::vector<QCPItemStraightLine*> lines;  // the plot's
  };
  void draw(Marker& marker);
  void remove_first();

  QCustomPlot* plot_;
  std::deque<Marker> markers_;
};

}  // namespace skein::ui
