#include "ui/main/arena_actions.h"

#include <QActionGroup>

#include "ui/arena/arena_view.h"
#include "ui/base/icons.h"

namespace skein::ui {

ArenaActions::ArenaActions(ArenaView* arena, QObject* parent) : QObject(parent), arena_(arena) {
  picture_ = toggle(tr("&Camera picture"), QStringLiteral("view_picture"), false, &ArenaView::show_picture);
  regions_ = toggle(tr("&Detection regions"), QStringLiteral("view_regions"), true, &ArenaView::show_regions);
  trails_ = toggle(tr("&Trails"), QStringLiteral("view_trails"), true, &ArenaView::show_trails);
  couplings_ = toggle(tr("Co&uplings"), QStringLiteral("view_couplings"), true, &ArenaView::show_couplings);
  grid_ = toggle(tr("&Grid"), QStringLiteral("view_grid"), true, &ArenaView::show_grid);
  const auto action = [this](const QString& text, const QString& name, const QKeySequence& keys,
                             void (ArenaView::*slot)()) {
    auto* made = new QAction(text, this);
    made->setObjectName(name);
    made->setShortcut(keys);
    connect(made, &QAction::triggered, arena_, slot);
    return made;
  };
  fit_ = action(tr("&Whole arena"), QStringLiteral("fit"), QKeySequence(tr("Ctrl+0")), &ArenaView::fit);
  zoom_in_ = action(tr("Zoom &in"), QStringLiteral("zoom_in"), QKeySequence::ZoomIn, &ArenaView::zoom_in);
  zoom_out_ = action(tr("&Zoom out"), QStringLiteral("zoom_out"), QKeySequence::ZoomOut, &ArenaView::zoom_out);

  auto* group = new QActionGroup(this);
  const auto tool = [&](ArenaTool which, const QString& text, const QString& name, const QKeySequence& keys,
                        const QString& tip) {
    auto* made = new QAction(text, this);
    made->setObjectName(name);
    made->setShortcut(keys);
    made->setToolTip(tip);
    made->setCheckable(true);
    made->setChecked(which == ArenaTool::hand);
    group->addAction(made);
    connect(made, &QAction::toggled, arena_, [this, which](bool on) {
      if (on) arena_->set_tool(which);
    });
    tools_[static_cast<std::size_t>(which)] = made;
  };
  tool(ArenaTool::hand, tr("&Hand"), QStringLiteral("tool_hand"), QKeySequence(tr("H")),
       tr("Hand (H): drag robots and obstacles, turn robots with the wheel, click a coupling to switch it"));
  tool(ArenaTool::kick, tr("&Kick"), QStringLiteral("tool_kick"), QKeySequence(tr("K")),
       tr("Kick (K): draw an arrow from a simulated robot, and it slides in that direction"));
  tool(ArenaTool::measure, tr("&Measure"), QStringLiteral("tool_measure"), QKeySequence(tr("M")),
       tr("Measure (M): drag from point to point; the ends snap to robots and obstacles"));
  tool(ArenaTool::obstacle, tr("&Obstacle"), QStringLiteral("tool_obstacle"), QKeySequence(tr("O")),
       tr("Obstacle (O): click drops one, drag draws it out to its size"));
}

QAction* ArenaActions::toggle(const QString& text, const QString& name, bool on, void (ArenaView::*show)(bool)) {
  auto* made = new QAction(text, this);
  made->setObjectName(name);
  made->setCheckable(true);
  made->setChecked(on);
  connect(made, &QAction::toggled, arena_, show);
  return made;
}

void ArenaActions::build_view_menu(QMenu* view) {
  view->addActions({picture_, regions_, trails_, couplings_, grid_});
  view->addSeparator();
  view->addActions({fit_, zoom_in_, zoom_out_});
}

void ArenaActions::build_tool_menu(QMenu* menu) {
  for (QAction* tool : tools_) menu->addAction(tool);
}

void ArenaActions::build_tool_bar(QToolBar* bar) {
  bar->setObjectName(QStringLiteral("arena_tools"));
  bar->setIconSize({18, 18});
  bar->addActions({fit_, zoom_in_, zoom_out_});
  bar->addSeparator();
  bar->addActions({picture_, couplings_, regions_, trails_, grid_});
  bar->addSeparator();
  for (QAction* tool : tools_) bar->addAction(tool);
}

void ArenaActions::show_experiment(const app::Experiment& experiment) {
  picture_->setEnabled(experiment.camera.kind() != app::CameraKind::absent);
  regions_->setEnabled(experiment.avoidance.enabled || experiment.shield.enabled);
}

void ArenaActions::show_picture() {
  if (picture_->isEnabled()) picture_->setChecked(true);
}

void ArenaActions::draw_icons(const QColor& ink) {
  fit_->setIcon(icon(QStringLiteral("fit"), ink));
  zoom_in_->setIcon(icon(QStringLiteral("zoom-in"), ink));
  zoom_out_->setIcon(icon(QStringLiteral("zoom-out"), ink));
  picture_->setIcon(icon(QStringLiteral("camera"), ink));
  regions_->setIcon(icon(QStringLiteral("regions"), ink));
  trails_->setIcon(icon(QStringLiteral("trails"), ink));
  couplings_->setIcon(icon(QStringLiteral("couplings"), ink));
  grid_->setIcon(icon(QStringLiteral("grid"), ink));
  for (QAction* tool : tools_) tool->setIcon(icon(tool->objectName().mid(5), ink));  // "tool_hand": the icon "hand"
}

void ArenaActions::restore(const QSettings& stored) {
  regions_->setChecked(stored.value(QStringLiteral("regions"), true).toBool());
  trails_->setChecked(stored.value(QStringLiteral("trails"), true).toBool());
  couplings_->setChecked(stored.value(QStringLiteral("couplings"), true).toBool());
  grid_->setChecked(stored.value(QStringLiteral("grid"), true).toBool());
}

void ArenaActions::store(QSettings& stored) const {
  stored.setValue(QStringLiteral("regions"), regions_->isChecked());
  stored.setValue(QStringLiteral("trails"), trails_->isChecked());
  stored.setValue(QStringLiteral("couplings"), couplings_->isChecked());
  stored.setValue(QStringLiteral("grid"), grid_->isChecked());
}

}  // namespace skein::ui
