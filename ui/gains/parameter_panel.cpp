#include "ui/gains/parameter_panel.h"

#include <QGridLayout>
#include <QSignalBlocker>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace skein::ui {
namespace {

constexpr int wish_settles_ms = 120, wish_taken_ms = 1000, key_held_ms = 1000;
constexpr double steepest = 4.0;      // exponent of a slider's scale
constexpr double widest_range = 1e6;  // beyond, a slider has no useful place for any value

/// A law that declares no range, or one as wide as that.
bool has_range(const app::LawParameter& p) {
  return p.high > p.low && p.high - p.low <= widest_range;
}

bool same_declaration(const app::LawParameter& a, app::LawParameter b) {
  b.value = a.value;
  return a == b;
}

/// That puts the value in the middle of the track, where it need not be steeper than the steepest.
double exponent_for(const app::LawParameter& p) {
  const double share = (p.value - p.low) / (p.high - p.low);
  return share > 0.0 && share < 1.0 ? std::clamp(std::log(share) / std::log(0.5), 1.0, steepest) : 1.0;
}

int decimals_for(const app::LawParameter& p) {
  const double width = has_range(p) ? p.high - p.low : 1.0;
  return std::clamp(4 - static_cast<int>(std::floor(std::log10(width))), 4, 9);
}

}  // namespace

ParameterPanel::ParameterPanel(QWidget* parent)
    : QWidget(parent), layout_(new QGridLayout(this)), none_(new QLabel(this)) {
  setObjectName(QStringLiteral("law_parameters"));
  layout_->setContentsMargins(0, 0, 0, 0);
  layout_->setVerticalSpacing(1);
  layout_->setColumnStretch(1, 1);
  none_->setObjectName(QStringLiteral("no_law_parameters"));
  none_->setWordWrap(true);
  layout_->addWidget(none_, 0, 0, 1, 3);
}

void ParameterPanel::clear(const QString& none) {
  rows_.clear();
  none_->setText(none);
  none_->show();
}

void ParameterPanel::show_parameters(const std::vector<app::LawParameter>& all) {
  const bool same =
      std::equal(rows_.begin(), rows_.end(), all.begin(), all.end(),
                 [](const auto& row, const app::LawParameter& p) { return same_declaration(row->of, p); });
  if (!same) {
    rows_.clear();
    for (const app::LawParameter& p : all) add_row(p);
    none_->setVisible(rows_.empty());
    return;
  }
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    Row& row = *rows_[k];
    const bool about_to_ask =
        (row.slider && row.slider->isSliderDown()) || row.rest->isActive() || row.field->is_being_typed();
    const bool not_taken_yet = row.asked.isValid() && !row.asked.hasExpired(wish_taken_ms);
    if (about_to_ask || not_taken_yet || all[k].value == row.of.value) continue;
    row.of.value = all[k].value;
    show_value(row, row.of.value);
  }
}

void ParameterPanel::add_row(const app::LawParameter& of) {
  rows_.push_back(std::make_unique<Row>());
  Row& row = *rows_.back();
  row.of = of;
  const QString name = QString::fromStdString(of.name), unit = QString::fromStdString(of.unit);
  const QString allowed = has_range(of) ? tr("%1 to %2").arg(of.low).arg(of.high) : QString();
  row.label = std::make_unique<QLabel>(name, this);
  row.range = std::make_unique<ElidingLabel>(this);
  row.range->setText(allowed);
  row.range->setAccessibleName(tr("%1 is allowed from %2").arg(name, allowed));
  row.range->setForegroundRole(QPalette::PlaceholderText);
  row.field = std::make_unique<NumberField>(this);
  row.field->setObjectName(QStringLiteral("spin_") + name);
  row.field->setAccessibleName(name);
  row.field->setDecimals(decimals_for(of));
  row.field->setAlignment(Qt::AlignRight);
  if (!unit.isEmpty()) row.field->setSuffix(QLatin1Char(' ') + unit);
  row.rest = std::make_unique<QTimer>();
  row.rest->setSingleShot(true);
  row.rest->setInterval(wish_settles_ms);
  const int line = 2 * static_cast<int>(rows_.size());
  layout_->addWidget(row.label.get(), line, 0);
  layout_->addWidget(row.range.get(), line, 1);
  layout_->addWidget(row.field.get(), line, 2);
  if (has_range(of)) {
    row.exponent = exponent_for(of);
    row.field->setSingleStep(std::pow(10.0, std::floor(std::log10(of.high - of.low)) - 2.0));
    add_slider(row, line + 1);
  }
  dress(row);
  show_value(row, of.value);
  connect(row.field.get(), &QDoubleSpinBox::valueChanged, this, [this, &row](double typed) { choose(row, typed); });
  connect(row.field.get(), &NumberField::refused, this,
          [this, name](const QString& why) { emit refused(QStringLiteral("%1: %2").arg(name, why)); });
  connect(row.rest.get(), &QTimer::timeout, this, [this, &row] {
    const double from = std::exchange(row.of.value, row.wish);
    row.asked.start();
    if (from != row.wish) emit wanted(QString::fromStdString(row.of.name), from, row.wish);
  });
}

