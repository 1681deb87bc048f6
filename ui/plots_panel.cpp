#include "ui/plots_panel.h"

#include <QComboBox>
#include <QHBoxLayout>
#include <QMenu>
#include <QScrollArea>
#include <QToolButton>
#include <QToolTip>
#include <algorithm>
#include <cmath>

#include "ui/modes.h"
#include "ui/plot_view.h"

namespace skein::ui {
namespace {

constexpr int replot_ms = 60;                   // at most some 16 pictures a second
constexpr std::size_t most_bytes = 64'000'000;  // of curves, but half an hour at 25 Hz whatever it takes

std::size_t most_samples(std::size_t curves) {
  constexpr std::size_t least = 49152, most = 131072, sample_bytes = 9;
  return std::clamp(most_bytes / (sample_bytes * std::max<std::size_t>(1, curves)), least, most);
}

QToolButton* menu_button(const QString& text, const QString& name, const QString& tip, QMenu* menu) {
  auto* button = new QToolButton;
  button->setObjectName(name);
  button->setText(text);
  button->setAccessibleName(text);
  button->setToolTip(tip);
  button->setMenu(menu);
  button->setPopupMode(QToolButton::InstantPopup);
  button->setAutoRaise(true);
  return button;
}

}  // namespace

PlotsPanel::PlotsPanel(QWidget* parent)
    : QWidget(parent),
      view_(new PlotView),
      scroll_(new QScrollArea(this)),
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
  layout->addWidget(scroll_, 1);

  view_->set_colours(colours(palette()));
  view_->setContextMenuPolicy(Qt::CustomContextMenu);
  view_->installEventFilter(this);
  connect(view_, &QWidget::customContextMenuRequested, this, &PlotsPanel::context_menu);
  connect(view_, &QCustomPlot::mouseWheel, this, &PlotsPanel::leave_live);
  connect(live_button_, &QPushButton::clicked, this, &PlotsPanel::go_live);
  connect(&timer_, &QTimer::timeout, this, &PlotsPanel::replot_if_due);
  timer_.start(replot_ms);
}

PlotsPanel::~PlotsPanel() = default;

void PlotsPanel::build_tools(QHBoxLayout* tools) {
  span_box_->setObjectName(QStringLiteral("plot_span"));
  span_box_->setAccessibleName(tr("Time seen"));
  span_box_->setToolTip(tr("How much of the time is seen"));
  for (const auto& [text, seconds] : {std::pair{tr("10 s"), 10.0},
                                      {tr("1 min"), 60.0},
                                      {tr("5 min"), 300.0},
                                      {tr("30 min"), 1800.0},
                                      {tr("All"), 0.0}})
    span_box_->addItem(text, seconds);
  span_box_->setCurrentIndex(span_box_->findData(span_));
  connect(span_box_, &QComboBox::activated, this, [this] { set_span(span_box_->currentData().toDouble()); });

  auto* freeze = new QToolButton;
  freeze->setObjectName(QStringLiteral("freeze_plots"));
  freeze->setText(tr("Hold"));
  freeze->setAccessibleName(tr("Hold the plots"));
  freeze->setToolTip(tr("The picture stands still to be read; the run goes on, and nothing of it is lost"));
  freeze->setAutoRaise(true);
  connect(freeze, &QToolButton::clicked, this, [this] { live_ ? leave_live() : go_live(); });

  connect(plots_menu_, &QMenu::aboutToShow, this, &PlotsPanel::fill_plots_menu);
  connect(robots_menu_, &QMenu::aboutToShow, this, &PlotsPanel::fill_robots_menu);
  auto* save = new QMenu(this);
  save->addAction(tr("What is seen …"), this, [this] { emit save_wanted(false); });
  save->addAction(tr("Everything …"), this, [this] { emit save_wanted(true); });
  tools->addWidget(span_box_);
  tools->addWidget(freeze);
  tools->addWidget(menu_button(tr("Plots"), QStringLiteral("choose_plots"), tr("Which plots are drawn"), plots_menu_));
  tools->addWidget(
      menu_button(tr("Robots"), QStringLiteral("choose_robots"), tr("Whose curves are drawn"), robots_menu_));
  tools->addWidget(menu_button(tr("Save"), QStringLiteral("save_plots"), tr("As PDF, PNG or CSV"), save));
  tools->addStretch();
}

