#pragma once

#include <QString>
#include <QStringList>
#include <vector>

namespace skein::ui {

/// Which plots are drawn and how, under a name.
struct PlotLayout {
  QString name;
  QStringList plots;           ///< names of their rows
  double span = 60.0;          ///< how much of the time is seen; 0: all there is [s]
  QString over_y{}, over_x{};  ///< names of the rows that are drawn over each other; empty: none
};

/// Those that the operator has kept, by name.
std::vector<PlotLayout> plot_layouts();
/// Keeps one for good, under a name that may have been in use.
void keep_plot_layout(const PlotLayout& layout);
void forget_plot_layout(const QString& name);

}  // namespace skein::ui
