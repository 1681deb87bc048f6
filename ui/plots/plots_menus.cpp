// The buttons above the plots, and their menus.
#include <QComboBox>
#include <QHBoxLayout>
#include <QMenu>
#include <QToolButton>
#include <QToolTip>
#include <algorithm>

#include "ui/base/dialogs.h"
#include "ui/base/menus.h"
#include "ui/plots/plot_view.h"
#include "ui/plots/plots_panel.h"

namespace skein::ui {
namespace {

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

void PlotsPanel::build_tools(QHBoxLayout* tools) {
  span_box_->setObjectName(QStringLiteral("plot_span"));
  span_box_->setAccessibleName(tr("Time seen"));
  span_box_->setToolTip(tr("Length of the time axis"));
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
  freeze->setToolTip(tr("Freezes the plots for reading; the run goes on and is still recorded"));
  freeze->setAutoRaise(true);
  connect(freeze, &QToolButton::clicked, this, [this] { live_ ? leave_live() : go_live(); });

  connect(plots_menu_, &QMenu::aboutToShow, this, &PlotsPanel::fill_plots_menu);
  connect(robots_menu_, &QMenu::aboutToShow, this, &PlotsPanel::fill_robots_menu);
  auto* save = new QMenu(this);
  save->addAction(tr("Visible part …"), this, [this] { emit save_wanted(false); });
  save->addAction(tr("Everything …"), this, [this] { emit save_wanted(true); });
  tools->addWidget(span_box_);
  tools->addWidget(freeze);
  tools->addWidget(menu_button(tr("Plots"), QStringLiteral("choose_plots"), tr("Which plots are drawn"), plots_menu_));
  tools->addWidget(
      menu_button(tr("Robots"), QStringLiteral("choose_robots"), tr("Whose curves are drawn"), robots_menu_));
  tools->addWidget(menu_button(tr("Save"), QStringLiteral("save_plots"), tr("As PDF, PNG or CSV"), save));
  tools->addStretch();
}

void PlotsPanel::fill_plots_menu() {
  clear_menu(plots_menu_);
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    QAction* action = plots_menu_->addAction(QStringLiteral("%1: %2").arg(rows_[row].title(), rows_[row].what));
    action->setCheckable(true);
    action->setChecked(shown_[row]);
    connect(action, &QAction::toggled, this, [this, name = rows_[row].name](bool on) {
      QStringList names = shown();
      if (on)
        names.append(name);
      else
        names.removeIf(
            [&](const QString& entry) { return entry == name || entry.startsWith(name + QLatin1Char('+')); });
      if (!names.isEmpty()) show_plots(names);
    });
  }
  plots_menu_->addSeparator();
  plots_menu_->addAction(tr("All"), this, &PlotsPanel::show_all_plots);
  plots_menu_->addAction(tr("The usual ones"), this, [this] { show_plots({}); });
  plots_menu_->addSeparator();
  auto* over = plots_menu_->addMenu(tr("One &over another"));
  for (std::size_t row = 0; row < rows_.size(); ++row)
    if (shown_[row]) fill_over_menu(over, row);
  auto* add = plots_menu_->addMenu(tr("&Into another's plot"));
  for (std::size_t row = 0; row < rows_.size(); ++row)
    if (shown_[row]) fill_add_menu(add, row);
  fill_layouts_menu(plots_menu_->addMenu(tr("&Layouts")));
}

void PlotsPanel::fill_layouts_menu(QMenu* menu) {
  const std::vector<PlotLayout> kept = plot_layouts();
  for (const PlotLayout& layout : kept) menu->addAction(layout.name, this, [this, layout] { use(layout); });
  menu->addSeparator();
  menu->addAction(tr("&Save this one …"), this, &PlotsPanel::ask_layout_name)
      ->setObjectName(QStringLiteral("keep_layout"));
  if (kept.empty()) return;
  auto* forget = menu->addMenu(tr("&Forget"));
  for (const PlotLayout& layout : kept)
    forget->addAction(layout.name, this, [name = layout.name] { forget_plot_layout(name); });
}

void PlotsPanel::ask_layout_name() {
  ask_name(this, QStringLiteral("layout_dialog"), tr("Save the layout of the plots"),
           [this](const QString& name) { keep_plot_layout(layout_now(name)); });
}

void PlotsPanel::fill_robots_menu() {
  clear_menu(robots_menu_);
  const auto choose = [this](const std::vector<bool>& robots) {
    robots_ = robots;
    view_->show_robots(robots_);
    refresh();
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

/// What this plot can be drawn over.
void PlotsPanel::fill_over_menu(QMenu* menu, std::size_t y) {
  auto* over = menu->addMenu(tr("Draw %1 o&ver").arg(rows_[y].title()));
  over->setObjectName(QStringLiteral("draw_over"));
  for (const PlotRow& x : rows_) {
    if (x.name == rows_[y].name || x.of != rows_[y].of || x.curves.size() != rows_[y].curves.size()) continue;
    QAction* action = over->addAction(QStringLiteral("%1: %2").arg(x.title(), x.what), this,
                                      [this, from = rows_[y].name, to = x.name] { show_over(from, to); });
    action->setCheckable(true);
    action->setChecked(over_y_ == rows_[y].name && over_x_ == x.name);
  }
  over->addSeparator();
  over->addAction(tr("Nothing: only over time"), this, [this] { show_over({}, {}); })->setEnabled(!over_y_.isEmpty());
}

/// What can be drawn in this plot as well.
void PlotsPanel::fill_add_menu(QMenu* menu, std::size_t plot) {
  auto* add = menu->addMenu(tr("Into the plot of %1").arg(rows_[plot].title()));
  add->setObjectName(QStringLiteral("add_signal"));
  for (std::size_t signal = 0; signal < rows_.size(); ++signal) {
    if (signal == plot) continue;
    add_choice(add, QStringLiteral("%1: %2").arg(rows_[signal].title(), rows_[signal].what), {rows_[signal].name},
               rows_[plot].name);
  }
}

/// An action that draws the signals in another's plot, or no longer.
void PlotsPanel::add_choice(QMenu* menu, const QString& text, const QStringList& signal, const QString& plot) {
  const std::vector<std::size_t>& there = added_[*row_of(plot)];
  QAction* action = menu->addAction(text);
  action->setCheckable(true);
  action->setChecked(std::all_of(signal.begin(), signal.end(), [&](const QString& name) {
    return std::find(there.begin(), there.end(), row_of(name)) != there.end();
  }));
  connect(action, &QAction::toggled, this, [this, signal, plot](bool on) {
    if (!on)
      for (const QString& name : signal) remove_signal(name, plot);
    else if (const QString why = add_signals(signal, plot); !why.isEmpty())
      QToolTip::showText(QCursor::pos(), why, view_);
  });
}

void PlotsPanel::fill_signal_menu(QMenu* menu, const QStringList& names) {
  menu->addAction(tr("In a plot of its &own"), this, [this, names] { show_signals(names); });
  menu->addSeparator();
  for (std::size_t plot = 0; plot < rows_.size(); ++plot)
    if (shown_[plot] && !names.contains(rows_[plot].name))
      add_choice(menu, tr("In the plot of %1: %2").arg(rows_[plot].title(), rows_[plot].what), names, rows_[plot].name);
}

void PlotsPanel::context_menu(const QPoint& where) {
  auto* menu = new QMenu(this);
  menu->setAttribute(Qt::WA_DeleteOnClose);
  menu->addAction(tr("Save the visible part …"), this, [this] { emit save_wanted(false); });
  menu->addAction(tr("Save everything …"), this, [this] { emit save_wanted(true); });
  menu->addAction(tr("Back to live"), this, &PlotsPanel::go_live)->setEnabled(!live_);
  menu->addSeparator();
  menu->addAction(tr("Measure from here"), this, [this, t = view_->time_at(where)] { set_mark(t); });
  menu->addAction(tr("Remove the mark"), this, [this] { set_mark({}); })->setEnabled(mark_.has_value());
  if (const int row = std::max(view_->row_at(where), view_->head_at(where)); row >= 0) {
    fill_over_menu(menu, static_cast<std::size_t>(row));
    fill_add_menu(menu, static_cast<std::size_t>(row));
  }
  menu->addAction(tr("Fit all heights"), this, &PlotsPanel::fit_heights)->setEnabled(view_->holds_heights());
  menu->popup(view_->mapToGlobal(where));
}

}  // namespace skein::ui
