#include "ui/gains/schedule_editor.h"

#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QLocale>
#include <QVBoxLayout>
#include <algorithm>
#include <utility>

#include "ui/base/number_field.h"
#include "ui/base/sentence.h"

namespace skein::ui {
namespace {

constexpr std::array keys{"t", "k_xx", "k_tt", "k_yy", "ramp"};

}  // namespace

void ScheduleModel::show(const app::Experiment& experiment) {
  const std::vector<app::GainChange>& changes = experiment.gain_changes;
  beginResetModel();
  for (const core::GainName gain : core::gain_names)
    start_[static_cast<std::size_t>(gain)] = core::table(experiment.controller.gains, gain).largest();
  rows_.clear();
  not_shown_ = false;
  for (const app::GainChange& change : changes) {
    std::array<std::optional<double>, columns> row;
    row[t] = change.t;
    row[ramp] = change.ramp;
    for (const core::GainName name : core::pair_names) {
      const std::optional<core::PairTable>& table = change[name];
      if (!table) continue;
      const bool has_column = name <= core::gain_names.back();
      if (has_column) row[k_xx + static_cast<std::size_t>(name)] = table->largest();
      not_shown_ = not_shown_ || !has_column || !table->uniform();  // what no column can hold
    }
    for (const core::TrackingGain name : core::tracking_names)
      not_shown_ = not_shown_ || !change.tracking[name].empty();
    rows_.push_back(row);
  }
  first_rows_ = rows_;
  endResetModel();
}

void ScheduleModel::take_back() {
  beginResetModel();
  rows_ = first_rows_;
  endResetModel();
}

void ScheduleModel::add(double at) {
  const int row = rowCount();
  beginInsertRows({}, row, row);
  std::array<std::optional<double>, columns> fresh;
  fresh[t] = at;
  for (const core::GainName gain : core::gain_names) {
    const std::size_t column = k_xx + static_cast<std::size_t>(gain);
    fresh[column] = start_[static_cast<std::size_t>(gain)];
    for (const auto& before : rows_)
      if (before[column]) fresh[column] = before[column];
  }
  fresh[ramp] = 2.0;
  rows_.push_back(fresh);
  endInsertRows();
  emit edited();
}

void ScheduleModel::remove(int row) {
  if (row < 0 || row >= rowCount()) return;
  beginRemoveRows({}, row, row);
  rows_.erase(rows_.begin() + row);
  endRemoveRows();
  emit edited();
}

QString ScheduleModel::as_toml() const {
  auto sorted = rows_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return *a[t] < *b[t]; });
  QStringList tables;
  for (const auto& row : sorted) {
    QStringList pairs;
    for (std::size_t k = 0; k < columns; ++k)
      if (row[k])
        pairs << QStringLiteral("%1 = %2").arg(QLatin1String(keys[k]),
                                               QString::number(*row[k], 'g', QLocale::FloatingPointShortest));
    tables << QStringLiteral("{ %1 }").arg(pairs.join(QStringLiteral(", ")));
  }
  return QStringLiteral("[%1]").arg(tables.join(QStringLiteral(", ")));
}

int ScheduleModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(rows_.size());
}

QVariant ScheduleModel::data(const QModelIndex& index, int role) const {
  if (!index.isValid()) return {};
  const auto& cell = rows_[static_cast<std::size_t>(index.row())][static_cast<std::size_t>(index.column())];
  if (role == Qt::TextAlignmentRole) return static_cast<int>(Qt::AlignRight | Qt::AlignVCenter);
  if (role != Qt::DisplayRole && role != Qt::EditRole) return {};
  return cell ? QVariant(QString::number(*cell, 'g', 6)) : QVariant(QString());
}

bool ScheduleModel::setData(const QModelIndex& index, const QVariant& value, int role) {
  if (!index.isValid() || role != Qt::EditRole) return false;
  const QString text = value.toString().trimmed();
  const bool may_be_empty = index.column() != t && index.column() != ramp;
  const auto number = parse_number(text);
  if (!(text.isEmpty() && may_be_empty) && !(number && *number >= 0.0)) {
    const QString column = headerData(index.column(), Qt::Horizontal, Qt::DisplayRole).toString();
    const QString allowed = may_be_empty ? tr("a number of at least 0, or nothing") : tr("a number of at least 0");
    emit refused(tr("Schedule, %1: %2").arg(column, why_refused(text, allowed)));
    return false;
  }
  auto& cell = rows_[static_cast<std::size_t>(index.row())][static_cast<std::size_t>(index.column())];
  cell = text.isEmpty() ? std::nullopt : number;
  emit dataChanged(index, index);
  emit edited();
  return true;
}

