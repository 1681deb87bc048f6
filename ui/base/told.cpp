#include "ui/base/told.h"

#include <QAccessibleWidget>
#include <QWidget>

namespace skein::ui {
namespace {

const QString teller_name = QStringLiteral("told_to_screen_readers");

/// Goes with its widget, and is found by it.
class Teller final : public QObject {
 public:
  Teller(QWidget* of, QAccessible::Role as, std::function<QString()> says)
      : QObject(of), role(as), what(std::move(says)) {
    setObjectName(teller_name);
  }
  const QAccessible::Role role;
  const std::function<QString()> what;
};

class Told final : public QAccessibleWidget {
 public:
  Told(QWidget* widget, const Teller& teller) : QAccessibleWidget(widget, teller.role), teller_(teller) {}
  QString text(QAccessible::Text kind) const override {
    const QString now = kind == QAccessible::Description && teller_.what ? teller_.what() : QString();
    return now.isEmpty() ? QAccessibleWidget::text(kind) : now;
  }

 private:
  const Teller& teller_;
};

QAccessibleInterface* told(const QString&, QObject* object) {
  auto* widget = qobject_cast<QWidget*>(object);
  const auto* teller = widget ? widget->findChild<QObject*>(teller_name, Qt::FindDirectChildrenOnly) : nullptr;
  return teller ? new Told(widget, *static_cast<const Teller*>(teller)) : nullptr;
}

}  // namespace

void tell(QWidget* widget, QAccessible::Role role, std::function<QString()> what) {
  [[maybe_unused]] static const bool installed = (QAccessible::installFactory(told), true);
  new Teller(widget, role, std::move(what));
}

}  // namespace skein::ui
