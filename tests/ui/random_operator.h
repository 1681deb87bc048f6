#pragma once

#include <QAbstractButton>
#include <QAbstractItemView>
#include <QAbstractSlider>
#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QContextMenuEvent>
#include <QDir>
#include <QDockWidget>
#include <QDropEvent>
#include <QFileDialog>
#include <QHelpEvent>
#include <QLineEdit>
#include <QMenu>
#include <QMimeData>
#include <QMouseEvent>
#include <QPlainTextEdit>
#include <QPointer>
#include <QPushButton>
#include <QTest>
#include <QTimer>
#include <QWheelEvent>
#include <fstream>
#include <functional>
#include <vector>

#include "random_experiment.h"
#include "ui/arena/arena_view.h"
#include "ui/main/main_window.h"
#include "ui/plots/plot_view.h"
#include "ui/status/time_line.h"

namespace skein::ui::test {

/// Somebody at the window who does anything that a hand with mouse and keyboard can do, in any order. Never waits for
/// anything, leaves no question open for long, and reaches nothing outside: no program of the desktop, no robots, and
/// no files but those of `folder`.
class RandomOperator : public QObject {
 public:
  RandomOperator(MainWindow& window, const QString& folder, std::uint64_t seed)
      : window_(window), folder_(folder), random_(seed, 1), of_menus_(seed, 2) {
    tend_menus();
  }
  RandomOperator(const RandomOperator&) = delete;
  RandomOperator& operator=(const RandomOperator&) = delete;

  /// Called with what is about to be done.
  std::function<void(const QString&)> on_action = [](const QString&) {};

  /// Does one thing. What follows of it by itself needs a loop of events.
  void act() {
    if (answer_file_dialog()) return;
    struct Kind {
      double share;
      void (RandomOperator::*act)();
    };
    static constexpr Kind kinds[] = {{14, &RandomOperator::press_button},    {10, &RandomOperator::trigger_action},
                                     {8, &RandomOperator::change_control},   {6, &RandomOperator::type_somewhere},
                                     {12, &RandomOperator::point_somewhere}, {12, &RandomOperator::work_in_arena},
                                     {6, &RandomOperator::work_in_plot},     {6, &RandomOperator::work_in_table},
                                     {10, &RandomOperator::press_key},       {3, &RandomOperator::resize},
                                     {2, &RandomOperator::change_font},      {4, &RandomOperator::move_dock},
                                     {4, &RandomOperator::close_dialog},     {3, &RandomOperator::open_something},
                                     {22, &RandomOperator::drive_run}};
    double all = 0.0;
    for (const Kind& kind : kinds) all += kind.share;
    double at = all * random_.uniform();
    for (const Kind& kind : kinds)
      if ((at -= kind.share) < 0.0) return (this->*kind.act)();
  }

  bool likely(double share) { return random_.uniform() < share; }
  int below(int count) { return static_cast<int>(random_.uniform() * count); }
  core::Random& random() { return random_; }

  /// The windows that are there, the main one last; no menus, no tips.
  std::vector<QWidget*> windows() const {
    std::vector<QWidget*> found;
    for (QWidget* widget : QApplication::topLevelWidgets())
      if (widget->isVisible() && widget != &window_ &&
          is_one_of(widget->windowType(), Qt::Dialog, Qt::Tool, Qt::Window))
        found.push_back(widget);
    found.push_back(&window_);
    return found;
  }

 private:
  template <typename T, typename... Others>
  static bool is_one_of(T one, Others... others) {
    return ((one == others) || ...);
  }