void PlotsPanel::show_experiment(const app::Experiment& experiment) {
  rows_ = plot_rows(experiment);
  const std::size_t curves = curve_count(rows_);
  history_ = PlotHistory(curves, most_samples(curves));
  other_.reset();
  playhead_.reset();
  robots_.assign(experiment.robots.size(), true);
  t_ = 0.0;
  selected_ = -1;
  view_->markers().clear();
  view_->select(-1);
  rebuild();
  go_live();
}

void PlotsPanel::rebuild() {
  shown_.assign(rows_.size(), false);
  for (std::size_t row = 0; row < rows_.size(); ++row)
    shown_[row] = wanted_.isEmpty() ? rows_[row].usual : wanted_.contains(rows_[row].name);
  view_->set_rows(rows_, shown_, robots_.size());
  view_->show_robots(robots_);
  if (playhead_) view_->set_playhead(playhead_);
  dirty_ = true;
}

QStringList PlotsPanel::shown() const {
  QStringList names;
  for (std::size_t row = 0; row < rows_.size(); ++row)
    if (shown_[row]) names << rows_[row].name;
  return names;
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

void PlotsPanel::take(const app::TickRecord& record) {
  note_events(record);
  const bool new_time = record.t > t_ || history_.empty();
  dirty_ = dirty_ || new_time || !record.events.empty();
  if (new_time) store_values(record);
}

void PlotsPanel::note_events(const app::TickRecord& record) {
  for (const app::Event& event : record.events)
    if (severity(event) != Severity::note)
      view_->markers().add(record.t, QString::fromStdString(app::describe(event)),
                           colour(severity(event), colours(palette())));
}

void PlotsPanel::store_values(const app::TickRecord& record) {
  t_ = record.t;
  sample(rows_, record, values_);
  history_.add(t_, values_);
}

void PlotsPanel::show_run(const std::vector<app::TickRecord>& rows) {
  for (const app::TickRecord& row : rows) take(row);
  set_span(0.0);
}

void PlotsPanel::set_playhead(double t) {
  playhead_ = t;
  view_->set_playhead(t);
}

void PlotsPanel::compare(const std::vector<app::TickRecord>* rows) {
  other_.reset();
  dirty_ = true;
  if (!rows) return;
  other_.emplace(history_.curves(), most_samples(history_.curves()));
  double last = -1.0;
  for (const app::TickRecord& row : *rows) {
    if (row.t <= last) continue;
    last = row.t;
    sample(rows_, row, values_);
    other_->add(row.t, values_);
  }
}

void PlotsPanel::select(int robot) {
  if (selected_ == robot) return;
  selected_ = robot;
  view_->select(robot);
  dirty_ = true;
}

void PlotsPanel::set_span(double seconds) {
  span_ = seconds;
  span_box_->setCurrentIndex(span_box_->findData(seconds));
  go_live();
}

void PlotsPanel::replot_if_due() {
  if (!dirty_ || !isVisible() || window()->isMinimized()) return;
  dirty_ = false;
  if (live_) follow_time();
  view_->draw(history_, other_ ? &*other_ : nullptr);
  view_->replot(QCustomPlot::rpQueuedReplot);
}

void PlotsPanel::follow_time() {
  const double begin = history_.empty() ? 0.0 : std::min(0.0, history_.first_time());
  if (span_ > 0.0) {
    const double end = std::max(t_, begin + span_);
    view_->set_time(end - span_, end);
  } else {
    view_->set_time(history_.empty() ? 0.0 : history_.first_time(), std::max(t_, begin + 10.0));
  }
}

void PlotsPanel::leave_live() {
  live_ = false;
  dirty_ = true;
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
  dirty_ = true;
  live_button_->hide();
}

void PlotsPanel::fill_plots_menu() {
  plots_menu_->clear();
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    QAction* action = plots_menu_->addAction(QStringLiteral("%1: %2").arg(rows_[row].name, rows_[row].what));
    action->setCheckable(true);
    action->setChecked(shown_[row]);
    connect(action, &QAction::toggled, this, [this, name = rows_[row].name](bool on) {
      QStringList names = shown();
      on ? names.append(name) : static_cast<void>(names.removeAll(name));
      if (!names.isEmpty()) show_plots(names);
    });
  }
  plots_menu_->addSeparator();
  plots_menu_->addAction(tr("All"), this, &PlotsPanel::show_all_plots);
  plots_menu_->addAction(tr("The usual ones"), this, [this] { show_plots({}); });
}

