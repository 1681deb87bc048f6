#include "ui/plots/plot_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "ui/base/compared.h"
#include "ui/base/told.h"
#include "ui/plots/curve_numbers.h"
#include "ui/plots/math_title.h"

namespace skein::ui {
namespace {

constexpr std::size_t most_named = 8;   // curves that a legend has room for: of more, each has its number on it
constexpr std::size_t times_every = 6;  // plots
// Qt draws wider lines stroke by stroke: with 1.5 a picture of all plots takes twice as long. [px]
constexpr double curve_width = 1.0, chosen_width = 2.6;

struct Legend {
  int columns = 8;
  bool first_robot_only = false;  // of many pairs there is no room for the second number
};
/// Of the signals that are drawn in another's plot, one after the other: their curves, and the mark before their
/// titles.
struct AddedStyle {
  Qt::PenStyle pen;
  const char* mark;
};
constexpr std::array added_styles{AddedStyle{Qt::DashLine, "– – "}, AddedStyle{Qt::DotLine, "· · "},
                                  AddedStyle{Qt::DashDotLine, "– · "}};
const AddedStyle& added_style(std::size_t k) {
  return added_styles[k % added_styles.size()];
}

Legend legend_of(const PlotRow& row) {
  switch (row.of) {
    case PlotRow::Of::robot:
    case PlotRow::Of::couple:
    case PlotRow::Of::group:
      return {};
    case PlotRow::Of::pair:
      return {.first_robot_only = row.curves.size() >= 6};
    case PlotRow::Of::stage:
      return {.columns = 3};
  }
  return {};
}

/// So many names a line, for the right end of a plot's head.
QCPLegend* compact_legend(int columns) {
  auto* legend = new QCPLegend;
  legend->setFillOrder(QCPLegend::foColumnsFirst);
  legend->setWrap(columns);
  legend->setIconSize(12, 8);
  legend->setIconTextPadding(3);
  legend->setRowSpacing(0);
  legend->setColumnSpacing(7);
  legend->setMargins(QMargins(0, 0, 8, 0));
  return legend;
}

}  // namespace

PlotView::PlotView(QWidget* parent) : QCustomPlot(parent), markers_(this) {
  setObjectName(QStringLiteral("plot"));
  tell(this, QAccessible::Chart);
  setAccessibleName(tr("Plots over time"));
  setAccessibleDescription(tr(
      "Arrow keys move a cursor along the time and from plot to plot, and its values are read; plus and minus zoom, "
      "Page Up and Page Down go back and on, Home goes back to live. D marks a time to measure differences from, Y and "
      "Shift+Y change a plot's height, A lets all plots follow their curves again."));
  setFocusPolicy(Qt::StrongFocus);
  setInteractions(QCP::iRangeDrag | QCP::iRangeZoom);
  setMouseTracking(true);
  setPlottingHint(QCP::phFastPolylines);  // stretch by stretch: of a thousand points an eighth of the time
  // The cursor moves with the mouse: it has a picture of its own, and the curves below stay as they are.
  // Above all others: what is above a picture of its own would need one as well.
  addLayer(QStringLiteral("cursor"), layer(QStringLiteral("overlay")), QCustomPlot::limAbove);
  layer(QStringLiteral("cursor"))->setMode(QCPLayer::lmBuffered);
  plotLayout()->setRowSpacing(0);
  plotLayout()->setMargins(QMargins(0, 5, 0, 3));
}

void PlotView::set_rows(const std::vector<PlotRow>& all, const std::vector<bool>& shown, std::size_t robots,
                        std::size_t others, bool foresees, const std::vector<std::vector<std::size_t>>& added) {
  others_ = others + (foresees ? 1 : 0);
  foresees_ = foresees;
  const QCPRange before = shown_.empty() ? QCPRange(0, 1) : time();
  markers_.drop_lines();
  for (const Shown& s : shown_) delete s.numbers;
  shown_.clear();
  clearItems();
  clearGraphs();
  plotLayout()->clear();
  delete sides_;
  sides_ = new QCPMarginGroup(this);
  rows_ = all;
  heights_.resize(rows_.size());
  robots_.resize(robots, true);
  const auto last = std::find(shown.rbegin(), shown.rend(), true);
  bool robots_named = false, couples_named = false;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    if (!shown[row]) continue;
    bool names_curves = false;  // robots and couples only once: the colours are the same in all plots
    switch (rows_[row].of) {
      case PlotRow::Of::robot:
        names_curves = !std::exchange(robots_named, true);
        break;
      case PlotRow::Of::couple:
        names_curves = !std::exchange(couples_named, true);
        break;
      case PlotRow::Of::pair:
      case PlotRow::Of::stage:
        names_curves = true;
        break;
      case PlotRow::Of::group:
        break;
    }
    names_curves = names_curves && rows_[row].curves.size() <= most_named;
    // The times stand below the last plot, and, where one has to scroll to it, here and there on the way.
    const bool last_one = row + 1 == static_cast<std::size_t>(shown.rend() - last);
    add_row(row, last_one, last_one || shown_.size() % times_every == times_every - 1, names_curves,
            row < added.size() ? added[row] : std::vector<std::size_t>());
  }
  for (const Shown& from : shown_)
    for (const Shown& to : shown_)
      if (from.rect != to.rect)
        connect(from.rect->axis(QCPAxis::atBottom), qOverload<const QCPRange&>(&QCPAxis::rangeChanged),
                to.rect->axis(QCPAxis::atBottom), qOverload<const QCPRange&>(&QCPAxis::setRange));
  markers_.draw_lines();
  style();
  set_time(before.lower, before.upper);
  setMinimumHeight(needed_height());
}

