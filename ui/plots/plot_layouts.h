#pragma once

#include <QString>
#include <QStringList>
#include <vector>

namespace skein::ui {

/// Which plots are drawn and how, under a name.
struct PlotLayout {
  QString name;
  QStringList plots;           ///< names of their rows
  double span = 60.0;          ///< the length of time that is seen; 0: all of it [s]
  QString over_y{}, over_x{};  ///< names of the rows that are drawn over each other; empty: none
};

/// Those that the operator has kept, by name.
std::vector<PlotLayout> plot_layouts();
/// Saves a layout; one of the same name is replaced.
void keep_plot_layout(const PlotLayout& layout);
void forget_plot_layout(const QString& name);

}  // namespace skein::ui
