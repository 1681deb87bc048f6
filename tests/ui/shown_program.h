#pragma once

#include <gtest/gtest.h>

#include <QDeadlineTimer>
#include <QDir>
#include <QProcess>
#include <QTemporaryDir>
#include <initializer_list>
#include <utility>

#include "tests/places.h"

namespace skein::ui::test {

/// Runs the program on a display server of the test's own.
class ShownProgram : public ::testing::Test {
 protected:
  static constexpr int patience_ms = 30000;
  using Variables = std::initializer_list<std::pair<const char*, QString>>;

  void TearDown() override {
    for (QProcess* process : {&skein, &server})
      if (process->state() != QProcess::NotRunning) {
        process->kill();
        process->waitForFinished(patience_ms);
      }
  }
  /// The environment without any display, and with these variables.
  QProcessEnvironment with(Variables variables) const {
    QProcessEnvironment environment = QProcessEnvironment::systemEnvironment();
    for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"}) environment.remove(QLatin1String(name));
    environment.insert(QStringLiteral("XDG_CONFIG_HOME"), directory.path());
    environment.insert(QStringLiteral("XDG_DATA_HOME"), directory.path());
    environment.insert(QStringLiteral("XDG_STATE_HOME"), directory.filePath(QStringLiteral("state")));
    // Under the AddressSanitizer: what libdbus and Qt's plugins keep to the end is not what is tested here.
    environment.insert(QStringLiteral("ASAN_OPTIONS"), QStringLiteral("detect_leaks=0"));
    for (const auto& [name, value] : variables) environment.insert(QLatin1String(name), value);
    return environment;
  }
  void launch(const QStringList& words, Variables variables) {
    skein.setProcessEnvironment(with(variables));
    skein.start(QString::fromStdString(skein::test::program()), words);
    ASSERT_TRUE(skein.waitForStarted(patience_ms));
  }
  /// Until it drives robots, where `words` name an experiment with links: such a run leaves a marker. Else for a while.
  void start(const QStringList& words, Variables variables) {
    launch(words, variables);
    const QDir markers(directory.filePath(QStringLiteral("state/skein")));
    const auto drives = [&] { return words.isEmpty() || !markers.isEmpty(); };
    if (words.isEmpty()) skein.waitForFinished(1500);
    for (const QDeadlineTimer deadline(patience_ms); !drives() && !deadline.hasExpired();)
      if (skein.waitForFinished(100)) break;
    ASSERT_EQ(skein.state(), QProcess::Running) << skein.readAllStandardError().toStdString();
    ASSERT_TRUE(drives()) << "no run began";
  }
  /// The display is gone while links to robots are open.
  void expect_stopped_robots() {
    ASSERT_TRUE(skein.waitForFinished(patience_ms)) << "it goes on without anybody who could stop it";
    said = QString::fromUtf8(skein.readAllStandardError());
    EXPECT_EQ(skein.exitStatus(), QProcess::NormalExit) << said.toStdString();
    EXPECT_EQ(skein.exitCode(), 3) << said.toStdString();
    EXPECT_TRUE(said.contains(QStringLiteral("the display is gone"))) << said.toStdString();
    EXPECT_TRUE(said.contains(QStringLiteral("all robots have stopped"))) << said.toStdString();
  }
  static QString experiment_with_links() {
    return QString::fromStdString(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  }

  QTemporaryDir directory;
  QProcess server, skein;
  QString said;  // by the program, at its end
};

}  // namespace skein::ui::test