void PlotView::add_row(std::size_t row, bool last, bool has_times, bool names_curves,
                       const std::vector<std::size_t>& added) {
  const PlotRow& spec = rows_[row];
  const int place = 2 * static_cast<int>(shown_.size());
  Shown s{};
  s.row = row;
  s.rect = new QCPAxisRect(this);
  auto* head = s.head = new QCPLayoutGrid;
  plotLayout()->addElement(place, 0, head);  // first: what goes into it learns its plot from it
  s.title = new MathTitle(this, spec.symbol, spec.index, spec.unit);
  s.title->setMarginGroup(QCP::msLeft, sides_);
  head->addElement(0, 0, s.title);
  for (std::size_t k = 0; k < added.size(); ++k) {
    const PlotRow& other = rows_[added[k]];
    const bool same = other.unit == spec.unit;
    auto* title = new MathTitle(this, QLatin1String("  ") + QString::fromUtf8(added_style(k).mark) + other.symbol,
                                other.index, other.unit);
    head->addElement(0, head->columnCount(), title);
    s.added.push_back({added[k], s.rect->axis(same ? QCPAxis::atLeft : QCPAxis::atRight), title, {}});
  }
  head->addElement(0, head->columnCount(), new QCPLayoutElement(this));  // takes up what is left before the legend
  head->setColumnStretchFactor(head->columnCount() - 1, 1000);
  if (names_curves) head->addElement(0, head->columnCount(), s.legend = compact_legend(legend_of(spec).columns));
  plotLayout()->addElement(place + 1, 0, s.rect);
  plotLayout()->setRowStretchFactor(place, 0.001);
  s.rect->setMarginGroup(QCP::msLeft | QCP::msRight, sides_);
  s.rect->setMinimumMargins(QMargins(4, 3, 8, last ? 0 : 5));
  s.rect->setRangeDrag(Qt::Horizontal);
  s.rect->setRangeZoom(Qt::Horizontal);
  QCPAxis* time = s.rect->axis(QCPAxis::atBottom);
  QCPAxis* value = s.rect->axis(QCPAxis::atLeft);
  time->setTickLabels(has_times);
  time->ticker()->setTickCount(6);
  if (last) time->setLabel(tr("t [s]"));
  time->setLabelPadding(0);
  value->ticker()->setTickCount(3);
  value->setNumberFormat(QStringLiteral("g"));
  value->setNumberPrecision(4);

  const auto graph = [&](QCPAxis* axis) {
    QCPGraph* made = addGraph(time, axis);
    made->removeFromLegend();
    return made;
  };
  s.others.resize(others_);
  for (auto& of_run : s.others)
    for (std::size_t c = 0; c < spec.curves.size(); ++c) of_run.push_back(graph(value));
  for (Added& one : s.added) {
    for (std::size_t c = 0; c < rows_[one.row].curves.size(); ++c) one.graphs.push_back(graph(one.axis));
    if (one.axis == value) continue;
    one.axis->setVisible(true);
    one.axis->ticker()->setTickCount(3);
    one.axis->setNumberFormat(QStringLiteral("g"));
    one.axis->setNumberPrecision(4);
  }
  for (std::size_t c = 0; c < spec.curves.size(); ++c) {
    s.graphs.push_back(graph(value));
    if (!names_curves) continue;
    s.graphs[c]->setName(legend_of(spec).first_robot_only ? QString::number(c + 1) : spec.curves[c]);
    s.graphs[c]->addToLegend(s.legend);
  }
  const bool of_robots = spec.of == PlotRow::Of::robot || spec.of == PlotRow::Of::pair;
  if (of_robots && spec.curves.size() > most_named) s.numbers = new CurveNumbers(s.rect);
  if (spec.band > 0.0) s.band = band(s.rect, spec.band);
  for (const double limit : spec.limits) {
    QCPItemStraightLine* at = line(s.rect, QStringLiteral("grid"));
    at->point1->setTypeX(QCPItemPosition::ptAxisRectRatio);
    at->point2->setTypeX(QCPItemPosition::ptAxisRectRatio);
    at->point1->setCoords(0.0, limit);
    at->point2->setCoords(1.0, limit);
    s.limits.push_back(at);
  }
  for (QCPItemStraightLine** made : {&s.cursor, &s.playhead, &s.mark}) {
    *made = line(s.rect, QStringLiteral("cursor"));
    (*made)->point1->setTypeY(QCPItemPosition::ptAxisRectRatio);
    (*made)->point2->setTypeY(QCPItemPosition::ptAxisRectRatio);
    (*made)->setVisible(false);
  }
  shown_.push_back(std::move(s));
}

