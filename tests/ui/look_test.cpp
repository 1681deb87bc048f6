// What is on the window: nothing cut off, nothing unreadable, nothing nameless; and the files it reads and writes.
#include <QAbstractButton>
#include <QAbstractItemView>
#include <QAbstractScrollArea>
#include <QAbstractSlider>
#include <QAbstractSpinBox>
#include <QAccessible>
#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDialog>
#include <QDockWidget>
#include <QHeaderView>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QPlainTextEdit>
#include <QScreen>
#include <QScrollBar>
#include <QTabBar>
#include <cmath>

#include "operator.h"
#include "ui/base/dialogs.h"
#include "ui/base/palette.h"
#include "ui/base/settings.h"
#include "ui/editor/experiment_editor.h"
#include "ui/plots/plots_panel.h"

namespace skein::ui::test {
namespace {

struct Screen {
  int width, height;
  Theme theme;
};

/// Whether it lies in something that scrolls: then it need not be seen as a whole.
bool scrolls(const QWidget* widget) {
  for (; widget; widget = widget->parentWidget())
    if (qobject_cast<const QAbstractScrollArea*>(widget)) return true;
  return false;
}

bool is_behind_another_tab(const MainWindow& window, QWidget* widget) {
  for (; widget; widget = widget->parentWidget())
    if (auto* dock = qobject_cast<QDockWidget*>(widget))
      return !window.tabifiedDockWidgets(dock).isEmpty() && dock->visibleRegion().isEmpty();
  return false;
}

/// What tabs and the heads of tables cut short, they mark with an ellipsis.
void expect_nothing_elided(const MainWindow& window) {
  for (const QTabBar* bar : window.findChildren<QTabBar*>())
    for (int k = 0; bar->isVisible() && k < bar->count(); ++k)
      EXPECT_GE(bar->tabRect(k).width(), bar->fontMetrics().horizontalAdvance(bar->tabText(k)))
          << bar->tabText(k).toStdString();
  for (const QHeaderView* head : window.findChildren<QHeaderView*>())
    for (int k = 0; head->isVisible() && head->orientation() == Qt::Horizontal && k < head->count(); ++k)
      if (const QString text = head->model()->headerData(k, Qt::Horizontal).toString(); !head->isSectionHidden(k)) {
        EXPECT_GE(head->sectionSize(k), head->fontMetrics().horizontalAdvance(text)) << text.toStdString();
      }
}

/// Every text and every button that this window shows now.
void expect_nothing_cut_off(MainWindow& window) {
  // A label whose text has just changed asks for its room by an event: nobody sees it before.
  QCoreApplication::sendPostedEvents(nullptr, QEvent::LayoutRequest);
  for (QWidget* widget : window.findChildren<QWidget*>()) {
    const bool text = qobject_cast<QAbstractButton*>(widget) || qobject_cast<QAbstractSpinBox*>(widget) ||
                      (qobject_cast<QLabel*>(widget) && widget->objectName() != QStringLiteral("alert"));
    if (!text || !widget->isVisible() || widget->objectName().startsWith(QStringLiteral("qt_"))) continue;  // Qt's own
    if (is_behind_another_tab(window, widget)) continue;
    const QSize needed = widget->minimumSizeHint().expandedTo(QSize(0, 0));
    EXPECT_GE(widget->width(), needed.width()) << widget->objectName().toStdString();
    EXPECT_GE(widget->height(), needed.height()) << widget->objectName().toStdString();
    if (!scrolls(widget)) {
      EXPECT_EQ(widget->visibleRegion().boundingRect(), widget->rect()) << widget->objectName().toStdString();
    }
    EXPECT_GE(widget->font().pointSizeF(), 9.0) << widget->objectName().toStdString();
    const QRect inside(QPoint(), widget->parentWidget()->size());
    EXPECT_TRUE(inside.contains(widget->geometry())) << widget->objectName().toStdString() << " lies outside";
  }
  const auto* stop = window.findChild<QPushButton*>(QStringLiteral("stop"));
  EXPECT_EQ(stop->visibleRegion().boundingRect(), stop->rect()) << "STOP is cut off";
  EXPECT_GE(stop->width(), 150);
  EXPECT_GE(stop->height(), 56);
  EXPECT_TRUE(QRect(QPoint(), window.size()).contains({stop->mapTo(&window, QPoint()), stop->size()}));
}

/// A panel that is a tab behind another one is looked at in front, and only there.
void expect_nothing_cut_off_in_any_tab(MainWindow& window) {
  for (const char* shown : {"go_to_gains", "go_to_plots"}) {
    window.findChild<QAction*>(QString::fromLatin1(shown))->trigger();
    lay_out();
    expect_nothing_cut_off(window);
  }
}

class Look : public Operator, public ::testing::WithParamInterface<Screen> {};

TEST_P(Look, CutsNothingOff) {
  const Screen screen = GetParam();
  window.set_theme(screen.theme);
  start();
  window.resize(screen.width, screen.height);
  ASSERT_TRUE(eventually([&] { return window.size() == QSize(screen.width, screen.height); }))
      << "it needs more: " << window.width() << " x " << window.height();
  lay_out();
  expect_nothing_cut_off_in_any_tab(window);
}

INSTANTIATE_TEST_SUITE_P(On, Look,
                         ::testing::Values(Screen{800, 600, Theme::light}, Screen{800, 600, Theme::dark},
                                           Screen{1024, 768, Theme::light}, Screen{1366, 728, Theme::light},
                                           Screen{1280, 720, Theme::light}, Screen{1280, 800, Theme::light},
                                           Screen{1280, 800, Theme::dark}, Screen{1920, 1080, Theme::light},
                                           Screen{1920, 1080, Theme::dark}),
                         [](const auto& screen) {
                           return std::to_string(screen.param.width) + "x" + std::to_string(screen.param.height) +
                                  (screen.param.theme == Theme::dark ? "Dark" : "Light");
                         });

TEST_F(Operator, HasTheWindowAsBeforeOnceItWasShrunkAndGrown) {
  start();
  const auto sizes = [&] {
    std::vector<QSize> all;
    for (const char* dock : {"gains_dock", "plots_dock", "robots_dock", "log_dock"}) all.push_back(find(dock)->size());
    return all;
  };
  // An X server and a busy machine take their time over it.
  const auto resized = [&](const QSize& size) {
    window.resize(size);
    std::vector<QSize> last;
    int same = 0;
    EXPECT_TRUE(eventually([&] {
      const std::vector<QSize> now = sizes();
      same = window.size() == size && now == last ? same + 1 : 0;
      last = now;
      return same >= 10;
    }));
    return last;
  };
  const std::vector<QSize> before = resized({1400, 900});
  for (const QSize small : {QSize(800, 600), QSize(1000, 650)}) {
    resized(small);
    const std::vector<QSize> after = resized({1400, 900});
    for (std::size_t k = 0; k < after.size(); ++k) {
      EXPECT_NEAR(after[k].width(), before[k].width(), 2) << k;
      EXPECT_NEAR(after[k].height(), before[k].height(), 2) << k;
    }
  }
}

TEST_F(Operator, ReadsEveryShortcutToItsEnd) {
  start();
  find<QAction>("shortcuts")->trigger();
  const auto* text = find<QDialog>("shortcuts_dialog")->findChild<QAbstractScrollArea*>();
  EXPECT_TRUE(eventually([&] { return text->isVisible() && text->horizontalScrollBar()->maximum() == 0; }))
      << text->horizontalScrollBar()->maximum() << " px are cut off";
  EXPECT_GE(text->width(), 600) << "one line each, where there is room";
}

TEST_F(Operator, FindsTheFirstWindowAndEveryDialogInsideTheScreen) {
  settings().clear();
  MainWindow first;
  const QSize screen = first.screen()->availableSize();
  EXPECT_LE(first.width(), screen.width());
  EXPECT_LE(first.height(), screen.height());
  start();
  for (const char* action :
       {"shortcuts", "about", "edit_experiment", "calibrate_camera", "camera", "connect_robots_page"})
    find<QAction>(action)->trigger();
  lay_out();
  for (QDialog* dialog : window.findChildren<QDialog*>()) {
    EXPECT_LE(dialog->width(), screen.width()) << dialog->objectName().toStdString();
    EXPECT_LE(dialog->height(), screen.height()) << dialog->objectName().toStdString();
  }
}

/// The first window that somebody sees, on the screen of this process: ctest runs it on dense ones too
/// (CMakeLists.txt).
TEST(FirstWindow, FitsTheScreenAndCutsNothingOff) {
  settings().clear();
  MainWindow first;
  first.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&first));
  if (const QString screen = qEnvironmentVariable("SKEIN_TEST_SCREEN"); !screen.isEmpty()) {
    const QSize points = first.screen()->size();
    ASSERT_EQ(QStringLiteral("%1x%2").arg(points.width()).arg(points.height()), screen)
        << "not the screen to be tested";
  }
  first.open(app::paper_experiment(), false);
  ASSERT_TRUE(eventually([&] { return first.live().is_open() && first.live().latest() != nullptr; }));
  EXPECT_TRUE(first.screen()->availableGeometry().contains(first.frameGeometry()))
      << first.frameGeometry().width() << " x " << first.frameGeometry().height();
  expect_nothing_cut_off_in_any_tab(first);
  expect_nothing_elided(first);
  first.close();
  EXPECT_TRUE(eventually([&] { return !first.isVisible(); }));
}

