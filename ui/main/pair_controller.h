#pragma once

#include "ui/main/messages.h"

namespace skein::ui {

class ArenaView;
class GainsPanel;

/// Gains and couplings of the run that is shown: sliders, the table of pairs, the lines in the arena.
class PairController final : public QObject {
  Q_OBJECT

 public:
  PairController(Runs& runs, const Messages& messages, GainsPanel* gains, ArenaView* arena, QObject* parent = nullptr);
  void refresh();  ///< five times a second, and whenever the present moment is moved

 private:
  void show_couplings();

  Runs& runs_;
  GainsPanel* gains_;
  ArenaView* arena_;
};

}  // namespace skein::ui
