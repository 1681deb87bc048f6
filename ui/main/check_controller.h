#pragma once

#include <optional>

#include "app/session/readiness.h"
#include "ui/base/aside.h"
#include "ui/main/messages.h"

namespace skein::ui {

class CheckList;
class GainsPanel;

/// The checks before a start, and the delay margin of the loops.
class CheckController final : public QObject {
  Q_OBJECT

 public:
  CheckController(Runs& runs, const Messages& messages, CheckList* list, GainsPanel* gains, QObject* parent = nullptr);

  void begin();              ///< for the experiment that the live run has now
  void set_wanted(bool on);  ///< the operator requests the list, whatever its results
  void refresh();            ///< five times a second
  Notice banner() const;     ///< before a start: whether it is possible, or why not
  QString why_not() const;   ///< the reason alone; empty: a start is possible
  bool all_hold() const { return first_amiss() == nullptr; }
  void start(bool overrule);                    ///< if all checks hold, or the operator overrides the soft ones
  void set_testing(bool on) { testing_ = on; }  ///< a robot turns its wheels: no start meanwhile

 private:
  const app::Check* first_amiss() const;
  void show_list();
  /// Waits for the certificate no longer than `patience`.
  const std::vector<app::Check>& judge(std::chrono::milliseconds patience = {});
  void show_delay();

  Runs& runs_;
  LiveRun& live_;
  const Messages& messages_;
  CheckList* list_;
  GainsPanel* gains_;
  Aside<app::Certificate> certifying_;
  std::optional<app::Certificate> certificate_;
  std::vector<app::Check> checks_;  // as last judged
  bool wanted_ = false, testing_ = false;
};

}  // namespace skein::ui
