#pragma once

#include <QPushButton>
#include <QTimer>
#include <QWidget>
#include <vector>

#include "app/experiment.h"
#include "app/tick_record.h"
#include "ui/event_markers.h"
#include "ui/palette.h"

class QCPAxisRect;
class QCPGraph;
class QCPLegend;
class QCustomPlot;

namespace skein::ui {

class MathTitle;

/// The errors of Fig. 4 as they come: e_x, e_y, e_theta of every robot in the world frame, delta of every pair of
/// neighbours, and V, one below the other along one time.
class PlotsPanel final : public QWidget {
  Q_OBJECT

 public:
  static constexpr double window_seconds = 60.0;
  static constexpr double history_seconds = 900.0;

  explicit PlotsPanel(QWidget* parent = nullptr);
  ~PlotsPanel() override;

  void show_experiment(const app::Experiment& experiment);
  void take(const app::TickRecord& record);
  void select(int robot);  ///< from 0, drawn bold; -1: all alike
  void go_live();
  bool is_live() const { return live_; }
  /// As .pdf or .png, dark on white whatever the screen looks like. The answer says what went wrong; empty: nothing.
  QString save(const QString& file);

  QSize sizeHint() const override { return {430, 600}; }
  QSize minimumSizeHint() const override { return {260, 300}; }

 signals:
  void save_wanted();

 protected:
  void changeEvent(QEvent*) override;
  void resizeEvent(QResizeEvent*) override;
  void showEvent(QShowEvent*) override;
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  enum Row { e_x, e_y, e_theta, delta, lyapunov, rows };

  void make_rows();
  QCPGraph* add_graph(Row row);
  void style(const Colours& colours);
  void style_graphs(const Colours& colours);
  void replot_if_due();
  void follow_time();
  void fit_values();
  void leave_live();
  void context_menu(const QPoint& where);
  void place_button();

  QCustomPlot* plot_;
  QPushButton* live_button_;
  std::vector<QCPAxisRect*> rects_;
  std::vector<MathTitle*> titles_;
  QCPLegend *robots_legend_, *pairs_legend_;
  std::vector<QCPGraph*> graphs_[rows];  // of every robot, of every pair, one
  EventMarkers markers_;
  QTimer timer_;
  double t_ = 0.0;
  int selected_ = -1;
  bool live_ = true, dirty_ = false;
};

}  // namespace skein::ui
