#include "ui/plots/plots_panel.h"

#include <QComboBox>
#include <QHBoxLayout>
#include <QMenu>
#include <QScrollArea>
#include <QScrollBar>
#include <QToolTip>
#include <algorithm>
#include <cmath>

#include "ui/base/compared.h"
#include "ui/base/modes.h"
#include "ui/base/sentence.h"
#include "ui/plots/comparison_bar.h"
#include "ui/plots/plot_view.h"
#include "ui/plots/xy_plot.h"

namespace skein::ui {
namespace {

constexpr double wheel_notch = 120.0;  // of a mouse wheel, in Qt's unit
const QLatin1Char with('+');           // between the name of a plot and those of signals that are drawn in it too
constexpr int replot_ms = 60;          // at most some 16 pictures a second
constexpr std::size_t most_bytes =
    64'000'000;  // of curves: an hour of four robots at 25 Hz; with all else below 200 MB

std::size_t most_samples(std::size_t curves) {
  constexpr std::size_t least = 49152, most = 524288, sample_bytes = 9;
  return std::clamp(most_bytes / (sample_bytes * std::max<std::size_t>(1, curves)), least, most);
}

}  // namespace

PlotsPanel::PlotsPanel(QWidget* parent)
    : QWidget(parent),
      view_(new PlotView),
      comparison_bar_(new ComparisonBar(this)),
      scroll_(new QScrollArea(this)),
      over_(new XyPlot(this)),
      live_button_(new QPushButton(tr("Back to live"), this)),
      span_box_(new QComboBox(this)),
      plots_menu_(new QMenu(this)),
      robots_menu_(new QMenu(this)) {
  setObjectName(QStringLiteral("plots"));
  live_button_->setObjectName(QStringLiteral("live"));
  live_button_->setAccessibleName(live_button_->text());
  live_button_->hide();
  scroll_->setObjectName(QStringLiteral("plot_scroll"));
  scroll_->setWidget(view_);
  scroll_->setWidgetResizable(true);
  scroll_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll_->setFrameShape(QFrame::NoFrame);
  scroll_->setFocusPolicy(Qt::NoFocus);
  auto* tools = new QHBoxLayout;
  tools->setContentsMargins(4, 2, 4, 2);
  tools->setSpacing(2);
  build_tools(tools);
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->setSpacing(0);
  layout->addLayout(tools);
  layout->addWidget(comparison_bar_);
  layout->addWidget(scroll_, 1);
  layout->addWidget(over_);
  over_->hide();

  view_->set_colours(colours(palette()));
  view_->setContextMenuPolicy(Qt::CustomContextMenu);
  view_->installEventFilter(this);
  connect(view_, &QWidget::customContextMenuRequested, this, &PlotsPanel::context_menu);
  connect(view_, &QCustomPlot::mouseWheel, this, &PlotsPanel::leave_live);
  connect(live_button_, &QPushButton::clicked, this, &PlotsPanel::go_live);
  connect(scroll_->verticalScrollBar(), &QScrollBar::valueChanged, this, &PlotsPanel::replot_now);
  connect(&timer_, &QTimer::timeout, this, &PlotsPanel::replot_if_due);
  timer_.start(replot_ms);
}

PlotsPanel::~PlotsPanel() = default;

void PlotsPanel::show_experiment(const app::Experiment& experiment) {
  rows_ = plot_rows(experiment);
  const std::size_t curves = curve_count(rows_);
  history_ = PlotHistory(curves, most_samples(curves));
  others_.clear();
  foreseen_.reset();
  playhead_.reset();
  mark_.reset();
  robots_.assign(experiment.robots.size(), true);
  t_ = 0.0;
  selected_ = -1;
  dragged_ = -1;
  cursor_.reset();
  cursor_row_ = 0;
  view_->markers().clear();
  view_->fit_heights();
  view_->select(-1);
  rebuild();
  go_live();
}

void PlotsPanel::rebuild() {
  shown_.assign(rows_.size(), false);
  added_.assign(rows_.size(), {});
  for (std::size_t row = 0; row < rows_.size(); ++row) shown_[row] = wanted_.isEmpty() && rows_[row].usual;
  for (const QString& entry : wanted_) {
    const QStringList names = entry.split(with);
    const auto plot = row_of(names.front());
    if (!plot) continue;
    shown_[*plot] = true;
    for (const QString& name : names.mid(1))
      if (const auto signal = row_of(name)) added_[*plot].push_back(*signal);
  }
  view_->set_rows(rows_, shown_, robots_.size(), others_.size(), foreseen_.has_value(), added_);
  view_->show_robots(robots_);
  if (playhead_) view_->set_playhead(playhead_);
  if (mark_) view_->set_mark(mark_);
  show_over(over_y_, over_x_);
  refresh();
}

QStringList PlotsPanel::shown() const {
  QStringList names;
  for (std::size_t row = 0; row < rows_.size(); ++row)
    if (shown_[row]) {
      QString entry = rows_[row].name;
      for (const std::size_t signal : added_[row]) entry += with + rows_[signal].name;
      names << entry;
    }
  return names;
}

std::optional<std::size_t> PlotsPanel::row_of(const QString& name) const {
  const auto row = std::find_if(rows_.begin(), rows_.end(), [&](const PlotRow& r) { return r.name == name; });
  return row == rows_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(row - rows_.begin()));
}

