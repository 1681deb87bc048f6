// The program on a real X server, and what it does when that dies. Skipped where there is no Xvfb.
#include <gtest/gtest.h>

#include <QProcess>
#include <QStandardPaths>
#include <QTemporaryDir>
#include <QTest>
#include <csignal>

#include "tests/places.h"

namespace skein::ui::test {
namespace {

constexpr int patience_ms = 30000;

class XServer : public ::testing::Test {
 protected:
  void SetUp() override {
    const QString program = QStandardPaths::findExecutable(QStringLiteral("Xvfb"));
    if (program.isEmpty()) GTEST_SKIP() << "there is no Xvfb: install the package xvfb";
    // It finds a free display by itself and says which.
    server.start(program,
                 {QStringLiteral("-displayfd"), QStringLiteral("1"), QStringLiteral("-screen"), QStringLiteral("0"),
                  QStringLiteral("1400x900x24"), QStringLiteral("-nolisten"), QStringLiteral("tcp")});
    if (!server.waitForReadyRead(patience_ms))
      GTEST_SKIP() << "Xvfb does not start: " << server.readAllStandardError().toStdString();
    display = QStringLiteral(":") + QString::fromLatin1(server.readLine().trimmed());
  }
  void TearDown() override {
    for (QProcess* process : {&skein, &server})
      if (process->state() != QProcess::NotRunning) {
        process->kill();
        process->waitForFinished(patience_ms);
      }
  }
  void launch(const QStringList& words) {
    QProcessEnvironment environment = QProcessEnvironment::systemEnvironment();
    environment.insert(QStringLiteral("DISPLAY"), display);
    environment.insert(QStringLiteral("QT_QPA_PLATFORM"), QStringLiteral("xcb"));
    environment.insert(QStringLiteral("XDG_CONFIG_HOME"), directory.path());
    environment.insert(QStringLiteral("XDG_DATA_HOME"), directory.path());
    environment.remove(QStringLiteral("WAYLAND_DISPLAY"));
    // Under the AddressSanitizer: what libdbus and Qt's X11 plugin keep to the end is not what is tested here.
    environment.insert(QStringLiteral("ASAN_OPTIONS"), QStringLiteral("detect_leaks=0"));
    skein.setProcessEnvironment(environment);
    skein.start(QString::fromStdString(skein::test::program()), words);
    ASSERT_TRUE(skein.waitForStarted(patience_ms));
  }
  void start(const QStringList& words) {
    launch(words);
    skein.waitForFinished(1500);  // long enough to be on the screen and running
    ASSERT_EQ(skein.state(), QProcess::Running) << skein.readAllStandardError().toStdString();
  }

  QTemporaryDir directory;
  QProcess server, skein;
  QString display;
};

TEST_F(XServer, ShowsTheWindowUntilItIsToldToEnd) {
  start({});
  ::kill(static_cast<pid_t>(skein.processId()), SIGTERM);
  ASSERT_TRUE(skein.waitForFinished(patience_ms)) << "it does not end";
  EXPECT_EQ(skein.exitStatus(), QProcess::NormalExit);
  EXPECT_EQ(skein.exitCode(), 0) << skein.readAllStandardError().toStdString();
}

TEST_F(XServer, ThatIsNotThereIsSaidInOneSentence) {
  // The number of a server that has ended is taken by the next one: this is one that none comes to by counting.
  display = QStringLiteral(":59000");
  launch({});
  ASSERT_TRUE(skein.waitForFinished(patience_ms)) << "it does not end";
  const QString said = QString::fromUtf8(skein.readAllStandardError());
  EXPECT_EQ(skein.exitStatus(), QProcess::NormalExit) << said.toStdString();
  EXPECT_EQ(skein.exitCode(), 2) << said.toStdString();
  EXPECT_TRUE(said.contains(QStringLiteral("skein: no display for the window (DISPLAY is %1, ").arg(display)))
      << said.toStdString();
}

TEST_F(XServer, StopsTheRobotsWhenTheServerDies) {
  start({QString::fromStdString(skein::test::in_source("resources/experiments/platoon-loopback.toml"))});
  server.kill();
  ASSERT_TRUE(skein.waitForFinished(patience_ms)) << "it goes on without anybody who could stop it";
  const QString said = QString::fromUtf8(skein.readAllStandardError());
  EXPECT_EQ(skein.exitStatus(), QProcess::NormalExit) << said.toStdString();
  EXPECT_EQ(skein.exitCode(), 3) << said.toStdString();
  EXPECT_TRUE(said.contains(QStringLiteral("the display is gone"))) << said.toStdString();
  EXPECT_TRUE(said.contains(QStringLiteral("all robots have stopped"))) << said.toStdString();
}

TEST_F(XServer, LivesThroughAServerThatStallsForAWhile) {
  start({});
  const auto id = static_cast<pid_t>(server.processId());
  ::kill(id, SIGSTOP);
  EXPECT_FALSE(skein.waitForFinished(1500)) << skein.readAllStandardError().toStdString();
  ::kill(id, SIGCONT);
  EXPECT_FALSE(skein.waitForFinished(500)) << skein.readAllStandardError().toStdString();
  ::kill(static_cast<pid_t>(skein.processId()), SIGTERM);
  ASSERT_TRUE(skein.waitForFinished(patience_ms)) << "it does not end";
  EXPECT_EQ(skein.exitCode(), 0) << skein.readAllStandardError().toStdString();
}

}  // namespace
}  // namespace skein::ui::test
