#include "ui/base/dialogs.h"

#include <QDialogButtonBox>
#include <QFileInfo>
#include <QGuiApplication>
#include <QInputDialog>
#include <QPushButton>
#include <QScreen>
#include <QShortcut>
#include <QTextDocument>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

namespace skein::ui {

void close_by_key(QDialog* dialog) {
  QObject::connect(new QShortcut(QKeySequence(QStringLiteral("Ctrl+W")), dialog), &QShortcut::activated, dialog,
                   &QDialog::reject);
}

QFileDialog* file_dialog(QWidget* parent, const FileQuestion& question) {
  auto* dialog = new QFileDialog(parent, question.title, question.directory, question.filter);
  dialog->setObjectName(question.name);
  dialog->setOption(QFileDialog::DontUseNativeDialog);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowModality(Qt::NonModal);
  close_by_key(dialog);
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
  auto* dialog = new QInputDialog(parent);
  dialog->setObjectName(name);
  dialog->setWindowTitle(title);
  dialog->setLabelText(QObject::tr("Under the name"));
  QObject::connect(dialog, &QInputDialog::textValueSelected, parent, [named](const QString& text) {
    if (!text.trimmed().isEmpty()) named(text);
  });
  show_beside(dialog);
}

QSize fitting(const QSize& wanted, const QWidget* parent) {
  constexpr int title_bar = 48, edges = 16;  // what a window manager adds
  const QScreen* screen = parent && parent->screen() ? parent->screen() : QGuiApplication::primaryScreen();
  return screen ? wanted.boundedTo(screen->availableSize() - QSize(edges, title_bar)) : wanted;
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
  // As large as the text asks for, within reason.
  constexpr int narrowest = 380, widest = 720;
  QTextDocument* document = text_->document();
  const int width = std::clamp(static_cast<int>(std::ceil(document->idealWidth())), narrowest, widest);
  document->setTextWidth(width);
  const QMargins margins = layout->contentsMargins();
  const int frame = 28;  // scroll bar and edges
  resize(fitting({width + margins.left() + margins.right() + frame,
                  static_cast<int>(document->size().height()) + buttons->sizeHint().height() + 3 * margins.top() + 12},
                 parent));
}

QString MessageDialog::text() const {
  return text_->toPlainText();
}

}  // namespace skein::ui