/// Where the results say "settled": both ways about zero, along all of the time.
QCPItemRect* PlotView::band(QCPAxisRect* rect, double half) {
  auto* made = new QCPItemRect(this);
  made->setClipAxisRect(rect);
  made->setLayer(QStringLiteral("background"));
  made->setSelectable(false);
  for (QCPItemPosition* position : {made->topLeft, made->bottomRight}) {
    position->setAxisRect(rect);
    position->setAxes(rect->axis(QCPAxis::atBottom), rect->axis(QCPAxis::atLeft));
    position->setTypeX(QCPItemPosition::ptAxisRectRatio);
    position->setTypeY(QCPItemPosition::ptPlotCoords);
  }
  made->topLeft->setCoords(0.0, half);
  made->bottomRight->setCoords(1.0, -half);
  return made;
}

QCPItemStraightLine* PlotView::line(QCPAxisRect* rect, const QString& layer) {
  auto* made = new QCPItemStraightLine(this);
  made->setClipAxisRect(rect);
  made->setLayer(layer);
  made->setSelectable(false);
  for (QCPItemPosition* position : made->positions()) {
    position->setAxisRect(rect);
    position->setAxes(rect->axis(QCPAxis::atBottom), rect->axis(QCPAxis::atLeft));
    position->setType(QCPItemPosition::ptPlotCoords);
  }
  return made;
}

void PlotView::set_time(double from, double to) {
  if (!shown_.empty()) shown_[0].rect->axis(QCPAxis::atBottom)->setRange(from, to);
}

QCPRange PlotView::time() const {
  return shown_.empty() ? QCPRange(0, 1) : shown_[0].rect->axis(QCPAxis::atBottom)->range();
}

bool PlotView::drawn(const PlotRow& row, std::size_t curve) const {
  const auto of = robots_of(row.of, curve, robots_.size());
  return !of || (robots_[of->first] && robots_[of->second]);
}

void PlotView::fill(QCPGraph* graph, const PlotHistory& history, std::size_t curve) {
  const QCPRange range = time();
  const auto columns = static_cast<std::size_t>(std::max(50, width()));
  history.points(curve, range.lower, range.upper, columns, points_);
  constexpr double unseen = 0.125;  // [px]
  const QCPAxis* value = graph->valueAxis();
  if (const int height = value->axisRect()->height(); height > 0)
    drop_level_points(points_, unseen * value->range().size() / height);
  QVector<QCPGraphData> drawn_points;
  drawn_points.reserve(static_cast<qsizetype>(points_.size()));
  for (const PlotHistory::Point& point : points_) drawn_points.push_back({point.t, point.value});
  graph->data()->set(drawn_points, true);
}

