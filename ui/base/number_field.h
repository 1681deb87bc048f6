#pragma once

#include <QDoubleSpinBox>
#include <optional>

namespace skein::ui {

/// A number as people type it, with either decimal sign; empty: it is not a number, or it can be read in two ways, as
/// "1,000", whose comma may be a decimal sign or separate thousands.
std::optional<double> parse_number(const QString& text);

/// Why a typed text is refused: both numbers of one that can be read in two ways, else "found TEXT, allowed: ALLOWED".
QString why_refused(const QString& text, const QString& allowed);

/// A spin box into which any number can be typed; one beyond its range becomes the range's end, and it says so. Qt's
/// own box discards digits that would leave its range: "0.3" becomes 0 where the maximum is 0.17. Without decimals it
/// takes whole numbers only.
class NumberField final : public QDoubleSpinBox {
  Q_OBJECT

 public:
  explicit NumberField(QWidget* parent = nullptr);
  bool is_being_typed() const;  ///< the text is not that of the value

  QValidator::State validate(QString& input, int& position) const override;
  double valueFromText(const QString& text) const override;
  void fixup(QString& input) const override;
  QString textFromValue(double value) const override;
  QSize sizeHint() const override;  ///< for usual numbers, not for the largest that can be typed
  QSize minimumSizeHint() const override { return sizeHint(); }

 signals:
  /// What was typed is not a number, can be read in two ways, or lies beyond the range; then also what is taken.
  void refused(const QString& why) const;

 private:
  bool is_taken(double number) const;            // as it stands
  QString number_in(const QString& text) const;  // without the suffix; of words that stand for a number, this number
};

}  // namespace skein::ui
