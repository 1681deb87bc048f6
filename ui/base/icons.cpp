#include "ui/base/icons.h"

#include <QFile>
#include <QPainter>
#include <QPixmap>
#include <QSvgRenderer>

// A static library's resources are linked only where somebody asks for them; the macro wants the global namespace.
static void load_resources() {
  Q_INIT_RESOURCE(icons);
}

namespace skein::ui {
namespace {

QByteArray read(const QString& name) {
  load_resources();
  QFile file(QStringLiteral(":/skein/icons/%1.svg").arg(name));
  return file.open(QIODevice::ReadOnly) ? file.readAll() : QByteArray();
}

QIcon draw(const QByteArray& svg, std::initializer_list<int> sizes) {
  QSvgRenderer renderer(svg);
  QIcon icon;
  for (const int size : sizes) {  // several sizes, so that a dense screen gets a sharp one
    QPixmap pixmap(size, size);
    pixmap.fill(Qt::transparent);
    QPainter painter(&pixmap);
    renderer.render(&painter);
    icon.addPixmap(pixmap);
  }
  return icon;
}

}  // namespace

QIcon icon(const QString& name, const QColor& ink) {
  return draw(read(name).replace("currentColor", ink.name().toLatin1()), {16, 20, 32, 48});
}

QIcon program_icon() {
  return draw(read(QStringLiteral("skein")), {16, 24, 32, 48, 64, 128, 256});
}

}  // namespace skein::ui
