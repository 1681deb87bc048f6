#include "ui/editor/experiment_editor.h"

#include <QFileDialog>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QListWidget>
#include <QPushButton>
#include <QSaveFile>
#include <QScrollArea>
#include <QSplitter>
#include <QVBoxLayout>

#include "app/experiment/experiment_file.h"
#include "app/experiment/toml_edit.h"
#include "ui/editor/editor_form.h"
#include "ui/editor/toml_text.h"
#include "ui/palette.h"

namespace skein::ui {
namespace {

constexpr int typing_pause_ms = 250;
constexpr int place_role = Qt::UserRole;  // QPoint(line, column)

}  // namespace

ExperimentEditor::ExperimentEditor(QWidget* parent)
    : QDialog(parent),
      text_(new TomlText(this)),
      form_(new EditorForm(this)),
      list_(new QListWidget(this)),
      verdict_(new QLabel(this)),
      save_(new QPushButton(tr("Save"), this)),
      save_as_(new QPushButton(tr("Save as …"), this)),
      open_(new QPushButton(tr("Save and open"), this)) {
  setObjectName(QStringLiteral("experiment_editor"));
  setAttribute(Qt::WA_DeleteOnClose);
  setWindowModality(Qt::NonModal);
  text_->setObjectName(QStringLiteral("editor_text"));
  text_->setAccessibleName(tr("Text of the experiment"));
  list_->setObjectName(QStringLiteral("editor_problems"));
  list_->setAccessibleName(tr("What is wrong in the text"));
  verdict_->setObjectName(QStringLiteral("editor_verdict"));
  save_->setObjectName(QStringLiteral("editor_save"));
  save_as_->setObjectName(QStringLiteral("editor_save_as"));
  open_->setObjectName(QStringLiteral("editor_open"));
  open_->setToolTip(tr("Ends the run that is on, and sets this experiment up in the window"));
  for (auto* button : {save_, save_as_, open_}) {
    button->setAccessibleName(button->text());
    button->setAutoDefault(false);
  }
  list_->setMaximumHeight(110);

  auto* scroll = new QScrollArea;
  scroll->setWidget(form_);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->setMinimumWidth(form_->sizeHint().width() + 24);
  auto* sides = new QSplitter;
  sides->addWidget(text_);
  sides->addWidget(scroll);
  sides->setStretchFactor(0, 1);
  auto* note = new QLabel(tr("While a run is on, Space and Esc are STOP, here too."), this);
  note->setForegroundRole(QPalette::PlaceholderText);
  auto* buttons = new QHBoxLayout;
  buttons->addWidget(note);
  buttons->addStretch();
  buttons->addWidget(save_);
  buttons->addWidget(save_as_);
  buttons->addWidget(open_);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(sides, 1);
  layout->addWidget(verdict_);
  layout->addWidget(list_);
  layout->addLayout(buttons);
  resize(980, 720);

  pause_.setSingleShot(true);
  connect(&pause_, &QTimer::timeout, this, &ExperimentEditor::check);
  connect(text_, &QPlainTextEdit::textChanged, this, [this] { pause_.start(typing_pause_ms); });
  connect(text_->document(), &QTextDocument::modificationChanged, this, &ExperimentEditor::show_title);
  connect(form_, &EditorForm::set_wanted, this, &ExperimentEditor::set_value);
  connect(list_, &QListWidget::itemActivated, this, [this](const QListWidgetItem* item) {
    const QPoint place = item->data(place_role).toPoint();
    text_->go_to(place.x(), place.y());
  });
  connect(save_, &QPushButton::clicked, this, [this] { save_and(false); });
  connect(save_as_, &QPushButton::clicked, this, [this] { ask_save(false); });
  connect(open_, &QPushButton::clicked, this, [this] { save_and(true); });
}

void ExperimentEditor::edit(const QString& text, const QString& file) {
  file_ = file;
  text_->setPlainText(text);
  text_->document()->setModified(file.isEmpty());
  check();
  show_title();
}

QString ExperimentEditor::text() const {
  return text_->toPlainText();
}

void ExperimentEditor::show_title() {
  const QString name = file_.isEmpty() ? tr("new experiment") : QFileInfo(file_).fileName();
  setWindowTitle(text_->document()->isModified() ? tr("%1 (changed)").arg(name) : name);
}

void ExperimentEditor::check() {
  pause_.stop();
  const QString name = file_.isEmpty() ? tr("experiment") : file_;
  const auto experiment = app::parse_experiment(text().toStdString(), name.toStdString());
  const std::vector<app::Problem> problems = experiment ? std::vector<app::Problem>() : experiment.error();
  problems_ = static_cast<int>(problems.size());
  text_->show_problems(problems);
  list_->clear();
  for (const app::Problem& problem : problems) {
    auto* item = new QListWidgetItem(
        tr("line %1, column %2: %3").arg(problem.line).arg(problem.column).arg(QString::fromStdString(problem.text)),
        list_);
    item->setData(place_role, QPoint(problem.line, problem.column));
  }
  list_->setVisible(!problems.empty());
  const Colours c = colours(palette());
  const QString verdict = problems.empty() ? tr("This experiment can be run.")
                                           : tr("%n problem(s): it cannot be saved like this.", nullptr, problems_);
  verdict_->setText(
      QStringLiteral("<span style=\"color:%1\">%2</span>").arg((problems.empty() ? c.good : c.alarm).name(), verdict));
  for (auto* button : {save_, save_as_, open_}) button->setEnabled(problems.empty());
  form_->show_text(text());
}

void ExperimentEditor::set_value(const QString& key, const QString& value) {
  const auto changed = app::with_toml_value(text().toStdString(), key.toStdString(), value.toStdString());
  if (!changed) {
    verdict_->setText(QString::fromStdString(changed.error()));
    return;
  }
  // As one edit, so that it can be undone.
  QTextCursor all(text_->document());
  all.select(QTextCursor::Document);
  all.insertText(QString::fromStdString(*changed));
  check();
}

void ExperimentEditor::save_and(bool then_open) {
  if (file_.isEmpty()) return ask_save(then_open);
  const QString problem = save(file_);
  if (!problem.isEmpty())
    verdict_->setText(problem);
  else if (then_open)
    emit open_wanted(file_);
}

void ExperimentEditor::ask_save(bool then_open) {
  auto* dialog = new QFileDialog(this, tr("Save experiment"), file_, tr("Experiments (*.toml)"));
  dialog->setObjectName(QStringLiteral("editor_save_dialog"));
  dialog->setOption(QFileDialog::DontUseNativeDialog);  // so that Space and Esc reach the program
  dialog->setAcceptMode(QFileDialog::AcceptSave);
  dialog->setDefaultSuffix(QStringLiteral("toml"));
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowModality(Qt::NonModal);
  connect(dialog, &QFileDialog::fileSelected, this, [this, then_open](const QString& file) {
    file_ = file;
    save_and(then_open);
  });
  dialog->show();
}

QString ExperimentEditor::save(const QString& file) {
  check();
  if (!is_valid()) return tr("%n problem(s): not saved.", nullptr, problems_);
  QSaveFile out(file);
  const QByteArray bytes = text().toUtf8();
  if (!out.open(QIODevice::WriteOnly) || out.write(bytes) < 0 || !out.commit())
    return tr("Could not write %1: %2.").arg(file, out.errorString());
  file_ = file;
  text_->document()->setModified(false);
  show_title();
  return {};
}

}  // namespace skein::ui