QVariant ScheduleModel::headerData(int section, Qt::Orientation orientation, int role) const {
  if (orientation != Qt::Horizontal) return {};
  if (role == Qt::DisplayRole)
    return section == t      ? tr("t [s]")
           : section == ramp ? tr("ramp [s]")
                             : gain_symbol(core::gain_names[static_cast<std::size_t>(section - k_xx)]);
  if (role == Qt::ToolTipRole)
    return section == t      ? tr("When the change begins")
           : section == ramp ? tr("How long it takes: Theorem 1 requires continuous gains")
                             : tr("Its new value for all pairs; empty: unchanged");
  return {};
}

Qt::ItemFlags ScheduleModel::flags(const QModelIndex& index) const {
  return QAbstractTableModel::flags(index) | Qt::ItemIsEditable;
}

ScheduleEditor::ScheduleEditor(QWidget* parent)
    : QWidget(parent),
      table_(new QTableView(this)),
      add_(new QPushButton(tr("Add"), this)),
      remove_(new QPushButton(tr("Remove"), this)),
      apply_(new QPushButton(tr("Apply"), this)) {
  setObjectName(QStringLiteral("schedule"));
  table_->setObjectName(QStringLiteral("schedule_table"));
  table_->setAccessibleName(tr("Changes of the gains during the run"));
  table_->setModel(&model_);
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setSelectionMode(QAbstractItemView::SingleSelection);
  table_->setTabKeyNavigation(false);
  table_->verticalHeader()->hide();
  table_->verticalHeader()->setDefaultSectionSize(fontMetrics().height() + 8);
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::Stretch);
  table_->horizontalHeader()->setMinimumSectionSize(20);
  for (const int column : {ScheduleModel::t, ScheduleModel::ramp})
    table_->horizontalHeader()->setSectionResizeMode(column, QHeaderView::ResizeToContents);
  const auto button = [](QPushButton* b, const QString& name, const QString& tip) {
    b->setObjectName(name);
    b->setAccessibleName(QString(b->text()));
    b->setToolTip(tip);
  };
  button(add_, QStringLiteral("schedule_add"), tr("Another change, after the last"));
  button(remove_, QStringLiteral("schedule_remove"), tr("Removes the selected change"));
  button(apply_, QStringLiteral("schedule_apply"), tr("Sets the experiment up again with this schedule"));

  auto* row = new QHBoxLayout;
  row->setSpacing(4);
  row->addWidget(add_);
  row->addWidget(remove_);
  row->addStretch();
  row->addWidget(apply_);
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 4, 0, 0);
  layout->setSpacing(4);
  auto* what = new QLabel(tr("From t on, each gain moves to its new value within the ramp; empty: unchanged."), this);
  what->setWordWrap(true);
  layout->addWidget(table_, 1);
  layout->addWidget(what);
  layout->addLayout(row);

  connect(&model_, &ScheduleModel::edited, this, [this] {
    edited_ = true;
    dress();
  });
  connect(&model_, &ScheduleModel::refused, this, &ScheduleEditor::refused);
  connect(add_, &QPushButton::clicked, this, [this] {
    const int last = model_.rowCount() - 1;
    model_.add(last < 0 ? 10.0 : model_.index(last, ScheduleModel::t).data(Qt::EditRole).toDouble() + 10.0);
  });
  connect(remove_, &QPushButton::clicked, this, [this] { model_.remove(table_->currentIndex().row()); });
  connect(apply_, &QPushButton::clicked, this, [this] { emit wanted(model_.as_toml()); });
  connect(table_->selectionModel(), &QItemSelectionModel::currentRowChanged, this, [this] { dress(); });
  dress();
}

void ScheduleEditor::show_experiment(const app::Experiment& experiment) {
  model_.show(experiment);
  edited_ = false;
  dress();
}

void ScheduleEditor::set_editable(bool editable) {
  if (editable == editable_) return;
  editable_ = editable;
  if (!editable && std::exchange(edited_, false)) {  // the run goes without them, and so does what is shown of it
    model_.take_back();
    emit refused(tr("The changed schedule was not applied: this run has the one before"));
  }
  dress();
}

void ScheduleEditor::dress() {
  const bool possible = editable_ && !model_.has_more();
  setToolTip(model_.has_more()
                 ? tr("It holds more than a value for all pairs of k_xx, k_θθ and k_yy: edit the experiment file")
             : editable_ ? QString()
                         : tr("A schedule can be changed before the start only"));
  table_->setEditTriggers(possible ? QAbstractItemView::DoubleClicked | QAbstractItemView::EditKeyPressed |
                                         QAbstractItemView::AnyKeyPressed
                                   : QAbstractItemView::NoEditTriggers);
  add_->setEnabled(possible);
  remove_->setEnabled(possible && table_->currentIndex().isValid());
  apply_->setEnabled(possible && edited_);
}

}  // namespace skein::ui