  /// What would end the test, or reach what is outside of it.
  static bool is_forbidden(const QObject* object) {
    return is_one_of(object->objectName(), QStringLiteral("quit"), QStringLiteral("connect_scan"),
                     QStringLiteral("connect_pair"), QStringLiteral("connect_save"), QStringLiteral("camera_search"));
  }
  /// Where files are deleted by a key.
  static bool is_in_file_dialog(const QWidget* widget) {
    for (; widget; widget = widget->parentWidget())
      if (qobject_cast<const QFileDialog*>(widget)) return true;
    return false;
  }
  QWidget* any_window() {
    if (QWidget* modal = QApplication::activeModalWidget()) return modal;
    const std::vector<QWidget*> all = windows();
    QWidget* const one = likely(0.6) ? all.back() : any_of_these(all, random_);
    return is_in_file_dialog(one) ? all.back() : one;
  }
  /// One of a window's widgets that a mouse can reach; null: there is none.
  template <typename Widget>
  Widget* any(QWidget* in) {
    std::vector<Widget*> found;
    for (Widget* widget : in->findChildren<Widget*>())
      if (widget->isVisible() && widget->window() == in && widget->isEnabled() && !is_forbidden(widget) &&
          !widget->visibleRegion().isEmpty())
        found.push_back(widget);
    return found.empty() ? nullptr : any_of_these(found, random_);
  }
  QPoint any_place(const QWidget* in) {
    const QRect seen = in->visibleRegion().boundingRect() & in->rect();
    return seen.isEmpty() ? in->rect().center() : seen.topLeft() + QPoint(below(seen.width()), below(seen.height()));
  }
  Qt::KeyboardModifiers any_modifiers() {
    static const Qt::KeyboardModifiers all[] = {Qt::NoModifier,    Qt::NoModifier,  Qt::NoModifier,
                                                Qt::ShiftModifier, Qt::AltModifier, Qt::ControlModifier};
    return any_of_these(all, random_);
  }
  static QString name_of(const QObject* object) {
    const QObject* named = object;
    while (named && (named->objectName().isEmpty() || named->objectName().startsWith(QStringLiteral("qt_"))))
      named = named->parent();
    const QString kind = QString::fromLatin1(object->metaObject()->className());
    return !named            ? kind
           : named == object ? kind + QLatin1Char(' ') + named->objectName()
                             : kind + QStringLiteral(" in ") + named->objectName();
  }
  void tell(const QString& what) { on_action(what); }

  void press_button() {
    auto* button = any<QAbstractButton>(any_window());
    if (!button) return;
    tell(QStringLiteral("click on %1 \"%2\"").arg(name_of(button), button->text()));
    QTest::mouseClick(button, Qt::LeftButton, {}, any_place(button));
  }

  void trigger_action() {
    const QList<QAction*> all = window_.findChildren<QAction*>();
    QAction* action = any_of_these(all, random_);
    if (action->menu()) {
      tell(QStringLiteral("fill menu ") + action->text());
      emit action->menu()->aboutToShow();
      return;
    }
    if (!action->isEnabled() || action->isSeparator() || is_forbidden(action) ||
        is_in_file_dialog(qobject_cast<QWidget*>(action->parent())))
      return;
    tell(QStringLiteral("action %1 \"%2\"").arg(action->objectName(), action->text()));
    action->trigger();
  }

  void change_control() {
    QWidget* in = any_window();
    if (auto* combo = likely(0.4) ? any<QComboBox>(in) : nullptr) {
      tell(QStringLiteral("choose in ") + name_of(combo));
      if (likely(0.5)) {
        QTest::mouseClick(combo, Qt::LeftButton, {}, any_place(combo));
      } else {
        static const Qt::Key keys[] = {Qt::Key_Up, Qt::Key_Down, Qt::Key_Home, Qt::Key_End};
        QTest::keyClick(combo, any_of_these(keys, random_));
      }
    } else if (auto* slider = any<QAbstractSlider>(in)) {
      tell(QStringLiteral("draw ") + name_of(slider));
      draw(slider, any_place(slider), any_place(slider), Qt::LeftButton);
    }
  }

  /// Numbers, and what is none.
  QString any_text() {
    static const QString texts[] = {QStringLiteral("0.01"),
                                    QStringLiteral("-3"),
                                    QStringLiteral("0,25"),
                                    QStringLiteral("1e300"),
                                    QStringLiteral("-1e-300"),
                                    QStringLiteral("nan"),
                                    QStringLiteral("inf"),
                                    QStringLiteral("1.000.000,5"),
                                    QStringLiteral("99999999999999999999"),
                                    QStringLiteral("%1 %n &x <b>bold</b>"),
                                    QStringLiteral("../../%s\"'`$(x)\\"),
                                    QStringLiteral("r1.x r2_y k_xx"),
                                    QStringLiteral("äöü ∂x/∂t 速度 🤖"),
                                    QStringLiteral("\t\n"),
                                    QString(20000, QLatin1Char('9')),
                                    QString(5000, QLatin1Char('W')),
                                    QString()};
    return any_of_these(texts, random_);
  }

