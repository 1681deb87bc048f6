#pragma once

#include <QSettings>
#include <QTemporaryDir>

#include "ui/base/settings.h"

namespace skein::ui::test {

/// Settings, drafts, kept runs and markers of runs of one program's own: what its user has is left alone and shows
/// nowhere.
class OwnHome {
 public:
  OwnHome() {
    for (const char* const place : {"XDG_STATE_HOME", "XDG_DATA_HOME"}) qputenv(place, folder_.path().toUtf8());
    QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, folder_.path());
    settings().setValue(QStringLiteral("keep_runs"), false);  // but where a test asks for it
  }

 private:
  const QTemporaryDir folder_;
};

}  // namespace skein::ui::test
