// Takes the pictures of the window for the documents: the paper's experiment shortly after a perturbation, light and
// dark. skein_screenshots DIR [SECONDS [WIDTH HEIGHT [EXPERIMENT]]]
#include <QApplication>
#include <QDir>
#include <QSettings>
#include <QTemporaryDir>
#include <QTest>
#include <cstdio>

#include "app/experiment_file.h"
#include "ui/main_window.h"
#include "ui/window.h"

namespace {

bool save(skein::ui::MainWindow& window, skein::ui::Theme theme, const QString& file) {
  window.set_theme(theme);
  QTest::qWait(300);  // two replots
  return window.grab().save(file);
}

}  // namespace

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  const QTemporaryDir settings;  // the user's own are none of this program's business
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, settings.path());
  skein::ui::prepare(application);
  const QStringList words = QApplication::arguments();
  if (words.size() < 2) {
    std::fprintf(stderr, "usage: skein_screenshots DIR [SECONDS [WIDTH HEIGHT [EXPERIMENT]]]\n");
    return 2;
  }
  const double seconds = words.size() > 2 ? words[2].toDouble() : 19.4;  // the first perturbation comes at 18 s
  skein::app::Experiment experiment = skein::app::paper_experiment();
  if (words.size() > 5) {
    auto loaded = skein::app::load_experiment(words[5].toStdString());
    if (!loaded) {
      std::fprintf(stderr, "%s\n", loaded.error().front().message().c_str());
      return 2;
    }
    experiment = *loaded;
  }

  skein::ui::MainWindow window;
  window.resize(words.size() > 4 ? QSize(words[3].toInt(), words[4].toInt()) : QSize(1280, 800));
  window.show();
  window.open(experiment, true);
  const auto there = [&] { return window.live().latest() && window.live().latest()->t >= seconds; };
  if (!QTest::qWaitFor(there, static_cast<int>(seconds * 1000) + 10000)) {
    std::fprintf(stderr, "the run did not get to %g s\n", seconds);
    return 3;
  }
  const QDir dir(words[1]);
  const bool done = save(window, skein::ui::Theme::light, dir.filePath(QStringLiteral("window.png"))) &&
                    save(window, skein::ui::Theme::dark, dir.filePath(QStringLiteral("window-dark.png")));
  if (!done) std::fprintf(stderr, "could not write to %s\n", argv[1]);
  window.close();
  static_cast<void>(QTest::qWaitFor([&] { return !window.isVisible(); }, 3000));
  return done ? 0 : 3;
}