void PlotsPanel::fill_robots_menu() {
  robots_menu_->clear();
  const auto choose = [this](const std::vector<bool>& robots) {
    robots_ = robots;
    view_->show_robots(robots_);
    dirty_ = true;
  };
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    QAction* action = robots_menu_->addAction(tr("Robot %1").arg(i + 1));
    action->setCheckable(true);
    action->setChecked(robots_[i]);
    connect(action, &QAction::toggled, this, [this, i, choose](bool on) {
      std::vector<bool> robots = robots_;
      robots[i] = on;
      choose(robots);
    });
  }
  robots_menu_->addSeparator();
  robots_menu_->addAction(tr("All"), this, [this, choose] { choose(std::vector<bool>(robots_.size(), true)); });
  robots_menu_
      ->addAction(tr("Only the selected one"), this,
                  [this, choose] {
                    std::vector<bool> robots(robots_.size(), false);
                    if (selected_ >= 0) robots[static_cast<std::size_t>(selected_)] = true;
                    choose(robots);
                  })
      ->setEnabled(selected_ >= 0);
}

void PlotsPanel::context_menu(const QPoint& where) {
  auto* menu = new QMenu(this);
  menu->setAttribute(Qt::WA_DeleteOnClose);
  menu->addAction(tr("Save what is seen …"), this, [this] { emit save_wanted(false); });
  menu->addAction(tr("Save everything …"), this, [this] { emit save_wanted(true); });
  menu->addAction(tr("Back to live"), this, &PlotsPanel::go_live)->setEnabled(!live_);
  menu->popup(view_->mapToGlobal(where));
}

/// What the cursor reads: the time, the values of the plot under it, and what happened there.
QString PlotsPanel::values_at(const QPoint& where) const {
  const int row = view_->row_at(where);
  if (row < 0) return {};
  const PlotRow& spec = rows_[static_cast<std::size_t>(row)];
  const double t = view_->time_at(where);
  QStringList lines{tr("<b>t = %1 s</b>, %2").arg(t, 0, 'f', 2).arg(spec.what)};
  for (std::size_t c = 0; c < spec.curves.size(); ++c) {
    if (spec.of == PlotRow::Of::robot && !robots_[c]) continue;
    const double value = history_.value(spec.first + c, t);
    QString text = std::isnan(value) ? tr("–") : QStringLiteral("%1 %2").arg(value, 0, 'g', 4).arg(spec.unit);
    if (other_ && !std::isnan(other_->value(spec.first + c, t)))
      text += tr(" (other run: %1)").arg(other_->value(spec.first + c, t), 0, 'g', 4);
    lines << (spec.curves[c].isEmpty() ? text : QStringLiteral("%1: %2").arg(spec.curves[c], text));
  }
  const QString events = view_->markers().text_at(where.x());
  if (!events.isEmpty()) lines << events.toHtmlEscaped().replace(QLatin1Char('\n'), QStringLiteral("<br>"));
  return lines.join(QStringLiteral("<br>"));
}

bool PlotsPanel::eventFilter(QObject* watched, QEvent* event) {
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
  if (event->type() == QEvent::Leave) view_->set_cursor(std::nullopt);
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
  dirty_ = true;
  place_button();
}

void PlotsPanel::place_button() {
  live_button_->adjustSize();
  live_button_->move(width() - live_button_->width() - 16, height() - live_button_->height() - 44);
}

}  // namespace skein::ui
