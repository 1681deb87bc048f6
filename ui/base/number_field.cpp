#include "ui/base/number_field.h"

#include <QLineEdit>
#include <QRegularExpression>
#include <QStyle>
#include <QStyleOptionSpinBox>
#include <algorithm>
#include <cmath>

#include "ui/base/number_text.h"
#include "ui/base/tr.h"

namespace skein::ui {
namespace {

constexpr double largest_number = 1e12;

/// Both numbers that the text may mean, in a sentence; empty: it cannot be read in two ways.
QString two_readings(const QString& text) {
  static const QRegularExpression either(QStringLiteral("^([+-]?[1-9]\\d{0,2}),(\\d{3})$"));
  const QRegularExpressionMatch match = either.match(text.trimmed());
  if (!match.hasMatch()) return {};
  const QString whole = match.captured(1), rest = match.captured(2);
  return tr("%1 may mean %2.%3 or %2%3: type one of these").arg(match.captured(0), whole, rest);
}

}  // namespace

std::optional<double> parse_number(const QString& text) {
  if (!two_readings(text).isEmpty()) return std::nullopt;
  bool is_number = false;
  const double number = text.trimmed().replace(QLatin1Char(','), QLatin1Char('.')).toDouble(&is_number);
  return is_number && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

QString why_refused(const QString& text, const QString& allowed) {
  const QString readings = two_readings(text);
  const QString typed = text.trimmed();
  return !readings.isEmpty() ? readings
                             : tr("found %1, allowed: %2").arg(typed.isEmpty() ? tr("nothing") : typed, allowed);
}

NumberField::NumberField(QWidget* parent) : QDoubleSpinBox(parent) {
  setRange(-largest_number, largest_number);
  setKeyboardTracking(false);
}

QString NumberField::number_in(const QString& text) const {
  if (!specialValueText().isEmpty() && text == specialValueText()) return textFromValue(minimum());
  QString number = text;
  if (!suffix().isEmpty() && number.endsWith(suffix())) number.chop(suffix().size());
  return number.trimmed();
}

bool NumberField::is_being_typed() const {
  return hasFocus() && number_in(text()) != textFromValue(value());
}

QValidator::State NumberField::validate(QString& input, int&) const {
  const QString typed = number_in(input);
  if (const auto number = parse_number(typed))
    return is_taken(*number) ? QValidator::Acceptable : QValidator::Intermediate;
  for (const QChar c : typed)
    if (!c.isDigit() && !QStringLiteral("+-.,eE").contains(c)) return QValidator::Invalid;
  return QValidator::Intermediate;
}

bool NumberField::is_taken(double number) const {
  const bool whole = decimals() > 0 || number == std::round(number);
  return whole && number >= minimum() && number <= maximum();
}

/// Called where typing ends with a text that is not taken as it stands. A number beyond the range becomes the range's
/// end; else the value stays as it was.
void NumberField::fixup(QString& input) const {
  const QString typed = number_in(input);
  if (typed.isEmpty()) return;
  const auto number = parse_number(typed);
  const QString range = tr("%1 to %2").arg(textFromValue(minimum()), textFromValue(maximum()));
  if (!number) return emit refused(why_refused(typed, tr("a number")));
  if (*number >= minimum() && *number <= maximum())  // it has digits behind the point
    return emit refused(why_refused(typed, tr("a whole number from %1").arg(range)));
  const QString taken = textFromValue(std::clamp(*number, minimum(), maximum()));
  input = taken + suffix();
  emit refused(tr("%1; %2 is taken").arg(why_refused(typed, range), taken + suffix()));
}

double NumberField::valueFromText(const QString& text) const {
  return parse_number(number_in(text)).value_or(value());
}

QSize NumberField::sizeHint() const {
  const QString usual = textFromValue(0.0) + suffix() + QLatin1Char(' ');
  const int widest =
      std::max(fontMetrics().horizontalAdvance(usual), fontMetrics().horizontalAdvance(specialValueText()));
  const QSize text(widest + 2, lineEdit()->sizeHint().height());
  QStyleOptionSpinBox option;
  initStyleOption(&option);
  return style()->sizeFromContents(QStyle::CT_SpinBox, &option, text, this);
}

QString NumberField::textFromValue(double value) const {
  return fixed(value, decimals());
}

}  // namespace skein::ui
