#pragma once

#include <QAccessible>
#include <QString>
#include <functional>

class QWidget;

namespace skein::ui {

/// What a screen reader is told of a widget that draws itself, of which Qt knows nothing but that it is there: its
/// role, and in `what` what is to be seen on it now, asked for whenever somebody wants to hear it (empty: its
/// accessible description). Before anything else is said of the widget.
void tell(QWidget* widget, QAccessible::Role role, std::function<QString()> what = {});

}  // namespace skein::ui