/// A laptop that was taken off its larger screen, or a lab's session on another desk.
TEST(FirstWindow, IsWholeWhereItWasPlacedOnALargerScreen) {
  settings().clear();
  const QRect screen = QGuiApplication::primaryScreen()->availableGeometry();
  for (const QPoint& off : {QPoint(42, 0), QPoint(200, 150), QPoint(-300, -90)}) {
    MainWindow before;
    before.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&before));
    before.setGeometry(screen.adjusted(30, 30, -30, -30).translated(off));
    before.close();
    ASSERT_TRUE(eventually([&] { return !before.isVisible(); }));
    MainWindow after;
    after.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&after));
    const QRect frame = after.frameGeometry();
    EXPECT_TRUE(screen.contains(frame)) << frame.left() << ", " << frame.top() << ": " << frame.width() << " x "
                                        << frame.height() << ", off by " << off.x() << ", " << off.y();
    after.close();
    EXPECT_TRUE(eventually([&] { return !after.isVisible(); }));
  }
  settings().clear();
}

double luminance(const QColor& colour) {
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  return 0.2126 * linear(colour.redF()) + 0.7152 * linear(colour.greenF()) + 0.0722 * linear(colour.blueF());
}

double contrast(const QColor& a, const QColor& b) {
  const auto [dim, bright] = std::minmax({luminance(a), luminance(b)});
  return (bright + 0.05) / (dim + 0.05);
}

