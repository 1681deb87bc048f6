#pragma once

#include <QMenu>

#include "ui/main/file_controller.h"
#include "ui/main/recording_loader.h"

namespace skein::ui {

/// Opens recorded runs: reads them on a thread of its own, then shows them.
class ReplayController final : public QObject {
  Q_OBJECT

 public:
  ReplayController(Runs& runs, FileController& files, const Messages& messages, QObject* parent = nullptr);
  void build_menu(QMenu* file);
  void load(const QString& file);
  void refresh();  ///< thirty times a second
  /// The file that is being read; empty: none.
  QString reading() const { return loader_.is_busy() ? file_ : QString(); }

 private:
  Runs& runs_;
  FileController& files_;
  const Messages& messages_;
  RecordingLoader loader_;
  QString file_;
};

}  // namespace skein::ui