QString PlotsPanel::add_signal(const QString& signal, const QString& plot) {
  const auto of = row_of(signal), in = row_of(plot);
  if (!of || !in || !shown_[*in]) return tr("There is no such plot");
  if (of == in || std::find(added_[*in].begin(), added_[*in].end(), *of) != added_[*in].end())
    return tr("%1 is drawn there already").arg(rows_[*of].title());
  for (const std::size_t other : added_[*in])
    if (const QString& unit = rows_[other].unit;
        unit != rows_[*in].unit && rows_[*of].unit != rows_[*in].unit && rows_[*of].unit != unit)
      return tr("A plot has room for two units, and this one has %1 and %2").arg(rows_[*in].unit, unit);
  QStringList names = shown();
  for (QString& entry : names)
    if (entry.split(with).front() == plot) entry += with + signal;
  show_plots(names);
  return {};
}

void PlotsPanel::remove_signal(const QString& signal, const QString& plot) {
  QStringList names = shown();
  for (QString& entry : names) {
    QStringList parts = entry.split(with);
    if (parts.front() != plot) continue;
    if (const qsizetype at = parts.indexOf(signal, 1); at > 0) parts.removeAt(at);
    entry = parts.join(with);
  }
  show_plots(names);
}

/// The answer says why none of them could be added.
QString PlotsPanel::add_signals(const QStringList& names, const QString& plot) {
  QString why;
  bool added = false;
  for (const QString& name : names) {
    const QString not_this = add_signal(name, plot);
    if (not_this.isEmpty()) added = true;
    if (why.isEmpty()) why = not_this;
  }
  return added ? QString() : why;
}

QString PlotsPanel::titles_of(const QStringList& names) const {
  QStringList titles;
  for (const QString& name : names)
    if (const auto row = row_of(name)) titles << rows_[*row].title();
  return titles.join(QStringLiteral(", "));
}

void PlotsPanel::show_signals(const QStringList& names) {
  const auto first = names.isEmpty() ? std::nullopt : row_of(names.front());
  if (!first) return;
  if (shown_[*first])
    add_signals(names.mid(1), names.front());
  else
    show_plots(shown() << names.join(with));
  // Once the plots have their places.
  QMetaObject::invokeMethod(
      this, [this, row = *first] { reveal(row); }, Qt::QueuedConnection);
}

void PlotsPanel::reveal(std::size_t row) {
  constexpr int margin = 60;
  if (row >= rows_.size()) return;  // another experiment has come meanwhile
  replot_now();
  const QPoint place = view_->place_of(row, view_->time().center());
  scroll_->ensureVisible(place.x(), place.y(), margin, margin);
}

