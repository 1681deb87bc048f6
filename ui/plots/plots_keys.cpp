// The plots without a mouse.
#include <QAccessible>
#include <QScrollArea>
#include <QToolTip>
#include <algorithm>

#include "ui/plots/plot_view.h"
#include "ui/plots/plots_panel.h"

namespace skein::ui {

bool PlotsPanel::take_key(int key, bool fine) {
  if (rows_.empty()) return false;
  const QCPRange seen = view_->time();
  const double step = seen.size() / (fine ? 600.0 : 60.0);
  const auto show_span = [&](double from, double to) {
    leave_live();
    view_->set_time(from, to);
    if (cursor_) move_cursor(*cursor_);
    return true;
  };
  const double at = cursor_.value_or(playhead_.value_or(std::min(t_, seen.upper)));
  switch (key) {
    case Qt::Key_Left:
    case Qt::Key_Right:
      move_cursor(at + (key == Qt::Key_Left ? -step : step));
      return true;
    case Qt::Key_Up:
    case Qt::Key_Down: {
      std::vector<std::size_t> drawn;
      for (std::size_t row = 0; row < rows_.size(); ++row)
        if (shown_[row]) drawn.push_back(row);
      const auto here = std::lower_bound(drawn.begin(), drawn.end(), cursor_row_);
      if (key == Qt::Key_Down && here != drawn.end() && here + 1 != drawn.end()) cursor_row_ = *(here + 1);
      if (key == Qt::Key_Up && here != drawn.begin()) cursor_row_ = *(here - 1);
      move_cursor(at);
      return true;
    }
    case Qt::Key_Plus:
      return show_span(at - (at - seen.lower) / zoom_step, at + (seen.upper - at) / zoom_step);
    case Qt::Key_Minus:
      return show_span(at - (at - seen.lower) * zoom_step, at + (seen.upper - at) * zoom_step);
    case Qt::Key_PageUp:
    case Qt::Key_PageDown: {
      const double by = (key == Qt::Key_PageUp ? -0.5 : 0.5) * seen.size();
      return show_span(seen.lower + by, seen.upper + by);
    }
    case Qt::Key_Y:
      if (!cursor_) move_cursor(at);
      zoom_height(cursor_row_, fine ? 1.0 / zoom_step : zoom_step);
      return true;
    case Qt::Key_A:
      fit_heights();
      return true;
    case Qt::Key_D:
      set_mark(fine ? std::nullopt : std::optional(at));
      move_cursor(at);
      return true;
    case Qt::Key_Home:
      go_live();
      return true;
    case Qt::Key_Return:
    case Qt::Key_Enter:
      if (!playhead_ || !cursor_) return false;
      emit time_wanted(*cursor_);
      return true;
    default:
      return false;
  }
}

void PlotsPanel::move_cursor(double t) {
  const QCPRange seen = view_->time();
  while (cursor_row_ < rows_.size() && !shown_[cursor_row_]) ++cursor_row_;
  if (cursor_row_ >= rows_.size()) return;
  cursor_ = std::clamp(t, seen.lower, seen.upper);
  view_->set_cursor(cursor_);
  show_values();
}

/// Beside the cursor, and for a screen reader.
void PlotsPanel::show_values() {
  const QPoint place = view_->place_of(cursor_row_, *cursor_);
  scroll_->ensureVisible(place.x(), place.y(), 20, 60);
  const QString values = values_of(cursor_row_, *cursor_, view_->markers().text_at(place.x()));
  QToolTip::showText(view_->mapToGlobal(place), values, view_);
  QString plain = values;
  plain.replace(QStringLiteral("<br>"), QStringLiteral("; "))
      .remove(QStringLiteral("<b>"))
      .remove(QStringLiteral("</b>"));
  view_->setAccessibleDescription(plain);
  QAccessibleEvent changed(view_, QAccessible::DescriptionChanged);
  QAccessible::updateAccessibility(&changed);
}

}  // namespace skein::ui
