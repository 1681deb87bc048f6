// Takes the pictures of the window for the documents: the paper's experiment shortly after a perturbation, light and
// dark. skein_screenshots DIR [SECONDS [WIDTH HEIGHT [EXPERIMENT]]]
#include <QAction>
#include <QApplication>
#include <QDir>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QMenu>
#include <QSlider>
#include <QTest>
#include <cstdio>

#include "app/experiment/experiment_file.h"
#include "own_home.h"
#include "ui/arena/arena_view.h"
#include "ui/main/main_window.h"
#include "ui/main/preview_controller.h"
#include "ui/window.h"

namespace {

bool save(skein::ui::MainWindow& window, skein::ui::Theme theme, const QString& file) {
  window.set_theme(theme);
  QTest::qWait(900);  // replots, and texts that change five times a second
  return window.grab().save(file);
}

QPoint at(const skein::ui::ArenaView& arena, double x, double y) {
  return arena.map().to_screen({x, y}).toPoint();
}

void drag(skein::ui::ArenaView& arena, QPoint from, QPoint to, bool let_go = true,
          Qt::KeyboardModifiers keys = Qt::NoModifier) {
  QTest::mousePress(&arena, Qt::LeftButton, keys, from);
  for (int k = 1; k <= 4; ++k) QTest::mouseMove(&arena, from + (to - from) * k / 4);
  if (let_go) QTest::mouseRelease(&arena, Qt::LeftButton, keys, to);
}

/// An obstacle in the platoon's way, a ruler between two robots, and a kick about to be given.
bool gestures(skein::ui::MainWindow& window, const QDir& dir) {
  auto& arena = *window.findChild<skein::ui::ArenaView*>();
  const auto use = [&](const char* tool) { window.findChild<QAction*>(QString::fromLatin1(tool))->trigger(); };
  const auto ahead =
      skein::app::make_reference(window.live().experiment())->at(0, window.live().latest()->t + 3.0).pose;
  use("tool_obstacle");
  QTest::mouseClick(&arena, Qt::LeftButton, {}, at(arena, ahead.x, ahead.y - 0.03));
  QTest::qWait(3000);
  const auto one = *arena.scene().pose(0), four = *arena.scene().pose(3);
  use("tool_measure");
  drag(arena, at(arena, one.x, one.y), at(arena, four.x, four.y));
  const bool measured = save(window, skein::ui::Theme::light, dir.filePath(QStringLiteral("measure.png")));
  use("tool_kick");
  const auto two = *arena.scene().pose(1);
  drag(arena, at(arena, two.x, two.y), at(arena, two.x, two.y - 0.18), false);
  const bool kicked = save(window, skein::ui::Theme::light, dir.filePath(QStringLiteral("kick.png")));
  QTest::mouseRelease(&arena, Qt::LeftButton, {}, at(arena, two.x, two.y - 0.18));
  use("tool_hand");
  return measured && kicked;
}

/// While a gain's slider is held: what the next seconds would be.
bool preview(skein::ui::MainWindow& window, const QDir& dir) {
  auto* slider = window.findChild<QSlider*>(QStringLiteral("slider_k_xx"));
  const auto place = [&](double share) {
    return QPoint(static_cast<int>(8 + share * (slider->width() - 16)), slider->height() / 2);
  };
  QTest::mousePress(slider, Qt::LeftButton, {}, place(static_cast<double>(slider->value()) / slider->maximum()));
  QTest::mouseMove(slider, place(0.6));
  const auto* controller = window.findChild<skein::ui::PreviewController*>();
  const bool shown = QTest::qWaitFor([&] { return controller->shown() != nullptr; }, 5000);
  const bool saved = save(window, skein::ui::Theme::light, dir.filePath(QStringLiteral("preview.png")));
  QTest::mouseRelease(slider, Qt::LeftButton, {}, place(0.6));
  return shown && saved;
}

/// A gain that was asked to go beyond its limit: which other one makes room.
bool gain_limit(skein::ui::MainWindow& window, const QDir& dir) {
  auto* field = window.findChild<QDoubleSpinBox*>(QStringLiteral("spin_k_yy"));
  auto* advice = window.findChild<QLabel*>(QStringLiteral("advice_k_yy"));
  const double before = field->value();
  field->setValue(0.2);
  const auto is_held = [&] { return field->value() < 0.2 && advice->isVisible(); };
  const bool held = QTest::qWaitFor(is_held, 5000);
  QTest::qWait(300);  // the layout
  const bool saved =
      window.findChild<QWidget*>(QStringLiteral("gains"))->grab().save(dir.filePath(QStringLiteral("gain-limit.png")));
  if (held) std::printf("%s\n", qUtf8Printable(advice->text()));
  field->setValue(before);
  return held && saved;
}

/// The menu of what can be done with robots, as it opens.
bool menu(skein::ui::MainWindow& window, const QDir& dir) {
  QTest::keyClick(window.findChild<skein::ui::ArenaView*>(), Qt::Key_2);  // of robot 2
  QTest::qWait(300);                                                      // it is said five times a second
  QMenu* robots = nullptr;
  for (QMenu* one : window.findChildren<QMenu*>())
    if (one->actions().contains(window.findChild<QAction*>(QStringLiteral("connect_robots_page")))) robots = one;
  if (!robots) return false;
  robots->ensurePolished();
  robots->resize(robots->sizeHint());
  return robots->grab().save(dir.filePath(QStringLiteral("menu-robots.png")));
}

/// Before a start, with a robot that is not where it should be.
bool checks(skein::ui::MainWindow& window, const QDir& dir) {
  auto& arena = *window.findChild<skein::ui::ArenaView*>();
  window.new_run();
  if (!QTest::qWaitFor([&] { return window.live().is_open() && window.live().latest(); }, 5000)) return false;
  QTest::qWait(300);
  const auto two = *arena.scene().pose(1);
  drag(arena, at(arena, two.x, two.y), at(arena, 0.2, 0.0));
  QTest::qWait(500);
  return save(window, skein::ui::Theme::light, dir.filePath(QStringLiteral("check-list.png")));
}

}  // namespace

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  const skein::ui::test::OwnHome home;
  skein::ui::prepare(application);
  const QStringList words = QApplication::arguments();
  if (words.size() < 2) {
    std::fprintf(stderr, "usage: skein_screenshots DIR [SECONDS [WIDTH HEIGHT [EXPERIMENT]]]\n");
    return 2;
  }
  const double seconds = words.size() > 2 ? words[2].toDouble() : 19.4;  // the first perturbation comes at 18 s
  skein::app::Experiment experiment = skein::app::paper_experiment();
  if (words.size() > 5) {
    auto loaded = skein::app::load_experiment(words[5].toStdString());
    if (!loaded) {
      std::fprintf(stderr, "%s\n", loaded.error().front().message().c_str());
      return 2;
    }
    experiment = *loaded;
  }

  skein::ui::MainWindow window;
  window.resize(words.size() > 4 ? QSize(words[3].toInt(), words[4].toInt()) : QSize(1280, 800));
  window.show();
  window.open(experiment, true);
  const auto there = [&] { return window.live().latest() && window.live().latest()->t >= seconds; };
  if (!QTest::qWaitFor(there, static_cast<int>(seconds * 1000) + 10000)) {
    std::fprintf(stderr, "the run did not get to %g s\n", seconds);
    return 3;
  }
  const QDir dir(words[1]);
  const bool done = save(window, skein::ui::Theme::light, dir.filePath(QStringLiteral("window.png"))) &&
                    save(window, skein::ui::Theme::dark, dir.filePath(QStringLiteral("window-dark.png"))) &&
                    preview(window, dir) && gain_limit(window, dir) && menu(window, dir) && gestures(window, dir) &&
                    checks(window, dir);
  if (!done) std::fprintf(stderr, "could not write to %s\n", argv[1]);
  window.close();
  static_cast<void>(QTest::qWaitFor([&] { return !window.isVisible(); }, 3000));
  return done ? 0 : 3;
}
