#include "ui/window.h"

#include <QApplication>
#include <QSettings>
#include <QStyleFactory>

#include "ui/icons.h"
#include "ui/main_window.h"

namespace skein::ui {

void prepare(QApplication& application) {
  QApplication::setOrganizationName(QStringLiteral("skein"));
  QApplication::setApplicationName(QStringLiteral("skein"));
  QApplication::setApplicationDisplayName(QStringLiteral("Skein"));
  QApplication::setStyle(QStyleFactory::create(QStringLiteral("Fusion")));
  QApplication::setWindowIcon(program_icon());
  constexpr double smallest = 9.0;  // [pt]: read from an arm's length
  QFont font = QApplication::font();
  if (font.pointSizeF() < smallest) {
    font.setPointSizeF(smallest);
    QApplication::setFont(font);
  }
  static_cast<void>(application);
}

int show_window(app::Experiment experiment, const WindowOptions& options) {
  QApplication application(options.argc, options.argv);
  prepare(application);
  MainWindow window;
  window.show();
  window.open(experiment, options.start_at_once);
  return QApplication::exec();
}

}  // namespace skein::ui