void ParameterPanel::add_slider(Row& row, int line) {
  const QString name = QString::fromStdString(row.of.name);
  row.slider = std::make_unique<LimitSlider>(this);
  LimitSlider* slider = row.slider.get();
  slider->setObjectName(QStringLiteral("slider_") + name);
  slider->setAccessibleName(tr("%1 slider").arg(name));
  layout_->addWidget(slider, line, 0, 1, 3);
  row.last_key = std::make_unique<QTimer>();
  row.last_key->setSingleShot(true);
  row.last_key->setInterval(key_held_ms);
  connect(row.last_key.get(), &QTimer::timeout, this, [this, slider] {
    if (!slider->isSliderDown()) emit let_go();
  });
  connect(slider, &QSlider::valueChanged, this, [this, &row, name](int step) {
    const double share = std::pow(static_cast<double>(step) / LimitSlider::steps, row.exponent);
    choose(row, std::min(row.of.high, row.of.low + share * (row.of.high - row.of.low)));
    if (!row.slider->isSliderDown()) row.last_key->start();
    emit held(name, row.field->value());
  });
  connect(slider, &QSlider::sliderPressed, this, [this, &row, name] { emit held(name, row.field->value()); });
  connect(slider, &QSlider::sliderReleased, this, [this, &row] {
    if (row.rest->isActive()) row.rest->start(0);
    row.last_key->stop();
    emit let_go();
  });
}

/// Its tips.
void ParameterPanel::dress(const Row& row) const {
  const QString help = QString::fromStdString(row.of.help).toHtmlEscaped();
  const QString unit = QString::fromStdString(row.of.unit).toHtmlEscaped();
  const QString allowed = row.range->text();
  const QString tip = (allowed.isEmpty() ? help : tr("%1. Allowed: %2 %3").arg(help, allowed, unit)).trimmed();
  for (QWidget* part : std::initializer_list<QWidget*>{row.label.get(), row.range.get(), row.field.get()}) {
    part->setToolTip(tip);
    part->show();
  }
  if (!row.slider) return;
  row.slider->setToolTip(no_preview_.isEmpty() ? tip
                                               : tr("%1<br>No preview: %2").arg(tip, no_preview_.toHtmlEscaped()));
  row.slider->show();
}

void ParameterPanel::set_no_preview(const QString& why) {
  no_preview_ = why;
  for (const auto& row : rows_) dress(*row);
}

void ParameterPanel::choose(Row& row, double value) {
  const std::string allowed = app::wrong_parameter(std::span(&row.of, 1), row.of.name, value);
  if (!allowed.empty()) {
    emit refused(tr("%1: found %2, allowed: %3")
                     .arg(QString::fromStdString(row.of.name))
                     .arg(value)
                     .arg(QString::fromStdString(allowed)));
    return show_value(row, row.of.value);
  }
  show_value(row, value);
  // As the field shows it, where that is allowed as well.
  const double shown = row.field->value();
  row.wish = shown >= row.of.low && shown <= row.of.high ? shown : value;
  row.rest->start();
}

void ParameterPanel::show_value(Row& row, double value) {
  const QSignalBlocker quiet_field(row.field.get());
  row.field->setValue(value);
  if (!row.slider) return;
  const QSignalBlocker quiet_slider(row.slider.get());
  const double share = std::clamp((value - row.of.low) / (row.of.high - row.of.low), 0.0, 1.0);
  const double along = std::pow(share, 1.0 / row.exponent);
  row.slider->set_marks(1.0, 1.0, along);
  if (!row.slider->isSliderDown()) row.slider->setValue(static_cast<int>(std::lround(along * LimitSlider::steps)));
}

void ParameterPanel::set(const QString& name, double value) {
  for (const auto& row : rows_)
    if (QString::fromStdString(row->of.name) == name) {
      row->rest->stop();
      row->of.value = value;
      row->asked.start();
      show_value(*row, value);
    }
}

QWidget* ParameterPanel::first_control() const {
  if (rows_.empty()) return nullptr;
  const Row& first = *rows_.front();
  return first.slider ? static_cast<QWidget*>(first.slider.get()) : first.field.get();
}

}  // namespace skein::ui
