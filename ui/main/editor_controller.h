#pragma once

#include <QMenu>
#include <utility>
#include <vector>

#include "ui/main/file_controller.h"

namespace skein::ui {

class ExperimentEditor;

/// The experiment as a text: to edit it, or to save its present state.
class EditorController final : public QObject {
  Q_OBJECT

 public:
  EditorController(const Runs& runs, FileController& files, const Messages& messages, QObject* parent = nullptr);
  void build_menu(QMenu* file);
  void edit(const QString& text, const QString& file);
  /// The experiment that is shown with other values for these keys, as TOML has them; not saved yet.
  void edit_with(const std::vector<std::pair<QString, QString>>& values);
  /// The same, saved and opened at once; the editor stays, where it can be undone. Where the file has changed
  /// meanwhile, or there is none, the editor asks first.
  void save_with(const std::vector<std::pair<QString, QString>>& values);
  /// As edit_with, with more tables at its end.
  void edit_with_tables(const QString& tables);
  /// Lets every editor with an unsaved text ask what to do with it; false: there is none.
  bool ask_about_changes() const;
  void edit_experiment();  ///< the one that is shown, as in its file

 private:
  ExperimentEditor* open_editor(const QString& text, const QString& file, const QString& in_file = {});
  ExperimentEditor* open_editor_of_shown();
  ExperimentEditor* open_editor_with(const std::vector<std::pair<QString, QString>>& values);
  void edit_present();
  QString as_done() const;

  const Runs& runs_;
  FileController& files_;
  const Messages& messages_;
};

}  // namespace skein::ui
