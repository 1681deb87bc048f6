#include "ui/base/dialogs.h"

#include <QDialogButtonBox>
#include <QFileInfo>
#include <QGuiApplication>
#include <QInputDialog>
#include <QPushButton>
#include <QScreen>
#include <QShortcut>
#include <QTextDocument>
#include <QUrl>
#include <QVBoxLayout>
#include <QWindow>
#include <algorithm>

namespace skein::ui {

namespace {

constexpr int title_bar = 48, edges = 16;  // what a window manager adds
constexpr QMargins frame(edges / 2, title_bar - edges / 2, edges / 2, edges / 2);

QRect inside(const QRect& rectangle, const QRect& room) {
  QRect moved(rectangle.topLeft(), rectangle.size().boundedTo(room.size()));
  moved.moveLeft(std::clamp(moved.left(), room.left(), room.right() - moved.width() + 1));
  moved.moveTop(std::clamp(moved.top(), room.top(), room.bottom() - moved.height() + 1));
  return moved;
}

/// The folder, or the nearest above it that exists: Qt takes the name of one that does not exist for a file's.
QString existing(QString folder) {
  while (!folder.isEmpty() && !QFileInfo(folder).isDir()) {
    const QString above = QFileInfo(folder).path();
    if (above == folder) return {};
    folder = above;
  }
  return folder;
}

}  // namespace

void close_by_key(QDialog* dialog) {
  QObject::connect(new QShortcut(QKeySequence(QStringLiteral("Ctrl+W")), dialog), &QShortcut::activated, dialog,
                   &QDialog::reject);
}

QFileDialog* file_dialog(QWidget* parent, const FileQuestion& question) {
  auto* dialog = new QFileDialog(parent, question.title, existing(question.directory), question.filter);
  dialog->setObjectName(question.name);
  dialog->setOption(QFileDialog::DontUseNativeDialog);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowModality(Qt::NonModal);
  close_by_key(dialog);
  QList<QUrl> side = dialog->sidebarUrls();  // also what the operator has put there
  for (const QString& place : question.places)
    if (const QUrl url = QUrl::fromLocalFile(place); QFileInfo(place).isDir() && !side.contains(url)) side << url;
  dialog->setSidebarUrls(side);
  if (question.save_as.isEmpty()) {
    dialog->setFileMode(QFileDialog::ExistingFile);
  } else {
    dialog->setAcceptMode(QFileDialog::AcceptSave);
    dialog->setDefaultSuffix(QFileInfo(question.save_as).suffix());
    dialog->selectFile(question.save_as);
  }
  return dialog;
}

void ask_name(QWidget* parent, const QString& name, const QString& title,
              const std::function<void(const QString&)>& named) {
  auto* dialog = new QInputDialog(parent->window());  // of a panel it would be disabled with it
  dialog->setObjectName(name);
  dialog->setWindowTitle(title);
  dialog->setLabelText(QObject::tr("Under the name"));
  QObject::connect(dialog, &QInputDialog::textValueSelected, parent, [named](const QString& text) {
    if (!text.trimmed().isEmpty()) named(text);
  });
  show_beside(dialog);
}

QSize fitting(const QSize& wanted, const QWidget* parent) {
  const QScreen* screen = parent && parent->screen() ? parent->screen() : QGuiApplication::primaryScreen();
  return screen ? wanted.boundedTo(screen->availableSize() - QSize(edges, title_bar)) : wanted;
}

void keep_on_screen(QWidget* window) {
  const QRect there = window->geometry() + frame;
  const QScreen* under = QGuiApplication::screenAt(there.center());
  const QScreen* screen = under ? under : QGuiApplication::primaryScreen();
  if (!screen || window->isMaximized() || window->isFullScreen()) return;
  const QRect whole = inside(there, screen->availableGeometry());
  if (whole != there) window->setGeometry(whole - frame);
}

QRect clear_of(const QRect& dialog, const QRect& button, const QRect& screen) {
  if (!dialog.intersects(button)) return dialog;
  QRect left = screen, below = screen, right = screen, above = screen;
  left.setRight(button.left() - 1);
  below.setTop(button.bottom() + 1);
  right.setLeft(button.right() + 1);
  above.setBottom(button.top() - 1);
  const auto kept = [&](const QRect& room) {
    const QSize size = dialog.size().boundedTo(room.size());
    return size.isEmpty() ? 0 : size.width() * size.height();
  };
  const QRect room =
      std::max({left, below, right, above}, [&](const QRect& a, const QRect& b) { return kept(a) < kept(b); });
  return inside(dialog, room);
}

void keep_clear_of(QWidget* dialog, const QWidget& button) {
  const QWidget& main = *button.window();
  const bool is_there = dialog->windowHandle() && dialog->windowHandle()->isExposed();
  QRect there = dialog->geometry();
  // Qt puts a dialog that nobody has placed over the middle of its parent.
  if (!is_there && !dialog->testAttribute(Qt::WA_Moved)) there.moveCenter(main.geometry().center());
  there += frame;
  const QRect stop(button.mapToGlobal(QPoint()), button.size());
  const QRect clear = clear_of(there, stop, main.screen()->availableGeometry());
  if (clear != there) dialog->setGeometry(clear - frame);
}

MessageDialog::MessageDialog(const QString& name, const QString& title, const QString& rich_text, QWidget* parent)
    : QDialog(parent), text_(new QTextBrowser(this)) {
  setObjectName(name);
  setWindowTitle(title);
  if (parent) addActions(parent->window()->actions());
  text_->setObjectName(QStringLiteral("message_text"));
  text_->setAccessibleName(title);
  text_->setFrameShape(QFrame::NoFrame);
  text_->viewport()->setAutoFillBackground(false);
  text_->setOpenExternalLinks(true);
  text_->setHtml(rich_text);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close, this);
  QPushButton* close = buttons->button(QDialogButtonBox::Close);
  close->setObjectName(QStringLiteral("message_close"));
  close->setAccessibleName(close->text());
  close->setFocus();
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(text_, 1);
  layout->addWidget(buttons);
  // As wide as it takes for the text to be no higher than wide, within reason.
  constexpr int narrowest = 380, widest = 720, step = 20;
  QTextDocument* document = text_->document();
  int width = narrowest;
  for (document->setTextWidth(width); width < widest && document->size().height() > width;)
    document->setTextWidth(width += step);
  const QMargins margins = layout->contentsMargins();
  const int bar = 28;  // scroll bar and edges
  resize(fitting({width + margins.left() + margins.right() + bar,
                  static_cast<int>(document->size().height()) + buttons->sizeHint().height() + 3 * margins.top() + 12},
                 parent));
}

QString MessageDialog::text() const {
  return text_->toPlainText();
}

}  // namespace skein::ui
