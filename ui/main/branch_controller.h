#pragma once

#include <QMenu>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/experiment.h"
#include "ui/main/messages.h"

namespace skein::ui {

/// "Go on from here": repeats a simulation up to the present moment, with all of the operator's actions, and pauses
/// there. From then on the operator may act differently: other gains, other moves. If the ticks of the run had exactly
/// their times, its past is repeated to nanometres, that of a run in real time to a fraction of a millimetre.
/// "Take back" does the same up to the moment before the last action, "do again" repeats the run with that action.
class BranchController final : public QObject {
  Q_OBJECT

 public:
  BranchController(Runs& runs, const Messages& messages, QObject* parent = nullptr);
  void build_menu(QMenu* run);
  void go_on_from_here();
  /// What was done to the simulation last, as one gesture: a drag, a kick, an obstacle, a gain, a coupling, a hold.
  void take_back();
  /// What was taken back last, if nothing else has been done since.
  void do_again();
  /// A branch that is run again does not pause where it began.
  void forget_pause(app::Experiment& experiment) const;

 signals:
  /// Requests to run this from its start. It pauses by itself at the present moment of the run that is shown now.
  void experiment_wanted(const skein::app::Experiment& experiment);

 private:
  /// A simulation that was repeated, and the moment at which it pauses.
  struct Past {
    app::Experiment experiment;
    double t;  // [s]
  };
  std::size_t rows_so_far() const;
  std::optional<Past> past(std::size_t count);
  void repeat(const Past& past);
  void show_record(const app::TickRecord& record);

  Runs& runs_;
  const Messages& messages_;
  double speed_ = 1.0;              // of the previous run, restored after the pause
  std::optional<double> pause_at_;  // while the past is repeated [s]
  std::optional<double> began_at_;  // the latest branch [s]
  std::vector<Past> taken_back_;    // the latest last
  std::string branch_;              // the text of the run that take_back() or do_again() asked for
};

}  // namespace skein::ui
