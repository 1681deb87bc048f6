#include "ui/window.h"

#include <QApplication>
#include <QLocale>
#include <QProxyStyle>
#include <QSettings>
#include <QStyleFactory>
#include <QThread>
#include <clocale>
#include <cstdlib>

#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "ui/base/icons.h"
#include "ui/main/main_window.h"

namespace skein::ui {
namespace {

MainWindow* open_window = nullptr;

/// Qt ends the program, without coming back to `show_window`, when the connection to the display breaks.
void stop_robots_at_exit() {
  if (!open_window) return;
  const QString result = open_window->close_session();  // first: whoever is told may not listen
  app::complain("the display is gone: stopping all robots");
  app::complain(result.toStdString());
  std::_Exit(3);  // a device failed; the destructors that are left would ask the display
}

QtMessageHandler usual_messages = nullptr;

/// Qt aborts when it cannot show windows, and says so in a message first: here the program ends in order instead.
void message_at_start(QtMsgType type, const QMessageLogContext& context, const QString& text) {
  if (type != QtFatalMsg) return usual_messages(type, context, text);
  std::string tried;
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"})
    if (const QByteArray value = qgetenv(name); !value.isEmpty())
      tried += (tried.empty() ? "" : ", ") + std::string(name) + " is " + value.toStdString();
  app::complain("no display for the window (" + tried + "); try: skein run EXPERIMENT, skein --help");
  std::_Exit(app::wrong_input);
}

/// Where the connection is Wayland's, or Qt is 6.10, Qt ends the program at once, without `std::atexit`: whichever of
/// its threads notices first, after a message.
void message_while_open(QtMsgType type, const QMessageLogContext& context, const QString& text) {
  usual_messages(type, context, text);
  const bool gone = text.startsWith(QLatin1String("The Wayland connection ")) ||
                    text.startsWith(QLatin1String("The X11 connection "));
  if (!open_window || !gone) return;
  if (QThread::currentThread() == open_window->thread()) return stop_robots_at_exit();
  constexpr unsigned long patience = 10;  // [s]: afterwards the guard stops the robots
  QMetaObject::invokeMethod(open_window, stop_robots_at_exit, Qt::QueuedConnection);
  QThread::sleep(patience);
}

/// Fusion, without animations: Qt 6.10 crashes when a panel vanishes while the layout of docks is animated.
class StillStyle final : public QProxyStyle {
 public:
  StillStyle() : QProxyStyle(QStyleFactory::create(QStringLiteral("Fusion"))) {}
  int styleHint(StyleHint hint, const QStyleOption* option, const QWidget* widget,
                QStyleHintReturn* returned) const override {
    if (hint == SH_Widget_Animation_Duration) return 0;
    return QProxyStyle::styleHint(hint, option, widget, returned);
  }
};

/// A Wayland client cannot place its windows, so that a dialog may open over the STOP button: where a Wayland session
/// offers XWayland, the window uses that, unless the user chose otherwise.
bool prefers_x() {
  return !qEnvironmentVariableIsEmpty("DISPLAY") && !qEnvironmentVariableIsEmpty("WAYLAND_DISPLAY") &&
         !qEnvironmentVariableIsSet("QT_QPA_PLATFORM");
}

}  // namespace

void prepare(QApplication& application) {
  QApplication::setOrganizationName(QStringLiteral("skein"));
  QApplication::setApplicationName(QStringLiteral("skein"));
  QApplication::setApplicationDisplayName(QStringLiteral("Skein"));
  QApplication::setStyle(new StillStyle);
  QApplication::setWindowIcon(program_icon());
  // Numbers have a decimal point everywhere, as in files and on the command line: Qt's own texts, such as the plots'
  // ticks, and those of the C libraries, whose locale QApplication has set to the user's.
  QLocale::setDefault(QLocale::c());
  std::setlocale(LC_NUMERIC, "C");
  constexpr double smallest = 9.0;  // [pt]: read from an arm's length
  QFont font = QApplication::font();
  if (font.pointSizeF() < smallest) {
    font.setPointSizeF(smallest);
    QApplication::setFont(font);
  }
  static_cast<void>(application);
}

int show_window(const app::WindowRequest& request, int& argc, char** argv) {
  usual_messages = qInstallMessageHandler(message_at_start);
  const bool set = prefers_x() && qputenv("QT_QPA_PLATFORM", "xcb;wayland");  // the second if the first does not start
  QApplication application(argc, argv);
  if (set) qunsetenv("QT_QPA_PLATFORM");  // programs that are started from here choose for themselves
  qInstallMessageHandler(message_while_open);
  prepare(application);
  MainWindow window;
  open_window = &window;
  std::atexit(stop_robots_at_exit);
  window.show();
  if (request.recording.empty() && request.experiment.robots.empty()) {
    window.open_file(QString::fromStdString(request.file));
  } else if (request.recording.empty()) {
    window.open(request.experiment, request.file.empty());
    window.set_experiment_file(QString::fromStdString(request.file));
  } else {
    window.open_recording(QString::fromStdString(request.recording));
  }
  const int status = QApplication::exec();
  open_window = nullptr;
  return status;
}

}  // namespace skein::ui
