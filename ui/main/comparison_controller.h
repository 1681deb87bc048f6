#pragma once

#include <QElapsedTimer>
#include <QMenu>
#include <QStringList>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "ui/arena/arena_scene.h"
#include "ui/main/messages.h"
#include "ui/main/recording_loader.h"
#include "ui/results/run_results.h"

namespace skein::ui {

class ArenaView;
class PlotsPanel;

/// Draws other runs, any number of them, pale behind the one that is shown: each with its own letter, line and switch,
/// aligned at the same time of the experiment or at a kick.
class ComparisonController final : public QObject {
  Q_OBJECT

 public:
  /// A run that is compared.
  struct Run {
    ReplayRun::Recording recording;
    QString name;
    std::shared_ptr<const RunResults> results;
    bool shown = true;
    double shift = 0.0;  ///< by how much later it is drawn [s]
  };

  ComparisonController(const Runs& runs, const Messages& messages, ArenaView* arena, PlotsPanel* plots,
                       QObject* parent = nullptr);
  void build_menu(QMenu* file);
  /// The kicks of the run that is shown; called about once a second.
  void set_kicks(std::function<std::vector<RunResults::Kick>()> kicks) { kicks_ = std::move(kicks); }
  void load(const QString& file);
  void compare_with_now();  ///< keeps the present run so far for comparison with later ones
  /// Another run is shown: the others stay if they have as many robots.
  void show_experiment();
  void refresh();  ///< thirty times a second
  const std::vector<Run>& runs() const { return others_; }

 signals:
  void compared();  ///< with other runs than before

 private:
  void ask();
  void add(ReplayRun::Recording recording);
  void end();
  void show();
  void align(int kick);
  std::vector<OtherRun> others_at(double t) const;

  const Runs& runs_;
  const Messages& messages_;
  ArenaView* arena_;
  PlotsPanel* plots_;
  std::function<std::vector<RunResults::Kick>()> kicks_;
  RecordingLoader loader_;
  QStringList waiting_;  // files
  std::vector<Run> others_;
  int aligned_at_ = 0;  // 0: the start; k: kick k
  QElapsedTimer looked_;
};

}  // namespace skein::ui