void PlotView::draw_history(const PlotHistory& history, const std::vector<const PlotHistory*>& others,
                            const QRect& within) {
  for (Shown& s : shown_) {
    const PlotRow& row = rows_[s.row];
    const QRect place = s.rect->outerRect();  // empty: it was not laid out yet, and the next picture may be the last
    s.rect->setVisible(within.isEmpty() || place.isEmpty() || place.intersects(within));  // with its axes and curves
    if (!s.rect->visible()) continue;
    fit(s, history, others);  // first: how many points a curve needs depends on it
    for (std::size_t c = 0; c < row.curves.size(); ++c) {
      const bool visible = drawn(row, c);
      s.graphs[c]->setVisible(visible);
      for (std::size_t k = 0; k < s.others.size(); ++k) {
        const PlotHistory* other = k < others.size() ? others[k] : nullptr;
        s.others[k][c]->setVisible(visible && other != nullptr);
        if (visible && other) fill(s.others[k][c], *other, row.first + c);
      }
      if (visible) fill(s.graphs[c], history, row.first + c);
    }
    for (Added& one : s.added)
      for (std::size_t c = 0; c < one.graphs.size(); ++c) {
        const bool visible = drawn(rows_[one.row], c);
        one.graphs[c]->setVisible(visible);
        if (visible) fill(one.graphs[c], history, rows_[one.row].first + c);
      }
    if (s.numbers) number_curves(s, history);
  }
}

/// Spread over the time that is seen of them or, as long as the time to come has more room, right behind their ends;
/// those of the selected robot stand before the others.
void PlotView::number_curves(const Shown& shown, const PlotHistory& history) const {
  const PlotRow& row = rows_[shown.row];
  std::vector<CurveNumbers::Number> numbers;
  if (history.empty()) return shown.numbers->show(numbers);
  const double from = std::max(time().lower, history.first_time()), to = std::min(time().upper, history.last_time());
  const bool behind = time().upper - to > to - from;
  const auto count = static_cast<double>(row.curves.size());
  for (std::size_t c = 0; c < row.curves.size(); ++c) {
    if (!drawn(row, c)) continue;
    const double t = behind ? to : from + (static_cast<double>(c) + 0.5) / count * (to - from);
    numbers.push_back({static_cast<int>(c) + 1, look_of(row, c).colour, t, history.value(row.first + c, t), behind});
  }
  std::stable_partition(numbers.begin(), numbers.end(), [&](const CurveNumbers::Number& one) {
    const auto of = robots_of(row.of, static_cast<std::size_t>(one.number - 1), robots_.size());
    const auto chosen = static_cast<std::size_t>(selected_);
    return selected_ >= 0 && of && (of->first == chosen || of->second == chosen);
  });
  shown.numbers->show(std::move(numbers));
}

void PlotView::fit(Shown& shown, const PlotHistory& history, const std::vector<const PlotHistory*>& others) {
  std::vector<const PlotHistory*> all{&history};
  all.insert(all.end(), others.begin(), others.end());
  std::vector<const PlotRow*> left{&rows_[shown.row]}, right;
  QCPAxis* value = shown.rect->axis(QCPAxis::atLeft);
  for (const Added& one : shown.added) (one.axis == value ? left : right).push_back(&rows_[one.row]);
  value->setRange(heights_[shown.row].value_or(fitted(left, all, history)));
  if (!right.empty()) shown.rect->axis(QCPAxis::atRight)->setRange(fitted(right, {&history}, history));
}

/// The height that shows all of some rows' curves; the first row's out of several runs.
QCPRange PlotView::fitted(const std::vector<const PlotRow*>& rows, const std::vector<const PlotHistory*>& of_first,
                          const PlotHistory& history) const {
  const QCPRange range = time();
  const bool from_zero = std::all_of(rows.begin(), rows.end(), [](const PlotRow* row) { return row->from_zero; });
  double high = 0.0;
  for (const PlotRow* row : rows) high = std::max(high, row->least);
  double low = from_zero ? 0.0 : -high;
  const auto reach = [&](const PlotHistory& from, std::size_t curve) {
    const PlotHistory::Range values = from.range(curve, range.lower, range.upper);
    if (values.low > values.high) return;
    low = std::min(low, values.low);
    high = std::max(high, values.high);
  };
  for (const PlotRow* row : rows)
    for (std::size_t c = 0; c < row->curves.size(); ++c) {
      if (!drawn(*row, c)) continue;
      if (row != rows.front()) {
        reach(history, row->first + c);
        continue;
      }
      for (const PlotHistory* from : of_first)
        if (from) reach(*from, row->first + c);
    }
  // A limit is in the picture once something comes near it.
  for (const double limit : rows.front()->limits) {
    if (limit > 0 && high > 0.6 * limit) high = std::max(high, 1.05 * limit);
    if (limit < 0 && low < 0.6 * limit) low = std::min(low, 1.05 * limit);
  }
  // In steps of a tenth of the height: a range that moved with every sample would make the curves swim.
  const double step = std::pow(10.0, std::floor(std::log10(high - low))) / 2;
  const double room = from_zero ? 0.0 : 0.3 * step;
  low = std::floor((low - room) / step) * step;
  high = std::ceil((high + 0.3 * step) / step) * step;
  return {low, high};
}

