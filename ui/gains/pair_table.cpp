#include "ui/gains/pair_table.h"

#include <QHeaderView>
#include <QKeyEvent>
#include <QStyledItemDelegate>
#include <QVBoxLayout>
#include <algorithm>

#include "app/run/event.h"
#include "ui/base/number_field.h"
#include "ui/base/sentence.h"
#include "ui/base/signal_drag.h"

namespace skein::ui {
namespace {

/// Both halves are the same pairs: the upper one shows the values, the lower one the ticks, so that both find room.
class HalfAndHalf final : public QStyledItemDelegate {
 public:
  using QStyledItemDelegate::QStyledItemDelegate;

 protected:
  void initStyleOption(QStyleOptionViewItem* option, const QModelIndex& index) const override {
    QStyledItemDelegate::initStyleOption(option, index);
    if (index.row() < index.column())
      option->features &= ~QStyleOptionViewItem::HasCheckIndicator;
    else
      option->text.clear();
    option->displayAlignment = Qt::AlignCenter;
    option->decorationAlignment = Qt::AlignCenter;
  }
};

}  // namespace

void PairModel::show_robots(std::size_t robots) {
  beginResetModel();
  robots_ = robots;
  pairs_.assign(robots * robots, {});
  endResetModel();
}

void PairModel::show_gain(core::GainName gain) {
  gain_ = gain;
}

bool PairModel::refresh(const Ask& ask) {
  bool changed = false;
  for (std::size_t i = 0; i < robots_; ++i)
    for (std::size_t j = i + 1; j < robots_; ++j) {
      const Pair fresh = ask(gain_, i, j);
      if (at(i, j) == fresh) continue;
      at(i, j) = fresh;
      changed = true;
      for (const auto& [row, column] : {std::pair{i, j}, std::pair{j, i}}) {
        const QModelIndex cell = index(static_cast<int>(row), static_cast<int>(column));
        emit dataChanged(cell, cell);
      }
    }
  return changed;
}

void PairModel::set_colours(const Colours& colours) {
  colours_ = colours;
  if (robots_ > 0) emit dataChanged(index(0, 0), index(rowCount() - 1, rowCount() - 1));
}

int PairModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(robots_);
}

QVariant PairModel::data(const QModelIndex& index, int role) const {
  if (!index.isValid()) return {};
  const auto i = static_cast<std::size_t>(index.row()), j = static_cast<std::size_t>(index.column());
  if (i == j) return role == Qt::BackgroundRole ? QVariant(colours_.grid) : QVariant();
  const Pair& pair = at(i, j);
  switch (role) {
    case Qt::DisplayRole:
      return pair.coupled ? QString::number(pair.target, 'g', 3) : tr("off");
    case Qt::EditRole:
      return QString::number(pair.target, 'g', 6);
    case Qt::CheckStateRole:
      return pair.coupled ? Qt::Checked : Qt::Unchecked;
    case Qt::ForegroundRole:
      return pair.coupled ? QVariant() : QVariant(colours_.faint_text);
    case Qt::ToolTipRole:
      return tr("%1 of robots %2 and %3: %4, at most %5 beside the others.\nValues are above the diagonal: "
                "double-click or F2 changes one. Ticks are below it: a click or X switches the whole coupling off and "
                "on.")
          .arg(gain_symbol(gain_))
          .arg(i + 1)
          .arg(j + 1)
          .arg(pair.coupled ? QString::number(pair.target, 'g', 4) : tr("switched off"))
          .arg(pair.limit, 0, 'g', 4);
    case plotted_role:
      return QStringList{QString::fromLatin1(core::word(gain_).data())};
    case Qt::AccessibleTextRole:
      return tr("Robots %1 and %2: %3").arg(i + 1).arg(j + 1).arg(data(index, Qt::DisplayRole).toString());
    default:
      return {};
  }
}

bool PairModel::setData(const QModelIndex& index, const QVariant& value, int role) {
  if (fixed_ || !index.isValid() || index.row() == index.column()) return false;
  const int i = std::min(index.row(), index.column()), j = std::max(index.row(), index.column());
  if (role == Qt::CheckStateRole) {
    emit couple_wanted(i, j, value.toInt() == Qt::Checked);
    return true;
  }
  if (role != Qt::EditRole) return false;
  const auto number = parse_number(value.toString());
  if (!number || *number < 0.0) {
    emit refused(tr("%1 of robots %2 and %3: %4")
                     .arg(gain_symbol(gain_))
                     .arg(i + 1)
                     .arg(j + 1)
                     .arg(why_refused(value.toString(), tr("a number of at least 0"))));
    return false;
  }
  emit gain_wanted(gain_, i, j, *number);
  return true;
}

