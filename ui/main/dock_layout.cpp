#include "ui/main/dock_layout.h"

#include <QApplication>
#include <QEvent>
#include <QMenu>
#include <QScreen>
#include <QScrollArea>
#include <QScrollBar>
#include <QTimer>
#include <algorithm>
#include <utility>

#include "ui/base/dialogs.h"

namespace skein::ui {
namespace {

constexpr int layout_version = 2;  // of the docks: a layout of another version is not restored

/// The panel in as much room as there is: what is higher scrolls. Never narrower than the panel, which may come to need
/// more than at first: the parameters of another law, a larger font.
class Scrolling final : public QScrollArea {
 public:
  explicit Scrolling(QWidget* panel) {
    setWidget(panel);
    setWidgetResizable(true);
    setFrameShape(QFrame::NoFrame);
    setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    setFocusPolicy(Qt::NoFocus);
    take_width();
  }

 protected:
  bool event(QEvent* event) override {
    if (event->type() == QEvent::LayoutRequest) take_width();
    return QScrollArea::event(event);
  }

 private:
  void take_width() { setMinimumWidth(widget()->minimumSizeHint().width() + verticalScrollBar()->sizeHint().width()); }
};

int least_width(const QDockWidget* dock) {
  return std::max(dock->minimumWidth(), dock->minimumSizeHint().width());
}

}  // namespace

void bring_forward(QDockWidget* dock) {
  dock->show();
  dock->raise();
}

DockLayout::DockLayout(const Panels& panels, QMainWindow* window) : QObject(window), window_(window) {
  gains_ =
      dock(new Scrolling(panels.gains), tr("Coupling gains"), QStringLiteral("gains_dock"), Qt::LeftDockWidgetArea);
  plots_ = dock(panels.plots, tr("Plots"), QStringLiteral("plots_dock"), Qt::RightDockWidgetArea);
  robots_ = dock(panels.robots, tr("Robots"), QStringLiteral("robots_dock"), Qt::BottomDockWidgetArea);
  results_ = dock(panels.results, tr("Results"), QStringLiteral("results_dock"), Qt::BottomDockWidgetArea);
  events_ = dock(panels.events, tr("Events"), QStringLiteral("log_dock"), Qt::BottomDockWidgetArea);
  window->installEventFilter(this);
}

QDockWidget* DockLayout::dock(QWidget* panel, const QString& title, const QString& name, Qt::DockWidgetArea area) {
  auto* dock = new QDockWidget(title, window_);
  dock->setObjectName(name);
  dock->setWidget(panel);
  dock->installEventFilter(this);
  dock->setFeatures(QDockWidget::DockWidgetMovable | QDockWidget::DockWidgetClosable);
  window_->addDockWidget(area, dock);
  return dock;
}

void DockLayout::set_usual() {
  for (QDockWidget* dock : all()) {
    dock->setFloating(false);
    dock->show();
  }
  stacked_ = false;
  window_->setCorner(Qt::BottomLeftCorner, Qt::BottomDockWidgetArea);
  window_->setCorner(Qt::BottomRightCorner, Qt::RightDockWidgetArea);
  window_->addDockWidget(Qt::LeftDockWidgetArea, gains_);
  window_->addDockWidget(Qt::RightDockWidgetArea, plots_);
  window_->addDockWidget(Qt::BottomDockWidgetArea, robots_);
  window_->splitDockWidget(robots_, events_, Qt::Horizontal);
  window_->tabifyDockWidget(events_, results_);
  events_->raise();
  sized_in_ = QSize(1280, 800);
  window_->resize(fitting(sized_in_, window_));
  sizes_ = {{gains_, {250, 0}}, {plots_, {400, 0}}, {robots_, {550, 176}}, {events_, {330, 176}}};
  fit();
}

void DockLayout::stack_columns() {
  constexpr int useful_arena = 400;  // width [px]
  const bool narrow = window_->width() < columns_width() + useful_arena || !columns_fit_screen();
  if (narrow == stacked_) return;
  const bool usual = stacked_ ? window_->tabifiedDockWidgets(gains_).contains(plots_)
                              : window_->dockWidgetArea(gains_) == Qt::LeftDockWidgetArea &&
                                    window_->dockWidgetArea(plots_) == Qt::RightDockWidgetArea;
  if (usual && narrow) {
    window_->tabifyDockWidget(gains_, plots_);
    gains_->raise();
  } else if (usual) {
    window_->addDockWidget(Qt::RightDockWidgetArea, plots_);
  }
  stacked_ = narrow && usual;
}

/// The least that both columns take side by side: it depends on the font.
int DockLayout::columns_width() const {
  return least_width(gains_) + least_width(plots_);
}

/// Whether both columns and the arena are no wider than the screen, nor the plots beside what is below: with a large
/// font they may be, and STOP with them.
bool DockLayout::columns_fit_screen() const {
  const int arena = window_->centralWidget() ? window_->centralWidget()->minimumSizeHint().width() : 0;
  const int below = least_width(robots_) + least_width(front(events_)) + least_width(plots_);
  return std::max(columns_width() + arena, below) <= window_->screen()->availableGeometry().width();
}

/// Of the tabs that the dock is one of, the one in front: Qt 6.8 does not size those behind it.
QDockWidget* DockLayout::front(QDockWidget* dock) const {
  const QList<QDockWidget*> others = window_->tabifiedDockWidgets(dock);
  const auto seen = [](const QDockWidget* other) { return !other->visibleRegion().isEmpty(); };
  const auto found = std::find_if(others.begin(), others.end(), seen);
  return found == others.end() ? dock : *found;
}

void DockLayout::fit() {
  stack_columns();
  const double x = std::min(1.0, static_cast<double>(window_->width()) / sized_in_.width());
  const double y = std::min(1.0, static_cast<double>(window_->height()) / sized_in_.height());
  const auto wide = [&](QDockWidget* dock) { return static_cast<int>(x * sizes_.at(dock).width()); };
  window_->resizeDocks({front(gains_), front(plots_)}, {wide(gains_), wide(plots_)}, Qt::Horizontal);
  window_->resizeDocks({robots_, front(events_)}, {wide(robots_), wide(events_)}, Qt::Horizontal);
  window_->resizeDocks({robots_}, {static_cast<int>(y * sizes_.at(robots_).height())}, Qt::Vertical);
  settled_ = window_->size();
}

bool DockLayout::eventFilter(QObject* watched, QEvent* event) {
  // Both columns may have no room any more beside the arena.
  if (event->type() == QEvent::LayoutRequest && watched == gains_ &&
      std::exchange(gains_need_, least_width(gains_)) != least_width(gains_))
    QTimer::singleShot(0, this, &DockLayout::stack_columns);
  if (event->type() == QEvent::Resize) {
    if (watched == window_)
      QTimer::singleShot(0, this, &DockLayout::on_window_resized);  // once the layout is done
    else if (auto* dock = qobject_cast<QDockWidget*>(watched))
      on_dock_resized(dock);
  }
  return QObject::eventFilter(watched, event);
}

void DockLayout::on_window_resized() {
  if (restored_ && window_->isVisible()) {
    const bool was_stacked = stacked_;
    stack_columns();
    settled_ = QSize();
    if (stacked_ == was_stacked) {  // else the window was narrow the last time, and the usual sizes hold
      for (auto& [dock, made] : sizes_) made = dock->size();
      sized_in_ = settled_ = window_->size();
    }
    restored_ = false;
  }
  if (settled_ != window_->size()) fit();
}

void DockLayout::on_dock_resized(QDockWidget* dock) {
  // In a window that keeps its size, it is the operator who sizes a dock.
  if (!window_->isVisible() || settled_ != window_->size() || QApplication::mouseButtons() == Qt::NoButton) return;
  if (sized_in_ != window_->size())
    for (auto& [other, made] : sizes_) made = other->size();
  sizes_[dock] = dock->size();
  sized_in_ = window_->size();
}

void DockLayout::restore(const QSettings& stored) {
  if (!stored.contains(QStringLiteral("geometry"))) return;
  window_->restoreGeometry(stored.value(QStringLiteral("geometry")).toByteArray());
  keep_on_screen(window_);
  restored_ = window_->restoreState(stored.value(QStringLiteral("layout")).toByteArray(), layout_version);
  if (restored_) stacked_ = stored.value(QStringLiteral("stacked")).toBool();
  const auto fits = [this] {
    return window_->minimumSizeHint().width() <= window_->screen()->availableGeometry().width();
  };
  if (columns_fit_screen() && fits()) return;
  stack_columns();  // the font, or the screen, is another one than the last time
  if (!fits()) set_usual();
  window_->resize(fitting(window_->size(), window_));
  keep_on_screen(window_);
}

void DockLayout::store(QSettings& stored) const {
  if (!window_->isFullScreen()) stored.setValue(QStringLiteral("geometry"), window_->saveGeometry());
  stored.setValue(QStringLiteral("layout"), window_->saveState(layout_version));
  stored.setValue(QStringLiteral("stacked"), stacked_);
}

void DockLayout::fill_menu(QMenu* menu) {
  for (QDockWidget* dock : all()) menu->addAction(dock->toggleViewAction());
  menu->addSeparator();
  menu->addAction(tr("&Back to the usual layout"), this, &DockLayout::set_usual);
}

}  // namespace skein::ui