void PlotView::place(QCPItemStraightLine* Shown::*line, std::optional<double> t) {
  for (Shown& s : shown_) {
    (s.*line)->setVisible(t.has_value());
    (s.*line)->point1->setCoords(t.value_or(0.0), 0.0);
    (s.*line)->point2->setCoords(t.value_or(0.0), 1.0);
  }
  layer(QStringLiteral("cursor"))->replot();
}

void PlotView::set_cursor(std::optional<double> t) {
  place(&Shown::cursor, t);
}

void PlotView::set_playhead(std::optional<double> t) {
  place(&Shown::playhead, t);
}

void PlotView::set_mark(std::optional<double> t) {
  place(&Shown::mark, t);
}

const PlotView::Shown* PlotView::find(std::size_t row) const {
  const auto found = std::find_if(shown_.begin(), shown_.end(), [row](const Shown& s) { return s.row == row; });
  return found == shown_.end() ? nullptr : &*found;
}

void PlotView::zoom_height(std::size_t row, double times, std::optional<double> value) {
  const Shown* const s = find(row);
  if (!s) return;
  const QCPRange now = height_of(row);
  const double about = value.value_or(now.center());
  const QCPRange asked(about - (about - now.lower) / times, about + (now.upper - about) / times);
  if (!QCPRange::validRange(asked)) return;  // nothing is that small
  heights_[row] = asked;
  s->rect->axis(QCPAxis::atLeft)->setRange(asked);
}

void PlotView::fit_heights() {
  heights_.assign(rows_.size(), std::nullopt);
}

QCPRange PlotView::height_of(std::size_t row) const {
  const Shown* const s = find(row);
  return s ? s->rect->axis(QCPAxis::atLeft)->range() : QCPRange();
}

bool PlotView::holds_heights() const {
  return std::any_of(heights_.begin(), heights_.end(), [](const auto& held) { return held.has_value(); });
}

double PlotView::value_at(std::size_t row, const QPoint& where) const {
  const Shown* const s = find(row);
  return s ? s->rect->axis(QCPAxis::atLeft)->pixelToCoord(where.y()) : 0.0;
}

QPoint PlotView::place_of(std::size_t row, double t) const {
  const Shown* const s = find(row);
  if (!s) return rect().center();
  return {static_cast<int>(s->rect->axis(QCPAxis::atBottom)->coordToPixel(t)), s->rect->rect().center().y()};
}

int PlotView::row_at(const QPoint& where) const {
  for (const Shown& s : shown_)
    if (s.rect->rect().contains(where)) return static_cast<int>(s.row);
  return -1;
}

const CurveNumbers* PlotView::numbers_of(std::size_t row) const {
  const Shown* const s = find(row);
  return s ? s->numbers : nullptr;
}

int PlotView::head_at(const QPoint& where) const {
  for (const Shown& s : shown_)
    if (s.head->outerRect().contains(where)) return static_cast<int>(s.row);
  return -1;
}

QRect PlotView::head_of(std::size_t row) const {
  const Shown* const s = find(row);
  return s ? s->head->outerRect() : QRect();
}

double PlotView::time_at(const QPoint& where) const {
  return shown_.empty() ? 0.0 : shown_[0].rect->axis(QCPAxis::atBottom)->pixelToCoord(where.x());
}

void PlotView::show_robots(const std::vector<bool>& robots) {
  robots_ = robots;
}

void PlotView::select(int robot) {
  selected_ = robot;
  style_curves();
}

void PlotView::set_colours(const Colours& colours) {
  colours_ = colours;
  style();
}

