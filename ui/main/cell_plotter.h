#pragma once

#include <QAbstractItemView>
#include <QObject>
#include <functional>

namespace skein::ui {

class PlotsPanel;

/// From the tables into the plots: what a cell shows is dragged there, or plotted from the table's menu.
class CellPlotter final : public QObject {
  Q_OBJECT

 public:
  /// `show_plots` brings the plots to the front.
  CellPlotter(PlotsPanel* plots, std::function<void()> show_plots, QObject* parent);
  /// The cells of this table can be plotted. Its own actions head its menu.
  void serve(QAbstractItemView* table);

 private:
  void show_menu(QAbstractItemView* table, const QPoint& where);

  PlotsPanel* plots_;
  std::function<void()> show_plots_;
};

}  // namespace skein::ui
