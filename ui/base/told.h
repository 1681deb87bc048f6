#pragma once

#include <QAccessible>
#include <QString>
#include <functional>

class QWidget;

namespace skein::ui {

/// Describes a widget that draws itself to screen readers, since Qt knows only that it exists: its role, and `what` it
/// shows now, called whenever a screen reader asks (empty: its accessible description). Call it before setting any
/// other accessible property of the widget.
void tell(QWidget* widget, QAccessible::Role role, std::function<QString()> what = {});

}  // namespace skein::ui