QVariant PairModel::headerData(int section, Qt::Orientation, int role) const {
  const auto robot = static_cast<std::size_t>(section);
  if (role == Qt::DisplayRole) return QString::number(section + 1);
  if (role == Qt::ForegroundRole) return colours_.robot(robot);
  if (role == Qt::TextAlignmentRole) return Qt::AlignCenter;
  return {};
}

Qt::ItemFlags PairModel::flags(const QModelIndex& index) const {
  if (index.row() == index.column()) return Qt::ItemIsEnabled;
  if (fixed_) return Qt::ItemIsEnabled | Qt::ItemIsSelectable;
  const Pair& pair = at(static_cast<std::size_t>(index.row()), static_cast<std::size_t>(index.column()));
  const Qt::ItemFlags flags = Qt::ItemIsEnabled | Qt::ItemIsSelectable | Qt::ItemIsUserCheckable;
  return pair.coupled ? flags | Qt::ItemIsEditable : flags;
}

PairTable::PairTable(QWidget* parent) : QWidget(parent), gain_(new QComboBox(this)), table_(new QTableView(this)) {
  setObjectName(QStringLiteral("pairs"));
  gain_->setObjectName(QStringLiteral("pair_gain"));
  gain_->setAccessibleName(tr("Which gain the table shows"));
  for (const core::GainName gain : core::gain_names) gain_->addItem(gain_symbol(gain));
  connect(gain_, &QComboBox::currentIndexChanged, this,
          [this](int k) { model_.show_gain(core::gain_names[static_cast<std::size_t>(k)]); });

  table_->setObjectName(QStringLiteral("pair_table"));
  table_->setAccessibleName(tr("Gains of every pair of robots"));
  table_->setModel(&model_);
  table_->setItemDelegate(new HalfAndHalf(table_));
  table_->setTabKeyNavigation(false);
  table_->setFrameShape(QFrame::NoFrame);
  table_->setSelectionMode(QAbstractItemView::SingleSelection);
  table_->setEditTriggers(QAbstractItemView::DoubleClicked | QAbstractItemView::EditKeyPressed);
  keep_values_whole();
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::Stretch);
  table_->verticalHeader()->setDefaultSectionSize(fontMetrics().height() + 8);
  table_->installEventFilter(this);
  model_.set_colours(colours(palette()));
  connect(&model_, &PairModel::gain_wanted, this, &PairTable::gain_wanted);
  connect(&model_, &PairModel::couple_wanted, this, &PairTable::couple_wanted);
  connect(&model_, &PairModel::refused, this, &PairTable::refused);

  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 4, 0, 0);
  layout->setSpacing(4);
  layout->addWidget(gain_);
  layout->addWidget(table_, 1);
}

void PairTable::show_robots(std::size_t robots) {
  model_.show_robots(robots);
}

void PairTable::refresh(const PairModel::Ask& ask) {
  if (model_.refresh(ask)) keep_values_whole();
}

void PairTable::keep_values_whole() {
  constexpr int beside = 8;  // of a cell's text
  int widest = fontMetrics().horizontalAdvance(QStringLiteral("0.0000"));
  for (int row = 0; row < model_.rowCount(); ++row)
    for (int column = row + 1; column < model_.columnCount(); ++column)
      widest = std::max(widest, fontMetrics().horizontalAdvance(model_.index(row, column).data().toString()));
  table_->horizontalHeader()->setMinimumSectionSize(widest + beside);
}

void PairTable::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) model_.set_colours(colours(palette()));
  QWidget::changeEvent(event);
}

/// X switches the pair of the current cell: Space, which would do that elsewhere, is STOP here.
bool PairTable::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() != QEvent::KeyPress || static_cast<QKeyEvent*>(event)->key() != Qt::Key_X)
    return QWidget::eventFilter(watched, event);
  const QModelIndex cell = table_->currentIndex();
  if (cell.isValid() && cell.row() != cell.column())
    model_.setData(cell, cell.data(Qt::CheckStateRole).toInt() == Qt::Checked ? Qt::Unchecked : Qt::Checked,
                   Qt::CheckStateRole);
  return true;
}

}  // namespace skein::ui
