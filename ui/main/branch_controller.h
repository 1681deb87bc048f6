#pragma once

#include <QMenu>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/experiment.h"
#include "ui/base/aside.h"
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
  /// Whether a past is being prepared. Of many robots with long timetables that takes a second; the run that is shown
  /// goes on meanwhile.
  bool is_busy() const { return preparing_.is_busy(); }
  void drop();            ///< what is being prepared is no longer wanted
  void refresh();         ///< thirty times a second
  QString doing() const;  ///< for the operator; empty: nothing is being prepared

 signals:
  /// Requests to run this from its start. It pauses by itself at the present moment of the run that is shown now.
  void experiment_wanted(const skein::app::Experiment& experiment);

 private:
  /// A simulation that was repeated, and the moment at which it pauses.
  struct Past {
    app::Experiment experiment;
    double t;  // [s]
  };
  using Prepared = tl::expected<Past, std::string>;
  struct Wanted {
    Prepared to;
    std::optional<Prepared> from;  // of an action that is taken back: what it was
  };
  static Prepared past(app::Experiment until_here, const RunHistory::Rows& kept, std::size_t count);
  std::size_t rows_so_far() const;
  bool can_be_repeated(std::size_t count) const;  // and if it cannot, says why
  void prepare(std::size_t to, std::optional<std::size_t> from);
  void repeat(const Past& past);
  void show_record(const app::TickRecord& record);

  Runs& runs_;
  const Messages& messages_;
  double speed_ = 1.0;              // of the previous run, restored after the pause
  std::optional<double> pause_at_;  // while the past is repeated [s]
  std::optional<double> began_at_;  // the latest branch [s]
  std::vector<Past> taken_back_;    // the latest last
  std::string branch_;              // the text of the run that take_back() or do_again() asked for
  Aside<Wanted> preparing_;
  double preparing_to_ = 0.0;  // [s]
};

}  // namespace skein::ui
