#pragma once

#include <QString>

namespace skein::ui {

QString shortcuts_text();
QString about_text();
/// How a camera is calibrated, in words.
QString calibration_text();

}  // namespace skein::ui
