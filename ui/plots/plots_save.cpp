// The plots as files.
#include <QFileInfo>
#include <QSaveFile>
#include <cmath>

#include "ui/plots/plot_view.h"
#include "ui/plots/plots_panel.h"

namespace skein::ui {

QString PlotsPanel::save(const QString& file, bool everything) {
  const QString kind = QFileInfo(file).suffix().toLower();
  const QCPRange seen = view_->time();
  const bool all = everything && !history_.empty();
  const double from = all ? history_.first_time() : seen.lower, to = all ? history_.last_time() : seen.upper;
  if (kind == QStringLiteral("csv")) return save_csv(file, from, to);
  view_->set_cursor(std::nullopt);
  view_->set_colours(colours(ui::palette(Theme::light)));
  view_->set_time(from, to);
  view_->draw_history(history_, drawn_others());
  const bool done = kind == QStringLiteral("pdf") ? view_->savePdf(file, 0, 0, QCP::epAllowCosmetic)
                                                  : view_->savePng(file, 0, 0, 2.0);
  view_->set_colours(colours(palette()));
  view_->set_time(seen.lower, seen.upper);
  refresh();
  return done ? QString() : tr("Could not write %1.").arg(file);
}

QString PlotsPanel::save_csv(const QString& file, double from, double to) const {
  QByteArray text = "t";
  std::vector<std::size_t> curves;
  for (std::size_t row = 0; row < rows_.size(); ++row)
    for (std::size_t c = 0; shown_[row] && c < rows_[row].curves.size(); ++c) {
      curves.push_back(rows_[row].first + c);
      QString name = rows_[row].curves[c];
      name.replace(QLatin1Char(','), QLatin1Char('_'));
      text += "," + (name.isEmpty() ? rows_[row].name : rows_[row].name + QLatin1Char('_') + name).toUtf8();
    }
  text += '\n';
  history_.each(from, to, [&](double t, const std::function<double(std::size_t)>& value) {
    text += QByteArray::number(t, 'g', 17);
    for (const std::size_t curve : curves) {
      text += ',';
      if (!std::isnan(value(curve))) text += QByteArray::number(value(curve), 'g', 17);
    }
    text += '\n';
  });
  QSaveFile out(file);
  if (!out.open(QIODevice::WriteOnly) || out.write(text) < 0 || !out.commit())
    return tr("Could not write %1: %2.").arg(file, out.errorString());
  return {};
}

}  // namespace skein::ui
