#include "ui/gains/margin_bars.h"

#include <QPainter>
#include <algorithm>
#include <cmath>

#include "ui/base/number_text.h"
#include "ui/base/palette.h"
#include "ui/base/told.h"

namespace skein::ui {
namespace {

constexpr double number_column = 22, gap = 8;

}  // namespace

MarginBars::MarginBars(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("margins"));
  tell(this, QAccessible::Graphic, [this] { return spoken(); });
  setAccessibleName(tr("Authority left to tracking"));
  setToolTip(
      tr("What the reference and the couplings leave to tracking: k_x of v_max (18f), k_θ of ω_max (18g).\n"
         "Stronger couplings, shorter bars. An empty bar means that (18) no longer holds."));
  setSizePolicy(QSizePolicy::Preferred, QSizePolicy::Fixed);
}

void MarginBars::show_experiment(const app::Experiment& experiment) {
  robots_ = experiment.robots.size();
  limits_.clear();
  for (std::size_t i = 0; i < robots_; ++i) limits_.push_back(app::make_limits(experiment, i));
  forward_.clear();
  turning_.clear();
  updateGeometry();
  update();
}

void MarginBars::show_record(const app::TickRecord& record) {
  constexpr double rounding = 1e-9;
  forward_.clear();
  turning_.clear();
  for (std::size_t i = 0; i < std::min(record.robots.size(), limits_.size()); ++i) {
    const app::RobotRecord& robot = record.robots[i];
    forward_.push_back({robot.k_x, limits_[i].v_max, robot.k_x > 0 && robot.margins.f >= -rounding});
    turning_.push_back({robot.k_theta, limits_[i].omega_max, robot.k_theta > 0 && robot.margins.g >= -rounding});
  }
  update();
}

QString MarginBars::spoken() const {
  const auto left = [](const Bar& bar) {
    return bar.holds ? tr("%1, %2 %").arg(fixed(bar.left, 4), fixed(100 * bar.left / bar.of, 0))
                     : tr("%1, (18) does not hold").arg(fixed(bar.left, 4));
  };
  QStringList robots;
  for (std::size_t i = 0; i < forward_.size(); ++i)
    robots << tr("Robot %1: k_x %2; k_θ %3").arg(i + 1).arg(left(forward_[i]), left(turning_[i]));
  return robots.join(QStringLiteral(". "));
}

QSize MarginBars::sizeHint() const {
  const int line = fontMetrics().height();
  return {230, static_cast<int>(robots_ + 1) * (line + 5)};
}

void MarginBars::paintEvent(QPaintEvent*) {
  QPainter p(this);
  p.setRenderHint(QPainter::Antialiasing);
  const Colours c = colours(palette());
  const double line = fontMetrics().height() + 5;
  const double width = (this->width() - number_column - gap) / 2;
  const double first = number_column, second = number_column + width + gap;
  p.setPen(c.faint_text);
  p.drawText(QRectF(first, 0, width, line), Qt::AlignVCenter, tr("k_x (18f), m/s"));
  p.drawText(QRectF(second, 0, width, line), Qt::AlignVCenter, tr("k_θ (18g), rad/s"));
  for (std::size_t i = 0; i < robots_; ++i) {
    const double top = line * static_cast<double>(i + 1);
    const QColor robot = c.robot(i);
    p.setPen(Qt::NoPen);
    p.setBrush(robot);
    p.drawEllipse(QPointF(9, top + line / 2), 8.5, 8.5);
    p.setPen(ink_on(robot));
    p.drawText(QRectF(0, top, 18, line), Qt::AlignCenter, QString::number(i + 1));
    if (i >= forward_.size()) continue;
    paint_bar(p, QRectF(first, top + 2, width, line - 4), forward_[i], c);
    paint_bar(p, QRectF(second, top + 2, width, line - 4), turning_[i], c);
  }
}

void MarginBars::paint_bar(QPainter& p, const QRectF& where, const Bar& bar, const Colours& c) const {
  const double share = std::clamp(bar.left / bar.of, 0.0, 1.0);
  p.setPen(Qt::NoPen);
  p.setBrush(c.dark ? c.panel.lighter(140) : c.panel.darker(108));
  p.drawRoundedRect(where, 3, 3);
  QColor fill = !bar.holds ? c.alarm : share < 0.1 ? c.warning : c.good;
  fill.setAlphaF(c.dark ? 0.55F : 0.40F);  // the number on it stays readable
  p.setBrush(fill);
  p.drawRoundedRect(QRectF(where.topLeft(), QSizeF(where.width() * share, where.height())), 3, 3);
  p.setPen(bar.holds ? c.text : c.alarm);
  const QString number = fixed(bar.left, bar.of < 1 ? 4 : 3);
  p.drawText(where.adjusted(5, 0, -5, 0), Qt::AlignVCenter | Qt::AlignLeft,
             bar.holds ? number : tr("%1 !").arg(number));
  p.drawText(where.adjusted(5, 0, -5, 0), Qt::AlignVCenter | Qt::AlignRight,
             QStringLiteral("%1 %").arg(fixed(100 * bar.left / bar.of, 0)));
}

}  // namespace skein::ui
