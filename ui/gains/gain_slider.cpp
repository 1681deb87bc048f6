#include "ui/gains/gain_slider.h"

#include <QGridLayout>
#include <QPainter>
#include <QSignalBlocker>
#include <QStyle>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>

#include "app/run/event.h"
#include "ui/base/palette.h"
#include "ui/base/sentence.h"

namespace skein::ui {
namespace {

constexpr int settle_ms = 120;
constexpr int held_ms = 1000;   // after a key
constexpr int taken_ms = 1000;  // the session has taken a wish by then, and says where the gain goes
constexpr double room_beyond_limit = 1.25;

struct Words {
  const char *symbol, *unit, *role, *what;
};

Words words(core::GainName gain) {
  switch (gain) {
    case core::GainName::k_xx:
      return {"<i>k</i><sub>xx</sub>", "m/s", QT_TRANSLATE_NOOP("GainSlider", "forward"),
              QT_TRANSLATE_NOOP("GainSlider", "Coupling of the forward errors x_e")};
    case core::GainName::k_tt:
      return {"<i>k</i><sub>θθ</sub>", "rad/s", QT_TRANSLATE_NOOP("GainSlider", "heading"),
              QT_TRANSLATE_NOOP("GainSlider", "Coupling of the heading errors θ_e")};
    case core::GainName::k_yy:
      return {"<i>k</i><sub>yy</sub>", "rad/s", QT_TRANSLATE_NOOP("GainSlider", "sideways"),
              QT_TRANSLATE_NOOP("GainSlider", "Coupling of the sideways errors y_e")};
    case core::GainName::c_xx:
    case core::GainName::c_tt:
    case core::GainName::c_yy:
    case core::GainName::l_xx:
    case core::GainName::l_tt:
      break;  // slopes and weights have no slider
  }
  return {"", "", "", ""};
}

/// What makes room beyond the limit.
const char* way_on(core::GainName gain) {
  switch (gain) {
    case core::GainName::k_tt:
      return QT_TRANSLATE_NOOP("GainSlider", "For more, lower k_yy by as much: (18g) limits their sum.");
    case core::GainName::k_yy:
      return QT_TRANSLATE_NOOP("GainSlider", "For more, lower k_θθ by as much: (18g) limits their sum.");
    case core::GainName::k_xx:
    case core::GainName::c_xx:
    case core::GainName::c_tt:
    case core::GainName::c_yy:
    case core::GainName::l_xx:
    case core::GainName::l_tt:
      break;
  }
  return QT_TRANSLATE_NOOP("GainSlider", "For more, the reference has to be slower: (18f).");
}

/// Three digits of the largest value: with many robots gains are small.
int places_for(double top) {
  return std::clamp(2 - static_cast<int>(std::floor(std::log10(std::max(top, 1e-9)))), 4, 9);
}

}  // namespace

LimitSlider::LimitSlider(QWidget* parent) : QSlider(Qt::Horizontal, parent) {
  setRange(0, steps);
  setPageStep(steps / 20);
  setSingleStep(steps / 100);
}

void LimitSlider::set_marks(double limit, double limit_now, double now) {
  if (limit == limit_ && limit_now == limit_now_ && now == now_) return;
  limit_ = limit;
  limit_now_ = limit_now;
  now_ = now;
  update();
}

QSize LimitSlider::sizeHint() const {
  return {120, 26};
}

void LimitSlider::paintEvent(QPaintEvent*) {
  QPainter p(this);
  p.setRenderHint(QPainter::Antialiasing);
  const Colours c = colours(palette());
  constexpr double knob = 7.5;
  // The same way along the track as QSlider's own mouse handling takes: half a knob at either end.
  const QRectF track(knob, height() / 2.0 - 3, width() - 2 * knob, 6);
  const auto x = [&](double share) { return track.left() + std::clamp(share, 0.0, 1.0) * track.width(); };

  p.setPen(Qt::NoPen);
  p.setBrush(c.dark ? c.panel.lighter(170) : c.panel.darker(118));
  p.drawRoundedRect(track, 3, 3);
  const QColor loud = isEnabled() || limit_ > 0.0 ? c.alarm : c.faint_text;  // one robot has no gains
  QColor forbidden = loud;
  forbidden.setAlphaF(0.25F);
  p.setBrush(forbidden);
  p.drawRoundedRect(QRectF(QPointF(x(limit_), track.top()), track.bottomRight()), 3, 3);
  forbidden.setAlphaF(0.6F);
  p.setBrush(forbidden);
  p.drawRoundedRect(QRectF(QPointF(x(limit_now_), track.top()), track.bottomRight()), 3, 3);
  p.setBrush(isEnabled() ? c.accent : c.faint_text);
  p.drawRoundedRect(QRectF(track.topLeft(), QPointF(x(now_), track.bottom())), 3, 3);  // what holds now
  p.setPen(QPen(loud, 2));
  if (limit_ <= 1.0) p.drawLine(QPointF(x(limit_), track.top() - 5), QPointF(x(limit_), track.bottom() + 5));

  p.setPen(QPen(hasFocus() ? c.accent : c.axis, hasFocus() ? 2.0 : 1.2));
  p.setBrush(c.dark ? c.panel.lighter(240) : QColor(Qt::white));
  p.drawEllipse(QPointF(x(static_cast<double>(value()) / steps), track.center().y()), knob - 1, knob - 1);
}

void LimitSlider::wheelEvent(QWheelEvent* event) {
  // Scrolling past must not change a gain of driving robots.
  if (hasFocus())
    QSlider::wheelEvent(event);
  else
    event->ignore();
}

GainSlider::GainSlider(core::GainName gain, QWidget* parent)
    : QWidget(parent),
      gain_(gain),
      slider_(new LimitSlider(this)),
      spin_(new NumberField(this)),
      now_text_(new QLabel(this)),
      limit_text_(new QLabel(this)),
      advice_text_(new QLabel(this)) {
  spin_->setDecimals(places_for(top_));
  const Words w = words(gain);
  const QString name = QString::fromLatin1(core::word(gain).data());
  auto* symbol = new QLabel(QString::fromUtf8(w.symbol), this);
  symbol->setToolTip(tr(w.what));
  QFont font = symbol->font();
  font.setPointSizeF(font.pointSizeF() * 1.25);
  symbol->setFont(font);
  symbol->setMinimumWidth(34);

  slider_->setObjectName(QStringLiteral("slider_") + name);
  slider_->setAccessibleName(tr("%1 slider").arg(gain_symbol(gain)));
  spin_->setObjectName(QStringLiteral("spin_") + name);
  spin_->setAccessibleName(gain_symbol(gain));
  spin_->setSuffix(QStringLiteral(" ") + QString::fromLatin1(w.unit));
  spin_->setAlignment(Qt::AlignRight);
  now_text_->setObjectName(QStringLiteral("now_") + name);
  limit_text_->setObjectName(QStringLiteral("limit_") + name);
  advice_text_->setObjectName(QStringLiteral("advice_") + name);
  advice_text_->setWordWrap(true);
  advice_text_->hide();
  auto* role = new QLabel(tr(w.role), this);
  role->setToolTip(tr(w.what));

  auto* layout = new QGridLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->setHorizontalSpacing(6);
  layout->setVerticalSpacing(1);
  layout->addWidget(symbol, 0, 0);
  layout->addWidget(role, 0, 1);
  layout->addWidget(spin_, 0, 2);
  layout->addWidget(slider_, 1, 0, 1, 3);
  layout->addWidget(now_text_, 2, 0, 1, 2);
  layout->addWidget(limit_text_, 2, 2, Qt::AlignRight);
  layout->addWidget(advice_text_, 3, 0, 1, 3);
  layout->setColumnStretch(1, 1);

  rest_.setSingleShot(true);
  rest_.setInterval(settle_ms);
  connect(&rest_, &QTimer::timeout, this, [this] {
    asked_.start();
    emit wanted(gain_, spin_->value());
  });
  last_key_.setSingleShot(true);
  last_key_.setInterval(held_ms);
  connect(&last_key_, &QTimer::timeout, this, [this] {
    if (!slider_->isSliderDown()) emit let_go();
  });
  connect(slider_, &QSlider::valueChanged, this, [this](int step) {
    choose(top_ * step / LimitSlider::steps);
    if (!slider_->isSliderDown()) last_key_.start();
    emit held(gain_, spin_->value());
  });
  connect(slider_, &QSlider::sliderPressed, this, [this] { emit held(gain_, spin_->value()); });
  connect(slider_, &QSlider::sliderReleased, this, [this] {
    if (rest_.isActive()) rest_.start(0);
    last_key_.stop();
    emit let_go();
  });
  connect(spin_, &QDoubleSpinBox::valueChanged, this, [this](double value) { choose(value); });
  connect(spin_, &NumberField::refused, this,
          [this](const QString& why) { emit refused(QStringLiteral("%1: %2").arg(gain_symbol(gain_), why)); });
}

double GainSlider::half_a_step() const {
  return 0.5 * std::pow(10.0, -spin_->decimals());
}

QString GainSlider::gain_text(double value) const {
  return QString::number(value, 'f', spin_->decimals());
}

/// Never rounded up: what is shown as the limit is allowed.
QString GainSlider::limit_text(double value) const {
  if (!std::isfinite(value)) return QStringLiteral("–");
  constexpr double rounding = 1e-6;
  const double per_unit = std::pow(10.0, spin_->decimals());
  return gain_text(std::floor(value * per_unit + rounding) / per_unit);
}

void GainSlider::set_no_preview(const QString& why) {
  no_preview_ = why;
  show_text();
}

void GainSlider::note_held(double asked, double held) {
  held_back_ = {asked, held};
  show_text();
}

/// Of what is asked for now, or was when it was clamped, if that is still too much and the gain at its limit; else
/// empty.
QString GainSlider::advice() const {
  constexpr double rounding = 1e-9;
  const bool is_held = held_back_ && std::abs(spin_->value() - held_back_->at) < half_a_step() &&
                       std::abs(held_back_->at - limit_) < half_a_step();
  const double wanted = is_held ? held_back_->asked : spin_->value();
  // A gain at its limit is shown rounded, which may be above.
  if (!remedy_ || !std::isfinite(limit_) || wanted <= limit_ + (is_held ? rounding : half_a_step())) return {};
  const QString remedy = remedy_(wanted);
  if (remedy.isEmpty()) return {};
  return tr("%1 cannot be more than %2: %3").arg(gain_symbol(gain_), limit_text(limit_), remedy);
}

int GainSlider::step_of(double value) const {
  return static_cast<int>(std::lround(std::clamp(value / top_, 0.0, 1.0) * LimitSlider::steps));
}

void GainSlider::choose(double value) {
  if (value < 0.0) {
    emit refused(tr("%1 is clamped at 0, its limit: found %2").arg(gain_symbol(gain_)).arg(value));
    value = 0.0;
  }
  const QSignalBlocker quiet_slider(slider_), quiet_spin(spin_);
  spin_->setValue(value);
  if (!slider_->isSliderDown()) slider_->setValue(step_of(value));
  show_text();
  rest_.start();
}

void GainSlider::reset(double value, double limit) {
  rest_.stop();
  held_back_.reset();
  limit_ = limit_now_ = limit;
  set_range(std::fmax(limit, value) * room_beyond_limit);  // of two numbers, if the limit is known
  now_ = value;
  set_target(value);
  show_text();
}

void GainSlider::set_range(double top) {
  const QSignalBlocker quiet_slider(slider_), quiet_spin(spin_);
  // Two significant digits: a range that reads well, and steps that do.
  const double digit = top > 0 ? std::pow(10.0, std::floor(std::log10(top)) - 1) : 0.1;
  top_ = std::max(digit, std::ceil(top / digit) * digit);
  const double value = spin_->value();
  spin_->setDecimals(places_for(top_));
  spin_->updateGeometry();
  spin_->setSingleStep(digit);
  slider_->setValue(step_of(value));
}

void GainSlider::set_limit(double limit, double limit_now) {
  if (limit == limit_ && limit_now == limit_now_) return;
  limit_ = limit;
  limit_now_ = limit_now;
  if (limit > top_ && !slider_->isSliderDown()) set_range(limit * room_beyond_limit);
  show_text();
}

void GainSlider::set_now(double value) {
  if (value == now_) return;
  now_ = value;
  show_text();
}

void GainSlider::follow_target(double value) {
  const bool about_to_ask = slider_->isSliderDown() || rest_.isActive() || spin_->is_being_typed();
  const bool not_taken_yet = asked_.isValid() && !asked_.hasExpired(taken_ms);
  if (!about_to_ask && !not_taken_yet && std::abs(value - spin_->value()) > half_a_step()) set_target(value);
}

void GainSlider::set_target(double value) {
  if (slider_->isSliderDown() || rest_.isActive() || spin_->is_being_typed()) return;
  asked_.start();
  const QSignalBlocker quiet_slider(slider_), quiet_spin(spin_);
  spin_->setValue(value);
  slider_->setValue(step_of(value));
  show_text();
}

void GainSlider::show_text() {
  constexpr double nowhere = 2.0;  // on the track
  const auto mark = [&](double limit) { return std::isfinite(limit) ? limit / top_ : nowhere; };
  slider_->set_marks(mark(limit_), mark(limit_now_), now_ / top_);
  const bool on_its_way = std::abs(now_ - spin_->value()) > half_a_step();
  now_text_->setText(on_its_way ? tr("now %1 …").arg(gain_text(now_)) : tr("now %1").arg(gain_text(now_)));
  limit_text_->setText(tr("limit %1").arg(limit_text(limit_)));
  for (QLabel* text : {now_text_, limit_text_})  // alone, they do not name the gain
    text->setAccessibleName(gain_symbol(gain_) + QLatin1Char(' ') + text->text());
  limit_text_->setToolTip(tr("The largest value that (18f) and (18g) leave over the whole reference. At this moment "
                             "they would leave %1: the reference needs less here than elsewhere.")
                              .arg(limit_text(limit_now_)) +
                          QLatin1Char(' ') + tr(way_on(gain_)));
  const QString told = advice();
  advice_text_->setText(told);
  advice_text_->setVisible(!told.isEmpty());
  QString tip = tr("%1, for all pairs. Red: more than (18) allows now; pale red: more than it allows somewhere along "
                   "the reference.")
                    .arg(tr(words(gain_).what));
  if (!told.isEmpty()) tip += QStringLiteral(" %1.").arg(told);
  slider_->setToolTip(no_preview_.isEmpty() ? tip : tr("%1 No preview: %2.").arg(tip, no_preview_));
}

}  // namespace skein::ui