  void type_somewhere() {
    QWidget* in = any_window();
    QWidget* field = any<QLineEdit>(in);
    if (QWidget* text = likely(0.3) || !field ? any<QPlainTextEdit>(in) : nullptr) field = text;
    if (!field) return;
    const QString text = any_text();
    tell(QStringLiteral("type \"%1\" in %2").arg(text.left(30), name_of(field)));
    field->setFocus();
    if (likely(0.8)) QTest::keyClick(field, Qt::Key_A, Qt::ControlModifier);
    // As an input method enters it: whole, in one event.
    if (auto* line = qobject_cast<QLineEdit*>(field))
      line->insert(text);
    else if (auto* plain = qobject_cast<QPlainTextEdit*>(field))
      plain->insertPlainText(text);
    const QPointer<QWidget> still(field);
    static const Qt::Key ends[] = {Qt::Key_Return, Qt::Key_Tab, Qt::Key_Backtab, Qt::Key_Up};
    if (likely(0.8) && still) QTest::keyClick(field, any_of_these(ends, random_));
  }

  void draw(QWidget* in, QPoint from, QPoint to, Qt::MouseButton button,
            Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    const QPointer<QWidget> still(in);
    QTest::mousePress(in, button, modifiers, from);
    for (int k = 1; k <= 3 && still; ++k) {
      const QPoint at = from + (to - from) * k / 3;
      QMouseEvent move(QEvent::MouseMove, at, in->mapToGlobal(at), Qt::NoButton, button, modifiers);
      QApplication::sendEvent(in, &move);
      if (still && k == 2 && likely(0.2)) QTest::qWait(below(80));
    }
    // QTest remembers the buttons that are down: also where what was pressed is gone.
    QTest::mouseRelease(still ? still.data() : &window_, button, modifiers, to);
  }
  void click_twice(QWidget* at, Qt::MouseButton button, Qt::KeyboardModifiers modifiers, QPoint place) {
    const QPointer<QWidget> still(at);
    QTest::mouseClick(at, button, modifiers, place);
    if (!still) return;
    QTest::mouseDClick(at, button, modifiers, place);
    QTest::mouseRelease(still ? still.data() : &window_, button, modifiers, place);
  }

  /// Anything that a mouse does, to this widget.
  void point(QWidget* at) {
    const QPoint place = any_place(at);
    const Qt::MouseButton buttons[] = {Qt::LeftButton, Qt::LeftButton, Qt::RightButton, Qt::MiddleButton};
    const Qt::MouseButton button = any_of_these(buttons, random_);
    const Qt::KeyboardModifiers modifiers = any_modifiers();
    const QString where = QStringLiteral("%1 at %2, %3, button %4, modifiers %5")
                              .arg(name_of(at))
                              .arg(place.x())
                              .arg(place.y())
                              .arg(static_cast<int>(button))
                              .arg(modifiers.toInt(), 0, 16);
    switch (below(7)) {
      case 0:
      case 1:
        tell(QStringLiteral("click on ") + where);
        return QTest::mouseClick(at, button, modifiers, place);
      case 2:
        tell(QStringLiteral("click twice on ") + where);
        return click_twice(at, button, modifiers, place);
      case 3: {
        tell(QStringLiteral("wheel on ") + where);
        const QPoint notches = QPoint(likely(0.2) ? 120 : 0, (below(2) * 2 - 1) * (1 + below(20)) * 40);
        QWheelEvent wheel(place, at->mapToGlobal(place), {}, notches, Qt::NoButton, modifiers, Qt::NoScrollPhase,
                          false);
        QApplication::sendEvent(at, &wheel);
        return;
      }
      case 4: {
        tell(QStringLiteral("menu of ") + where);
        QContextMenuEvent menu(QContextMenuEvent::Mouse, place, at->mapToGlobal(place));
        QApplication::sendEvent(at, &menu);
        return;
      }
      case 5: {
        tell(QStringLiteral("tip of ") + where);
        QMouseEvent move(QEvent::MouseMove, place, at->mapToGlobal(place), Qt::NoButton, Qt::NoButton, modifiers);
        const QPointer<QWidget> still(at);
        QApplication::sendEvent(at, &move);
        QHelpEvent tip(QEvent::ToolTip, place, at->mapToGlobal(place));
        if (still) QApplication::sendEvent(at, &tip);
        return;
      }
      default:
        tell(QStringLiteral("draw from ") + where);
        return draw(at, place, any_place(at), button, modifiers);
    }
  }

