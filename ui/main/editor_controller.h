#pragma once

#include <QMenu>

#include "ui/main/file_controller.h"

namespace skein::ui {

/// The experiment as a text: to be edited, or to be written down as it is now.
class EditorController final : public QObject {
  Q_OBJECT

 public:
  EditorController(const Runs& runs, FileController& files, const Messages& messages, QObject* parent = nullptr);
  void build_menu(QMenu* file);
  void edit(const QString& text, const QString& file);
  /// Every editor with an unsaved text asks what to do with it; false: there is none.
  bool ask_about_changes() const;
  void edit_experiment();  ///< the one that is shown, as its file has it

 private:
  void edit_present();
  QString as_done() const;

  const Runs& runs_;
  FileController& files_;
  const Messages& messages_;
};

}  // namespace skein::ui
