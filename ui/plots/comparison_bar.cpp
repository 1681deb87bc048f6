#include "ui/plots/comparison_bar.h"

#include <QEvent>
#include <QHBoxLayout>
#include <QLabel>
#include <QPainter>
#include <QPixmap>
#include <QSignalBlocker>
#include <QVBoxLayout>

#include "ui/base/compared.h"
#include "ui/base/palette.h"

namespace skein::ui {

ComparisonBar::ComparisonBar(QWidget* parent)
    : QWidget(parent), switches_(new QVBoxLayout), align_(new QComboBox(this)) {
  setObjectName(QStringLiteral("comparison_bar"));
  align_->setObjectName(QStringLiteral("compare_align"));
  align_->setAccessibleName(tr("What compared runs are aligned at"));
  align_->setToolTip(tr("Kick k of the other runs is drawn at the time of kick k of this one"));
  align_->addItem(tr("the start"));
  connect(align_, &QComboBox::activated, this, &ComparisonBar::align_wanted);
  auto* row = new QHBoxLayout;
  row->addWidget(new QLabel(tr("Aligned at"), this));
  row->addWidget(align_, 1);
  switches_->setSpacing(1);
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(6, 2, 6, 2);
  layout->setSpacing(2);
  layout->addLayout(switches_);
  layout->addLayout(row);
  hide();
}

void ComparisonBar::show_runs(const std::vector<Run>& runs) {
  while (buttons_.size() > runs.size()) {
    delete buttons_.back();
    buttons_.pop_back();
  }
  while (buttons_.size() < runs.size()) {
    const std::size_t k = buttons_.size();
    auto* button = new QToolButton(this);
    button->setObjectName(QStringLiteral("compared_%1").arg(compared_letter(k)));
    button->setCheckable(true);
    button->setAutoRaise(true);
    button->setFocusPolicy(Qt::StrongFocus);
    button->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
    button->setIconSize({36, 12});
    button->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);
    connect(button, &QToolButton::clicked, this, [this, k](bool on) { emit switched(static_cast<int>(k), on); });
    switches_->addWidget(button);
    buttons_.push_back(button);
  }
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const QString text = QStringLiteral("%1  %2").arg(compared_letter(k), runs[k].name);
    buttons_[k]->setText(text);
    buttons_[k]->setToolTip(tr("Draws this run, or leaves it out: %1").arg(runs[k].name));
    buttons_[k]->setAccessibleName(tr("Compared run %1").arg(text));
    buttons_[k]->setChecked(runs[k].shown);
  }
  dress();
  setVisible(!runs.empty());
}

void ComparisonBar::show_kicks(const std::vector<double>& kicks) {
  const QSignalBlocker quiet(align_);
  while (align_->count() > static_cast<int>(kicks.size()) + 1) align_->removeItem(align_->count() - 1);
  for (std::size_t k = 0; k < kicks.size(); ++k) {
    const QString text = tr("kick %1, at %2 s").arg(k + 1).arg(kicks[k], 0, 'f', 2);
    const int item = static_cast<int>(k) + 1;
    if (item < align_->count())
      align_->setItemText(item, text);
    else
      align_->addItem(text);
  }
}

/// The line of each run as the plots draw it.
void ComparisonBar::dress() {
  const Colours c = colours(palette());
  for (std::size_t k = 0; k < buttons_.size(); ++k) {
    QPixmap line(72, 24);
    line.setDevicePixelRatio(2.0);
    line.fill(Qt::transparent);
    QPainter painter(&line);
    painter.setPen(QPen(c.text, 2, compared_style(k)));
    painter.drawLine(QPointF(0, 6), QPointF(36, 6));
    painter.end();
    buttons_[k]->setIcon(QIcon(line));
  }
}

void ComparisonBar::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) dress();
  QWidget::changeEvent(event);
}

}  // namespace skein::ui