int PlotView::needed_height() const {
  constexpr int usual = 84, times = 40, lines = 5;  // a title, and three numbers with some room between them
  return static_cast<int>(shown_.size()) * std::max(usual, lines * fontMetrics().height()) +
         std::max(times, 2 * fontMetrics().height());
}

void PlotView::changeEvent(QEvent* event) {
  if (event->type() == QEvent::FontChange) {
    style();
    setMinimumHeight(needed_height());
  }
  QCustomPlot::changeEvent(event);
}

void PlotView::style() {
  const Colours& c = colours_;
  setBackground(c.plot);
  const QFont text = font();
  for (Shown& s : shown_) {
    for (QCPAxis* axis : s.rect->axes()) {
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
    s.title->set_colour(c.text);
    if (s.numbers) s.numbers->set_ground(c.plot);
    for (const Added& one : s.added) one.title->set_colour(c.text);
    for (QCPItemStraightLine* limit : s.limits) limit->setPen(QPen(c.warning, 1, Qt::DashLine));
    if (s.band) {
      QColor pale = c.good;
      pale.setAlphaF(0.14F);
      s.band->setBrush(pale);
      pale.setAlphaF(0.5F);
      s.band->setPen(QPen(pale, 1, Qt::DotLine));  // not by its colour alone
    }
    s.cursor->setPen(QPen(c.faint_text, 1));
    s.playhead->setPen(QPen(c.accent, 2));
    s.mark->setPen(QPen(c.text, 1, Qt::DashDotLine));
    if (!s.legend) continue;
    s.legend->setFont(text);
    s.legend->setTextColor(c.text);
    s.legend->setBrush(Qt::NoBrush);
    s.legend->setBorderPen(Qt::NoPen);
  }
  style_curves();
}

PlotView::Look PlotView::look_of(const PlotRow& row, std::size_t curve) const {
  constexpr std::size_t hues = 7;  // then they come round again
  const QColor colour = colour_of(row.of, curve, colours_);
  switch (row.of) {
    case PlotRow::Of::couple:
      return {colour, curve >= hues ? Qt::DashLine : Qt::SolidLine};
    case PlotRow::Of::robot:
    case PlotRow::Of::stage:
    case PlotRow::Of::pair:
    case PlotRow::Of::group:
      break;
  }
  return {colour};
}

void PlotView::style_curve(QCPGraph* graph, const PlotRow& row, std::size_t curve,
                           std::optional<Qt::PenStyle> style) const {
  auto [colour, own_style] = look_of(row, curve);
  const bool crowd = row.curves.size() > most_named;  // thin lines without smooth edges cost a fifth
  double width = curve_width;
  const auto chosen = static_cast<std::size_t>(selected_);
  const auto of = robots_of(row.of, curve, robots_.size());
  const bool belongs = selected_ >= 0 && of && (of->first == chosen || of->second == chosen);
  if (selected_ >= 0 && of) {
    if (belongs) width = chosen_width;
    colour.setAlphaF(belongs ? 1.0F : 0.45F);
  }
  graph->setAntialiased(!crowd);
  graph->setPen(QPen(colour, width, style.value_or(own_style)));
  graph->setLayer(belongs ? QStringLiteral("axes") : QStringLiteral("main"));
}

void PlotView::style_curves() {
  for (Shown& s : shown_) {
    const PlotRow& row = rows_[s.row];
    for (std::size_t k = 0; k < s.added.size(); ++k)
      for (std::size_t i = 0; i < s.added[k].graphs.size(); ++i)
        style_curve(s.added[k].graphs[i], rows_[s.added[k].row], i, added_style(k).pen);
    for (std::size_t i = 0; i < row.curves.size(); ++i) {
      style_curve(s.graphs[i], row, i, {});
      QColor pale = look_of(row, i).colour;
      pale.setAlphaF(0.6F);
      for (std::size_t k = 0; k < s.others.size(); ++k) {
        s.others[k][i]->setAntialiased(row.curves.size() <= most_named);
        if (foresees_ && k + 1 == s.others.size()) {  // what has not happened yet: paler than anything else
          QColor faint = pale;
          faint.setAlphaF(0.35F);
          s.others[k][i]->setPen(QPen(faint, curve_width));
        } else {
          s.others[k][i]->setPen(QPen(pale, curve_width, compared_style(k)));
        }
      }
    }
  }
}

}  // namespace skein::ui
