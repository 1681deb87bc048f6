// The window's menus, dialogs and settings.
#include <QActionGroup>
#include <QApplication>
#include <QFileDialog>
#include <QFileInfo>
#include <QMenuBar>
#include <QMessageBox>
#include <QSettings>

#include "ui/arena/arena_view.h"
#include "ui/gains/gains_panel.h"
#include "ui/help.h"
#include "ui/icons.h"
#include "ui/main/main_window.h"
#include "ui/modes.h"
#include "ui/plots/plots_panel.h"
#include "ui/run/alert_strip.h"
#include "ui/run/run_bar.h"
#include "ui/settings.h"

namespace skein::ui {
namespace {

constexpr int layout_version = 1;  // of the docks: a layout of another version is not restored

/// Dialogs never block the window: STOP can be clicked while one is open. And they are Qt's own, never the desktop's,
/// so that Space and Esc reach the program.
template <typename Dialog>
void show_beside(Dialog* dialog) {
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowModality(Qt::NonModal);
  dialog->show();
}

QFileDialog* file_dialog(QWidget* parent, const QString& title, const QString& name, const QString& filter) {
  auto* dialog = new QFileDialog(parent, title, QString(), filter);
  dialog->setObjectName(name);
  dialog->setOption(QFileDialog::DontUseNativeDialog);
  return dialog;
}

void message(QWidget* parent, const QString& name, const QString& title, const QString& text) {
  auto* box = new QMessageBox(parent);
  box->setObjectName(name);
  box->setWindowTitle(title);
  box->setTextFormat(Qt::RichText);
  box->setText(text);
  box->setStandardButtons(QMessageBox::Close);
  show_beside(box);
}

}  // namespace

void MainWindow::build_menus(QMenuBar* menus) {
  const auto action = [this](QMenu* menu, const QString& text, const QString& name, const QKeySequence& keys,
                             auto&& slot) {
    QAction* made = menu->addAction(text, this, slot);
    made->setObjectName(name);
    made->setShortcut(keys);
    return made;
  };
  const auto toggle = [this](QMenu* menu, const QString& text, const QString& name, bool on, auto&& slot) {
    QAction* made = menu->addAction(text);
    made->setObjectName(name);
    made->setCheckable(true);
    made->setChecked(on);
    connect(made, &QAction::toggled, this, slot);
    return made;
  };

  QMenu* file = menus->addMenu(tr("&File"));
  build_files_menu(file);
  build_editor_menu(file);
  file->addSeparator();
  build_replay_menu(file);
  file->addSeparator();
  save_csv_action_ =
      action(file, tr("&Save CSV …"), QStringLiteral("save_csv"), QKeySequence::Save, [this] { ask_save_csv(); });
  action(file, tr("Save &plot …"), QStringLiteral("save_plot"), QKeySequence(tr("Ctrl+P")),
         [this] { ask_save_plot(false); });
  file->addSeparator();
  action(file, tr("&Quit"), QStringLiteral("quit"), QKeySequence(tr("Ctrl+Q")), [this] { close(); });

  QMenu* run = menus->addMenu(tr("&Run"));
  build_run_menu(run);
  run->addSeparator();
  QAction* undo = gains_->undo_stack().createUndoAction(this, tr("&Undo gain:"));
  undo->setShortcut(QKeySequence::Undo);
  QAction* redo = gains_->undo_stack().createRedoAction(this, tr("&Redo gain:"));
  redo->setShortcut(QKeySequence(tr("Ctrl+Shift+Z")));
  run->addActions({undo, redo});
  run->addSeparator();
  checks_action_ = toggle(run, tr("&Check list"), QStringLiteral("view_checks"), false, [this] { show_checks(); });
  checks_action_->setShortcut(QKeySequence(tr("Ctrl+L")));
  action(run, tr("Calibrate ca&mera …"), QStringLiteral("calibrate_camera"), {}, [this] { calibrate_camera(); });

  QMenu* view = menus->addMenu(tr("&View"));
  picture_ = toggle(view, tr("&Camera picture"), QStringLiteral("view_picture"), false,
                    [this](bool on) { arena_->show_picture(on); });
  regions_ = toggle(view, tr("&Detection regions"), QStringLiteral("view_regions"), true,
                    [this](bool on) { arena_->show_regions(on); });
  trails_ =
      toggle(view, tr("&Trails"), QStringLiteral("view_trails"), true, [this](bool on) { arena_->show_trails(on); });
  couplings_ = toggle(view, tr("Co&uplings"), QStringLiteral("view_couplings"), true,
                      [this](bool on) { arena_->show_couplings(on); });
  grid_ = toggle(view, tr("&Grid"), QStringLiteral("view_grid"), true, [this](bool on) { arena_->show_grid(on); });
  view->addSeparator();
  fit_ = action(view, tr("&Whole arena"), QStringLiteral("fit"), QKeySequence(tr("Ctrl+0")), [this] { arena_->fit(); });
  zoom_in_ =
      action(view, tr("Zoom &in"), QStringLiteral("zoom_in"), QKeySequence::ZoomIn, [this] { arena_->zoom_in(); });
  zoom_out_ =
      action(view, tr("Zoom &out"), QStringLiteral("zoom_out"), QKeySequence::ZoomOut, [this] { arena_->zoom_out(); });
  view->addSeparator();
  dark_ = toggle(view, tr("Dar&k palette"), QStringLiteral("view_dark"), false,
                 [this](bool on) { set_theme(on ? Theme::dark : Theme::light); });
  action(view, tr("As the des&ktop"), QStringLiteral("view_as_desktop"), {}, [this] {
    set_theme(desktop_at_start_);
    theme_chosen_ = false;
  });
  full_screen_ = toggle(view, tr("&Full screen"), QStringLiteral("view_full_screen"), false,
                        [this](bool on) { on ? showFullScreen() : showNormal(); });
  full_screen_->setShortcut(QKeySequence(tr("F11")));
  QMenu* panels = view->addMenu(tr("&Panels"));
  connect(panels, &QMenu::aboutToShow, this, [this, panels] {  // the docks come after the menus
    panels->clear();
    for (QDockWidget* dock : {gains_dock_, plots_dock_, robots_dock_, log_dock_})
      panels->addAction(dock->toggleViewAction());
    panels->addSeparator();
    panels->addAction(tr("&Back to the usual layout"), this, [this] { default_layout(); });
  });

  QMenu* arena = menus->addMenu(tr("&Arena"));
  auto* tools = new QActionGroup(this);
  const auto tool = [&](ArenaTool which, const QString& text, const QString& name, const QKeySequence& keys,
                        const QString& tip) {
    QAction* made = arena->addAction(text);
    made->setObjectName(name);
    made->setShortcut(keys);
    made->setToolTip(tip);
    made->setCheckable(true);
    made->setChecked(which == ArenaTool::hand);
    tools->addAction(made);
    connect(made, &QAction::toggled, this, [this, which](bool on) {
      if (on) arena_->set_tool(which);
    });
    tools_[static_cast<std::size_t>(which)] = made;
  };
  tool(ArenaTool::hand, tr("&Hand"), QStringLiteral("tool_hand"), QKeySequence(tr("H")),
       tr("Hand (H): drag robots and obstacles, turn robots with the wheel, click a coupling to switch it"));
  tool(ArenaTool::kick, tr("&Kick"), QStringLiteral("tool_kick"), QKeySequence(tr("K")),
       tr("Kick (K): draw an arrow out of a simulated robot, and it slides that way"));
  tool(ArenaTool::measure, tr("&Measure"), QStringLiteral("tool_measure"), QKeySequence(tr("M")),
       tr("Measure (M): drag from point to point; the ends hold on to robots and obstacles"));
  tool(ArenaTool::obstacle, tr("&Obstacle"), QStringLiteral("tool_obstacle"), QKeySequence(tr("O")),
       tr("Obstacle (O): click drops one, drag draws it out to its size"));

  QMenu* help = menus->addMenu(tr("&Help"));
  action(help, tr("&Shortcuts"), QStringLiteral("shortcuts"), QKeySequence(tr("F1")),
         [this] { message(this, QStringLiteral("shortcuts_dialog"), tr("Shortcuts"), shortcuts_text()); });
  action(help, tr("&About Skein"), QStringLiteral("about"), {},
         [this] { message(this, QStringLiteral("about_dialog"), tr("About Skein"), about_text()); });
}

void MainWindow::build_arena_tools(QToolBar* tools) {
  tools->setObjectName(QStringLiteral("arena_tools"));
  tools->setIconSize({18, 18});
  tools->addActions({fit_, zoom_in_, zoom_out_});
  tools->addSeparator();
  tools->addActions({picture_, couplings_, regions_, trails_, grid_});
  tools->addSeparator();
  for (QAction* tool : tools_) tools->addAction(tool);
  dress_icons();
}

void MainWindow::dress_icons() {
  const QColor ink = colours(palette()).text;
  fit_->setIcon(icon(QStringLiteral("fit"), ink));
  zoom_in_->setIcon(icon(QStringLiteral("zoom-in"), ink));
  zoom_out_->setIcon(icon(QStringLiteral("zoom-out"), ink));
  picture_->setIcon(icon(QStringLiteral("camera"), ink));
  regions_->setIcon(icon(QStringLiteral("regions"), ink));
  trails_->setIcon(icon(QStringLiteral("trails"), ink));
  couplings_->setIcon(icon(QStringLiteral("couplings"), ink));
  grid_->setIcon(icon(QStringLiteral("grid"), ink));
  for (std::size_t k = 0; k < tools_.size(); ++k)
    tools_[k]->setIcon(icon(tools_[k]->objectName().mid(5), ink));  // "tool_hand": the icon "hand"
}

void MainWindow::set_theme(Theme theme) {
  theme_chosen_ = true;
  apply(theme);
  const QSignalBlocker quiet(dark_);
  dark_->setChecked(theme == Theme::dark);
}

void MainWindow::ask_save_csv() {
  QFileDialog* dialog =
      file_dialog(this, tr("Save CSV"), QStringLiteral("save_csv_dialog"), tr("CSV (*.csv);;All files (*)"));
  dialog->setAcceptMode(QFileDialog::AcceptSave);
  dialog->setDefaultSuffix(QStringLiteral("csv"));
  dialog->selectFile(QString::fromStdString(live_.experiment().name) + QStringLiteral(".csv"));
  connect(dialog, &QFileDialog::fileSelected, this, &MainWindow::save_csv);
  show_beside(dialog);
}

void MainWindow::save_csv(const QString& file) {
  if (saving_) return;
  // Aside: thousands of rows of a hundred numbers take longer than a frame.
  saving_ = Saving{file, std::async(std::launch::async, [rows = live_.history().rows(), experiment = live_.experiment(),
                                                         file] { return write_csv(rows, experiment, file); })};
}

void MainWindow::ask_save_plot(bool everything) {
  QFileDialog* dialog = file_dialog(this, tr("Save plot"), QStringLiteral("save_plot_dialog"),
                                    tr("PDF (*.pdf);;PNG (*.png);;CSV (*.csv)"));
  dialog->setAcceptMode(QFileDialog::AcceptSave);
  dialog->setDefaultSuffix(QStringLiteral("pdf"));
  connect(dialog, &QFileDialog::filterSelected, dialog,
          [dialog](const QString& filter) { dialog->setDefaultSuffix(filter.left(3).toLower()); });
  dialog->selectFile(QString::fromStdString(live_.experiment().name) + QStringLiteral("-errors"));
  connect(dialog, &QFileDialog::fileSelected, this,
          [this, everything](const QString& file) { save_plot(file, everything); });
  show_beside(dialog);
}

void MainWindow::save_plot(const QString& file, bool everything) {
  const QString problem = plots_->save(file, everything);
  if (problem.isEmpty())
    alert_->say(tr("Saved %1").arg(file), Severity::good);
  else
    show_problem(tr("The plot was not saved"), problem);
}

void MainWindow::show_problem(const QString& title, const QString& text, const QString& details) {
  QString body = text.toHtmlEscaped();
  if (!details.isEmpty()) body += QStringLiteral("<pre>") + details.toHtmlEscaped() + QStringLiteral("</pre>");
  message(this, QStringLiteral("problem_dialog"), title,
          QStringLiteral("<p><b>%1</b></p><p>%2</p>").arg(title.toHtmlEscaped(), body));
}

void MainWindow::restore_settings() {
  const QSettings stored = settings();
  const QString theme = stored.value(QStringLiteral("theme")).toString();
  set_theme(theme.isEmpty() ? desktop_at_start_ : theme == QStringLiteral("dark") ? Theme::dark : Theme::light);
  theme_chosen_ = !theme.isEmpty();
  if (stored.contains(QStringLiteral("geometry"))) {
    restoreGeometry(stored.value(QStringLiteral("geometry")).toByteArray());
    restoreState(stored.value(QStringLiteral("layout")).toByteArray(), layout_version);
  }
  plots_->show_plots(stored.value(QStringLiteral("plots")).toStringList());
  regions_->setChecked(stored.value(QStringLiteral("regions"), true).toBool());
  trails_->setChecked(stored.value(QStringLiteral("trails"), true).toBool());
  couplings_->setChecked(stored.value(QStringLiteral("couplings"), true).toBool());
  grid_->setChecked(stored.value(QStringLiteral("grid"), true).toBool());
}

void MainWindow::store_settings() {
  QSettings stored = settings();
  if (theme_chosen_)
    stored.setValue(QStringLiteral("theme"), dark_->isChecked() ? QStringLiteral("dark") : QStringLiteral("light"));
  else
    stored.remove(QStringLiteral("theme"));
  if (!isFullScreen()) stored.setValue(QStringLiteral("geometry"), saveGeometry());
  stored.setValue(QStringLiteral("layout"), saveState(layout_version));
  stored.setValue(QStringLiteral("plots"), plots_->shown());
  stored.setValue(QStringLiteral("regions"), regions_->isChecked());
  stored.setValue(QStringLiteral("trails"), trails_->isChecked());
  stored.setValue(QStringLiteral("couplings"), couplings_->isChecked());
  stored.setValue(QStringLiteral("grid"), grid_->isChecked());
}

}  // namespace skein::ui
