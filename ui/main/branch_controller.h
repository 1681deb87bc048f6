#pragma once

#include <QMenu>
#include <optional>

#include "ui/main/messages.h"

namespace skein::ui {

/// "Go on from here": repeats a simulation up to the present moment, everything that was done by hand included, and
/// pauses there. From then on it is the operator's: other gains, another hand. The past of a run whose ticks had
/// exactly their times comes out the same to nanometres, that of one in real time to a fraction of a millimetre.
class BranchController final : public QObject {
  Q_OBJECT

 public:
  BranchController(Runs& runs, const Messages& messages, QObject* parent = nullptr);
  void build_menu(QMenu* run);
  void go_on_from_here();
  /// A branch that is run anew does not pause where it began.
  void forget_pause(app::Experiment& experiment) const;

 signals:
  /// Run this from its start. It pauses by itself at the present moment of the run that is shown now.
  void experiment_wanted(const skein::app::Experiment& experiment);

 private:
  void show_record(const app::TickRecord& record);

  Runs& runs_;
  const Messages& messages_;
  double speed_ = 1.0;              // of the run before, which comes back after the pause
  std::optional<double> pause_at_;  // while the past is repeated [s]
  std::optional<double> began_at_;  // the latest branch [s]
};

}  // namespace skein::ui
