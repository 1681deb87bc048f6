#include "ui/base/number_field.h"

#include <QLineEdit>
#include <QStyle>
#include <QStyleOptionSpinBox>
#include <cmath>

#include "ui/base/number_text.h"

namespace skein::ui {
namespace {

constexpr double largest_number = 1e6;

}  // namespace

std::optional<double> parse_number(const QString& text) {
  bool is_number = false;
  const double number = text.trimmed().replace(QLatin1Char(','), QLatin1Char('.')).toDouble(&is_number);
  return is_number && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

NumberField::NumberField(QWidget* parent) : QDoubleSpinBox(parent) {
  setRange(-largest_number, largest_number);
  setKeyboardTracking(false);
}

QString NumberField::number_in(const QString& text) const {
  QString number = text;
  if (!suffix().isEmpty() && number.endsWith(suffix())) number.chop(suffix().size());
  return number.trimmed();
}

bool NumberField::is_being_typed() const {
  return hasFocus() && number_in(text()) != textFromValue(value());
}

QValidator::State NumberField::validate(QString& input, int&) const {
  const QString number = number_in(input);
  if (parse_number(number)) return QValidator::Acceptable;
  for (const QChar c : number)
    if (!c.isDigit() && !QStringLiteral("+-.,eE").contains(c)) return QValidator::Invalid;
  return QValidator::Intermediate;
}

double NumberField::valueFromText(const QString& text) const {
  return parse_number(number_in(text)).value_or(value());
}

QSize NumberField::sizeHint() const {
  const QString usual = textFromValue(0.0) + suffix() + QLatin1Char(' ');
  const QSize text(fontMetrics().horizontalAdvance(usual) + 2, lineEdit()->sizeHint().height());
  QStyleOptionSpinBox option;
  initStyleOption(&option);
  return style()->sizeFromContents(QStyle::CT_SpinBox, &option, text, this);
}

QString NumberField::textFromValue(double value) const {
  return fixed(value, decimals());
}

}  // namespace skein::ui
