#include "ui/results/result_panel.h"

#include <QClipboard>
#include <QGuiApplication>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QScrollArea>
#include <QScrollBar>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "ui/base/palette.h"

namespace skein::ui {
namespace {

/// "1.5 s earlier", "0.6 s later", "alike"
QString difference(const std::optional<double>& here, const std::optional<double>& there) {
  if (!here || !there) return QStringLiteral("–");
  const double later = *here - *there;
  if (std::abs(later) < 0.005) return ResultPanel::tr("alike");
  return later < 0.0 ? ResultPanel::tr("%1 s earlier").arg(-later, 0, 'f', 2)
                     : ResultPanel::tr("%1 s later").arg(later, 0, 'f', 2);
}

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
  table_->setHorizontalHeaderLabels(
      {tr("t"), tr("Kick"), tr("Formation"), tr("Tracking"), tr("Order"), tr("Closest"), tr("Error"), tr("Beside")});
  const QStringList tips{tr("When [s]"),
                         tr("The kick"),
                         tr("Time until the distances in the formation stayed within 1 cm of their references"),
                         tr("Time until every robot stayed within 1 cm of its place"),
                         tr("What settled first, and by how much"),
                         tr("The smallest distance of two robots until the next kick"),
                         tr("The largest distance of a robot from its reference until the next kick"),
                         tr("Difference to the compared run's kick at the same time, or to the one in its place")};
  for (int k = 0; k < columns; ++k) table_->horizontalHeaderItem(k)->setToolTip(tips[k]);
  table_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setTabKeyNavigation(false);
  table_->setFrameShape(QFrame::NoFrame);
  table_->verticalHeader()->hide();
  table_->verticalHeader()->setDefaultSectionSize(fontMetrics().height() + 6);
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
  // First the numbers: a narrow panel has no room for the sentences as well.
  for (const int sentence : {1, 4}) {
    QHeaderView* header = table_->horizontalHeader();
    header->moveSection(header->visualIndex(sentence), header->visualIndex(against) - 1);
  }
  table_->setColumnHidden(against, true);
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
    if (results_) copy(as_text(name_, *results_));
  });
  connect(copy_latex_, &QPushButton::clicked, this, [this] {
    if (results_) copy(as_latex(*results_));
  });
  auto* inside = new QWidget;
  auto* content = new QVBoxLayout(inside);
  content->setContentsMargins(0, 0, 0, 0);
  content->setSpacing(2);
  content->addWidget(table_, 1);
  content->addWidget(rest_);
  auto* row = new QHBoxLayout;
  row->setContentsMargins(6, 0, 6, 2);
  row->addWidget(copy_text_);
  row->addWidget(copy_latex_);
  row->addWidget(save_);
  row->addStretch();
  content->addLayout(row);
  content->addStretch();
  auto* scroll = new QScrollArea(this);
  scroll->setWidget(inside);
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->setFocusPolicy(Qt::NoFocus);
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

void ResultPanel::compare(std::vector<Beside> others) {
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
  std::vector<std::vector<RunResults::Kick>> others;
  std::vector<std::vector<std::optional<std::size_t>>> theirs;  // by run, then by kick
  for (const Beside& other : others_) {
    others.push_back(other.results->kicks());
    theirs.push_back(counterparts(kicks, others.back()));
  }
  table_->setColumnHidden(against, others_.empty());
  const int rows = static_cast<int>(kicks.size());
  table_->setRowCount(rows);
  // No higher than its rows, so that the text below is not behind an empty table.
  constexpr int few = 4;
  const auto height_of = [&](int shown) {
    return table_->horizontalHeader()->sizeHint().height() + shown * table_->verticalHeader()->defaultSectionSize() +
           table_->horizontalScrollBar()->sizeHint().height();
  };
  table_->setMinimumHeight(height_of(std::min(rows, few)));
  table_->setMaximumHeight(height_of(rows));
  for (std::size_t k = 0; k < kicks.size(); ++k) {
    const RunResults::Kick& kick = kicks[k];
    QStringList differences;
    for (std::size_t o = 0; o < others.size(); ++o) {
      const auto other = theirs[o][k];
      const QString text = other ? tr("formation %1, tracking %2")
                                       .arg(difference(kick.formation, others[o][*other].formation),
                                            difference(kick.tracking, others[o][*other].tracking))
                                 : QStringLiteral("–");
      differences << (others.size() > 1 ? QStringLiteral("%1: %2").arg(others_[o].letter, text) : text);
    }
    const QString beside = differences.join(QStringLiteral("; "));
    const QStringList cells{QString::number(kick.t, 'f', 2), kick.what,      settling_text(kick.formation),
                            settling_text(kick.tracking),    order_of(kick), centimetres(kick.closest),
                            centimetres(kick.largest),       beside};
    for (int column = 0; column < columns; ++column) {
      QTableWidgetItem* item = table_->item(static_cast<int>(k), column);
      if (!item) table_->setItem(static_cast<int>(k), column, item = new QTableWidgetItem);
      if (item->text() != cells[column]) item->setText(cells[column]);
      if (column == 1) item->setToolTip(kick.words);
    }
  }
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
  for (const Beside& other : others_) lines << tr("Beside %1: %2").arg(other.letter, other.name.toHtmlEscaped());
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

void ResultPanel::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  dirty_ = true;
  refresh();
}

}  // namespace skein::ui
