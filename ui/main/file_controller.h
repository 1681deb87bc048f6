#pragma once

#include <QMenu>
#include <QMimeData>

#include "ui/main/messages.h"

namespace skein::ui {

/// Experiments and recordings as files: opened, dropped onto the window, remembered.
class FileController final : public QObject {
  Q_OBJECT

 public:
  FileController(LiveRun& live, const Messages& messages, QObject* parent = nullptr);
  void build_menu(QMenu* file);

  /// Reads an experiment file; one with errors is to be mended in the editor; of a recorded run (.csv): says that it is
  /// wanted.
  void open(const QString& file);
  void open_recording(const QString& file);
  /// The open experiment, without its hardware.
  void rehearse();
  /// The one file that is dragged; empty: none, or more than one.
  static QString dragged(const QMimeData* data);

  /// Where the open experiment comes from, for the editor and the list of recent files; empty: nobody knows.
  void set_experiment_file(const QString& file);
  void remember(const QString& file);

 signals:
  void experiment_wanted(const skein::app::Experiment& experiment);
  void recording_wanted(const QString& file);
  void broken(const QString& text, const QString& file);  ///< an experiment that cannot be run: to be mended

 private:
  void ask();
  bool cannot_open() const;       // and says why: real robots drive, or a session is being opened or closed
  bool real_robots_move() const;  // and says that nothing is opened meanwhile

  LiveRun& live_;
  const Messages& messages_;
};

}  // namespace skein::ui
