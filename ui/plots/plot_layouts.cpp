#include "ui/plots/plot_layouts.h"

#include "ui/base/settings.h"

namespace skein::ui {
namespace {

const QString group = QStringLiteral("plot_layouts");

}  // namespace

std::vector<PlotLayout> plot_layouts() {
  std::vector<PlotLayout> layouts;
  QSettings stored = settings();
  stored.beginGroup(group);
  for (const QString& name : stored.childKeys()) {
    QStringList words = stored.value(name).toStringList();
    if (words.size() < 4) continue;  // not from here
    PlotLayout layout{name, {}, words[0].toDouble(), words[1], words[2]};
    layout.plots = words.mid(3);
    layouts.push_back(layout);
  }
  return layouts;
}

void keep_plot_layout(const PlotLayout& layout) {
  QString name = layout.name.trimmed();
  name.replace(QLatin1Char('/'), QLatin1Char('-'));  // a slash would be a group of the settings
  QSettings stored = settings();
  stored.setValue(group + QLatin1Char('/') + name,
                  QStringList{QString::number(layout.span), layout.over_y, layout.over_x} + layout.plots);
}

void forget_plot_layout(const QString& name) {
  QSettings stored = settings();
  stored.remove(group + QLatin1Char('/') + name);
}

}  // namespace skein::ui
