// What a screen reader is told: the tree of QAccessible, of the window and of every dialog.
#include <QAccessible>
#include <QAction>
#include <QDir>
#include <QDockWidget>
#include <QLabel>
#include <QMenu>
#include <QRegularExpression>
#include <QTabWidget>
#include <QToolButton>
#include <functional>
#include <set>
#include <vector>

#include "operator.h"
#include "ui/plots/plots_panel.h"

namespace skein::ui::test {
namespace {

QString text_of(QAccessibleInterface* item, QAccessible::Text what) {
  return item->text(what).trimmed();
}

/// What somebody can do something with, or reads a state off.
bool wants_a_name(QAccessible::Role role) {
  static const std::set<int> roles{
      QAccessible::PushButton,   QAccessible::ButtonMenu, QAccessible::ButtonDropDown, QAccessible::CheckBox,
      QAccessible::RadioButton,  QAccessible::ComboBox,   QAccessible::SpinBox,        QAccessible::Slider,
      QAccessible::EditableText, QAccessible::Table,      QAccessible::List,           QAccessible::PageTab,
      QAccessible::PageTabList,  QAccessible::MenuItem,   QAccessible::Dialog,         QAccessible::Window,
      QAccessible::Graphic,      QAccessible::Chart,      QAccessible::Canvas,         QAccessible::ProgressBar,
      QAccessible::StaticText};  // the last: labels that tell a state
  return roles.contains(role);
}

struct Tree {
  int named = 0;
  QStringList nameless, without_role;

