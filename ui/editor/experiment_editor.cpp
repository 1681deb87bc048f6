#include "ui/editor/experiment_editor.h"

#include <QFile>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QListWidget>
#include <QLocale>
#include <QMessageBox>
#include <QPushButton>
#include <QSaveFile>
#include <QScrollArea>
#include <QSplitter>
#include <QVBoxLayout>
#include <optional>
#include <utility>

#include "app/experiment/experiment_file.h"
#include "app/experiment/experiment_sets.h"
#include "app/experiment/toml_edit.h"
#include "ui/base/dialogs.h"
#include "ui/base/number_text.h"
#include "ui/base/palette.h"
#include "ui/editor/draft.h"
#include "ui/editor/editor_form.h"
#include "ui/editor/toml_text.h"

namespace skein::ui {
namespace {

constexpr int typing_pause_ms = 250;
constexpr int place_role = Qt::UserRole;  // QPoint(line, column)

/// With ends of lines as the editor has them.
QString as_edited(QString text) {
  return text.replace(QStringLiteral("\r\n"), QStringLiteral("\n"));
}

/// What a file holds, as the editor has it; none: it cannot be read.
std::optional<QString> text_of(const QString& path) {
  QFile file(path);
  if (!file.open(QIODevice::ReadOnly)) return std::nullopt;
  return as_edited(QString::fromUtf8(file.readAll()));
}

/// The keys in which one experiment differs from another: "duration, controller.k_y".
QString differing_keys(const QString& before, const QString& after) {
  constexpr qsizetype most = 5;
  QStringList keys;
  for (const std::string& set : app::sets_between(before.toStdString(), after.toStdString()))
    keys << QString::fromStdString(set.substr(0, set.find('=')));
  const bool more = keys.size() > most;
  keys = keys.mid(0, most);
  if (more) keys << QStringLiteral("…");
  return keys.join(QStringLiteral(", "));
}

}  // namespace

ExperimentEditor::ExperimentEditor(QWidget* parent)
    : QDialog(parent),
      text_(new TomlText(this)),
      form_(new EditorForm(this)),
      list_(new QListWidget(this)),
      verdict_(new QLabel(this)),
      save_(new QPushButton(tr("Save"), this)),
      save_as_(new QPushButton(tr("Save as …"), this)),
      open_(new QPushButton(tr("Save and open"), this)),
      offer_(new QWidget(this)),
      offer_text_(new QLabel(offer_)) {
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
  open_->setToolTip(tr("Ends the present run, and sets this experiment up in the window"));
  for (auto* button : {save_, save_as_, open_}) {
    button->setAccessibleName(button->text());
    button->setAutoDefault(false);
  }
  list_->setMaximumHeight(110);

  auto* scroll = new QScrollArea;
  scroll->setWidget(form_);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->setFocusPolicy(Qt::NoFocus);
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
  offer_->setObjectName(QStringLiteral("editor_draft"));
  offer_->hide();
  offer_text_->setWordWrap(true);
  auto* offer = new QHBoxLayout(offer_);
  offer->setContentsMargins(0, 0, 0, 0);
  offer->addWidget(offer_text_, 1);
  const auto answer = [&](const QString& text, const char* name, bool use) {
    auto* button = new QPushButton(text, offer_);
    button->setObjectName(QLatin1String(name));
    button->setAccessibleName(text);
    button->setAutoDefault(false);
    connect(button, &QPushButton::clicked, this, [this, use] { settle_draft(use); });
    offer->addWidget(button);
  };
  answer(tr("Go on with it"), "editor_draft_use", true);
  answer(tr("Forget it"), "editor_draft_forget", false);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(offer_);
  layout->addWidget(sides, 1);
  layout->addWidget(verdict_);
  layout->addWidget(list_);
  layout->addLayout(buttons);
  resize(fitting({980, 720}, parent));
  close_by_key(this);

  asks_.setSingleShot(true);
  connect(&asks_, &QTimer::timeout, this, [this] { take_verdict({}); });
  pause_.setSingleShot(true);
  connect(&pause_, &QTimer::timeout, this, &ExperimentEditor::check);
  connect(text_, &QPlainTextEdit::textChanged, this, [this] { pause_.start(typing_pause_ms); });
  connect(text_->document(), &QTextDocument::modificationChanged, this, &ExperimentEditor::show_title);
  connect(form_, &EditorForm::set_wanted, this, &ExperimentEditor::set_value);
  list_->setWordWrap(true);  // a problem is read to its end
  list_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  connect(list_, &QListWidget::itemActivated, this, [this](const QListWidgetItem* item) {
    const QPoint place = item->data(place_role).toPoint();
    text_->go_to(place.x(), place.y());
  });
  connect(save_, &QPushButton::clicked, this, [this] { save_and(false); });
  connect(save_as_, &QPushButton::clicked, this, [this] { ask_save(false); });
  connect(open_, &QPushButton::clicked, this, [this] { save_and(true); });
  text_->setFocus();  // once it has its place: before, the layout would take the focus away
}

ExperimentEditor::~ExperimentEditor() = default;

void ExperimentEditor::edit(const QString& text, const QString& file, const QString& in_file) {
  file_ = file;
  draft_ = std::make_unique<Draft>(file.isEmpty() ? text : file);
  text_->setPlainText(text);
  text_->document()->setModified(file.isEmpty());
  kept_ = on_disk_ = this->text();
  if (!in_file.isEmpty()) on_disk_ = as_edited(in_file);
  offer_draft();  // before the check, which would take it for settled
  check();
  show_title();
  if (list_->count() > 0) emit list_->itemActivated(list_->item(0));
}

/// While one is offered it is not written over.
void ExperimentEditor::keep_draft() {
  if (!draft_ || !offer_->isHidden()) return;
  if (has_changes())
    draft_->keep(text());
  else
    draft_->forget();
}

void ExperimentEditor::offer_draft() {
  const std::optional<Draft::Kept> kept = draft_->kept();
  const bool differs = kept && kept->text != text();
  offer_->setVisible(differs);
  if (differs)
    offer_text_->setText(tr("There is another text of this experiment, of %1, which nobody saved.")
                             .arg(QLocale::system().toString(kept->at, QLocale::ShortFormat)));
}

void ExperimentEditor::settle_draft(bool use) {
  const std::optional<Draft::Kept> kept = draft_->kept();
  offer_->hide();
  if (use && kept)
    replace_text(kept->text);
  else
    keep_draft();
}

QString ExperimentEditor::text() const {
  return text_->toPlainText();
}

void ExperimentEditor::show_title() {
  const QString name = file_.isEmpty() ? tr("new experiment") : QFileInfo(file_).fileName();
  setWindowTitle(text_->document()->isModified() ? tr("%1 (changed)").arg(name) : name);
}

/// An experiment of many robots with long timetables takes seconds, and this thread shows runs of real robots too.
void ExperimentEditor::check() {
  constexpr std::chrono::milliseconds unnoticed{100};
  pause_.stop();
  opens_then_ = false;
  const QString name = file_.isEmpty() ? tr("experiment") : file_;
  checking_.run([text = text().toStdString(), file = name.toStdString(), keys = form_->keys()](const std::stop_token&) {
    auto experiment = app::parse_experiment(text, file);
    return Verdict{experiment ? std::vector<app::Problem>() : std::move(experiment.error()),
                   app::toml_values(text, keys)};
  });
  take_verdict(unnoticed);
}

void ExperimentEditor::take_verdict(std::chrono::milliseconds patience) {
  constexpr int asks_every_ms = 30;
  if (const auto verdict = checking_.take(patience)) return show_verdict(*verdict);
  open_->setEnabled(false);
  tell(tr("Checking …"), Severity::notice);
  asks_.start(asks_every_ms);
}

void ExperimentEditor::show_verdict(const Verdict& told) {
  const std::vector<app::Problem>& problems = told.problems;
  asks_.stop();
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
  tell(problems.empty() ? tr("This experiment can be run.")
                        : tr("%1: this experiment cannot run.").arg(counted(problems_, "problem")),
       problems.empty() ? Severity::good : Severity::alarm);
  open_->setEnabled(problems.empty());
  form_->show_values(told.values);
  keep_draft();
  if (std::exchange(opens_then_, false) && problems.empty()) emit open_wanted(file_);
}

void ExperimentEditor::tell(const QString& verdict, Severity tone) {
  tone_ = tone;
  verdict_->setText(QStringLiteral("<span style=\"color:%1\">%2</span>")
                        .arg(colour(tone, colours(palette())).name(), verdict.toHtmlEscaped()));
  told_ = verdict;
}

void ExperimentEditor::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) tell(told_, tone_);
  QDialog::changeEvent(event);
}