TEST(Palette, CanBeRead) {
  for (const Theme theme : {Theme::light, Theme::dark}) {
    const QPalette p = palette(theme);
    const Colours c = colours(p);
    EXPECT_EQ(c.dark, theme == Theme::dark);
    constexpr double text = 4.5, graphics = 1.9;  // WCAG's AA for text; lines are told apart by their numbers as well
    EXPECT_GE(contrast(c.text, c.panel), text);
    EXPECT_GE(contrast(c.faint_text, c.panel), text);
    EXPECT_GE(contrast(p.color(QPalette::ButtonText), p.color(QPalette::Button)), text);
    for (const QColor& colour : {c.good, c.notice, c.alarm})
      EXPECT_GE(contrast(colour, c.panel), text) << colour.name().toStdString();
    for (const QColor& colour : {c.alarm, c.warning, c.notice})
      EXPECT_GE(contrast(colour, ink_on(colour)), 3.0) << colour.name().toStdString();
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_GE(contrast(c.robot(i), c.plot), graphics) << i;
      EXPECT_GE(contrast(c.robot(i), ink_on(c.robot(i))), 3.0) << i;
      for (std::size_t j = 0; j < i; ++j) EXPECT_NE(c.robot(i), c.robot(j));
    }
  }
}

/// What a screen reader says of it.
QString spoken(QWidget* widget) {
  QAccessibleInterface* spoken = QAccessible::queryAccessibleInterface(widget);
  return spoken ? spoken->text(QAccessible::Name) : QString();
}

