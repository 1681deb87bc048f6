#pragma once

#include <QMenu>
#include <future>
#include <optional>

#include "ui/main/messages.h"

namespace skein::ui {

/// Runs as files: recorded as they go, or saved afterwards.
class RecordingController final : public QObject {
  Q_OBJECT

 public:
  RecordingController(LiveRun& live, const Messages& messages, QObject* parent = nullptr);

  bool records() const { return records_; }  ///< this run and those that follow
  void record(bool on);
  bool keeps() const { return keeps_; }  ///< every run from the next on, in its own folder, unless switched off
  void keep(bool on);                    ///< remembered
  /// Records this run to the file live, including its beginning, and later runs to files beside it.
  void record_to(const QString& file);
  /// Whether the folder of a kept run gets the film of its camera, from the next session on.
  bool keeps_films() const { return keeps_films_; }
  void keep_films(bool on);  ///< remembered
  /// Where the film of a run of this experiment goes.
  FilmOfRun film(const app::Experiment& experiment) const;
  static QString directory();
  /// Folders with runs, for the side of a dialog that opens one.
  static QStringList places();
  /// A free name for a file or a folder of this experiment; empty: there is no place for it.
  static QString path(const app::Experiment& experiment, const QString& ending);

  void ask_save();
  void save(const QString& file);  ///< `saved` follows
  bool is_saving() const { return saving_.has_value(); }
  void refresh();  ///< thirty times a second

 signals:
  void saved(const QString& file, const QString& problem);  ///< no problem: empty
  void keeping(const QString& folder);                      ///< this run

 private:
  void record_if_wanted();
  void keep_if_wanted();

  LiveRun& live_;
  const Messages& messages_;
  struct Saving {
    QString file;
    std::future<QString> problem;
  };
  std::optional<Saving> saving_;
  bool records_ = false;
  bool keeps_, keeps_films_;
};

}  // namespace skein::ui
