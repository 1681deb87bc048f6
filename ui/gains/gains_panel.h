#pragma once

#include <QComboBox>
#include <QLabel>
#include <QPushButton>
#include <QTabWidget>
#include <QToolButton>
#include <QUndoStack>
#include <QWidget>
#include <array>
#include <functional>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "ui/base/number_field.h"
#include "ui/gains/gain_presets.h"
#include "ui/gains/gain_slider.h"
#include "ui/gains/margin_bars.h"
#include "ui/gains/pair_table.h"
#include "ui/gains/parameter_panel.h"
#include "ui/gains/schedule_editor.h"

namespace skein::ui {

/// The three coupling gains, their schedule, and the margins for tracking; of another law, the parameters that it
/// declares. Every change can be undone.
class GainsPanel final : public QWidget {
  Q_OBJECT

 public:
  using GainValue = std::function<double(core::GainName)>;

  explicit GainsPanel(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment, const GainValue& limit);
  void show_record(const app::TickRecord& record);
  void set_limits(const GainValue& over_all, const GainValue& now);
  /// A text on how to make room for a value of a gain beyond its limit.
  using Remedy = std::function<QString(core::GainName, double wanted)>;
  void set_remedy(const Remedy& remedy);
  /// The target of each gain: the sliders return to it.
  void follow_targets(const GainValue& target);
  /// The delay margin from camera to wheels, in words, with the measured delay; `short_`: it is too small.
  void show_delay_margin(const QString& text, bool short_ = false);
  /// How to read the pairs: now and whenever one of them changes.
  void set_pairs(PairModel::Ask ask) { ask_ = std::move(ask); }
  void refresh_pairs();
  QAbstractItemView* pair_cells() const { return pairs_->cells(); }
  /// What the law declares, with the values in force.
  void follow_parameters(const std::vector<app::LawParameter>& all) { parameters_->show_parameters(all); }
  /// Why there is no preview while a knob is held, for the tips; empty: there is one.
  void set_no_preview(const QString& why);
  /// A single robot has no couplings, but its law may have parameters.
  static bool has_anything_to_set(const app::Experiment& experiment);
  /// The first slider that has an effect, to give it the focus; null: there is none.
  QWidget* first_control() const;
  /// Toggles the coupling of two robots.
  void switch_pair(int i, int j);
  /// Disables changes, with the reason; the values remain readable; empty: enables them.
  void set_fixed(const QString& why);
  /// Before the start the experiment itself can be changed here: its schedule and the form of its couplings.
  void set_before_start(bool before);
  QUndoStack& undo_stack() { return undo_; }
  /// The duration of a change of a gain during a run; 0: as fast as allowed. [s]
  double ramp() const { return ramp_->value(); }

 signals:
  void wanted(skein::core::GainName gain, double value);
  void refused(const QString& why);
  /// A gain's knob is being moved, and has been released; see GainSlider.
  void held(skein::core::GainName gain, double value);
  void let_go();
  void parameter_held(const QString& name, double value);
  void pair_wanted(skein::core::GainName gain, int i, int j, double value);
  void couple_wanted(int i, int j, bool on);
  void parameter_wanted(const QString& name, double value);
  /// The experiment is to be opened again with this "key=value" of its file.
  void experiment_wanted(const QString& set);

 private:
  GainSlider* slider(core::GainName gain) const { return sliders_[static_cast<std::size_t>(gain)]; }
  void change(core::GainName gain, double value);
  void change_pair(core::GainName gain, int i, int j, double value);
  void couple_pair(int i, int j, bool on);
  void change_parameter(const QString& name, double from, double to);
  void use(const GainPreset& preset);
  void fill_presets();
  void keep_as_preset();

  app::Experiment experiment_;
  std::array<GainSlider*, 3> sliders_{};
  std::array<double, 3> targets_{};  // the session's targets
  QUndoStack undo_;
  QToolButton *undo_button_, *redo_button_, *presets_;
  QPushButton* reset_;
  QComboBox* coupling_;
  NumberField* ramp_;
  std::vector<QWidget*> controls_;  // those that change something
  std::vector<QWidget*> of_gains_;  // those without a use if the gains have no effect
  ParameterPanel* parameters_;
  QTabWidget* tabs_;
  MarginBars* margins_;
  QLabel* delay_;
  PairTable* pairs_;
  PairModel::Ask ask_;
  ScheduleEditor* schedule_;
};

}  // namespace skein::ui