TEST_F(Operator, HearsANameForEverythingInEveryTabAndDialog) {
  start();
  for (const char* action : {"shortcuts", "about", "open", "save_csv", "save_plot", "edit_experiment",
                             "calibrate_camera", "camera", "connect_robots_page", "compare"})
    find<QAction>(action)->trigger();
  int named = 0;
  for (QWidget* widget : window.findChildren<QWidget*>()) {
    const bool usable = qobject_cast<QAbstractButton*>(widget) || qobject_cast<QAbstractSlider*>(widget) ||
                        qobject_cast<QAbstractSpinBox*>(widget) || qobject_cast<QComboBox*>(widget) ||
                        qobject_cast<QLineEdit*>(widget) || qobject_cast<QAbstractItemView*>(widget) ||
                        qobject_cast<ArenaView*>(widget);
    QWidget* parent = widget->parentWidget();
    const bool part_of_another = qobject_cast<QComboBox*>(parent) || qobject_cast<QAbstractSpinBox*>(parent) ||
                                 qobject_cast<QAbstractItemView*>(parent) || qobject_cast<QLineEdit*>(parent) ||
                                 widget->inherits("QScrollBar") || widget->inherits("QHeaderView") ||
                                 widget->inherits("QComboBoxListView");
    const bool of_qt = widget->objectName().startsWith(QStringLiteral("qt_")) ||
                       widget->window()->inherits("QFileDialog") || parent->inherits("QTabBar");
    if (!usable || part_of_another || of_qt) continue;
    EXPECT_FALSE(spoken(widget).isEmpty())
        << widget->metaObject()->className() << " " << widget->objectName().toStdString();
    ++named;
  }
  EXPECT_GT(named, 30);
  for (QDialog* dialog : window.findChildren<QDialog*>()) delete dialog;
}

TEST_F(Operator, FindsANameOnEverythingThatCanBeUsed) {
  start();
  for (QWidget* widget : window.findChildren<QWidget*>()) {
    const bool usable = qobject_cast<QPushButton*>(widget) || qobject_cast<QAbstractSlider*>(widget) ||
                        qobject_cast<QAbstractSpinBox*>(widget);
    if (!usable || !widget->isVisible() || widget->inherits("QScrollBar")) continue;
    EXPECT_FALSE(widget->objectName().isEmpty()) << widget->metaObject()->className();
    EXPECT_FALSE(widget->accessibleName().isEmpty()) << widget->objectName().toStdString();
  }
}

