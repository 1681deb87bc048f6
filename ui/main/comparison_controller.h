#pragma once

#include <QMenu>
#include <optional>

#include "ui/arena/arena_scene.h"
#include "ui/main/messages.h"
#include "ui/main/recording_loader.h"

namespace skein::ui {

class ArenaView;
class PlotsPanel;

/// A second run, pale behind the one that is shown.
class ComparisonController final : public QObject {
  Q_OBJECT

 public:
  ComparisonController(const Runs& runs, const Messages& messages, ArenaView* arena, PlotsPanel* plots,
                       QObject* parent = nullptr);
  void build_menu(QMenu* file);
  void load(const QString& file);
  void compare_with_now();  ///< keeps the present run so far for comparison with later ones
  /// Another run is shown: the second one stays if it has as many robots.
  void show_experiment();
  void refresh();  ///< thirty times a second

 signals:
  void compared(skein::ui::ReplayRun::Recording other);  ///< null: with nothing any more

 private:
  void ask();
  void compare(ReplayRun::Recording other);
  std::optional<OtherRun> other_at(double t) const;

  const Runs& runs_;
  const Messages& messages_;
  ArenaView* arena_;
  PlotsPanel* plots_;
  RecordingLoader loader_;
  ReplayRun::Recording other_;
};

}  // namespace skein::ui
