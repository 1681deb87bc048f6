#pragma once

#include <QDialog>
#include <QTimer>

class QLabel;
class QListWidget;
class QPushButton;

namespace skein::ui {

class EditorForm;
class TomlText;

/// An experiment's file: its text with what is wrong in it, and its common keys as fields. What is wrong is never
/// saved.
class ExperimentEditor final : public QDialog {
  Q_OBJECT

 public:
  explicit ExperimentEditor(QWidget* parent = nullptr);
  /// `file`: where it lies, empty for a text that has no file yet.
  void edit(const QString& text, const QString& file);
  QString text() const;
  bool is_valid() const { return problems_ == 0; }
  /// The answer says what went wrong; empty: nothing.
  QString save(const QString& file);

 signals:
  void open_wanted(const QString& file);  ///< it is saved, and the window is to run it

 private:
  void check();
  void set_value(const QString& key, const QString& value);
  void ask_save(bool then_open);
  void save_and(bool then_open);
  void show_title();

  TomlText* text_;
  EditorForm* form_;
  QListWidget* list_;
  QLabel* verdict_;
  QPushButton *save_, *save_as_, *open_;
  QTimer pause_;  // in typing
  QString file_;
  int problems_ = 0;
};

}  // namespace skein::ui
