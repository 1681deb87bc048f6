#pragma once

#include <QAction>
#include <QMenu>
#include <QSettings>
#include <QToolBar>
#include <array>

#include "app/experiment/experiment.h"

namespace skein::ui {

class ArenaView;

/// The actions for what the arena shows and for its mouse tool: in the menus View and Arena, and in the bar above it.
class ArenaActions final : public QObject {
  Q_OBJECT

 public:
  explicit ArenaActions(ArenaView* arena, QObject* parent = nullptr);
  void build_view_menu(QMenu* view);
  void build_tool_menu(QMenu* menu);
  void build_tool_bar(QToolBar* bar);
  void show_experiment(const app::Experiment& experiment);
  /// Shows the camera's picture, where there is one.
  void show_picture();
  void draw_icons(const QColor& ink);
  void restore(const QSettings& stored);
  void store(QSettings& stored) const;

 private:
  QAction* toggle(const QString& text, const QString& name, bool on, void (ArenaView::*show)(bool));

  ArenaView* arena_;
  QAction *picture_, *regions_, *trails_, *couplings_, *grid_, *fit_, *zoom_in_, *zoom_out_;
  std::array<QAction*, 4> tools_{};  // in the order of ArenaTool
};

}  // namespace skein::ui
