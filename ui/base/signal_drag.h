#pragma once

#include <QAbstractItemView>
#include <QPoint>
#include <QStringList>
#include <functional>

namespace skein::ui {

/// The role under which a table's cell names the plots (PlotRow::name) that show its value: a QStringList.
inline constexpr int plotted_role = Qt::UserRole + 1;

/// Lets what a table's cells show be dragged out of the table. It uses the table's own mouse events: a drag of Qt's
/// (QDrag) would take every key until it ends, and a key may be STOP.
class SignalDrag final : public QObject {
  Q_OBJECT

 public:
  /// Where it may end; `where` is on the screen.
  struct Target {
    std::function<bool(const QStringList& names, const QPoint& where)> over;  ///< whether they can be dropped there
    std::function<void(const QStringList& names, const QPoint& where)> drop;
  };
  SignalDrag(QAbstractItemView* table, Target target);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void begin(const QPoint& where);
  bool move(const QMouseEvent& event);
  bool end(const QPoint& where);

  QAbstractItemView* table_;
  Target target_;
  QPoint pressed_at_;
  QStringList names_;  // what was pressed; empty: nothing that can be plotted
  bool drags_ = false;
};

}  // namespace skein::ui
