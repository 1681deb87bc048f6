#pragma once

#include <QString>

#include "app/run/number_text.h"

namespace skein::ui {

/// A number for people, with so many decimals: app::fixed as Qt's text.
inline QString fixed(double value, int decimals) {
  return QString::fromStdString(app::fixed(value, decimals));
}

/// "1 robot", "3 robots".
inline QString counted(qsizetype number, const char* what) {
  const QString of = QString::fromUtf8(what);
  return QStringLiteral("%1 %2").arg(number).arg(number == 1 ? of : of + QLatin1Char('s'));
}

}  // namespace skein::ui