void PlotsPanel::show_plots(const QStringList& names) {
  wanted_ = names;
  rebuild();
}

void PlotsPanel::show_all_plots() {
  QStringList names;
  for (const PlotRow& row : rows_) names << row.name;
  show_plots(names);
}

void PlotsPanel::show_record(const app::TickRecord& record) {
  if (!is_sample(record)) return;
  note_events(record);
  const bool new_time = record.t > t_ || history_.empty();
  dirty_ = dirty_ || new_time || !record.events.empty();
  if (new_time) store_values(record);
}

void PlotsPanel::note_events(const app::TickRecord& record) {
  for (const app::Event& event : record.events)
    if (severity(event) != Severity::note)
      view_->markers().add(record.t, tr("%1 (%2)").arg(sentence(event), QString::fromStdString(app::describe(event))),
                           colour(severity(event), colours(palette())));
}

void PlotsPanel::store_values(const app::TickRecord& record) {
  t_ = record.t;
  sample(rows_, record, values_);
  history_.add(t_, values_);
}

void PlotsPanel::set_playhead(std::optional<double> t) {
  if (!t && !playhead_) return;
  playhead_ = t;
  view_->set_playhead(t);
}

void PlotsPanel::set_mark(std::optional<double> t) {
  mark_ = t;
  view_->set_mark(t);
}

void PlotsPanel::zoom_height(std::size_t row, double times, std::optional<double> value) {
  view_->zoom_height(row, times, value);
  refresh();
}

void PlotsPanel::fit_heights() {
  view_->fit_heights();
  refresh();
}

void PlotsPanel::compare(const std::vector<Compared>& runs) {
  const bool another_number = runs.size() != others_.size();
  others_.assign(runs.size(), PlotHistory(history_.curves(), most_samples(history_.curves())));
  for (std::size_t k = 0; k < runs.size(); ++k) {
    double last = -1.0;
    if (!runs[k].shown) continue;
    for (const app::TickRecord& row : *runs[k].rows) {
      if (row.t <= last || !is_sample(row)) continue;
      last = row.t;
      sample(rows_, row, values_);
      others_[k].add(row.t + runs[k].shift, values_);
    }
  }
  if (another_number) rebuild();
  refresh();
}

void PlotsPanel::foresee(const std::vector<app::TickRecord>& rows) {
  if (rows.empty() && !foreseen_) return;
  const bool first = !foreseen_;
  foreseen_.emplace(history_.curves(), most_samples(history_.curves()));
  for (const app::TickRecord& row : rows) {
    sample(rows_, row, values_);
    foreseen_->add(row.t, values_);
  }
  if (first) rebuild();
  refresh();
}

std::vector<const PlotHistory*> PlotsPanel::drawn_others() const {
  std::vector<const PlotHistory*> drawn;
  drawn.reserve(others_.size() + 1);
  for (const PlotHistory& other : others_) drawn.push_back(other.empty() ? nullptr : &other);
  if (foreseen_) drawn.push_back(foreseen_->empty() ? nullptr : &*foreseen_);
  return drawn;
}

PlotLayout PlotsPanel::layout_now(const QString& name) const {
  return {name, shown(), span_, over_y_, over_x_};
}

void PlotsPanel::use(const PlotLayout& layout) {
  show_plots(layout.plots);
  set_span(layout.span);
  show_over(layout.over_y, layout.over_x);
}

bool PlotsPanel::show_over(const QString& y, const QString& x) {
  const auto row_y = row_of(y), row_x = row_of(x);
  const bool fit = row_y && row_x && rows_[*row_y].of == rows_[*row_x].of &&
                   rows_[*row_y].curves.size() == rows_[*row_x].curves.size();
  over_->setVisible(fit);
  over_y_ = fit ? y : QString();
  over_x_ = fit ? x : QString();
  if (fit) over_->set_rows(rows_[*row_x], rows_[*row_y], colours(palette()));
  refresh();
  return fit;
}

