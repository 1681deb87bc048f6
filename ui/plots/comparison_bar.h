#pragma once

#include <QComboBox>
#include <QToolButton>
#include <QWidget>
#include <vector>

class QVBoxLayout;

namespace skein::ui {

/// The runs that this one is compared with: a switch for each, which is also its legend, and the choice of their
/// alignment. Hidden while there are none.
class ComparisonBar final : public QWidget {
  Q_OBJECT

 public:
  explicit ComparisonBar(QWidget* parent = nullptr);
  /// One run: its name, and whether it is drawn.
  struct Run {
    QString name;
    bool shown = true;
  };
  void show_runs(const std::vector<Run>& runs);
  /// The times at which this run was kicked [s]: the choices for the alignment.
  void show_kicks(const std::vector<double>& kicks);
  int aligned_at() const { return align_->currentIndex(); }  ///< 0: the start; k: kick k

 signals:
  void switched(int run, bool on);  ///< from 0
  void align_wanted(int kick);      ///< 0: at the start

 protected:
  void changeEvent(QEvent*) override;

 private:
  void dress();

  QVBoxLayout* switches_;
  std::vector<QToolButton*> buttons_;
  QComboBox* align_;
};

}  // namespace skein::ui
