#pragma once

#include <QColor>
#include <QIcon>
#include <QString>

namespace skein::ui {

/// A symbol of resources/icons in the ink of the palette in use (the files say "currentColor").
QIcon icon(const QString& name, const QColor& ink);
QIcon program_icon();

}  // namespace skein::ui
