#pragma once

#include <QElapsedTimer>
#include <QEvent>
#include <QPushButton>
#include <QStringList>
#include <QTimer>
#include <QWidget>
#include <memory>
#include <optional>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "ui/plots/plot_history.h"
#include "ui/plots/plot_layouts.h"
#include "ui/plots/plot_rows.h"

class QComboBox;
class QHBoxLayout;
class QMenu;
class QScrollArea;
class QToolButton;

namespace skein::ui {

class ComparisonBar;
class PlotView;
class XyPlot;

/// A run's numbers as they come, along one time: errors, V, commands with their limits, period and the cost of a tick.
/// The operator chooses plots, robots and the visible time, freezes the picture, reads values at the mouse, and saves
/// the visible part or everything. Half an hour costs no more to draw than a minute.
class PlotsPanel final : public QWidget {
  Q_OBJECT

 public:
  static constexpr double zoom_step = 1.25;  ///< of a key, or of a notch of the wheel
  explicit PlotsPanel(QWidget* parent = nullptr);
  ~PlotsPanel() override;

  void show_experiment(const app::Experiment& experiment);
  void show_record(const app::TickRecord& record);
  /// A line marks where a replay is.
  void set_playhead(std::optional<double> t);  ///< none: no line
  /// Another run behind this one.
  struct Compared {
    const std::vector<app::TickRecord>* rows;
    double shift = 0.0;  ///< by how much later its times are drawn [s]
    bool shown = true;
  };
  /// Draws other runs paler behind this one, each with a line of its own; none: only this one.
  void compare(const std::vector<Compared>& runs);
  /// Draws this run's next seconds paler; empty: none.
  void foresee(const std::vector<app::TickRecord>& rows);
  const std::optional<PlotHistory>& foreseen() const { return foreseen_; }
  /// Values at the mouse and the cursor are also shown as differences from those at this time; none: no longer.
  void set_mark(std::optional<double> t);
  std::optional<double> mark() const { return mark_; }
  /// All plots follow their curves again, in height.
  void fit_heights();
  ComparisonBar& comparison_bar() { return *comparison_bar_; }

  /// Draws one plot's curves over another's below the others; false: there are no two such plots with equally many
  /// curves. Empty names: removes it.
  bool show_over(const QString& y, const QString& x);
  XyPlot& over() { return *over_; }

  void select(int robot);  ///< from 0, drawn bold; -1: all alike
  void go_live();
  void show_time(double t);  ///< in the middle, with frozen plots
  bool is_live() const { return live_; }
  /// The length of time that is seen; 0: all of it. [s]
  void set_span(double seconds);
  double span() const { return span_; }

  /// Names of the plots that are drawn; one with the curves of others in it has their names as well: "e_x+v".
  QStringList shown() const;
  void show_plots(const QStringList& names);
  /// Draws a row's curves in another's plot as well, or no longer. Those with another unit share one axis at the right,
  /// and one unit. Returns why that is not possible; empty: it is done.
  QString add_signal(const QString& signal, const QString& plot);
  void remove_signal(const QString& signal, const QString& plot);
  /// Signals of these names in a plot of their own, which comes into view.
  void show_signals(const QStringList& names);
  /// Their names in menus.
  QString titles_of(const QStringList& names) const;
  /// Signals that are dragged here from elsewhere, to this place of the screen: shows beside it what a drop would do;
  /// false: nothing.
  bool drag_over(const QStringList& names, const QPoint& where);
  /// Dropped on a plot, they are also drawn in it; beside the plots, they get one of their own.
  void drop(const QStringList& names, const QPoint& where);
  /// The same by keys: every place where they can be drawn.
  void fill_signal_menu(QMenu* menu, const QStringList& names);
  void show_all_plots();

  /// What is drawn and how, to restore it later.
  PlotLayout layout_now(const QString& name) const;
  void use(const PlotLayout& layout);

  /// As .pdf or .png, dark on white whatever the screen looks like; as .csv what is seen, or everything. Returns the
  /// error; empty: none.
  QString save(const QString& file, bool everything = false);

  const PlotHistory& history() const { return history_; }
  const std::vector<PlotRow>& rows() const { return rows_; }
  PlotView& view() { return *view_; }
  QSize sizeHint() const override { return {430, 600}; }
  QSize minimumSizeHint() const override { return {QWidget::minimumSizeHint().width(), 150}; }  // its buttons fit

 signals:
  void save_wanted(bool everything);
  void time_wanted(double t);  ///< a replay is to go there

 protected:
  void changeEvent(QEvent*) override;
  void resizeEvent(QResizeEvent*) override;
  void showEvent(QShowEvent*) override;
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void build_tools(QHBoxLayout* tools);
  void rebuild();
  void store_values(const app::TickRecord& record);
  void note_events(const app::TickRecord& record);
  void refresh() { dirty_ = hurry_ = true; }  // at the next refresh: the operator is waiting for it
  void replot_if_due();
  void replot_now();
  int rest_ms() const;
  void follow_time();
  void leave_live();
  void place_button();
  void fill_plots_menu();
  void fill_robots_menu();
  void fill_layouts_menu(QMenu* menu);
  void ask_layout_name();
  void context_menu(const QPoint& where);
  void fill_over_menu(QMenu* menu, std::size_t y);
  void fill_add_menu(QMenu* menu, std::size_t plot);
  void add_choice(QMenu* menu, const QString& text, const QStringList& signal, const QString& plot);
  QString add_signals(const QStringList& names, const QString& plot);
  int plot_at(const QPoint& where) const;
  void reveal(std::size_t row);
  std::optional<std::size_t> row_of(const QString& name) const;
  bool drag_signal(QMouseEvent* event, QEvent::Type type);
  void draw_over();
  bool is_chosen(const PlotRow& row, std::size_t curve) const;  // its robots are
  QString values_at(const QPoint& where) const;
  QString values_of(std::size_t row, double t, const QString& events) const;
  bool take_key(int key, bool fine);
  void zoom_height(std::size_t row, double times, std::optional<double> value = {});
  void move_cursor(double t);
  void show_values();
  QString save_csv(const QString& file, double from, double to) const;
  bool save_picture(const QString& file, bool pdf);
  bool is_saved(std::size_t row) const;

  std::vector<const PlotHistory*> drawn_others() const;

  PlotView* view_;
  ComparisonBar* comparison_bar_;
  QScrollArea* scroll_;
  XyPlot* over_;
  QString over_y_, over_x_;  // names of the rows that it shows; empty: none
  QPushButton* live_button_;
  QComboBox* span_box_;
  QMenu *plots_menu_, *robots_menu_;
  std::vector<PlotRow> rows_;
  std::vector<bool> shown_, robots_;
  std::vector<std::vector<std::size_t>> added_;  // of each row, those that are drawn in its plot as well
  int dragged_ = -1;                             // the row whose title is dragged; -1: none
  QStringList wanted_;                           // chosen by the operator; empty: the usual ones
  PlotHistory history_;
  std::vector<PlotHistory> others_;      // of the compared runs, empty where one is switched off
  std::optional<PlotHistory> foreseen_;  // itself empty: its curves have places, but no preview is requested
  std::vector<double> values_;
  QTimer timer_;
  QElapsedTimer since_replot_;
  double cost_ms_ = 0.0;  // of the last picture
  std::optional<double> playhead_, mark_;
  std::optional<double> cursor_;  // where the keyboard reads, and in which plot of all
  std::size_t cursor_row_ = 0;
  double t_ = 0.0, span_ = 60.0;
  int selected_ = -1;
  bool live_ = true, dirty_ = false, hurry_ = false;
};

}  // namespace skein::ui
