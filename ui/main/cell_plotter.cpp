#include "ui/main/cell_plotter.h"

#include <QMenu>
#include <utility>

#include "ui/base/signal_drag.h"
#include "ui/plots/plots_panel.h"

namespace skein::ui {

CellPlotter::CellPlotter(PlotsPanel* plots, std::function<void()> show_plots, QObject* parent)
    : QObject(parent), plots_(plots), show_plots_(std::move(show_plots)) {}

void CellPlotter::serve(QAbstractItemView* table) {
  new SignalDrag(table, {[this](const QStringList& names, const QPoint& to) { return plots_->drag_over(names, to); },
                         [this](const QStringList& names, const QPoint& to) { plots_->drop(names, to); }});
  table->setContextMenuPolicy(Qt::CustomContextMenu);
  connect(table, &QWidget::customContextMenuRequested, this,
          [this, table](const QPoint& where) { show_menu(table, where); });
}

void CellPlotter::show_menu(QAbstractItemView* table, const QPoint& where) {
  auto* menu = new QMenu(table);
  menu->setObjectName(QStringLiteral("cell_menu"));
  menu->setAttribute(Qt::WA_DeleteOnClose);
  menu->setToolTipsVisible(true);
  menu->addActions(table->actions());
  menu->addSeparator();
  const QStringList names = table->currentIndex().data(plotted_role).toStringList();
  QMenu* plot = menu->addMenu(tr("&Plot this"));
  plot->setObjectName(QStringLiteral("plot_cell"));
  if (names.isEmpty()) {
    plot->menuAction()->setEnabled(false);
    plot->menuAction()->setToolTip(tr("No plot has what this cell shows"));
  } else {
    plot->setTitle(tr("&Plot this (%1)").arg(plots_->titles_of(names)));
    plots_->fill_signal_menu(plot, names);
    connect(plot, &QMenu::triggered, this, [this] { show_plots_(); });
  }
  menu->popup(table->viewport()->mapToGlobal(where));
}

}  // namespace skein::ui
