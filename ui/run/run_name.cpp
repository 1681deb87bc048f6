#include "ui/run/run_name.h"

#include <QDir>
#include <QFileInfo>

#include "app/runs/run_folder.h"

namespace skein::ui {

bool is_kept_record(const QString& file) {
  const QFileInfo record(file);
  return record.fileName() == QLatin1String(app::run_files::record) &&
         record.dir().exists(QLatin1String(app::run_files::story));
}

QString run_name(const QString& file) {
  const QFileInfo record(file);
  return is_kept_record(file) ? record.absoluteDir().dirName() : record.fileName();
}

}  // namespace skein::ui
