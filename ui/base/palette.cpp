#include "ui/base/palette.h"

#include <QApplication>
#include <QToolTip>
#include <array>

namespace skein::ui {
namespace {

// Okabe and Ito, "Color Universal Design" (2008).
constexpr QRgb orange = 0xffe69f00, sky = 0xff56b4e9, green = 0xff009e73, yellow = 0xfff0e442, blue = 0xff0072b2,
               vermillion = 0xffd55e00, purple = 0xffcc79a7;

// The same families of hue in the same order; of each, the one that stands out from the background.
constexpr std::array on_light{blue, vermillion, green, purple, orange, sky, QRgb{0xff303030}};
constexpr std::array on_dark{sky, orange, green, purple, vermillion, yellow, QRgb{0xffe0e0e0}};
constexpr std::array pairs_on_light{orange, sky, QRgb{0xff303030}, purple};
constexpr std::array pairs_on_dark{yellow, vermillion, QRgb{0xffe0e0e0}, purple};

}  // namespace

Theme desktop_theme() {
  return QApplication::palette().color(QPalette::Window).lightness() < 128 ? Theme::dark : Theme::light;
}

QPalette palette(Theme theme) {
  const bool dark = theme == Theme::dark;
  const QColor window = dark ? QColor(0x24272b) : QColor(0xf3f4f6);
  const QColor text = dark ? QColor(0xe4e6e9) : QColor(0x1c1f23);
  const QColor faint = dark ? QColor(0x7d838b) : QColor(0x8d939b);
  QPalette p(dark ? QColor(0x33373d) : QColor(0xe9ebee), window);
  p.setColor(QPalette::WindowText, text);
  p.setColor(QPalette::Text, text);
  p.setColor(QPalette::ButtonText, text);
  p.setColor(QPalette::Base, dark ? QColor(0x1b1d20) : QColor(0xffffff));
  p.setColor(QPalette::AlternateBase, dark ? QColor(0x212428) : QColor(0xf6f7f9));
  p.setColor(QPalette::ToolTipBase, dark ? QColor(0x3a3f46) : QColor(0xfffbe6));
  p.setColor(QPalette::ToolTipText, text);
  p.setColor(QPalette::PlaceholderText, faint);
  p.setColor(QPalette::BrightText, Qt::white);
  p.setColor(QPalette::Link, QColor(dark ? sky : blue));
  p.setColor(QPalette::Highlight, dark ? QColor(0x30506a) : QColor(0xc3dcef));  // like no robot's colour
  p.setColor(QPalette::HighlightedText, text);
  for (const auto role : {QPalette::WindowText, QPalette::Text, QPalette::ButtonText})
    p.setColor(QPalette::Disabled, role, faint);
  return p;
}

void apply(Theme theme) {
  const QPalette p = palette(theme);
  QApplication::setPalette(p);
  QToolTip::setPalette(p);
}

Colours colours(const QPalette& p) {
  Colours c;
  c.dark = p.color(QPalette::Window).lightness() < 128;
  c.text = p.color(QPalette::WindowText);
  c.faint_text = c.dark ? QColor(0x9aa1aa) : QColor(0x5f666e);
  c.panel = p.color(QPalette::Window);
  c.surroundings = c.dark ? QColor(0x1a1c1f) : QColor(0xe3e6ea);
  c.floor = c.dark ? QColor(0x202328) : QColor(0xfcfcfb);
  c.grid = c.dark ? QColor(0x2e3238) : QColor(0xe8eaed);
  c.bounds = c.dark ? QColor(0x6b727b) : QColor(0x7b828b);
  c.path = c.dark ? QColor(0x7c848e) : QColor(0x8a929c);
  c.obstacle = c.dark ? QColor(0x59606a) : QColor(0x9aa1aa);
  c.coupling = c.dark ? QColor(0xb9a6e0) : QColor(0x7a68a6);
  c.plot = p.color(QPalette::Base);
  c.plot_grid = c.dark ? QColor(0x30343a) : QColor(0xe6e8eb);
  c.axis = c.dark ? QColor(0x8b929b) : QColor(0x70777f);
  c.good = c.dark ? QColor(0x2fbf8f) : QColor(0x007a59);
  c.notice = c.dark ? QColor(0x56b4e9) : QColor(0x0072b2);
  c.warning = c.dark ? QColor(0xf0b429) : QColor(0xb36b00);
  c.alarm = c.dark ? QColor(0xff5a4f) : QColor(0xc8102e);
  c.alarm_fill = QColor(0xc8102e);  // of the STOP button, under white text
  c.accent = c.dark ? QColor(0x3d8fc4) : QColor(blue);
  c.avoiding = QColor(orange);
  c.shielded = c.dark ? QColor(0xc792ea) : QColor(0x8e44ad);
  c.limited = c.dark ? QColor(0xf0e442) : QColor(0xa08800);
  c.standing = c.dark ? QColor(0xaeb4bb) : QColor(0x5f666e);
  return c;
}

QColor Colours::robot(std::size_t i) const {
  return QColor(dark ? on_dark[i % on_dark.size()] : on_light[i % on_light.size()]);
}

QColor Colours::pair(std::size_t i) const {
  return QColor(dark ? pairs_on_dark[i % pairs_on_dark.size()] : pairs_on_light[i % pairs_on_light.size()]);
}

QColor ink_on(const QColor& background) {
  // Relative luminance, roughly: the eye takes most of it from green.
  const double luminance = 0.30 * background.redF() + 0.59 * background.greenF() + 0.11 * background.blueF();
  return luminance > 0.55 ? QColor(0x101214) : QColor(Qt::white);
}

}  // namespace skein::ui
