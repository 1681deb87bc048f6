#pragma once

#include <QStringList>
#include <future>

#include "ui/main/messages.h"
#include "ui/results/run_results.h"

namespace skein::ui {

class ResultPanel;

/// Saves the results with everything that they come from, in one folder: as text and LaTeX, with the run's CSV, its
/// figures, and a page for a browser. For a replayed kept run that is its own folder.
class ResultController final : public QObject {
  Q_OBJECT

 public:
  ResultController(const Runs& runs, const Messages& messages, ResultPanel* results, QObject* parent = nullptr);
  void save();     ///< `saved` follows
  void refresh();  ///< thirty times a second

 signals:
  void saved(const QString& folder, const QStringList& problems);  ///< sentences; none: everything is there

 private:
  struct Saved {
    QString folder;
    QStringList problems;
  };
  static Saved write(const QString& folder, bool kept, const RunHistory::Rows& rows, const app::Experiment& experiment,
                     const std::vector<app::TagCrop>& crops, const std::vector<RunBeside>& others);

  const Runs& runs_;
  const Messages& messages_;
  const ResultPanel* results_;
  std::future<Saved> saving_;
};

}  // namespace skein::ui
