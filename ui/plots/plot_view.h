#pragma once

#include <qcustomplot.h>

#include <optional>
#include <set>
#include <vector>

#include "ui/base/palette.h"
#include "ui/plots/event_markers.h"
#include "ui/plots/plot_history.h"
#include "ui/plots/plot_rows.h"

namespace skein::ui {

class CurveNumbers;
class MathTitle;

/// Some rows of plots, one below the other along one time: curves from a PlotHistory, those of compared runs paler and
/// dashed behind them, limits, events, a cursor.
class PlotView final : public QCustomPlot {
  Q_OBJECT

 public:
  explicit PlotView(QWidget* parent = nullptr);

  /// `others`: how many runs this one is compared with; `foresees`: behind the last of them come this run's next
  /// seconds; `added`: for each row (of all), the rows whose curves are also drawn in its plot; may be empty.
  void set_rows(const std::vector<PlotRow>& all, const std::vector<bool>& shown, std::size_t robots,
                std::size_t others = 0, bool foresees = false, const std::vector<std::vector<std::size_t>>& added = {});
  void show_robots(const std::vector<bool>& robots);  ///< of each, whether its curves are drawn
  void select(int robot);                             ///< from 0, drawn bold; -1: all alike
  void set_colours(const Colours& colours);

  void set_time(double from, double to);
  QCPRange time() const;
  /// Draws the curves of the visible time; `others`: of every run to compare with, null: it is switched off. Rows that
  /// lie outside `within`, in pixels of this widget, are left out; empty: none is.
  void draw_history(const PlotHistory& history, const std::vector<const PlotHistory*>& others,
                    const QRect& within = {});

  EventMarkers& markers() { return markers_; }
  /// A line through all plots; none: no line. From the mark, values at the cursor are measured.
  void set_cursor(std::optional<double> t);
  void set_playhead(std::optional<double> t);
  void set_mark(std::optional<double> t);
  /// Divides the height of a row (of all) by `times`, about `value` or, without one, about its middle. The height then
  /// stays until `fit_heights`, which lets all rows follow their curves again.
  void zoom_height(std::size_t row, double times, std::optional<double> value = {});
  void fit_heights();
  QCPRange height_of(std::size_t row) const;  ///< of a row (of all) that is shown
  bool holds_heights() const;                 ///< whether a row's height stays as it is
  /// The row (of all) at this height; -1: between two.
  int row_at(const QPoint& where) const;
  /// The row (of all) whose title and legend are there; -1: none.
  int head_at(const QPoint& where) const;
  const CurveNumbers* numbers_of(std::size_t row) const;  ///< of a row (of all); none: its curves have none
  QRect head_of(std::size_t row) const;                   ///< of a row (of all) that is shown
  double time_at(const QPoint& where) const;
  double value_at(std::size_t row, const QPoint& where) const;
  /// Where a row (of all) is at this time; the middle of the widget if it is not shown.
  QPoint place_of(std::size_t row, double t) const;

  int needed_height() const;  ///< so that the numbers at the axes are apart
  QSize minimumSizeHint() const override { return {200, 200}; }

 protected:
  void changeEvent(QEvent* event) override;

 private:
  struct Added {
    std::size_t row;  // of all
    QCPAxis* axis;    // that of the plot itself, or, with another unit, the one at the right
    MathTitle* title;
    std::vector<QCPGraph*> graphs;
  };
  struct Shown {
    std::size_t row;  // of all
    QCPAxisRect* rect;
    QCPLayoutGrid* head;
    MathTitle* title;
    QCPLegend* legend;      // or none
    CurveNumbers* numbers;  // or none: then there is a legend, or it has another plot's colours
    std::vector<QCPGraph*> graphs;
    std::vector<std::vector<QCPGraph*>> others;  // of every compared run
    std::vector<Added> added;
    std::vector<QCPItemStraightLine*> limits;
    QCPItemRect* band;  // or none
    QCPItemStraightLine *cursor, *playhead, *mark;
  };
  void add_row(std::size_t row, bool last, bool has_times, bool names_curves, const std::vector<std::size_t>& added);
  QCPItemRect* band(QCPAxisRect* rect, double half);
  QCPItemStraightLine* line(QCPAxisRect* rect, const QString& layer);
  void place(QCPItemStraightLine* Shown::*line, std::optional<double> t);
  void number_curves(const Shown& shown, const PlotHistory& history) const;
  const Shown* find(std::size_t row) const;
  void style();
  void style_curves();
  bool drawn(const PlotRow& row, std::size_t curve) const;
  void fill(QCPGraph* graph, const PlotHistory& history, std::size_t curve);
  void fit(Shown& shown, const PlotHistory& history, const std::vector<const PlotHistory*>& others);
  QCPRange fitted(const std::vector<const PlotRow*>& rows, const std::vector<const PlotHistory*>& of_first,
                  const PlotHistory& history) const;
  void style_curve(QCPGraph* graph, const PlotRow& row, std::size_t curve, std::optional<Qt::PenStyle> style) const;
  struct Look {
    QColor colour;
    Qt::PenStyle style = Qt::SolidLine;
  };
  Look look_of(const PlotRow& row, std::size_t curve) const;

  std::vector<PlotRow> rows_;
  std::vector<Shown> shown_;
  std::vector<bool> robots_;
  std::vector<std::optional<QCPRange>> heights_;  // of all rows: those that do not follow their curves
  std::vector<PlotHistory::Point> points_;
  EventMarkers markers_;
  Colours colours_;
  std::size_t others_ = 0;  // the foreseen one included
  bool foresees_ = false;
  int selected_ = -1;
  QCPMarginGroup* sides_ = nullptr;
};

}  // namespace skein::ui
