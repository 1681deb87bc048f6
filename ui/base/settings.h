#pragma once

#include <QSettings>

namespace skein::ui {

/// What the window remembers from one start to the next.
inline QSettings settings() {
  return {QSettings::IniFormat, QSettings::UserScope, QStringLiteral("skein"), QStringLiteral("skein")};
}

}  // namespace skein::ui
