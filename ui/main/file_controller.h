#pragma once

#include <QMenu>
#include <QMimeData>

#include "app/experiment/problem.h"
#include "ui/base/aside.h"
#include "ui/main/messages.h"

namespace skein::ui {

/// Experiments and recordings as files: opened, dropped onto the window, remembered.
class FileController final : public QObject {
  Q_OBJECT

 public:
  FileController(LiveRun& live, const Messages& messages, QObject* parent = nullptr);
  void build_menu(QMenu* file);

  /// Reads an experiment file, instead of one that is still being read; one with errors opens in the editor. For a
  /// recorded run (.csv), emits the request to show it.
  void open(const QString& file);
  void drop();     ///< whatever is being read is no longer wanted
  void refresh();  ///< thirty times a second
  /// The experiment file that is being read; empty: none.
  QString reading() const { return reading_.is_busy() ? file_ : QString(); }
  void open_recording(const QString& file);
  /// The open experiment, without its hardware.
  void rehearse();
  /// The one file that is dragged; empty: none, or more than one.
  static QString dragged(const QMimeData* data);

  /// Where the open experiment comes from, for the editor and the list of recent files; empty: not known.
  /// One that is known already is not read anew: the experiment is that of the file as it was.
  void set_experiment_file(const QString& file);
  void remember(const QString& file);

 signals:
  void superseded();  ///< a recording that is being read is no longer wanted
  void experiment_wanted(const skein::app::Experiment& experiment);
  void recording_wanted(const QString& file);
  void broken(const QString& text, const QString& file);  ///< an experiment with errors, which cannot be run

 private:
  struct Read {
    QString file;
    std::string text;
    std::vector<app::Problem> unreadable;  // why; empty: it has been read
    tl::expected<app::Experiment, std::vector<app::Problem>> experiment;
  };
  static Read read(const QString& file);

  void ask();
  void set_file(const QString& file, const QString& text);
  bool cannot_open() const;       // and reports why: real robots drive, or a session is being opened or closed
  bool real_robots_move() const;  // and reports that nothing is opened meanwhile

  LiveRun& live_;
  const Messages& messages_;
  Aside<Read> reading_;
  QString file_;
};

}  // namespace skein::ui
