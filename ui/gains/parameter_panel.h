#pragma once

#include <QElapsedTimer>
#include <QLabel>
#include <QTimer>
#include <QWidget>
#include <memory>
#include <vector>

#include "app/experiment/controller_spec.h"
#include "ui/base/eliding_label.h"
#include "ui/base/number_field.h"
#include "ui/gains/gain_slider.h"

class QGridLayout;

namespace skein::ui {

/// The parameters that the law of the experiment declares: for each a number, and a slider over the allowed range. The
/// file's value is near the middle of the slider if possible. A parameter without a range has no slider.
class ParameterPanel final : public QWidget {
  Q_OBJECT

 public:
  explicit ParameterPanel(QWidget* parent = nullptr);
  /// The declared parameters, with the values in force; leaves alone what the operator is about to request.
  void show_parameters(const std::vector<app::LawParameter>& all);
  /// Removes them, for a new experiment. `none`: the text while there are none.
  void clear(const QString& none);
  /// Why there is no preview while a knob is held, for the tips; empty: there is one.
  void set_no_preview(const QString& why);
  /// At once, for undo.
  void set(const QString& name, double value);
  /// The first control, to give it the focus; null: there is none.
  QWidget* first_control() const;

 signals:
  void wanted(const QString& name, double from, double to);
  void refused(const QString& why);
  /// A parameter's knob is being moved, and has been released; as a GainSlider's.
  void held(const QString& name, double value);
  void let_go();

 private:
  struct Row {
    app::LawParameter of;   // its value: in force, or requested
    double exponent = 1.0;  // of the slider's scale
    std::unique_ptr<QLabel> label;
    std::unique_ptr<ElidingLabel> range;  // the field must stay whole in a narrow column: the tip says it, too
    std::unique_ptr<NumberField> field;
    std::unique_ptr<LimitSlider> slider;  // null: no range
    std::unique_ptr<QTimer> rest;         // a drag along the slider is one request
    std::unique_ptr<QTimer> last_key;     // that moved the knob
    double wish = 0.0;
    QElapsedTimer asked{};  // since the last request: when it has expired, the session has had time to execute it
  };
  void add_row(const app::LawParameter& of);
  void add_slider(Row& row, int line);
  void dress(const Row& row) const;
  void choose(Row& row, double value);
  void show_value(Row& row, double value);

  QGridLayout* layout_;
  QLabel* none_;
  std::vector<std::unique_ptr<Row>> rows_;
  QString no_preview_;
};

}  // namespace skein::ui
