// Drives the real window without a screen. The user's settings stay out of it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <QApplication>
#include <string>
#include <string_view>

#include "own_home.h"
#include "tests/places.h"
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
  const skein::ui::test::OwnHome home;
  skein::ui::prepare(application);
  return RUN_ALL_TESTS();
}
