#include "ui/plots_panel.h"

#include <qcustomplot.h>

#include <QFileInfo>
#include <QMenu>
#include <QToolTip>
#include <algorithm>
#include <cmath>

#include "ui/math_title.h"
#include "ui/modes.h"

namespace skein::ui {
namespace {

constexpr int replot_ms = 60;  // at most some 16 pictures a second

/// The smallest height of a plot, so that noise does not fill it.
constexpr double least[] = {0.02, 0.02, 0.1, 0.02, 0.002};

/// One line, for the right end of a plot's head.
QCPLegend* compact_legend() {
  auto* legend = new QCPLegend;
  legend->setFillOrder(QCPLegend::foColumnsFirst);
  legend->setWrap(12);
  legend->setIconSize(12, 8);
  legend->setIconTextPadding(3);
  legend->setRowSpacing(0);
  legend->setColumnSpacing(7);
  legend->setMargins(QMargins(0, 0, 8, 0));
  return legend;
}

}  // namespace

PlotsPanel::PlotsPanel(QWidget* parent)
    : QWidget(parent),
      plot_(new QCustomPlot(this)),
      live_button_(new QPushButton(tr("Back to live"), this)),
      robots_legend_(nullptr),
      pairs_legend_(nullptr),
      markers_(plot_) {
  setObjectName(QStringLiteral("plots"));
  plot_->setObjectName(QStringLiteral("plot"));
  plot_->setAccessibleName(tr("Plots of the errors over time"));
  live_button_->setObjectName(QStringLiteral("live"));
  live_button_->setAccessibleName(live_button_->text());
  live_button_->hide();
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(plot_);

  make_rows();
  style(colours(palette()));
  plot_->setInteractions(QCP::iRangeDrag | QCP::iRangeZoom);
  plot_->setContextMenuPolicy(Qt::CustomContextMenu);
  plot_->setMouseTracking(true);
  plot_->installEventFilter(this);
  connect(plot_, &QWidget::customContextMenuRequested, this, &PlotsPanel::context_menu);
  connect(plot_, &QCustomPlot::mouseWheel, this, &PlotsPanel::leave_live);
  connect(live_button_, &QPushButton::clicked, this, &PlotsPanel::go_live);
  connect(&timer_, &QTimer::timeout, this, &PlotsPanel::replot_if_due);
  timer_.start(replot_ms);
}

PlotsPanel::~PlotsPanel() = default;

void PlotsPanel::make_rows() {
  struct {
    QString symbol, index, unit;
  } const names[rows] = {{QStringLiteral("e"), QStringLiteral("x"), tr("[m]")},
                         {QStringLiteral("e"), QStringLiteral("y"), tr("[m]")},
                         {QStringLiteral("e"), QStringLiteral("θ"), tr("[rad]")},
                         {QStringLiteral("δ"), QStringLiteral("i,j"), tr("[m]")},
                         {QStringLiteral("V"), {}, tr("[–]")}};
  plot_->plotLayout()->clear();
  plot_->plotLayout()->setRowSpacing(0);
  plot_->plotLayout()->setMargins(QMargins(0, 5, 0, 3));
  auto* sides = new QCPMarginGroup(plot_);
  for (int row = 0; row < rows; ++row) {
    auto* rect = new QCPAxisRect(plot_);
    auto* head = new QCPLayoutGrid;
    plot_->plotLayout()->addElement(2 * row, 0, head);  // first: what goes into it learns its plot from it
    auto* title = new MathTitle(plot_, names[row].symbol, names[row].index, names[row].unit);
    title->setMarginGroup(QCP::msLeft, sides);
    head->addElement(0, 0, title);
    head->addElement(0, 1, new QCPLayoutElement(plot_));  // takes up what is left between title and legend
    if (row == e_x) head->addElement(0, 2, robots_legend_ = compact_legend());
    if (row == delta) head->addElement(0, 2, pairs_legend_ = compact_legend());
    head->setColumnStretchFactor(1, 1000);
    plot_->plotLayout()->addElement(2 * row + 1, 0, rect);
    plot_->plotLayout()->setRowStretchFactor(2 * row, 0.001);
    titles_.push_back(title);
    rect->setMarginGroup(QCP::msLeft | QCP::msRight, sides);
    rect->setMinimumMargins(QMargins(4, 3, 8, row == rows - 1 ? 0 : 5));
    rect->setRangeDrag(Qt::Horizontal);
    rect->setRangeZoom(Qt::Horizontal);
    QCPAxis* time = rect->axis(QCPAxis::atBottom);
    QCPAxis* value = rect->axis(QCPAxis::atLeft);
    time->setTickLabels(row == rows - 1);
    time->setRange(0, window_seconds);
    time->ticker()->setTickCount(6);
    value->ticker()->setTickCount(3);
    value->setNumberFormat(QStringLiteral("g"));
    value->setNumberPrecision(4);
    rects_.push_back(rect);
  }
  rects_.back()->axis(QCPAxis::atBottom)->setLabel(tr("t [s]"));
  rects_.back()->axis(QCPAxis::atBottom)->setLabelPadding(0);
  for (QCPAxisRect* from : rects_)
    for (QCPAxisRect* to : rects_)
      if (from != to)
        connect(from->axis(QCPAxis::atBottom), qOverload<const QCPRange&>(&QCPAxis::rangeChanged),
                to->axis(QCPAxis::atBottom), qOverload<const QCPRange&>(&QCPAxis::setRange));
}

QCPGraph* PlotsPanel::add_graph(Row row) {
  QCPAxisRect* rect = rects_[static_cast<std::size_t>(row)];
  QCPGraph* graph = plot_->addGraph(rect->axis(QCPAxis::atBottom), rect->axis(QCPAxis::atLeft));
  graph->removeFromLegend();
  graphs_[row].push_back(graph);
  return graph;
}

void PlotsPanel::show_experiment(const app::Experiment& experiment) {
  markers_.clear();
  robots_legend_->clearItems();
  pairs_legend_->clearItems();
  plot_->clearGraphs();
  for (auto& graphs : graphs_) graphs.clear();
  const std::size_t n = experiment.robots.size();
  for (std::size_t i = 0; i < n; ++i) {
    QCPGraph* first = add_graph(e_x);
    first->setName(QString::number(i + 1));
    first->addToLegend(robots_legend_);
    add_graph(e_y);
    add_graph(e_theta);
  }
  for (std::size_t i = 0; i + 1 < n; ++i) {
    QCPGraph* pair = add_graph(delta);
    // Of many pairs the legend has room for the first robot's number only.
    pair->setName(n <= 6 ? QStringLiteral("%1,%2").arg(i + 1).arg(i + 2) : QString::number(i + 1));
    pair->addToLegend(pairs_legend_);
  }
  add_graph(lyapunov);
  t_ = 0.0;
  selected_ = -1;
  style_graphs(colours(palette()));
  go_live();
}

void PlotsPanel::take(const app::TickRecord& record) {
  const Colours c = colours(palette());
  for (const app::Event& event : record.events)
    if (severity(event) != Severity::note)
      markers_.add(record.t, QString::fromStdString(app::describe(event)), colour(severity(event), c));
  const bool new_time = record.t > t_ || graphs_[lyapunov][0]->data()->isEmpty();
  dirty_ = dirty_ || new_time || !record.events.empty();
  if (!new_time) return;
  t_ = record.t;
  for (std::size_t i = 0; i < record.robots.size() && i < graphs_[e_x].size(); ++i) {
    const app::RobotRecord& robot = record.robots[i];
    const core::Pose& nominal = robot.nominal.pose;
    const bool known = !robot.is(app::lost);
    graphs_[e_x][i]->addData(t_, known ? nominal.x - robot.pose.x : app::none);
    graphs_[e_y][i]->addData(t_, known ? nominal.y - robot.pose.y : app::none);
    graphs_[e_theta][i]->addData(t_, known ? core::wrap_angle(nominal.theta - robot.pose.theta) : app::none);
  }
  for (std::size_t i = 0; i < record.delta.size() && i < graphs_[delta].size(); ++i)
    graphs_[delta][i]->addData(t_, record.delta[i]);
  graphs_[lyapunov][0]->addData(t_, record.V);

  constexpr double slack = 10.0;  // cleared out now and then, not at every tick
  const auto range = graphs_[lyapunov][0]->data()->constBegin();
  if (range->key < t_ - history_seconds - slack) {
    for (auto& graphs : graphs_)
      for (QCPGraph* graph : graphs) graph->data()->removeBefore(t_ - history_seconds);
    markers_.remove_before(t_ - history_seconds);
  }
}

void PlotsPanel::select(int robot) {
  if (selected_ == robot) return;
  selected_ = robot;
  style_graphs(colours(palette()));
  dirty_ = true;
}

void PlotsPanel::replot_if_due() {
  if (!dirty_ || !isVisible() || window()->isMinimized()) return;
  dirty_ = false;
  if (live_) follow_time();
  fit_values();
  plot_->replot(QCustomPlot::rpQueuedReplot);
}

void PlotsPanel::follow_time() {
  const double end = std::max(t_, window_seconds);
  rects_[0]->axis(QCPAxis::atBottom)->setRange(end - window_seconds, end);
}

void PlotsPanel::fit_values() {
  const QCPRange time = rects_[0]->axis(QCPAxis::atBottom)->range();
  for (int row = 0; row < rows; ++row) {
    double low = row == lyapunov ? 0.0 : -least[row], high = least[row];
    for (const QCPGraph* graph : graphs_[row]) {
      bool found = false;
      const QCPRange values = graph->getValueRange(found, QCP::sdBoth, time);
      if (!found) continue;
      low = std::min(low, values.lower);
      high = std::max(high, values.upper);
    }
    // In steps of a tenth of the height: a range that moved with every sample would make the curves swim.
    const double step = std::pow(10.0, std::floor(std::log10(high - low))) / 2;
    const double room = row == lyapunov ? 0.0 : 0.3 * step;
    low = std::floor((low - room) / step) * step;
    high = std::ceil((high + 0.3 * step) / step) * step;
    rects_[static_cast<std::size_t>(row)]->axis(QCPAxis::atLeft)->setRange(low, high);
  }
}

void PlotsPanel::leave_live() {
  live_ = false;
  dirty_ = true;
  place_button();
  live_button_->show();
  live_button_->raise();
}

void PlotsPanel::go_live() {
  live_ = true;
  dirty_ = true;
  live_button_->hide();
}

void PlotsPanel::style(const Colours& c) {
  plot_->setBackground(c.plot);
  const QFont text = font();
  plot_->setFont(text);
  for (QCPAxisRect* rect : rects_)
    for (QCPAxis* axis : rect->axes()) {
      axis->setBasePen(QPen(c.axis));
      axis->setTickPen(QPen(c.axis));
      axis->setSubTickPen(QPen(c.axis));
      axis->setSubTicks(false);
      axis->setTickLabelFont(text);
      axis->setTickLabelColor(c.text);
      axis->setLabelFont(text);
      axis->setLabelColor(c.text);
      axis->grid()->setPen(QPen(c.plot_grid));
      axis->grid()->setZeroLinePen(QPen(c.axis, 1));
    }
  for (MathTitle* title : titles_) title->set_colour(c.text);
  for (QCPLegend* legend : {robots_legend_, pairs_legend_}) {
    legend->setFont(text);
    legend->setTextColor(c.text);
    legend->setBrush(Qt::NoBrush);
    legend->setBorderPen(Qt::NoPen);
  }
  style_graphs(c);
}

void PlotsPanel::style_graphs(const Colours& c) {
  for (int row = 0; row < rows; ++row)
    for (std::size_t i = 0; i < graphs_[row].size(); ++i) {
      QColor colour = row == lyapunov ? c.text : row == delta ? c.pair(i) : c.robot(i);
      double width = 1.5;
      if (selected_ >= 0 && row != lyapunov) {
        const auto chosen = static_cast<std::size_t>(selected_);
        const bool belongs = row == delta ? i == chosen || i + 1 == chosen : i == chosen;
        width = belongs ? 2.6 : 1.2;
        colour.setAlphaF(belongs ? 1.0F : 0.45F);
      }
      graphs_[row][i]->setPen(QPen(colour, width));
      if (row != delta && row != lyapunov && i == static_cast<std::size_t>(selected_))
        graphs_[row][i]->setLayer(QStringLiteral("axes"));
      else
        graphs_[row][i]->setLayer(QStringLiteral("main"));
    }
}

QString PlotsPanel::save(const QString& file) {
  const QString kind = QFileInfo(file).suffix().toLower();
  style(colours(ui::palette(Theme::light)));
  const bool done = kind == QStringLiteral("pdf") ? plot_->savePdf(file, 0, 0, QCP::epAllowCosmetic)
                                                  : plot_->savePng(file, 0, 0, 2.0);
  style(colours(palette()));
  dirty_ = true;
  return done ? QString() : tr("Could not write %1.").arg(file);
}

void PlotsPanel::context_menu(const QPoint& where) {
  auto* menu = new QMenu(this);
  menu->setAttribute(Qt::WA_DeleteOnClose);
  menu->addAction(tr("Save plot …"), this, &PlotsPanel::save_wanted);
  menu->addAction(tr("Back to live"), this, &PlotsPanel::go_live)->setEnabled(!live_);
  menu->popup(plot_->mapToGlobal(where));
}

bool PlotsPanel::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::MouseMove) {
    const auto* move = static_cast<QMouseEvent*>(event);
    if (move->buttons() & Qt::LeftButton)
      leave_live();
    else
      QToolTip::showText(move->globalPosition().toPoint(), markers_.text_at(move->position().x()), plot_);
  }
  if (event->type() == QEvent::MouseButtonDblClick) go_live();
  return QWidget::eventFilter(watched, event);
}

void PlotsPanel::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) {
    style(colours(palette()));
    dirty_ = true;
  }
  QWidget::changeEvent(event);
}

void PlotsPanel::showEvent(QShowEvent* event) {
  dirty_ = true;
  QWidget::showEvent(event);
}

void PlotsPanel::resizeEvent(QResizeEvent* event) {
  QWidget::resizeEvent(event);
  place_button();
}

void PlotsPanel::place_button() {
  live_button_->adjustSize();
  live_button_->move(width() - live_button_->width() - 16, height() - live_button_->height() - 44);
}

}  // namespace skein::ui
