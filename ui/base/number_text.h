#pragma once

#include <QString>

#include "app/run/number_text.h"

namespace skein::ui {

/// A number for people, with so many decimals: app::fixed as Qt's text.
inline QString fixed(double value, int decimals) {
  return QString::fromStdString(app::fixed(value, decimals));
}

}  // namespace skein::ui