  void walk(QAccessibleInterface* item, int depth = 0) {
    if (!item || !item->isValid() || depth > 40) return;
    const QAccessible::State state = item->state();
    auto* widget = qobject_cast<QWidget*>(item->object());
    // Qt's own insides: arrows of a scroll bar, the button that leads to what does not fit into a tool bar ...
    const bool of_qt = widget && (widget->inherits("QScrollBar") || widget->inherits("QHeaderView") ||
                                  widget->inherits("QTableCornerButton") || widget->inherits("QFileDialog") ||
                                  widget->objectName().startsWith(QStringLiteral("qt_")));
    if (state.invisible || of_qt) return;
    const QAccessible::Role role = item->role();
    const bool takes_keys = state.focusable && widget && widget->focusPolicy() != Qt::NoFocus && !widget->focusProxy();
    const QString name = text_of(item, QAccessible::Name);
    const QString place = QStringLiteral("%1 %2, role %3")
                              .arg(widget ? QLatin1String(widget->metaObject()->className()) : QLatin1String("item"),
                                   widget ? widget->objectName() : QString())
                              .arg(static_cast<int>(role));
    if (takes_keys && (role == QAccessible::NoRole || role == QAccessible::Client)) without_role << place;
    if (takes_keys || wants_a_name(role)) name.isEmpty() ? static_cast<void>(nameless << place) : void(++named);
    if (role == QAccessible::Table || role == QAccessible::List || role == QAccessible::Tree) return;  // cells: below
    for (int k = 0; k < item->childCount(); ++k) walk(item->child(k), depth + 1);
  }
};

void expect_told(QWidget* window, int at_least) {
  Tree tree;
  tree.walk(QAccessible::queryAccessibleInterface(window));
  EXPECT_EQ(tree.nameless.join(QStringLiteral("; ")).toStdString(), "") << window->objectName().toStdString();
  EXPECT_EQ(tree.without_role.join(QStringLiteral("; ")).toStdString(), "") << window->objectName().toStdString();
  EXPECT_GE(tree.named, at_least) << window->objectName().toStdString();
}

class Accessible : public Operator {
 protected:
  QAccessibleInterface* of(const char* name) { return QAccessible::queryAccessibleInterface(find(name)); }
};

TEST_F(Accessible, TheWindowTellsNameAndRoleOfEverything) {
  start();
  find<QAction>("view_checks")->trigger();
  for (int tab = 0; tab < 3; ++tab) {
    find<QTabWidget>("gain_tabs")->setCurrentIndex(tab);
    QTest::qWait(20);
    expect_told(&window, 45);
  }
  find<QDockWidget>("results_dock")->raise();
  QTest::qWait(20);
  expect_told(&window, 45);
  find<QAction>("compare_now")->trigger();
  ASSERT_TRUE(eventually([&] { return find("comparison_bar")->isVisible(); }));
  QTest::qWait(20);
  expect_told(&window, 47);
}

TEST_F(Accessible, EveryDialogTellsNameAndRoleOfEverything) {
  start();
  for (const char* button : {"gain_presets", "choose_plots"}) emit find<QToolButton>(button)->menu()->aboutToShow();
  int dialogs = 0;
  const auto problem = [this] { window.save_plot(QStringLiteral("/nowhere/plot.pdf"), false); };
  std::vector<std::function<void()>> ways{problem};
  for (const char* action : {"shortcuts", "about", "edit_experiment", "calibrate_camera", "camera",
                             "connect_robots_page", "keep_preset", "keep_layout"})
    ways.emplace_back([this, action] { find<QAction>(action)->trigger(); });
  for (const std::function<void()>& comes : ways) {
    comes();
    for (QDialog* dialog : window.findChildren<QDialog*>()) {
      if (!dialog->isVisible()) continue;
      ++dialogs;
      for (QTabWidget* tabs : dialog->findChildren<QTabWidget*>())
        for (int tab = 0; tab < tabs->count(); ++tab) {
          tabs->setCurrentIndex(tab);
          QTest::qWait(20);
          expect_told(dialog, 2);
        }
      expect_told(dialog, 2);
      delete dialog;
    }
  }
  EXPECT_EQ(dialogs, 9);
}

TEST_F(Accessible, WhatIsNotAlwaysInTheWindowTellsNameAndRoleToo) {
  const QTemporaryDir dir;
  const EnvironmentVariable state_home("XDG_STATE_HOME", dir.path().toUtf8());
  ASSERT_TRUE(QDir(dir.path()).mkpath(QStringLiteral("skein")));
  QFile marker(dir.filePath(QStringLiteral("skein/run-999999")));
  ASSERT_TRUE(marker.open(QIODevice::WriteOnly));
  marker.write("skein run lab\nserial:/dev/no-such-robot\n");
  marker.close();
  const auto other_law =
      app::parse_experiment(app::paper_experiment().source, "leader.toml", {"controller.kind=\"leader_follower\""});
  ASSERT_TRUE(other_law);
  open_and_wait(*other_law);
  ASSERT_TRUE(eventually([&] { return find("left_behind")->isVisible(); }));
  ASSERT_TRUE(eventually([&] { return !find<QLabel>("pace")->text().isEmpty(); })) << "an empty label tells nothing";
  auto* plots = find<PlotsPanel>("plots");
  plots->show_plots({QStringLiteral("e_x"), QStringLiteral("e_y")});
  ASSERT_TRUE(plots->show_over(QStringLiteral("e_y"), QStringLiteral("e_x")));
  plots->show_time(0.0);  // frozen: a button leads back
  QTest::qWait(20);
  expect_told(&window, 45);
  plots->show_over({}, {});
}

TEST_F(Accessible, ValuesAndStatesAreTold) {
  start();
  auto* slider = of("slider_k_xx");
  EXPECT_EQ(slider->role(), QAccessible::Slider);
  ASSERT_NE(slider->valueInterface(), nullptr);
  EXPECT_GT(slider->valueInterface()->maximumValue().toDouble(), 0.0);
  EXPECT_EQ(of("stop")->role(), QAccessible::PushButton);
  EXPECT_EQ(text_of(of("stop"), QAccessible::Name), QStringLiteral("STOP all robots"));
  EXPECT_TRUE(of("arena")->role() != QAccessible::Client) << "the arena is an unknown thing";
  EXPECT_TRUE(of("plot")->role() != QAccessible::Client) << "the plots are an unknown thing";
  EXPECT_FALSE(text_of(of("arena"), QAccessible::Description).isEmpty());

  // The state of the run and the alert say what they show, not only what they are.
  for (const char* name : {"phase", "alert", "time", "pace", "now_k_xx", "limit_k_xx"}) {
    const QString told =
        text_of(of(name), QAccessible::Name) + QLatin1Char(' ') + text_of(of(name), QAccessible::Value);
    QString shown = find<QLabel>(name)->text();
    shown.remove(QRegularExpression(QStringLiteral("<[^>]*>")));
    EXPECT_TRUE(told.contains(shown.trimmed()))
        << name << " shows \"" << shown.toStdString() << "\" and tells \"" << told.toStdString() << '"';
  }
  auto* robots = of("robots");
  ASSERT_NE(robots->tableInterface(), nullptr);
  EXPECT_EQ(robots->tableInterface()->rowCount(), 4);
  EXPECT_FALSE(text_of(robots->tableInterface()->cellAt(1, 5), QAccessible::Name).isEmpty());
}

}  // namespace
}  // namespace skein::ui::test