TEST_F(Operator, MendsABrokenFileInTheEditorAtItsFirstError) {
  start();
  const QTemporaryDir dir;
  const QString file = dir.filePath(QStringLiteral("wrong.toml"));
  QFile out(file);
  ASSERT_TRUE(out.open(QIODevice::WriteOnly));
  out.write("name = \"x\"\nrate = -3\nfrobnicate = 1\n");
  out.close();
  window.open_file(file);
  ExperimentEditor* editor = nullptr;
  ASSERT_TRUE(eventually([&] { return (editor = window.findChild<ExperimentEditor*>()) != nullptr; }))
      << "there is no way to the editor";
  auto* problems = editor->findChild<QListWidget*>(QStringLiteral("editor_problems"));
  ASSERT_GE(problems->count(), 2);
  EXPECT_TRUE(problems->item(0)->text().contains(QStringLiteral("rate"))) << problems->item(0)->text().toStdString();
  EXPECT_EQ(editor->findChild<QPlainTextEdit*>(QStringLiteral("editor_text"))->textCursor().blockNumber(), 1)
      << "the cursor stands elsewhere";
  EXPECT_TRUE(find<QLabel>("alert")->text().contains(QStringLiteral("wrong.toml")));
  EXPECT_TRUE(running()) << "what ran went on";
}

TEST_F(Operator, IsToldWhyAnExperimentDoesNotOpen) {
  app::Experiment experiment = app::paper_experiment();
  experiment.camera.source = "v4l2:/dev/no-such-camera";
  window.show();
  window.activateWindow();
  window.open(experiment, false);
  ASSERT_TRUE(
      eventually([&] { return window.findChild<MessageDialog*>(QStringLiteral("problem_dialog")) != nullptr; }));
  auto* box = find<MessageDialog>("problem_dialog");
  EXPECT_TRUE(box->text().contains(QStringLiteral("no-such-camera"))) << box->text().toStdString();
  EXPECT_TRUE(eventually([&] { return arena().scene().banner_alarms; }));
  EXPECT_TRUE(eventually([&] { return !find<QPushButton>("go")->isEnabled(); }));
  delete box;
  const QString title = arena().scene().banner;
  EXPECT_TRUE(eventually([&] { return arena().scene().alert.contains(QStringLiteral("no-such-camera")); }));
  for (const QString& said : {find<QLabel>("alert")->text(), arena().scene().alert})
    EXPECT_FALSE(said.contains(title)) << "once more: " << said.toStdString();
  EXPECT_EQ(find<QLabel>("limit_k_xx")->text(), QStringLiteral("limit –")) << "nobody knows it";
}

TEST_F(Operator, ZoomsThePlotsAndComesBack) {
  start();
  auto* plots = find<PlotsPanel>("plots");
  auto* plot = find("plot");
  QWheelEvent event(QPointF(200, 100), plot->mapToGlobal(QPointF(200, 100)), {}, {0, 120}, Qt::NoButton, {},
                    Qt::NoScrollPhase, false);
  QCoreApplication::sendEvent(plot, &event);
  EXPECT_FALSE(plots->is_live());
  auto* live_button = find<QPushButton>("live");
  ASSERT_TRUE(live_button->isVisible());
  QTest::mouseClick(live_button, Qt::LeftButton);
  EXPECT_TRUE(plots->is_live());
  EXPECT_FALSE(live_button->isVisible());
}

TEST_F(Operator, SavesThePlots) {
  start();
  const QTemporaryDir dir;
  for (const auto& [name, magic] : {std::pair{"plot.pdf", "%PDF"}, std::pair{"plot.png", "\x89PNG"}}) {
    const QString file = dir.filePath(QString::fromLatin1(name));
    window.save_plot(file);
    QFile saved(file);
    ASSERT_TRUE(saved.open(QIODevice::ReadOnly)) << name;
    EXPECT_TRUE(saved.read(4) == QByteArray(magic)) << name;
    EXPECT_GT(saved.size(), 5000) << name;
  }
}

TEST_F(Operator, ComesBackToTheSameWindow) {
  start();
  window.set_theme(Theme::dark);
  const QSize size = fitting({1400, 900}, &window);
  window.resize(size);
  window.close();
  ASSERT_TRUE(eventually([&] { return !window.isVisible(); }));
  MainWindow again;
  EXPECT_EQ(again.size(), size);
  EXPECT_EQ(QApplication::palette().color(QPalette::Window), palette(Theme::dark).color(QPalette::Window));
}

}  // namespace
}  // namespace skein::ui::test
