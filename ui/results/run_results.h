#pragma once

#include <QString>
#include <memory>
#include <optional>
#include <vector>

#include "app/record/statistics.h"

namespace skein::ui {

/// The results of a run, collected row by row: for every kick the settling times of formation and tracking, the closest
/// approach and the largest error; and the file's expectations, each with a tick or a cross.
class RunResults {
 public:
  explicit RunResults(const app::Experiment& experiment);
  /// Every record of a session in order; those before the start are skipped.
  void add_record(const app::TickRecord& record);

  struct Kick {
    double t = 0.0;  ///< [s]
    QString what;    ///< in sentences
    QString words;   ///< the same in the CSV's words
    /// Until the error stayed within 1 cm; none: it has not yet. [s]
    std::optional<double> formation, tracking;
    double closest = app::none;  ///< two robots, until the next kick [m]
    double largest = app::none;  ///< distance from a reference, until the next kick [m]
  };
  struct Expectation {
    QString what;   ///< "closest pair at least 0.07 m"
    QString found;  ///< why it fails; empty where it holds
    bool holds() const { return found.isEmpty(); }
  };
  std::vector<Kick> kicks() const;
  std::vector<Expectation> expectations() const;
  bool is_over() const { return over_; }
  bool empty() const { return !seen_; }
  /// Smallest distance of two robots, largest distance from a reference; of the whole run. [m]
  double closest() const;
  double largest() const;

 private:
  /// The closest approach and the largest error from one kick to the next, in memory that does not grow with the run.
  struct Extremes {
    double since = 0.0;  // [s]
    double closest = app::none, largest = app::none;
    void add(double distance, double error);
  };
  const app::Experiment experiment_;
  app::Statistics statistics_;
  std::vector<Extremes> extremes_ = std::vector<Extremes>(1);  // before the first kick, then one a kick
  bool seen_ = false, started_ = false, over_ = false;
};

/// For each kick the one of another run that it is compared with: that at the same time; kicks between two of those are
/// paired in their order. None: the other run has none.
std::vector<std::optional<std::size_t>> counterparts(const std::vector<RunResults::Kick>& kicks,
                                                     const std::vector<RunResults::Kick>& others);

/// A run that is shown beside this one, and its results.
struct RunBeside {
  QString letter, name;
  std::shared_ptr<const RunResults> results;
};
/// How much later than the corresponding kick of another run this one settled.
struct KickBeside {
  bool has_counterpart = false;
  std::optional<double> formation, tracking;  ///< negative: earlier; none: one of the two has not settled [s]
};
/// By run, then by kick.
std::vector<std::vector<KickBeside>> compare(const std::vector<RunResults::Kick>& kicks,
                                             const std::vector<RunBeside>& others);
/// "formation 1.50 s earlier, tracking 0.60 s later"; a dash: the other run has no such kick.
QString beside_text(const KickBeside& kick);

/// What settles first after a kick, and how much earlier: "formation 1.2 s earlier".
QString order_of(const RunResults::Kick& kick);
/// A duration for people: "1.52 s", "not yet".
QString settling_text(const std::optional<double>& seconds);
/// "7.2 cm"; a dash where there is no number. [m]
QString centimetres(double metres);

/// Every kick a line, then closest approach, largest error and what was expected, which a run that is not over has not
/// been judged by; for mail and notes. With the differences to `others`.
QString as_text(const QString& name, const RunResults& results, const std::vector<RunBeside>& others = {});
/// The kicks as a LaTeX tabular (booktabs); two columns more for each of the others.
QString as_latex(const RunResults& results, const std::vector<RunBeside>& others = {});

}  // namespace skein::ui