  void point_somewhere() {
    if (auto* widget = any<QWidget>(any_window())) point(widget);
  }

  void work_in_arena() {
    auto* arena = any<ArenaView>(&window_);
    if (!arena || QApplication::activeModalWidget()) return;
    const std::size_t robots = window_.live().experiment().robots.size();
    const auto pose = robots > 0 ? arena->scene().pose(static_cast<std::size_t>(below(static_cast<int>(robots))))
                                 : std::optional<core::Pose>();
    if (!pose || likely(0.3)) return point(arena);
    const QPoint at = arena->map().to_screen({pose->x, pose->y}).toPoint();
    if (!arena->rect().contains(at)) return;
    tell(QStringLiteral("draw robot at %1, %2").arg(at.x()).arg(at.y()));
    draw(arena, at, any_place(arena), Qt::LeftButton, any_modifiers());
  }

  void work_in_plot() {
    if (QApplication::activeModalWidget()) return;
    if (QWidget* line = likely(0.3) ? any<TimeLine>(&window_) : nullptr) return point(line);
    if (auto* plot = any<PlotView>(&window_)) point(plot);
  }

  void work_in_table() {
    auto* table = any<QAbstractItemView>(any_window());
    if (!table || !table->model() || table->model()->rowCount() == 0 || is_in_file_dialog(table)) return;
    const QAbstractItemModel& model = *table->model();
    const QModelIndex cell = model.index(below(model.rowCount()), below(std::max(1, model.columnCount())));
    table->scrollTo(cell);
    const QPoint at = table->visualRect(cell).center();
    if (!table->viewport()->rect().contains(at)) return;
    tell(QStringLiteral("cell %1, %2 of %3").arg(cell.row()).arg(cell.column()).arg(name_of(table)));
    const QPointer<QWidget> viewport(table->viewport());
    QTest::mouseClick(table->viewport(), Qt::LeftButton, any_modifiers(), at);
    if (viewport && likely(0.4)) click_twice(viewport, Qt::LeftButton, {}, at);
    if (viewport && likely(0.3)) {
      QContextMenuEvent menu(QContextMenuEvent::Mouse, at, viewport->mapToGlobal(at));
      QApplication::sendEvent(viewport, &menu);
    }
  }

  void press_key() {
    static const Qt::Key keys[] = {Qt::Key_Tab,    Qt::Key_Tab,  Qt::Key_Backtab, Qt::Key_Return, Qt::Key_Up,
                                   Qt::Key_Down,   Qt::Key_Left, Qt::Key_Right,   Qt::Key_PageUp, Qt::Key_PageDown,
                                   Qt::Key_Home,   Qt::Key_End,  Qt::Key_Delete,  Qt::Key_Insert, Qt::Key_Plus,
                                   Qt::Key_Minus,  Qt::Key_F5,   Qt::Key_F6,      Qt::Key_F11,    Qt::Key_F2,
                                   Qt::Key_A,      Qt::Key_O,    Qt::Key_R,       Qt::Key_5,      Qt::Key_Backspace,
                                   Qt::Key_Escape, Qt::Key_Menu, Qt::Key_Enter,   Qt::Key_F4};
    QWidget* in = any_window();
    Qt::Key key = any_of_these(keys, random_);
    Qt::KeyboardModifiers modifiers = any_modifiers();
    if (likely(0.4)) {
      const QList<QAction*> all = window_.findChildren<QAction*>();
      const QAction* action = any_of_these(all, random_);
      if (action->shortcut().isEmpty() || is_forbidden(action)) return;
      key = action->shortcut()[0].key();
      modifiers = action->shortcut()[0].keyboardModifiers();
    }
    QWidget* focus = QApplication::focusWidget();
    if (!in->windowHandle() || is_in_file_dialog(focus)) return;
    if (is_one_of(key, Qt::Key_F4, Qt::Key_Q) && modifiers != Qt::NoModifier) return;  // closes the window
    tell(QStringLiteral("key %1 in %2, focus: %3")
             .arg(QKeySequence(key | modifiers).toString(), name_of(in),
                  focus ? name_of(focus) : QStringLiteral("nowhere")));
    QTest::keyClick(in->windowHandle(), key, modifiers);
  }

