#include "ui/gains/gain_presets.h"

#include <QSettings>
#include <QStringList>

#include "ui/base/settings.h"
#include "ui/base/tr.h"

namespace skein::ui {
namespace {

const QString presets_group = QStringLiteral("gain_presets");

std::array<double, 3> largest(const core::CouplingGains& gains) {
  return {gains.k_xx.largest(), gains.k_tt.largest(), gains.k_yy.largest()};
}

}  // namespace

std::vector<GainPreset> gain_presets(const app::Experiment& experiment) {
  const std::array<double, 3> file = largest(experiment.controller.gains);
  const std::array<double, 3> paper = largest(app::Experiment().controller.gains);
  const auto times = [](const std::array<double, 3>& values, double factor) {
    return std::array{factor * values[0], factor * values[1], factor * values[2]};
  };
  std::vector<GainPreset> presets{{tr("The file's"), file},
                                  {tr("The paper's (36)"), paper},
                                  {tr("Uncoupled"), {}},
                                  {tr("Weak: half the paper's"), times(paper, 0.5)},
                                  {tr("Strong: one and a half times the paper's"), times(paper, 1.5)}};
  QSettings stored = settings();
  stored.beginGroup(presets_group);
  for (const QString& name : stored.childKeys()) {
    const QStringList numbers = stored.value(name).toStringList();
    if (numbers.size() != 3) continue;  // not from here
    presets.push_back({name, {numbers[0].toDouble(), numbers[1].toDouble(), numbers[2].toDouble()}, true});
  }
  return presets;
}

void keep_gain_preset(const GainPreset& preset) {
  QStringList numbers;
  for (const double value : preset.values) numbers << QString::number(value, 'g', 17);
  QString name = preset.name.trimmed();
  name.replace(QLatin1Char('/'), QLatin1Char('-'));  // a slash would be a group of the settings
  QSettings stored = settings();
  stored.setValue(presets_group + QLatin1Char('/') + name, numbers);
}

void forget_gain_preset(const QString& name) {
  QSettings stored = settings();
  stored.remove(presets_group + QLatin1Char('/') + name);
}

}  // namespace skein::ui
