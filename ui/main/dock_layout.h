#pragma once

#include <QDockWidget>
#include <QMainWindow>
#include <QSettings>
#include <QSize>
#include <array>
#include <map>

class QMenu;

namespace skein::ui {

/// Where the panels around the arena are, and how large: as the operator made them, smaller in a smaller window. After
/// shrinking and growing, the window is as before.
class DockLayout final : public QObject {
  Q_OBJECT

 public:
  struct Panels {
    QWidget *gains, *plots, *robots, *events, *results;
  };
  /// Puts each panel into a dock, which the window owns.
  DockLayout(const Panels& panels, QMainWindow* window);

  QDockWidget* gains() const { return gains_; }
  QDockWidget* plots() const { return plots_; }
  QDockWidget* robots() const { return robots_; }
  QDockWidget* events() const { return events_; }
  QDockWidget* results() const { return results_; }

  /// The window and its docks as a newcomer finds them.
  void set_usual();
  /// The window and its docks as they were stored, if they were.
  void restore(const QSettings& stored);
  void store(QSettings& stored) const;
  /// Which of the panels are shown, and back to the usual layout.
  void fill_menu(QMenu* menu);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  std::array<QDockWidget*, 5> all() const { return {gains_, plots_, robots_, events_, results_}; }
  QDockWidget* dock(QWidget* panel, const QString& title, const QString& name, Qt::DockWidgetArea area);
  QDockWidget* front(QDockWidget* dock) const;
  void fit();
  /// In a narrow window, puts the plots in a tab behind the gains, if both are at their usual places: the arena gets
  /// the room.
  void stack_columns();
  int columns_width() const;
  bool columns_fit_screen() const;
  void on_window_resized();
  void on_dock_resized(QDockWidget* dock);

  QMainWindow* window_;
  QDockWidget *gains_, *plots_, *robots_, *events_, *results_;
  std::map<QDockWidget*, QSize> sizes_;  // the usual or the operator's, in a window of this size:
  QSize sized_in_, settled_;
  int gains_need_ = 0;     // width, at least
  bool stacked_ = false;   // plots behind the gains, by stack_columns
  bool restored_ = false;  // the sizes of the last time hold, once the window is seen
};

/// Shows a panel, before those that are tabs of the same place.
void bring_forward(QDockWidget* dock);

}  // namespace skein::ui