  void resize() {
    static const QSize sizes[] = {{1, 1},      {300, 3000}, {4000, 200}, {784, 552},
                                  {1024, 768}, {1280, 800}, {1366, 768}, {1900, 1040}};
    const QSize size = any_of_these(sizes, random_);
    QWidget* in = any_window();
    tell(QStringLiteral("resize %1 to %2 x %3").arg(name_of(in)).arg(size.width()).arg(size.height()));
    in->resize(size);
  }

  void change_font() {
    QFont font = QApplication::font();
    static const int sizes[] = {6, 8, 9, 10, 10, 10, 12, 14, 20, 28};
    font.setPointSize(any_of_these(sizes, random_));
    tell(QStringLiteral("font of %1 pt").arg(font.pointSize()));
    QApplication::setFont(font);
  }

  void move_dock() {
    const QList<QDockWidget*> docks = window_.findChildren<QDockWidget*>();
    QDockWidget* dock = any_of_these(docks, random_);
    static const Qt::DockWidgetArea areas[] = {Qt::LeftDockWidgetArea, Qt::RightDockWidgetArea, Qt::TopDockWidgetArea,
                                               Qt::BottomDockWidgetArea};
    const Qt::DockWidgetArea area = any_of_these(areas, random_);
    const int what = below(5);
    tell(QStringLiteral("dock %1, way %2, area %3").arg(dock->objectName()).arg(what).arg(static_cast<int>(area)));
    if (what <= 1) return dock->toggleViewAction()->trigger();
    if (what == 2) return dock->raise();
    if (what == 3 && dock->features().testFlag(QDockWidget::DockWidgetFloatable))
      return dock->setFloating(!dock->isFloating());
    if (dock->isAreaAllowed(area)) window_.addDockWidget(area, dock);
  }

  void close_dialog() {
    const std::vector<QWidget*> all = windows();
    QWidget* one = any_of_these(all, random_);
    if (one == &window_ || qobject_cast<QDockWidget*>(one)) return;
    tell(QStringLiteral("close ") + name_of(one));
    if (likely(0.5) && one->windowHandle())
      QTest::keyClick(one->windowHandle(), Qt::Key_W, Qt::ControlModifier);
    else
      one->close();
  }

  QString written(const QString& name, const std::string& text) {
    const QString file = QDir(folder_).filePath(name);
    std::ofstream(file.toStdString()) << text;
    return file;
  }
  QString any_file() {
    const QDir folder(folder_);
    const QStringList files = folder.entryList({QStringLiteral("*.toml"), QStringLiteral("*.csv")}, QDir::Files);
    return files.isEmpty() ? QString() : folder.filePath(any_of_these(files, random_));
  }

