#include "ui/status/event_log.h"

#include <QAbstractItemView>
#include <QApplication>
#include <QClipboard>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QKeyEvent>
#include <QRegularExpression>
#include <QScrollBar>
#include <QVBoxLayout>
#include <algorithm>

#include "ui/base/number_text.h"
#include "ui/base/sentence.h"

namespace skein::ui {
namespace {

constexpr int settles_ms = 50;  // while a panel is being drawn wider, sentences need not be laid out at every step

/// Numbers as people read them: the CSV has all their digits, and so has the tool tip.
QString shortened(QString text) {
  static const QRegularExpression long_number(QStringLiteral("-?\\d+\\.\\d{5,}"));
  for (QRegularExpressionMatch match = long_number.match(text); match.hasMatch(); match = long_number.match(text))
    text.replace(match.capturedStart(), match.capturedLength(), fixed(match.captured().toDouble(), 4));
  return text;
}

constexpr QChar may_break(0x200B);  // a blank of no width

/// Long words, such as the names of files, may go on in the next line.
QString breakable(const QString& text) {
  static const QRegularExpression long_word(QStringLiteral("\\S{16,}")), joint(QStringLiteral("([/_.-])"));
  QString broken;
  qsizetype done = 0;
  for (auto words = long_word.globalMatch(text); words.hasNext();) {
    const QRegularExpressionMatch word = words.next();
    broken +=
        text.mid(done, word.capturedStart() - done) + word.captured().replace(joint, QStringLiteral("\\1") + may_break);
    done = word.capturedEnd();
  }
  return broken + text.mid(done);
}

}  // namespace

void EventModel::clear() {
  beginResetModel();
  lines_.clear();
  endResetModel();
}

void EventModel::add(double t, const QString& text, Severity severity, const QString& word) {
  if (static_cast<int>(lines_.size()) >= capacity) {
    beginRemoveRows({}, 0, 0);
    lines_.pop_front();
    endRemoveRows();
  }
  const int row = rowCount();
  beginInsertRows({}, row, row);
  lines_.push_back({t, text, severity, word});
  endInsertRows();
}

int EventModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(lines_.size());
}

QVariant EventModel::data(const QModelIndex& index, int role) const {
  if (!index.isValid()) return {};
  const Line& line = lines_[static_cast<std::size_t>(index.row())];
  const int column = index.column();
  switch (role) {
    case Qt::DisplayRole:
      return column == time    ? tr("%1 s").arg(line.t, 0, 'f', 2)
             : column == level ? symbol(line.severity)
                               : breakable(shortened(line.text));
    case Qt::ToolTipRole:
      if (column == level) return severity_text(line.severity);
      return line.word.isEmpty() ? line.text : tr("%1\nIn the CSV: %2").arg(line.text, line.word);
    case Qt::AccessibleTextRole:
      return column == level   ? severity_text(line.severity)
             : column == event ? QVariant(shortened(line.text))
                               : QVariant();
    case Qt::TextAlignmentRole:
      if (column == time) return static_cast<int>(Qt::AlignRight | Qt::AlignVCenter);
      return column == level ? QVariant(Qt::AlignCenter) : QVariant();
    case Qt::ForegroundRole:
      if (column == time) return colours_.faint_text;
      if (column == event && (line.severity == Severity::note || line.severity == Severity::notice)) return {};
      return colour(line.severity, colours_);
    case time_role:
      return line.t;
    case severity_role:
      return static_cast<int>(line.severity);
    default:
      return {};
  }
}

QVariant EventModel::headerData(int section, Qt::Orientation orientation, int role) const {
  if (orientation != Qt::Horizontal || role != Qt::DisplayRole) return {};
  return section == time ? tr("Time") : section == level ? tr("Level") : tr("Event");
}

void EventFilter::set_least(Severity least) {
  begin_change();
  least_ = least;
  end_change();
}

void EventFilter::set_words(const QString& words) {
  begin_change();
  words_ = words.trimmed();
  end_change();
}

// Qt 6.10 deprecates the only way that older versions have.
#if QT_VERSION >= QT_VERSION_CHECK(6, 10, 0)
void EventFilter::begin_change() {
  beginFilterChange();
}

void EventFilter::end_change() {
  endFilterChange(Direction::Rows);
}
#else
void EventFilter::begin_change() {}

void EventFilter::end_change() {
  invalidateRowsFilter();
}
#endif

bool EventFilter::filterAcceptsRow(int row, const QModelIndex& parent) const {
  const QModelIndex line = sourceModel()->index(row, EventModel::event, parent);
  return line.data(EventModel::severity_role).toInt() >= static_cast<int>(least_) &&
         (words_.isEmpty() || line.data(Qt::ToolTipRole).toString().contains(words_, Qt::CaseInsensitive));
}