void PlotsPanel::draw_over() {
  if (over_y_.isEmpty()) return;
  const QCPRange time = view_->time();
  const PlotRow& y = rows_[*row_of(over_y_)];
  std::vector<bool> drawn(y.curves.size(), true);
  for (std::size_t c = 0; c < drawn.size(); ++c) drawn[c] = is_chosen(y, c);
  over_->draw_history(history_, time.lower, time.upper, drawn);
}

void PlotsPanel::select(int robot) {
  if (selected_ == robot) return;
  selected_ = robot;
  view_->select(robot);
  refresh();
}

void PlotsPanel::set_span(double seconds) {
  span_ = seconds;
  span_box_->setCurrentIndex(span_box_->findData(seconds));
  go_live();
}

/// How long one picture stands: until a curve has moved by a good part of a pixel, and so long that pictures take a
/// fifth of this thread at most. What the operator does is seen at once: it makes the picture dirty itself.
int PlotsPanel::rest_ms() const {
  constexpr double share_of_a_pixel = 0.25, longest = 1000.0, rests_for_work = 4.0;
  if (!live_) return replot_ms;
  const double moved = 1e3 * share_of_a_pixel * view_->time().size() / std::max(1, view_->width());
  return static_cast<int>(std::clamp(std::max(moved, rests_for_work * cost_ms_), double(replot_ms), longest));
}

void PlotsPanel::replot_if_due() {
  if (!dirty_ || !isVisible() || window()->isMinimized()) return;
  if (!hurry_ && since_replot_.isValid() && !since_replot_.hasExpired(rest_ms())) return;
  replot_now();
}

void PlotsPanel::replot_now() {
  dirty_ = hurry_ = false;
  since_replot_.start();
  if (live_) follow_time();
  const QRect seen(view_->mapFrom(scroll_->viewport(), QPoint()), scroll_->viewport()->size());
  view_->draw_history(history_, drawn_others(), seen);
  draw_over();
  view_->replot(QCustomPlot::rpQueuedRefresh);
  cost_ms_ = 1e-6 * static_cast<double>(since_replot_.nsecsElapsed());
}

void PlotsPanel::follow_time() {
  const double begin = history_.empty() ? 0.0 : std::min(0.0, history_.first_time());
  const double last = foreseen_ && !foreseen_->empty() ? foreseen_->last_time() : t_;
  if (span_ > 0.0) {
    const double end = std::max(last, begin + span_);
    view_->set_time(end - span_, end);
  } else {
    view_->set_time(history_.empty() ? 0.0 : history_.first_time(), std::max(last, begin + 10.0));
  }
}

void PlotsPanel::leave_live() {
  live_ = false;
  refresh();
  live_button_->setText(playhead_ ? tr("Whole run") : tr("Back to live"));
  place_button();
  live_button_->show();
  live_button_->raise();
}

void PlotsPanel::show_time(double t) {
  const double half = view_->time().size() / 2;
  leave_live();
  view_->set_time(t - half, t + half);
}

void PlotsPanel::go_live() {
  live_ = true;
  refresh();
  live_button_->hide();
}

/// What the cursor reads: the time, the values of the plot under it, and what happened there.
QString PlotsPanel::values_at(const QPoint& where) const {
  const int row = view_->row_at(where);
  if (row < 0) return {};
  return values_of(static_cast<std::size_t>(row), view_->time_at(where), view_->markers().text_at(where.x()));
}

bool PlotsPanel::is_chosen(const PlotRow& row, std::size_t curve) const {
  const auto of = robots_of(row.of, curve, robots_.size());
  return !of || (robots_[of->first] && robots_[of->second]);
}

