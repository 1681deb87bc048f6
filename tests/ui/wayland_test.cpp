// The program under a real Wayland compositor, on X through XWayland and natively, and what it does when that dies.
// Skipped where there is no Weston.
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <QFile>
#include <QLibraryInfo>
#include <QProcess>
#include <QStandardPaths>
#include <csignal>

#include "tests/ui/shown_program.h"

namespace skein::ui::test {
namespace {

class Wayland : public ShownProgram {
 protected:
  void SetUp() override {
    const QString program = QStandardPaths::findExecutable(QStringLiteral("weston"));
    if (program.isEmpty()) GTEST_SKIP() << "there is no Weston: install the packages weston and xwayland";
    if (QStandardPaths::findExecutable(QStringLiteral("Xwayland")).isEmpty())
      GTEST_SKIP() << "there is no XWayland: install the package xwayland";
    QFile::setPermissions(directory.path(), QFile::ReadOwner | QFile::WriteOwner | QFile::ExeOwner);
    // For the sockets of X servers: Weston needs it, and does not make it.
    ::mkdir("/tmp/.X11-unix", 0777);
    ::chmod("/tmp/.X11-unix", 01777);
    server.setProcessEnvironment(with({{"XDG_RUNTIME_DIR", directory.path()}, {"HOME", directory.path()}}));
    server.setProcessChannelMode(QProcess::MergedChannels);
    server.start(program, {QStringLiteral("--backend=headless-backend.so"), QStringLiteral("--use-pixman"),
                           QStringLiteral("--socket=") + socket, QStringLiteral("--width=1400"),
                           QStringLiteral("--height=900"), QStringLiteral("--xwayland")});
    QString said;
    const QString listens = QStringLiteral("xserver listening on display ");
    while (!said.contains(listens) && server.waitForReadyRead(patience_ms)) said += server.readAll();
    if (!said.contains(listens)) GTEST_SKIP() << "Weston does not start: " << said.toStdString();
    display = said.section(listens, 1).section(QLatin1Char('\n'), 0, 0).trimmed();
  }
  void start(const QStringList& words, const QString& x_display) {
    ShownProgram::start(words, {{"XDG_RUNTIME_DIR", directory.path()},
                                {"WAYLAND_DISPLAY", socket},
                                {"DISPLAY", x_display},
                                {"XDG_SESSION_TYPE", QStringLiteral("wayland")}});
  }
  bool has_plugin() const {
    return QFile::exists(QLibraryInfo::path(QLibraryInfo::PluginsPath) +
                         QStringLiteral("/platforms/libqwayland-generic.so"));
  }

  const QString socket = QStringLiteral("skein-test");
  QString display;
};

TEST_F(Wayland, ShowsTheWindowOnXWhereItCanPlaceItsDialogs) {
  start({experiment_with_links()}, display);
  server.kill();
  expect_stopped_robots();
  EXPECT_TRUE(said.contains(QStringLiteral("The X11 connection broke"))) << said.toStdString();
}

TEST_F(Wayland, StopsTheRobotsWhenTheCompositorDies) {
  if (!has_plugin()) GTEST_SKIP() << "Qt has no plugin for Wayland: install the package qt6-wayland";
  start({experiment_with_links()}, {});
  server.kill();
  expect_stopped_robots();
  EXPECT_TRUE(said.contains(QStringLiteral("The Wayland connection broke"))) << "the control: " << said.toStdString();
}

}  // namespace
}  // namespace skein::ui::test
