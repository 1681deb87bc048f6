// The program on a real X server, and what it does when that dies. Skipped where there is no Xvfb.
#include <gtest/gtest.h>

#include <QProcess>
#include <QStandardPaths>
#include <csignal>

#include "tests/ui/shown_program.h"

namespace skein::ui::test {
namespace {

class XServer : public ShownProgram {
 protected:
  void SetUp() override {
    const QString program = QStandardPaths::findExecutable(QStringLiteral("Xvfb"));
    if (program.isEmpty()) GTEST_SKIP() << "there is no Xvfb: install the package xvfb";
    // It finds a free display by itself and says which.
    server.start(program, {QStringLiteral("-displayfd"), QStringLiteral("1"), QStringLiteral("-screen"),
                           QStringLiteral("0"), QStringLiteral("1400x900x24"), QStringLiteral("-nolisten"),
                           QStringLiteral("tcp"), QStringLiteral("-noreset")});
    if (!server.waitForReadyRead(patience_ms))
      GTEST_SKIP() << "Xvfb does not start: " << server.readAllStandardError().toStdString();
    display = QStringLiteral(":") + QString::fromLatin1(server.readLine().trimmed());
  }
  void launch(const QStringList& words) {
    ShownProgram::launch(words, {{"DISPLAY", display}, {"QT_QPA_PLATFORM", QStringLiteral("xcb")}});
  }
  void start(const QStringList& words) {
    ShownProgram::start(words, {{"DISPLAY", display}, {"QT_QPA_PLATFORM", QStringLiteral("xcb")}});
  }

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
  start({experiment_with_links()});
  server.kill();
  expect_stopped_robots();
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
