#include "ui/results/result_panel.h"

#include <QClipboard>
#include <QGuiApplication>
#include <QHeaderView>
#include <QScrollArea>
#include <QScrollBar>
#include <QStyledItemDelegate>
#include <QVBoxLayout>
#include <algorithm>

#include "ui/base/flow_layout.h"
#include "ui/base/palette.h"

namespace skein::ui {
namespace {

/// A sentence lies across all columns that are seen: the one in which it begins need not hold it.
class AcrossColumns final : public QStyledItemDelegate {
 public:
  explicit AcrossColumns(QTableWidget* table) : QStyledItemDelegate(table), table_(table) {}
  static bool is_sentence(int row) { return row % 2 == 1; }
  QSize sizeHint(const QStyleOptionViewItem& option, const QModelIndex& index) const override {
    const QSize usual = QStyledItemDelegate::sizeHint(option, index);
    return is_sentence(index.row()) ? QSize(0, usual.height()) : usual;
  }
  void paint(QPainter* painter, const QStyleOptionViewItem& option, const QModelIndex& index) const override {
    QStyleOptionViewItem seen = option;
    if (is_sentence(index.row())) seen.rect.setWidth(std::min(option.rect.width(), table_->viewport()->width()));
    QStyledItemDelegate::paint(painter, seen, index);
  }

