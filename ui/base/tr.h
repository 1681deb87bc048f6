#pragma once

#include <QCoreApplication>
#include <QString>

namespace skein::ui {

/// The text in the user's language, for code that belongs to no widget.
inline QString tr(const char* text) {
  return QCoreApplication::translate("skein", text);
}

}  // namespace skein::ui
