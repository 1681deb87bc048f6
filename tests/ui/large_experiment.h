#pragma once

#include <QString>
#include <cmath>

namespace skein::ui::test {

/// 64 robots, each with a timetable of so many places: its check takes many times as long as the window waits.
inline QString timetables_of_64_robots(int places = 2000) {
  QString text = QStringLiteral(
      "name = \"large\"\nduration = 600\n[arena]\nwidth = 9\nheight = 9\n[avoidance]\nenabled = false\n"
      "[controller.gains]\nk_xx = 0\nk_tt = 0\nk_yy = 0\n[reference]\nkind = \"independent\"\n");
  constexpr int robots = 64;
  for (int i = 0; i < robots; ++i) {
    text += QStringLiteral("[[robot]]\ntag = %1\ntrajectory = { samples = [").arg(i + 1);
    for (int k = 0; k < places; ++k) {
      const int column = i % 8, row = i / 8;
      const double share = k / (places - 1.0), t = 600.0 * share, x = 1.08 * column - 3.8, y = 1.08 * row - 3.8;
      const double turned = 60.0 * share * share * share * (10.0 - 15.0 * share + 6.0 * share * share);
      text += QStringLiteral("[%1, %2, %3], ")
                  .arg(t, 0, 'f', 6)
                  .arg(x + 0.2 * std::cos(turned), 0, 'f', 9)
                  .arg(y + 0.2 * std::sin(turned), 0, 'f', 9);
    }
    text += QStringLiteral("] }\n");
  }
  return text;
}

}  // namespace skein::ui::test
