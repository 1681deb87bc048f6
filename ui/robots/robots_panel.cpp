#include "ui/robots/robots_panel.h"

#include <QEvent>
#include <QHeaderView>
#include <QHelpEvent>
#include <QSignalBlocker>
#include <QStyledItemDelegate>
#include <QToolTip>
#include <algorithm>

namespace skein::ui {
namespace {

/// What is coloured keeps its colour in the row that is selected.
class KeepColours final : public QStyledItemDelegate {
 public:
  using QStyledItemDelegate::QStyledItemDelegate;

 protected:
  void initStyleOption(QStyleOptionViewItem* option, const QModelIndex& index) const override {
    QStyledItemDelegate::initStyleOption(option, index);
    if (index.column() == RobotsModel::robot) option->state &= ~(QStyle::State_Selected | QStyle::State_HasFocus);
    option->palette.setBrush(QPalette::HighlightedText, option->palette.brush(QPalette::Text));
  }
};

}  // namespace

RobotsPanel::RobotsPanel(QWidget* parent) : QTableView(parent) {
  setObjectName(QStringLiteral("robots"));
  setAccessibleName(tr("Robots"));
  setModel(&model_);
  model_.set_colours(colours(palette()));
  setItemDelegate(new KeepColours(this));
  setSelectionBehavior(SelectRows);
  setSelectionMode(SingleSelection);
  setFrameShape(NoFrame);
  setShowGrid(false);
  setAlternatingRowColors(true);
  setWordWrap(false);
  setTabKeyNavigation(false);
  setHorizontalScrollMode(ScrollPerPixel);
  verticalHeader()->hide();
  verticalHeader()->setDefaultSectionSize(fontMetrics().height() + 5);  // with those of links, four rows have room
  horizontalHeader()->setHighlightSections(false);
  horizontalHeader()->setResizeContentsPrecision(0);  // of the rows that are seen
  // Wide enough for what usually stands there; fixed, so that numbers do not make columns dance.
  const auto width = [this](const QString& text) { return fontMetrics().horizontalAdvance(text) + 12; };
  setColumnWidth(RobotsModel::robot, width(QStringLiteral("00")));
  setColumnWidth(RobotsModel::tag, width(tr("Tag")));
  setColumnWidth(RobotsModel::link, width(tr("connecting")));
  setColumnWidth(RobotsModel::round_trip, width(QStringLiteral("000.0 ms")));
  setColumnWidth(RobotsModel::battery, width(tr("Battery")));
  setColumnWidth(RobotsModel::found, width(tr("simulated")));
  setColumnWidth(RobotsModel::firmware, width(tr("Firmware")));
  setColumnWidth(RobotsModel::tag_age, width(QStringLiteral("0000 ms")));
  setColumnWidth(RobotsModel::wheels, width(QStringLiteral("−000 / −000")));
  horizontalHeader()->setSectionResizeMode(RobotsModel::mode, QHeaderView::Stretch);
  connect(&model_, &QAbstractItemModel::modelReset, this, &RobotsPanel::hide_empty_columns);
  connect(&model_, &QAbstractItemModel::dataChanged, this, &RobotsPanel::hide_empty_columns);
  connect(&model_, &QAbstractItemModel::dataChanged, this, &RobotsPanel::follow_tip);
  connect(selectionModel(), &QItemSelectionModel::currentRowChanged, this,
          [this](const QModelIndex& now) { emit picked(now.isValid() ? now.row() : -1); });
}

/// What only robots with a link have takes no room where there are none, nor do tags that say the robots' numbers, or
/// a firmware that no robot has reported.
void RobotsPanel::hide_empty_columns() {
  bool same = true;
  for (int row = 0; row < model_.rowCount(); ++row)
    same = same && model_.index(row, RobotsModel::tag).data() == model_.index(row, RobotsModel::robot).data();
  if (isColumnHidden(RobotsModel::tag) != same) setColumnHidden(RobotsModel::tag, same);
  const auto hide = [this](int column, bool hidden) {
    if (isColumnHidden(column) != hidden) setColumnHidden(column, hidden);
  };
  hide(RobotsModel::round_trip, !model_.has_links());
  hide(RobotsModel::battery, !model_.has_links());
  bool nobody = true;
  for (int row = 0; row < model_.rowCount(); ++row)
    nobody = nobody && model_.index(row, RobotsModel::firmware).data().toString() == RobotsModel::nothing();
  hide(RobotsModel::firmware, nobody);
  fit_mode();
}

/// The mode has whatever the other columns leave; where that is too little for it, the table scrolls.
void RobotsPanel::fit_mode() {
  const int least =
      std::max(fontMetrics().horizontalAdvance(tr("shielded")) + 12, sizeHintForColumn(RobotsModel::mode));
  int others = 0;
  for (int column = 0; column < model_.columnCount(); ++column)
    if (column != RobotsModel::mode && !isColumnHidden(column)) others += columnWidth(column);
  const bool fits = viewport()->width() - others >= least;
  const QHeaderView::ResizeMode wanted = fits ? QHeaderView::Stretch : QHeaderView::Fixed;
  if (horizontalHeader()->sectionResizeMode(RobotsModel::mode) != wanted)
    horizontalHeader()->setSectionResizeMode(RobotsModel::mode, wanted);
  if (!fits && columnWidth(RobotsModel::mode) != least) setColumnWidth(RobotsModel::mode, least);
}

void RobotsPanel::resizeEvent(QResizeEvent* event) {
  QTableView::resizeEvent(event);
  fit_mode();
}

bool RobotsPanel::viewportEvent(QEvent* event) {
  const bool done = QTableView::viewportEvent(event);
  if (event->type() == QEvent::ToolTip) {
    const auto* asked = static_cast<QHelpEvent*>(event);
    const QModelIndex of = indexAt(asked->pos());
    tip_ = {of, asked->globalPos(), of.data(Qt::ToolTipRole).toString()};
  }
  if (event->type() == QEvent::Leave) tip_ = {};  // whatever follows would keep it there
  return done;
}

/// What a tip says goes on, in a run as in a replay: it says what is so now, as long as it is there.
void RobotsPanel::follow_tip() {
  if (!tip_.of.isValid() || !QToolTip::isVisible() || QToolTip::text() != tip_.said) return;
  const QString now = tip_.of.data(Qt::ToolTipRole).toString();
  if (now == tip_.said) return;
  tip_.said = now;
  QToolTip::showText(tip_.where, now, viewport());
}

void RobotsPanel::select_robot(int robot) {
  const QSignalBlocker quiet(selectionModel());
  if (robot < 0) {
    clearSelection();
    setCurrentIndex({});
  } else {
    selectRow(robot);
  }
  viewport()->update();
}

QSize RobotsPanel::sizeHint() const {
  const int rows = std::clamp(model_.rowCount(), 2, 8);
  return {500, horizontalHeader()->sizeHint().height() + rows * verticalHeader()->defaultSectionSize() + 4};
}

void RobotsPanel::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) model_.set_colours(colours(palette()));
  QTableView::changeEvent(event);
}

}  // namespace skein::ui
