#pragma once

#include <QMenu>

namespace skein::ui {

/// Empties a menu that is filled anew each time it is opened. QMenu::clear leaves its submenus behind.
inline void clear_menu(QMenu* menu) {
  qDeleteAll(menu->findChildren<QMenu*>(Qt::FindDirectChildrenOnly));
  menu->clear();
}

}  // namespace skein::ui
