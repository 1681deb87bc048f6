#pragma once

#include <QDialog>
#include <QTimer>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/problem.h"
#include "ui/base/aside.h"
#include "ui/base/modes.h"

class QLabel;
class QListWidget;
class QPushButton;

namespace skein::ui {

class Draft;
class EditorForm;
class TomlText;

/// An experiment's file: its text with its errors marked, and its common keys as fields. An unfinished text can be
/// saved, but not run. Nothing is lost without a question: neither what was typed, nor what another program wrote to
/// the file meanwhile. After the program was killed, the typed text is offered when the file is opened again.
class ExperimentEditor final : public QDialog {
  Q_OBJECT

 public:
  explicit ExperimentEditor(QWidget* parent = nullptr);
  ~ExperimentEditor() override;
  /// `file`: where it lies, empty for a text that has no file yet. `in_file`: what the file held when the experiment
  /// was opened, which may differ from the text; empty: the text.
  void edit(const QString& text, const QString& file, const QString& in_file = {});
  QString text() const;
  /// One key with another value, as TOML has it; errors are shown below the text.
  void set_value(const QString& key, const QString& value);
  /// More tables at the end of the text.
  void append(const QString& tables);
  /// Whether it can be run, as far as is known: a large experiment is checked on another thread.
  bool is_valid() const { return problems_ == 0 && !is_checking(); }
  bool is_checking() const { return checking_.is_busy(); }
  /// Whether it differs from the last opened or saved text.
  bool has_changes() const { return text() != kept_; }
  /// Writes the text, finished or not. Returns the error; empty: none.
  QString save(const QString& file);
  /// As the button of this name does: it asks where the file has changed meanwhile, or there is none.
  void save_and_open() { save_and(true); }

 protected:
  void changeEvent(QEvent*) override;

 public slots:
  void reject() override;  ///< closes, or asks about unsaved changes

 signals:
  void open_wanted(const QString& file);  ///< it is saved, and the window is to run it

 private:
  void replace_text(const QString& text);
  void check();
  void take_verdict(std::chrono::milliseconds patience);
  struct Verdict {
    std::vector<app::Problem> problems;
    std::vector<std::optional<std::string>> values;  // of the form's keys
  };
  void show_verdict(const Verdict& verdict);
  void tell(const QString& verdict, Severity tone);
  void ask_save(bool then_open);
  void save_and(bool then_open);
  void write_and(bool then_open);
  bool was_changed_by_others() const;
  bool differs_from_file() const { return kept_ != on_disk_; }
  void ask_overwrite(bool then_open, const QString& why);
  void ask_close();
  void show_title();
  void keep_draft();
  void offer_draft();
  void settle_draft(bool use);

  TomlText* text_;
  EditorForm* form_;
  QListWidget* list_;
  QLabel* verdict_;
  QString told_;  // by it
  Severity tone_ = Severity::note;
  QPushButton *save_, *save_as_, *open_;
  QWidget* offer_;  // of a draft
  QLabel* offer_text_;
  std::unique_ptr<Draft> draft_;
  QTimer pause_;  // in typing
  Aside<Verdict> checking_;
  QTimer asks_;              // for the verdict
  bool opens_then_ = false;  // if the verdict is good
  QString file_;
  QString kept_;     // the text as it was opened or saved last
  QString on_disk_;  // what file_ held then, as far as is known
  int problems_ = 0;
};

}  // namespace skein::ui
