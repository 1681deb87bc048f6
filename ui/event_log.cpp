#include "ui/event_log.h"

#include <QApplication>
#include <QClipboard>
#include <QHeaderView>
#include <QKeyEvent>
#include <QRegularExpression>
#include <QScrollBar>
#include <algorithm>

namespace skein::ui {
namespace {

/// Numbers as people read them: the CSV has all their digits, and so has the tool tip.
QString shortened(QString text) {
  static const QRegularExpression long_number(QStringLiteral("-?\\d+\\.\\d{5,}"));
  for (QRegularExpressionMatch match = long_number.match(text); match.hasMatch(); match = long_number.match(text))
    text.replace(match.capturedStart(), match.capturedLength(), QString::number(match.captured().toDouble(), 'f', 4));
  return text;
}

}  // namespace

void EventModel::clear() {
  beginResetModel();
  lines_.clear();
  endResetModel();
}

void EventModel::add(double t, const QString& text, Severity severity) {
  if (static_cast<int>(lines_.size()) >= capacity) {
    beginRemoveRows({}, 0, 0);
    lines_.pop_front();
    endRemoveRows();
  }
  const int row = rowCount();
  beginInsertRows({}, row, row);
  lines_.push_back({t, text, severity});
  endInsertRows();
}

int EventModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(lines_.size());
}

QVariant EventModel::data(const QModelIndex& index, int role) const {
  if (!index.isValid()) return {};
  const Line& line = lines_[static_cast<std::size_t>(index.row())];
  if (role == Qt::DisplayRole) return index.column() == 0 ? tr("%1 s").arg(line.t, 0, 'f', 2) : shortened(line.text);
  if (role == Qt::ToolTipRole) return line.text;
  if (role == Qt::TextAlignmentRole && index.column() == 0) return static_cast<int>(Qt::AlignRight | Qt::AlignVCenter);
  if (role == Qt::ForegroundRole) {
    if (index.column() == 0) return colours_.faint_text;
    if (line.severity == Severity::note || line.severity == Severity::notice) return {};
    return colour(line.severity, colours_);
  }
  return {};
}

QVariant EventModel::headerData(int section, Qt::Orientation orientation, int role) const {
  if (orientation != Qt::Horizontal || role != Qt::DisplayRole) return {};
  return section == 0 ? tr("Time") : tr("Event");
}

EventLog::EventLog(QWidget* parent) : QTableView(parent) {
  setObjectName(QStringLiteral("event_log"));
  setAccessibleName(tr("Event log"));
  setModel(&model_);
  model_.set_colours(colours(palette()));
  setSelectionBehavior(SelectRows);
  setFrameShape(NoFrame);
  setShowGrid(false);
  setWordWrap(false);
  setTabKeyNavigation(false);
  verticalHeader()->hide();
  verticalHeader()->setDefaultSectionSize(fontMetrics().height() + 5);
  horizontalHeader()->hide();
  setColumnWidth(0, fontMetrics().horizontalAdvance(QStringLiteral("0000.00 s")) + 12);
  horizontalHeader()->setSectionResizeMode(1, QHeaderView::Stretch);
}

void EventLog::take(const app::TickRecord& record) {
  for (const app::Event& event : record.events)
    note(record.t, QString::fromStdString(app::describe(event)), severity(event));
  if (record.events.dropped() > 0) note(record.t, tr("+%1 more").arg(record.events.dropped()), Severity::note);
}

void EventLog::note(double t, const QString& text, Severity severity) {
  const bool at_end = verticalScrollBar()->value() >= verticalScrollBar()->maximum();
  model_.add(t, text, severity);
  if (at_end) scrollToBottom();
}

void EventLog::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) {
    model_.set_colours(colours(palette()));
    viewport()->update();
  }
  QTableView::changeEvent(event);
}

void EventLog::keyPressEvent(QKeyEvent* event) {
  if (!event->matches(QKeySequence::Copy)) return QTableView::keyPressEvent(event);
  QModelIndexList rows = selectionModel()->selectedRows();
  std::sort(rows.begin(), rows.end());
  QStringList lines;
  for (const QModelIndex& row : rows)
    lines << row.data().toString() + QLatin1Char('\t') + row.siblingAtColumn(1).data().toString();
  QApplication::clipboard()->setText(lines.join(QLatin1Char('\n')));
}

}  // namespace skein::ui
