// Drives the real window without a screen. The user's settings stay out of it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <QApplication>
#include <QSettings>
#include <QTemporaryDir>
#include <string>
#include <string_view>

#include "tests/places.h"
#include "ui/base/settings.h"
#include "ui/window.h"

int main(int argc, char** argv) {
  // A run with real robots starts this program as its guard: let that be the program, not the tests once more.
  if (argc > 1 && std::string_view(argv[1]) == "guard") {
    const std::string program = skein::test::program();
    return execv(program.c_str(), argv);
  }
  if (qEnvironmentVariableIsEmpty("QT_QPA_PLATFORM")) qputenv("QT_QPA_PLATFORM", "offscreen");
  testing::InitGoogleTest(&argc, argv);
  QApplication application(argc, argv);
  const QTemporaryDir settings;
  qputenv("XDG_STATE_HOME", settings.path().toUtf8());  // markers of runs
  qputenv("XDG_DATA_HOME", settings.path().toUtf8());   // kept runs
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, settings.path());
  skein::ui::settings().setValue(QStringLiteral("keep_runs"), false);  // but where a test asks for it
  skein::ui::prepare(application);
  return RUN_ALL_TESTS();
}
