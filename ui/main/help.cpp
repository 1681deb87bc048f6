#include "ui/main/help.h"

#include "ui/base/tr.h"

namespace skein::ui {

QString shortcuts_text() {
  const QString row = QStringLiteral(
      "<tr><td style=\"padding: 2px 18px 2px 0; white-space: nowrap\"><b>%1</b></td>"
      "<td style=\"padding: 2px 0\">%2</td></tr>");
  const auto section = [](const QString& title) {
    return QStringLiteral("<tr><td colspan=\"2\" style=\"padding-top: 8px\"><i>%1</i></td></tr>").arg(title);
  };
  return QStringLiteral("<table>") + section(tr("The run")) +
         row.arg(tr("Space, Esc"), tr("STOP: all robots, at once, wherever the focus is, even while you type")) +
         row.arg(QStringLiteral("F5"), tr("Start, pause, resume")) +
         row.arg(QStringLiteral("F6"), tr("A simulation or a replay: one tick on, and pause")) +
         row.arg(tr("Ctrl+Up, Ctrl+Down"), tr("A simulation or a replay: faster, slower")) +
         row.arg(QStringLiteral("Ctrl+R"), tr("Record as CSV")) + row.arg(QStringLiteral("Ctrl+N"), tr("New run")) +
         row.arg(QStringLiteral("Ctrl+B"), tr("A simulation or its replay: go on from this moment, with changes")) +
         row.arg(QStringLiteral("Ctrl+Alt+Z"),
                 tr("A simulation: take the last drag, kick, obstacle or other action back")) +
         row.arg(QStringLiteral("Ctrl+Alt+Shift+Z"), tr("Do again what was taken back")) +
         row.arg(QStringLiteral("Ctrl+L"), tr("Check list: the conditions for a start")) +
         row.arg(tr("Ctrl+Z, Ctrl+Shift+Z"), tr("Undo and redo a change of a gain")) +
         row.arg(tr("Tab, Return"), tr("To the next control; presses the button that has the focus")) +
         row.arg(tr("Ctrl+1 … Ctrl+7"), tr("To arena, gains, plots, robots, events, results, time line")) +
         row.arg(QStringLiteral("Shift+F1"), tr("The tip of the focused control")) +
         row.arg(QStringLiteral("Shift+F10"), tr("Its menu, as the menu key")) +
         row.arg(QStringLiteral("Ctrl+W"), tr("Closes a dialog, also during a run")) +
         section(tr("A simulated robot")) + row.arg(tr("Drag"), tr("Moves it; it keeps its heading")) +
         row.arg(tr("Wheel"), tr("Turns it by 15° a notch, with Shift by 1°")) +
         row.arg(tr("Shift+drag, K"), tr("Kicks it: it slides along the arrow")) +
         row.arg(tr("Click, 1 … 9, N"), tr("Selects it: bold in the plots, marked in the table")) +
         row.arg(tr("Arrows, Page Up, Page Down"), tr("Move and turn the selected one, with Shift finely")) +
         section(tr("The arena")) + row.arg(tr("H, K, M, O"), tr("Hand, kick, measure, obstacle")) +
         row.arg(tr("Arrows, Return"), tr("Kick, measure, obstacle: move the cross, press there and let go")) +
         row.arg(tr("1 … 9, Backspace"), tr("The cross onto a robot; gives up what was begun")) +
         row.arg(tr("Click on a coupling"), tr("Switches it off and on; X does in the table of pairs")) +
         row.arg(tr("Wheel, Delete on an obstacle"), tr("Changes its size (also Page Up, Page Down); removes it")) +
         row.arg(tr("Ctrl+wheel, Ctrl++, Ctrl+−"), tr("Zoom")) +
         row.arg(tr("Middle or right drag, Alt+arrows"), tr("Pan")) +
         row.arg(tr("Ctrl+0, double click"), tr("All of it")) + section(tr("The plots")) +
         row.arg(tr("Wheel, drag"), tr("Zoom and move along the time; the run goes on")) +
         row.arg(tr("Arrows"), tr("Read values along the time, and from plot to plot")) +
         row.arg(tr("+, −, Page Up, Page Down"), tr("Zoom and move along the time")) +
         row.arg(tr("Double click, Home"), tr("Back to live")) +
         row.arg(tr("Right click"), tr("Save, measure, heights")) +
         row.arg(tr("Drag a title, or a cell of a table"), tr("Draws it in another plot as well")) +
         row.arg(tr("D, Shift+D"), tr("Measure differences from the cursor's time on; no longer")) +
         row.arg(tr("Ctrl+wheel, Y, Shift+Y, A"), tr("A plot's height; all follow their curves again")) +
         section(tr("Files and window")) +
         row.arg(QStringLiteral("Ctrl+O"), tr("Open an experiment or a recorded run; or drop the file here")) +
         row.arg(tr("Ctrl+E, Ctrl+Shift+E, Ctrl+Alt+E"), tr("Edit it; with present gains; as this run was done")) +
         row.arg(QStringLiteral("Ctrl+S"), tr("Save the run as CSV")) +
         row.arg(QStringLiteral("F11"), tr("Full screen")) +
         row.arg(QStringLiteral("Ctrl+Q"), tr("Stop all robots and quit")) + QStringLiteral("</table>");
}

QString about_text() {
  return tr(
      "<h3>Skein</h3>"
      "<p>Real-time lab control for groups of unicycle robots.</p>"
      "<p>Implements <i>Collision-free Motion Coordination of Unicycle Multi-agent Systems</i> "
      "(D. Kostić, S. Adinandra, J. Caarls, H. Nijmeijer, 2010).</p>"
      "<p>GPL-3.0-or-later. Built with Qt and QCustomPlot.</p>");
}

}  // namespace skein::ui
