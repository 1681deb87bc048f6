#include "ui/editor/draft.h"

#include <QCryptographicHash>
#include <QDir>
#include <QFile>
#include <QFileInfo>
#include <QSaveFile>
#include <QStandardPaths>

namespace skein::ui {

Draft::Draft(const QString& of) {
  const QString folder =
      QStandardPaths::writableLocation(QStandardPaths::GenericDataLocation) + QStringLiteral("/skein/drafts/");
  const QByteArray hash = QCryptographicHash::hash(of.toUtf8(), QCryptographicHash::Sha1).toHex();
  file_ = folder + QString::fromLatin1(hash.left(16)) + QStringLiteral(".toml");
}

std::optional<Draft::Kept> Draft::kept() const {
  QFile file(file_);
  if (!file.open(QIODevice::ReadOnly)) return {};
  return Kept{QString::fromUtf8(file.readAll()), QFileInfo(file_).lastModified()};
}

void Draft::keep(const QString& text) const {
  QDir().mkpath(QFileInfo(file_).path());
  QSaveFile file(file_);
  if (file.open(QIODevice::WriteOnly) && file.write(text.toUtf8()) >= 0) file.commit();
}

void Draft::forget() const {
  QFile::remove(file_);
}

}  // namespace skein::ui
