#pragma once

#include <QString>
#include <Qt>
#include <array>
#include <cstddef>

namespace skein::ui {

/// How the run k (from 0) that this one is compared with is drawn: never distinguished from the others by colour alone.
inline Qt::PenStyle compared_style(std::size_t k) {
  constexpr std::array styles{Qt::DashLine, Qt::DotLine, Qt::DashDotLine, Qt::DashDotDotLine};
  return styles[k % styles.size()];
}

/// Its letter in arena, plots and results: "A", "B" ... "Z", "A2" ...
inline QString compared_letter(std::size_t k) {
  constexpr std::size_t letters = 26;
  const QString letter(QLatin1Char(static_cast<char>('A' + k % letters)));
  return k < letters ? letter : letter + QString::number(k / letters + 1);
}

}  // namespace skein::ui
