#pragma once

#include <QColor>
#include <QPalette>
#include <cstddef>

namespace skein::ui {

enum class Theme { light, dark };

/// The desktop's theme, from its own palette: call it before `apply`.
Theme desktop_theme();
QPalette palette(Theme theme);
void apply(Theme theme);  ///< to the whole program

/// The colours that a QPalette has no role for. They are derived from the palette, so that a widget needs only its own
/// palette.
struct Colours {
  bool dark = false;
  QColor text, faint_text, panel;
  QColor surroundings, floor, grid, bounds, path, obstacle, coupling;  // arena
  QColor plot, plot_grid, axis;                                        // plots
  QColor good, notice, warning, alarm, alarm_fill, accent;             // by severity
  QColor avoiding, shielded, limited, standing;                        // modes

  /// Robot i, from 0: Okabe and Ito's colours, which nearly everybody can distinguish. They repeat after seven; the
  /// number on the robot does not.
  QColor robot(std::size_t i) const;
  /// The pair i, i+1: colours that no nearby robot has.
  QColor pair(std::size_t i) const;
};
Colours colours(const QPalette& palette);

/// Black or white, whichever is more legible on this.
QColor ink_on(const QColor& background);

}  // namespace skein::ui
