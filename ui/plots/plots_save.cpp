// The plots as files.
#include <QFileInfo>
#include <QPdfWriter>
#include <QSaveFile>
#include <algorithm>
#include <cmath>

#include "ui/plots/plot_view.h"
#include "ui/plots/plots_panel.h"
#include "ui/plots/xy_plot.h"

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
  const bool over = !over_y_.isEmpty();
  if (over) {
    over_->set_rows(rows_[*row_of(over_x_)], rows_[*row_of(over_y_)], colours(ui::palette(Theme::light)));
    draw_over();
  }
  const bool done = save_picture(file, kind == QStringLiteral("pdf"));
  view_->set_colours(colours(palette()));
  view_->set_time(seen.lower, seen.upper);
  if (over) show_over(over_y_, over_x_);
  refresh();
  return done ? QString() : tr("Could not write %1.").arg(file);
}

/// The plots, and below them the one over another.
bool PlotsPanel::save_picture(const QString& file, bool pdf) {
  const QSize below = over_y_.isEmpty() ? QSize() : over_->size();
  const QSize size(std::max(view_->width(), below.width()), view_->height() + std::max(0, below.height()));
  const auto paint = [&](QCPPainter& painter) {
    painter.fillRect(QRect(QPoint(), size), colours(ui::palette(Theme::light)).plot);
    view_->toPainter(&painter, view_->width(), view_->height());
    if (below.isEmpty()) return;
    painter.translate(0, view_->height());
    over_->toPainter(&painter, below.width(), below.height());
  };
  if (!pdf) {
    constexpr int dense = 2;
    QPixmap picture(dense * size);
    QCPPainter painter(&picture);
    painter.scale(dense, dense);
    painter.setMode(QCPPainter::pmNonCosmetic);  // lines grow with the picture
    paint(painter);
    painter.end();
    return picture.save(file, "PNG");
  }
  constexpr int dots = 96;  // as on a screen, so that texts have the same share of the picture
  QFile out(file);
  if (!out.open(QIODevice::WriteOnly)) return false;
  QPdfWriter paper(&out);
  paper.setResolution(dots);
  paper.setPageSize(QPageSize(QSizeF(size), QPageSize::Point, {}, QPageSize::ExactMatch));
  paper.setPageMargins({});
  QCPPainter painter;
  if (!painter.begin(&paper)) return false;
  painter.setMode(QCPPainter::pmVectorized);
  painter.setMode(QCPPainter::pmNoCaching);
  painter.setWindow(QRect(QPoint(), size));
  paint(painter);
  return painter.end();
}

/// Its curves are in one of the pictures.
bool PlotsPanel::is_saved(std::size_t row) const {
  bool added = false;
  for (std::size_t plot = 0; plot < rows_.size(); ++plot)
    added = added || std::find(added_[plot].begin(), added_[plot].end(), row) != added_[plot].end();
  return shown_[row] || added || rows_[row].name == over_y_ || rows_[row].name == over_x_;
}

QString PlotsPanel::save_csv(const QString& file, double from, double to) const {
  QByteArray text = "t";
  std::vector<std::size_t> curves;
  for (std::size_t row = 0; row < rows_.size(); ++row)
    for (std::size_t c = 0; is_saved(row) && c < rows_[row].curves.size(); ++c) {
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