 private:
  const QTableWidget* table_;
};

}  // namespace

ResultPanel::ResultPanel(QWidget* parent)
    : QWidget(parent),
      table_(new QTableWidget(this)),
      rest_(new QLabel(this)),
      copy_text_(new QPushButton(tr("Copy"), this)),
      copy_latex_(new QPushButton(tr("Copy as LaTeX"), this)),
      save_(new QPushButton(tr("Save report"), this)) {
  setObjectName(QStringLiteral("results"));
  table_->setObjectName(QStringLiteral("result_table"));
  table_->setAccessibleName(tr("Results of every kick"));
  table_->setColumnCount(columns);
  table_->setHorizontalHeaderLabels({tr("t"), tr("Formation"), tr("Tracking"), tr("Closest"), tr("Error")});
  const QStringList tips{tr("When [s]"),
                         tr("Time until the distances in the formation stayed within 1 cm of their references"),
                         tr("Time until every robot stayed within 1 cm of its place"),
                         tr("The smallest distance of two robots until the next kick"),
                         tr("The largest distance of a robot from its reference until the next kick")};
  for (int k = 0; k < columns; ++k) table_->horizontalHeaderItem(k)->setToolTip(tips[k]);
  table_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setTabKeyNavigation(false);
  table_->setFrameShape(QFrame::NoFrame);
  table_->verticalHeader()->hide();
  table_->verticalHeader()->setDefaultSectionSize(fontMetrics().height() + 6);
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
  table_->setVerticalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  table_->setItemDelegateForColumn(0, new AcrossColumns(table_));
  table_->horizontalHeader()->setMinimumSectionSize(fontMetrics().horizontalAdvance(centimetres(0.999)) + 10);
  table_->horizontalHeader()->setSectionResizeMode(largest, QHeaderView::Stretch);  // sentences need the whole width
  rest_->setObjectName(QStringLiteral("result_text"));
  rest_->setTextFormat(Qt::RichText);
  rest_->setWordWrap(true);
  rest_->setContentsMargins(6, 2, 6, 2);
  rest_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  const auto button = [&](QPushButton* made, const char* name, const QString& tip) {
    made->setObjectName(QLatin1String(name));
    made->setAccessibleName(tip);
    made->setToolTip(tip);
  };
  button(copy_text_, "copy_results", tr("The results as text, to the clipboard"));
  button(copy_latex_, "copy_results_latex", tr("The table of kicks as LaTeX, to the clipboard"));
  button(save_, "save_results",
         tr("Saves the results as text and LaTeX, the run as CSV, its figures and a page for a browser, in a folder"));
  connect(save_, &QPushButton::clicked, this, &ResultPanel::save_wanted);
  connect(copy_text_, &QPushButton::clicked, this, [this] {
    if (results_) copy(as_text(name_, *results_, others_));
  });
  connect(copy_latex_, &QPushButton::clicked, this, [this] {
    if (results_) copy(as_latex(*results_, others_));
  });
  auto* inside = new QWidget;
  auto* content = new QVBoxLayout(inside);
  content->setContentsMargins(0, 0, 0, 0);
  content->setSpacing(2);
  content->addWidget(table_);
  content->addWidget(rest_);
  auto* buttons = new QWidget;
  auto* flow = new FlowLayout(buttons);  // a row of three would make a narrow panel wider than its place
  flow->setContentsMargins(6, 0, 6, 2);
  for (QPushButton* each : {copy_text_, copy_latex_, save_}) flow->addWidget(each);
  content->addWidget(buttons);
  content->addStretch();
  auto* scroll = new QScrollArea(this);
  scroll->setWidget(inside);
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->setFocusPolicy(Qt::NoFocus);
  connect(table_, &QTableWidget::currentItemChanged, scroll, [this, scroll](const QTableWidgetItem* current) {
    if (!current) return;
    const QPoint centre = table_->visualItemRect(current).center();
    scroll->ensureVisible(0, table_->viewport()->mapTo(scroll->widget(), centre).y());
  });
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(scroll);
}

void ResultPanel::show_experiment(const app::Experiment& experiment) {
  name_ = QString::fromStdString(experiment.name);
  results_ = std::make_unique<RunResults>(experiment);
  kept_.clear();
  timing_.clear();
  dirty_ = true;
  refresh();
}

void ResultPanel::show_record(const app::TickRecord& record) {
  if (!results_) return;
  results_->add_record(record);
  dirty_ = true;
}

void ResultPanel::compare(std::vector<RunBeside> others) {
  others_ = std::move(others);
  dirty_ = true;
  refresh();
}

void ResultPanel::refresh() {
  if (!dirty_ || !results_ || !isVisible()) return;
  dirty_ = false;
  show_kicks();
  show_rest();
}

void ResultPanel::show_kept(const QString& folder) {
  kept_ = folder;
  dirty_ = true;
}

void ResultPanel::show_timing(const QString& text) {
  if (text == timing_) return;
  timing_ = text;
  dirty_ = true;
}

void ResultPanel::show_kicks() {
  const std::vector<RunResults::Kick> kicks = results_->kicks();
  const std::vector<std::vector<KickBeside>> compared = ui::compare(kicks, others_);
  table_->setVisible(!kicks.empty());  // of none, a head would only take the room of the text
  const int rows = 2 * static_cast<int>(kicks.size());
  if (table_->rowCount() != rows) table_->clearSpans();
  table_->setRowCount(rows);
  const auto put = [this](int row, int column, const QString& text) {
    QTableWidgetItem* item = table_->item(row, column);
    if (!item) table_->setItem(row, column, item = new QTableWidgetItem);
    if (item->text() != text) item->setText(text);
    return item;
  };
  for (std::size_t k = 0; k < kicks.size(); ++k) {
    const RunResults::Kick& kick = kicks[k];
    const int numbers = 2 * static_cast<int>(k), sentences = numbers + 1;
    const QStringList cells{QString::number(kick.t, 'f', 2), settling_text(kick.formation),
                            settling_text(kick.tracking), centimetres(kick.closest), centimetres(kick.largest)};
    for (int column = 0; column < columns; ++column) put(numbers, column, cells[column]);
    QStringList said{tr("%1: %2").arg(kick.what, order_of(kick))};
    for (std::size_t o = 0; o < others_.size(); ++o)
      said << tr("Beside %1: %2").arg(others_[o].letter, beside_text(compared[o][k]));
    QString tip = kick.words;
    if (!others_.empty())
      tip += QLatin1Char('\n') +
             tr("Beside: the difference to the compared run's kick at the same time, or to the one in its place");
    put(sentences, 0, said.join(QLatin1Char('\n')))->setToolTip(tip);
    if (table_->columnSpan(sentences, 0) != columns) table_->setSpan(sentences, 0, 1, columns);
  }
  keep_sentences_whole();
}

/// Rows as high as their sentences, and a table as high as its rows: the panel scrolls as a whole.
void ResultPanel::keep_sentences_whole() {
  constexpr int beside = 12, above = 6;  // around a text [px]
  const QFontMetrics metrics = table_->fontMetrics();
  const int wide = table_->horizontalHeader()->length(), seen = table_->viewport()->width();
  const QRect room(0, 0, std::min(wide, seen) - beside, 0);
  int height = table_->horizontalHeader()->sizeHint().height() + 2 * table_->frameWidth();
  for (int row = 0; row < table_->rowCount(); ++row) {
    const bool sentences = AcrossColumns::is_sentence(row);
    const int text = sentences ? metrics.boundingRect(room, Qt::TextWordWrap, table_->item(row, 0)->text()).height()
                               : metrics.height();
    table_->setRowHeight(row, text + above);
    height += text + above;
  }
  if (wide > seen) height += table_->horizontalScrollBar()->sizeHint().height();
  table_->setFixedHeight(height);
}

void ResultPanel::show_rest() {
  const Colours c = colours(palette());
  QStringList lines;
  if (results_->empty())
    lines << tr("No run yet.");
  else
    lines << tr("Whole run: closest pair %1, largest error %2")
                 .arg(centimetres(results_->closest()), centimetres(results_->largest()));
  if (!timing_.isEmpty()) lines << timing_.toHtmlEscaped();
  if (!kept_.isEmpty()) lines << tr("Kept in %1").arg(kept_.toHtmlEscaped());
  for (const RunBeside& other : others_) lines << tr("Beside %1: %2").arg(other.letter, other.name.toHtmlEscaped());
  for (const RunResults::Expectation& expected : results_->expectations()) {
    if (!results_->is_over()) {
      lines << QStringLiteral("… ") + expected.what.toHtmlEscaped();
      continue;
    }
    const QColor colour = expected.holds() ? c.good : c.alarm;
    const QString mark = expected.holds() ? QStringLiteral("✓") : QStringLiteral("✗");
    lines << QStringLiteral("<span style=\"color:%1\">%2</span> %3")
                 .arg(colour.name(), mark,
                      (expected.holds() ? expected.what : expected.what + QStringLiteral(": ") + expected.found)
                          .toHtmlEscaped());
  }
  const QString text = lines.join(QStringLiteral("<br>"));
  if (rest_->text() != text) rest_->setText(text);
}

void ResultPanel::copy(const QString& text) {
  QGuiApplication::clipboard()->setText(text);
}

void ResultPanel::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) dirty_ = true;  // marks of other colours
  QWidget::changeEvent(event);
}

void ResultPanel::resizeEvent(QResizeEvent* event) {
  QWidget::resizeEvent(event);
  dirty_ = true;  // sentences take other lines
}

void ResultPanel::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  dirty_ = true;
  refresh();
}

}  // namespace skein::ui