void ExperimentEditor::set_value(const QString& key, const QString& value) {
  const auto changed = app::with_toml_value(text().toStdString(), key.toStdString(), value.toStdString());
  if (!changed) {
    tell(QString::fromStdString(changed.error()), Severity::alarm);
    return;
  }
  replace_text(QString::fromStdString(*changed));
}

void ExperimentEditor::append(const QString& tables) {
  const QString before = text();
  const bool ends = before.isEmpty() || before.endsWith(QLatin1Char('\n'));
  replace_text(before + QLatin1String(ends ? "\n" : "\n\n") + tables);
}

/// As one edit, so that it can be undone.
void ExperimentEditor::replace_text(const QString& text) {
  QTextCursor all(text_->document());
  all.select(QTextCursor::Document);
  all.insertText(text);
  check();
}

void ExperimentEditor::save_and(bool then_open) {
  if (file_.isEmpty()) return ask_save(then_open);
  const QString name = QFileInfo(file_).fileName();
  if (was_changed_by_others())
    return ask_overwrite(then_open, tr("%1 was changed by another program since it was opened here.").arg(name));
  if (differs_from_file()) {
    const QString keys = differing_keys(on_disk_, kept_);
    return ask_overwrite(
        then_open, tr("The experiment that is open differs from %1: by --set, by values of other files, or by what was "
                      "changed in the window. "
                      "Saving writes that into the file too%2")
                       .arg(name, keys.isEmpty() ? QStringLiteral(".") : QStringLiteral(": ") + keys));
  }
  write_and(then_open);
}