QString PlotsPanel::values_of(std::size_t row, double t, const QString& events) const {
  const PlotRow& spec = rows_[row];
  QStringList lines{tr("<b>t = %1 s</b>, %2").arg(t, 0, 'f', 2).arg(spec.what)};
  if (mark_) lines << tr("Δt = %1 s since the mark at %2 s").arg(t - *mark_, 0, 'f', 2).arg(*mark_, 0, 'f', 2);
  for (std::size_t c = 0; c < spec.curves.size(); ++c) {
    if (!is_chosen(spec, c)) continue;
    const double value = history_.value(spec.first + c, t);
    QString text = std::isnan(value) ? tr("–") : QStringLiteral("%1 %2").arg(value, 0, 'g', 4).arg(spec.unit);
    if (const double since = mark_ ? value - history_.value(spec.first + c, *mark_) : app::none; !std::isnan(since))
      text += tr(", Δ %1").arg(since, 0, 'g', 4);
    for (std::size_t k = 0; k < others_.size(); ++k)
      if (const double other = others_[k].value(spec.first + c, t); !std::isnan(other))
        text += QStringLiteral(" (%1: %2)").arg(compared_letter(k)).arg(other, 0, 'g', 4);
    lines << (spec.curves[c].isEmpty() ? text : QStringLiteral("%1: %2").arg(spec.curves[c], text));
  }
  for (const std::size_t signal : added_[row]) {
    QStringList values;
    for (std::size_t c = 0; c < rows_[signal].curves.size(); ++c)
      if (const double value = history_.value(rows_[signal].first + c, t); is_chosen(rows_[signal], c))
        values << (rows_[signal].curves[c].isEmpty() ? QString() : rows_[signal].curves[c] + QStringLiteral(": ")) +
                      (std::isnan(value) ? tr("–") : QString::number(value, 'g', 4));
    lines << QStringLiteral("%1 %2: %3")
                 .arg(rows_[signal].title(), rows_[signal].unit, values.join(QStringLiteral("; ")));
  }
  if (spec.band > 0.0) lines << tr("band: ±%1 cm, settled").arg(100 * spec.band);
  if (!events.isEmpty()) lines << events.toHtmlEscaped().replace(QLatin1Char('\n'), QStringLiteral("<br>"));
  return lines.join(QStringLiteral("<br>"));
}

/// From the title of a plot onto another plot: all in this widget, so that no key is lost on the way, which may be
/// STOP.
bool PlotsPanel::drag_signal(QMouseEvent* event, QEvent::Type type) {
  const QPoint where = event->position().toPoint();
  if (type == QEvent::MouseButtonPress && event->button() == Qt::LeftButton) dragged_ = view_->head_at(where);
  if (event->buttons() == Qt::NoButton && type != QEvent::MouseButtonRelease) dragged_ = -1;
  const auto show = [this](Qt::CursorShape shape) {
    if (view_->cursor().shape() != shape) view_->setCursor(shape);
  };
  if (dragged_ < 0) {
    if (event->buttons() == Qt::NoButton) show(view_->head_at(where) >= 0 ? Qt::OpenHandCursor : Qt::ArrowCursor);
    return false;
  }
  const int onto = view_->row_at(where);
  const bool elsewhere = onto >= 0 && onto != dragged_;
  const PlotRow& signal = rows_[static_cast<std::size_t>(dragged_)];
  const QPoint on_screen = event->globalPosition().toPoint();
  if (type == QEvent::MouseButtonRelease) {
    dragged_ = -1;
    show(Qt::ArrowCursor);
    QToolTip::hideText();
    if (elsewhere) drop({signal.name}, on_screen);
    return true;
  }
  show(elsewhere ? Qt::DragCopyCursor : Qt::ClosedHandCursor);
  if (elsewhere)
    drag_over({signal.name}, on_screen);
  else
    QToolTip::showText(on_screen, tr("%1: drop it on another plot").arg(signal.title()), view_);
  return true;
}

/// The plot at a place of the screen that is seen there; -1: none is.
int PlotsPanel::plot_at(const QPoint& where) const {
  const QWidget* seen = scroll_->viewport();
  if (!isVisible() || !seen->rect().contains(seen->mapFromGlobal(where))) return -1;
  return view_->row_at(view_->mapFromGlobal(where));
}

