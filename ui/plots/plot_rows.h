#pragma once

#include <QColor>
#include <QString>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// One plot of the panel: what its curves are, and where their values come from.
struct PlotRow {
  enum class Of { robot, pair, couple, stage, group };  ///< what each curve stands for; a pair is of neighbours

  QString name;                      ///< in menus and in a CSV's head: "e_x"
  QString symbol, index = {}, unit;  ///< as the paper writes it
  QString what;                      ///< in a sentence
  Of of = Of::robot;
  double least = 0.0;             ///< the smallest height, so that noise does not fill it
  bool from_zero = false;         ///< otherwise centred on zero
  bool usual = false;             ///< shown unless the operator chose otherwise
  double band = 0.0;              ///< half-width about zero within which the results say "settled"; 0: none
  std::vector<double> limits{};   ///< dashed lines: values that must not, or should not, be exceeded
  std::vector<QString> curves{};  ///< names: "1", "1,2", "law"
  std::size_t first = 0;          ///< its first curve among all of the rows'
  std::function<double(const app::TickRecord&, std::size_t curve)> value;
  /// Its symbol in plain text: "e_θ".
  QString title() const { return index.isEmpty() ? symbol : symbol + QLatin1Char('_') + index; }
};

/// Every plot there is for an experiment.
std::vector<PlotRow> plot_rows(const app::Experiment& experiment);
/// In which a curve is drawn.
QColor colour_of(PlotRow::Of of, std::size_t curve, const Colours& colours);
/// The robots, from 0, of a row's curve, of `robots` in all: one robot twice, two robots, or none for the group or a
/// stage.
std::optional<std::pair<std::size_t, std::size_t>> robots_of(PlotRow::Of of, std::size_t curve, std::size_t robots);
std::size_t curve_count(const std::vector<PlotRow>& rows);
/// Whether a record is part of the run: before it, while robots are moved or drive to their starts, t stands still.
bool is_sample(const app::TickRecord& record);
/// The values of all curves of all rows at one tick; NaN: none.
void sample(const std::vector<PlotRow>& rows, const app::TickRecord& record, std::vector<double>& values);

}  // namespace skein::ui