void ExperimentEditor::write_and(bool then_open) {
  const QString problem = save(file_);
  if (!problem.isEmpty())
    tell(problem, Severity::alarm);
  else if (then_open && is_checking())
    opens_then_ = true;
  else if (then_open && is_valid())
    emit open_wanted(file_);
}

bool ExperimentEditor::was_changed_by_others() const {
  const std::optional<QString> now = text_of(file_);
  return now && *now != on_disk_;
}

void ExperimentEditor::ask_overwrite(bool then_open, const QString& why) {
  auto* box = new QMessageBox(QMessageBox::Warning, tr("The file differs"), why, QMessageBox::NoButton, this);
  box->setObjectName(QStringLiteral("editor_overwrite_dialog"));
  auto* overwrite = box->addButton(tr("Overwrite it"), QMessageBox::DestructiveRole);
  auto* reload = box->addButton(tr("Open the file as it is"), QMessageBox::ResetRole);
  auto* other = box->addButton(tr("Save under another name …"), QMessageBox::ActionRole);
  box->addButton(QMessageBox::Cancel);
  connect(overwrite, &QPushButton::clicked, this, [this, then_open] { write_and(then_open); });
  connect(reload, &QPushButton::clicked, this, [this] { edit(text_of(file_).value_or(text()), file_); });
  connect(other, &QPushButton::clicked, this, [this, then_open] { ask_save(then_open); });
  show_beside(box);
}

void ExperimentEditor::reject() {
  if (has_changes())
    ask_close();
  else
    QDialog::reject();
}

void ExperimentEditor::ask_close() {
  if (auto* asked = findChild<QMessageBox*>(QStringLiteral("editor_close_dialog"))) return asked->raise();
  auto* box = new QMessageBox(QMessageBox::Question, tr("Not saved"), tr("This experiment has unsaved changes."),
                              QMessageBox::NoButton, this);
  box->setObjectName(QStringLiteral("editor_close_dialog"));
  auto* keep = box->addButton(tr("Save"), QMessageBox::AcceptRole);
  auto* discard = box->addButton(tr("Discard them"), QMessageBox::DestructiveRole);
  box->addButton(tr("Keep editing"), QMessageBox::RejectRole);
  connect(keep, &QPushButton::clicked, this, [this] { save_and(false); });
  connect(discard, &QPushButton::clicked, this, [this] {
    draft_->forget();
    pause_.stop();
    QDialog::reject();
  });
  show_beside(box);
}

void ExperimentEditor::ask_save(bool then_open) {
  QFileDialog* dialog =
      file_dialog(this, {tr("Save experiment"), QStringLiteral("editor_save_dialog"), tr("Experiments (*.toml)"),
                         QFileInfo(file_).path(),
                         file_.isEmpty() ? QStringLiteral("experiment.toml") : QFileInfo(file_).fileName()});
  connect(dialog, &QFileDialog::fileSelected, this, [this, then_open](const QString& file) {  // Qt asks to overwrite
    file_ = file;
    write_and(then_open);
  });
  dialog->show();
}

QString ExperimentEditor::save(const QString& file) {
  check();
  QSaveFile out(file);
  const QByteArray bytes = text().toUtf8();
  if (!out.open(QIODevice::WriteOnly) || out.write(bytes) < 0 || !out.commit())
    return tr("Could not write %1: %2.").arg(file, out.errorString());
  file_ = file;
  kept_ = on_disk_ = text();
  keep_draft();  // there is nothing to keep
  draft_ = std::make_unique<Draft>(file);
  text_->document()->setModified(false);
  show_title();
  return {};
}

}  // namespace skein::ui