bool PlotsPanel::drag_over(const QStringList& names, const QPoint& where) {
  const int onto = plot_at(where);
  const bool beside = onto < 0 && isVisible() && rect().contains(mapFromGlobal(where));
  const QString what = titles_of(names);
  const QString text = onto >= 0 ? tr("%1 into the plot of %2").arg(what, rows_[static_cast<std::size_t>(onto)].title())
                       : beside  ? tr("%1 in a plot of its own").arg(what)
                                 : tr("%1: drop it on a plot").arg(what);
  QToolTip::showText(where, text, view_);
  return onto >= 0 || beside;
}

void PlotsPanel::drop(const QStringList& names, const QPoint& where) {
  QToolTip::hideText();
  const int onto = plot_at(where);
  if (onto >= 0) {
    const QString why = add_signals(names, rows_[static_cast<std::size_t>(onto)].name);
    if (!why.isEmpty()) QToolTip::showText(where, why, view_);
  } else if (isVisible() && rect().contains(mapFromGlobal(where))) {
    show_signals(names);
  }
}

bool PlotsPanel::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::MouseButtonPress || event->type() == QEvent::MouseMove ||
      event->type() == QEvent::MouseButtonRelease)
    if (drag_signal(static_cast<QMouseEvent*>(event), event->type())) return true;
  if (event->type() == QEvent::MouseMove) {
    const auto* move = static_cast<QMouseEvent*>(event);
    if (move->buttons() & Qt::LeftButton) {
      leave_live();
    } else {
      const QPoint where = move->position().toPoint();
      const bool over = view_->row_at(where) >= 0;
      view_->set_cursor(over ? std::optional(view_->time_at(where)) : std::nullopt);
      QToolTip::showText(move->globalPosition().toPoint(), values_at(where), view_);
    }
  }
  if (event->type() == QEvent::Wheel) {
    const auto* wheel = static_cast<QWheelEvent*>(event);
    const QPoint where = wheel->position().toPoint();
    if (const int row = view_->row_at(where); row >= 0 && wheel->modifiers() & Qt::ControlModifier) {
      const auto of = static_cast<std::size_t>(row);
      zoom_height(of, std::pow(zoom_step, wheel->angleDelta().y() / wheel_notch), view_->value_at(of, where));
      return true;
    }
  }
  if (event->type() == QEvent::KeyPress) {
    const auto* key = static_cast<QKeyEvent*>(event);
    const Qt::KeyboardModifiers other = key->modifiers() & ~(Qt::ShiftModifier | Qt::KeypadModifier);
    if (other == Qt::NoModifier && take_key(key->key(), key->modifiers() & Qt::ShiftModifier)) return true;
  }
  if (event->type() == QEvent::ContextMenu && cursor_ &&
      static_cast<QContextMenuEvent*>(event)->reason() == QContextMenuEvent::Keyboard) {
    context_menu(view_->place_of(cursor_row_, *cursor_));  // there, and not in the middle of all plots
    return true;
  }
  if (event->type() == QEvent::Leave || event->type() == QEvent::FocusOut) {
    cursor_.reset();
    view_->set_cursor(std::nullopt);
  }
  if (event->type() == QEvent::MouseButtonDblClick) {
    if (playhead_)
      emit time_wanted(view_->time_at(static_cast<QMouseEvent*>(event)->position().toPoint()));
    else
      go_live();
  }
  return QWidget::eventFilter(watched, event);
}

void PlotsPanel::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) {
    view_->set_colours(colours(palette()));
    show_over(over_y_, over_x_);
  }
  QWidget::changeEvent(event);
}

void PlotsPanel::showEvent(QShowEvent* event) {
  refresh();
  QWidget::showEvent(event);
}

void PlotsPanel::resizeEvent(QResizeEvent* event) {
  QWidget::resizeEvent(event);
  refresh();
  place_button();
}

void PlotsPanel::place_button() {
  live_button_->adjustSize();
  live_button_->move(width() - live_button_->width() - 16, height() - live_button_->height() - 44);
}

}  // namespace skein::ui
