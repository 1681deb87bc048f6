#pragma once

#include <QString>

namespace skein::ui {

QString shortcuts_text();
QString about_text();

}  // namespace skein::ui