  void open_something() {
    if (const QString file = any_file(); !file.isEmpty() && likely(0.5)) {
      const int way = below(4);
      tell(QStringLiteral("open %1, way %2").arg(file).arg(way));
      if (way == 0) return window_.open_file(file);
      if (way == 1) return window_.open_recording(file);
      if (way == 2) return window_.compare_with(file);
      QMimeData data;
      data.setUrls({QUrl::fromLocalFile(file)});
      QDropEvent drop(window_.rect().center(), Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
      QApplication::sendEvent(&window_, &drop);
      return;
    }
    const app::Experiment experiment = random_experiment(random_);
    if (likely(0.2)) {
      const QString file = written(
          QStringLiteral("written-%1.toml").arg(below(3)),
          likely(0.3) ? experiment.source.substr(0, experiment.source.size() / 2) + "= 3\n" : experiment.source);
      tell(QStringLiteral("open ") + file);
      return window_.open_file(file);
    }
    const bool at_once = likely(0.5);
    tell(QStringLiteral("open %1%2")
             .arg(QString::fromStdString(experiment.name), at_once ? QStringLiteral(", started") : QString()));
    window_.open(experiment, at_once);
  }

  /// What brings a run on: random clicks alone would leave most of them at their beginning.
  void drive_run() {
    static const double speeds[] = {0.1, 0.5, 1.0, 5.0, 20.0, 50.0};
    if (likely(0.15)) {
      tell(QStringLiteral("speed"));
      return window_.set_speed(any_of_these(speeds, random_));
    }
    if (likely(0.15)) {
      tell(QStringLiteral("save CSV"));
      return window_.save_csv(QDir(folder_).filePath(QStringLiteral("saved-%1.csv").arg(below(3))));
    }
    auto* go = window_.findChild<QPushButton*>(QStringLiteral("go"));
    const bool drives = window_.live().phase() == app::Phase::running;
    if (!go->isEnabled() || (drives && likely(0.8))) return;
    tell(QStringLiteral("go on: %1").arg(go->text()));
    go->click();
  }

  /// Whether there was one.
  bool answer_file_dialog() {
    for (auto* dialog : window_.findChildren<QFileDialog*>()) {
      if (!dialog->isVisible()) continue;
      QString file = any_file();
      const bool saves = dialog->acceptMode() == QFileDialog::AcceptSave;
      if (saves)
        file = QDir(folder_).filePath(
            QStringLiteral("chosen-%1.%2")
                .arg(below(3))
                .arg(dialog->defaultSuffix().isEmpty() ? QStringLiteral("toml") : dialog->defaultSuffix()));
      if (file.isEmpty() || likely(0.3)) {
        tell(QStringLiteral("reject ") + dialog->objectName());
        dialog->reject();
        return true;
      }
      tell(QStringLiteral("%1 in %2").arg(file, dialog->objectName()));
      const QPointer<QFileDialog> still(dialog);
      dialog->setDirectory(folder_);
      dialog->selectFile(file);
      QMetaObject::invokeMethod(dialog, "accept");
      if (still && still->isVisible()) still->reject();
      return true;
    }
    return false;
  }

  /// Menus and questions that hold a loop of events of their own.
  void tend_menus() {
    QTimer::singleShot(20, this, [this] {
      tend_menus();  // first: what follows may open the next
      if (QWidget* popup = QApplication::activePopupWidget()) return tend(popup);
      patience_ = 0;
      // Those that the window opens itself are not modal.
      QWidget* modal = QApplication::activeModalWidget();
      if (!modal) return;
      const QList<QPushButton*> buttons = modal->findChildren<QPushButton*>();
      if (buttons.isEmpty()) return static_cast<void>(modal->close());
      any_of_these(buttons, of_menus_)->click();
    });
  }
  void tend(QWidget* popup) {
    if (++patience_ > 12 || is_in_file_dialog(popup)) {
      patience_ = 0;
      popup->close();
      return;
    }
    static const Qt::Key keys[] = {Qt::Key_Down,  Qt::Key_Down, Qt::Key_Down,   Qt::Key_Up,
                                   Qt::Key_Right, Qt::Key_Left, Qt::Key_Return, Qt::Key_Escape};
    const Qt::Key key = any_of_these(keys, of_menus_);
    const auto* menu = qobject_cast<QMenu*>(popup);
    if (menu && menu->activeAction() && is_forbidden(menu->activeAction()) && key == Qt::Key_Return) return;
    on_action(QStringLiteral("key %1 in %2").arg(QKeySequence(key).toString(), name_of(popup)));
    QTest::keyClick(popup, key);
  }

  MainWindow& window_;
  const QString folder_;
  core::Random random_, of_menus_;
  int patience_ = 0;
};

}  // namespace skein::ui::test