EventLog::EventLog(QWidget* parent) : QTableView(parent) {
  setObjectName(QStringLiteral("event_log"));
  setAccessibleName(tr("Event log"));
  filter_.setSourceModel(&model_);
  setModel(&filter_);
  model_.set_colours(colours(palette()));
  setSelectionBehavior(SelectRows);
  setFrameShape(NoFrame);
  setShowGrid(false);
  setWordWrap(true);
  setTabKeyNavigation(false);
  verticalHeader()->hide();
  verticalHeader()->setDefaultSectionSize(fontMetrics().height() + 5);
  horizontalHeader()->hide();
  setColumnWidth(EventModel::time, fontMetrics().horizontalAdvance(QStringLiteral("0000.00 s")) + 12);
  setColumnWidth(EventModel::level, fontMetrics().height() + 6);
  horizontalHeader()->setMinimumSectionSize(10);
  horizontalHeader()->setSectionResizeMode(EventModel::event, QHeaderView::Stretch);
  connect(&filter_, &QAbstractItemModel::rowsInserted, this,
          [this](const QModelIndex&, int first, int last) { fit_rows(first, last); });
  narrowed_.setSingleShot(true);
  narrowed_.setInterval(settles_ms);
  connect(&narrowed_, &QTimer::timeout, this, [this] { fit_rows(0, filter_.rowCount() - 1); });
  connect(horizontalHeader(), &QHeaderView::sectionResized, this, [this](int section, int before, int now) {
    if (section == EventModel::event && before != now) narrowed_.start();
  });
  connect(this, &QTableView::activated, this,
          [this](const QModelIndex& index) { emit time_picked(index.data(EventModel::time_role).toDouble()); });
}

void EventLog::fit_rows(int first, int last) {
  const bool at_end = verticalScrollBar()->value() >= verticalScrollBar()->maximum();
  for (int row = first; row <= last; ++row) resizeRowToContents(row);
  if (at_end) scrollToBottom();
}

void EventLog::note(double t, const QString& text, Severity severity, const QString& word) {
  const bool at_end = verticalScrollBar()->value() >= verticalScrollBar()->maximum();
  model_.add(t, text, severity, word);
  if (at_end) scrollToBottom();
}

EventPanel::EventPanel(QWidget* parent)
    : QWidget(parent), level_(new QComboBox(this)), words_(new QLineEdit(this)), log_(new EventLog(this)) {
  setObjectName(QStringLiteral("events"));
  level_->setObjectName(QStringLiteral("event_level"));
  level_->setAccessibleName(tr("Which events are shown"));
  level_->addItem(tr("Everything"), static_cast<int>(Severity::note));
  level_->addItem(tr("Notices and above"), static_cast<int>(Severity::notice));
  level_->addItem(tr("Warnings and above"), static_cast<int>(Severity::warning));
  level_->addItem(tr("Alarms"), static_cast<int>(Severity::alarm));
  level_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  level_->setMinimumContentsLength(8);  // the list itself is as wide as its words
  level_->view()->setMinimumWidth(level_->fontMetrics().horizontalAdvance(tr("Warnings and above")) + 40);
  words_->setObjectName(QStringLiteral("event_words"));
  words_->setAccessibleName(tr("Words that an event must contain"));
  words_->setPlaceholderText(tr("Filter: r2, gain …"));
  words_->setClearButtonEnabled(true);
  connect(level_, &QComboBox::currentIndexChanged, this,
          [this] { log_->filter().set_least(static_cast<Severity>(level_->currentData().toInt())); });
  connect(words_, &QLineEdit::textChanged, this, [this](const QString& words) { log_->filter().set_words(words); });
  connect(log_, &EventLog::time_picked, this, &EventPanel::time_picked);

  auto* row = new QHBoxLayout;
  row->setContentsMargins(6, 2, 6, 2);
  row->addWidget(level_);
  row->addWidget(words_, 1);
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->setSpacing(0);
  layout->addLayout(row);
  layout->addWidget(log_, 1);
}

void EventPanel::show_record(const app::TickRecord& record, const std::vector<app::RobotStatus>& robots) {
  for (const app::Event& event : record.events)
    log_->note(record.t, sentence(event, robots), severity(event), QString::fromStdString(app::describe(event)));
  if (record.events.dropped() > 0) note(record.t, tr("+%1 more").arg(record.events.dropped()), Severity::note);
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
    lines << row.data().toString() + QLatin1Char('\t') + row.siblingAtColumn(EventModel::event).data().toString();
  QApplication::clipboard()->setText(lines.join(QLatin1Char('\n')).remove(may_break));
}

}  // namespace skein::ui
