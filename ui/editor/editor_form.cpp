#include "ui/editor/editor_form.h"

#include <QComboBox>
#include <QFormLayout>
#include <QLabel>
#include <QLineEdit>

#include "app/experiment/experiment_file.h"
#include "app/experiment/experiment_keys.h"

namespace skein::ui {
namespace {

QString bare(const std::optional<std::string>& literal) {
  QString text = QString::fromStdString(literal.value_or(std::string()));
  const bool quoted = text.size() >= 2 && (text.front() == QLatin1Char('"') || text.front() == QLatin1Char('\''));
  return quoted ? text.mid(1, text.size() - 2) : text;
}

/// The words that a key can have; empty: it is a number or a free text.
QStringList choices_of(const app::ExperimentKey* key) {
  QStringList choices;
  if (!key) return choices;
  if (const auto* const choice = std::get_if<app::ChoiceKey>(&key->value))
    for (const std::string_view word : choice->words())
      choices << QString::fromLatin1(word.data(), static_cast<qsizetype>(word.size()));
  if (std::holds_alternative<app::FlagKey>(key->value)) choices << QStringLiteral("true") << QStringLiteral("false");
  return choices;
}

bool is_text(const app::ExperimentKey* key) {
  return key &&
         (std::holds_alternative<app::TextKey>(key->value) || std::holds_alternative<app::ChoiceKey>(key->value));
}

}  // namespace

EditorForm::EditorForm(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("editor_form"));
  auto* layout = new QFormLayout(this);
  layout->setContentsMargins(10, 8, 10, 8);
  layout->setVerticalSpacing(4);
  const auto heading = [&](const QString& text) {
    auto* label = new QLabel(QStringLiteral("<b>%1</b>").arg(text), this);
    layout->addRow(label);
  };
  const app::Experiment defaults;
  const auto gains = app::paper_experiment().controller.gains;  // without robots there are no pairs
  const auto number = [](double value) { return QString::number(value); };
  add("name", tr("Name"));
  add("duration", tr("Duration"));
  add("rate", tr("Ticks a second"));
  add("seed", tr("Seed"));
  heading(tr("Reference"));
  add("reference.speed", tr("Speed"));
  add("reference.spacing", tr("Spacing"), number(defaults.reference.spacing), QStringLiteral("m"));
  heading(tr("Controller"));
  add("controller.saturation", tr("Saturation"));
  add("controller.coupling", tr("Coupling"));
  add("controller.v_max", tr("v limit"));
  add("controller.omega_max", tr("ω limit"));
  add("controller.gains.k_xx", tr("k_xx"), number(gains.k_xx.largest()), QStringLiteral("m/s"));
  add("controller.gains.k_tt", tr("k_θθ"), number(gains.k_tt.largest()), QStringLiteral("rad/s"));
  add("controller.gains.k_yy", tr("k_yy"), number(gains.k_yy.largest()), QStringLiteral("rad/s"));
  heading(tr("Safety"));
  add("avoidance.enabled", tr("Avoidance"));
  add("shield.enabled", tr("Shield"));
  add("shield.distance", tr("Shield distance"));
  heading(tr("Simulation"));
  add("simulation.pose_noise", tr("Pose noise"));
  add("simulation.heading_noise", tr("Heading noise"));
  add("simulation.latency", tr("Latency"));
}

void EditorForm::add(const char* name, const QString& label, const QString& usual, const QString& unit) {
  const app::ExperimentKey* const key = app::find_experiment_key(name);
  const QString measured = key ? QString::fromStdString(app::unit_of(*key)) : unit;
  Field field{QString::fromLatin1(name), is_text(key),
              key ? QString::fromStdString(app::shown_value(*key, app::Experiment{})) : usual, nullptr, nullptr};
  const std::size_t index = fields_.size();
  const auto wanted = [this, index](const QString& text) {
    const Field& f = fields_[index];
    if (text.isEmpty()) return;
    emit set_wanted(f.name, f.is_text ? QStringLiteral("\"%1\"").arg(text) : text);
  };
  QWidget* made = nullptr;
  if (const QStringList choices = choices_of(key); choices.isEmpty()) {
    made = field.line = new QLineEdit(this);
    connect(field.line, &QLineEdit::editingFinished, this, [line = field.line, wanted] {
      if (line->isModified()) wanted(line->text());
      line->setModified(false);
    });
  } else {
    made = field.box = new QComboBox(this);
    field.box->addItems(choices);
    connect(field.box, &QComboBox::textActivated, this, wanted);
  }
  const QString text = measured.isEmpty() ? label : QStringLiteral("%1 [%2]").arg(label, measured);
  made->setObjectName(QStringLiteral("form_") + field.name);
  made->setAccessibleName(text);
  made->setToolTip(key ? QStringLiteral("%1: %2").arg(field.name, QString::fromLatin1(key->help)) : field.name);
  static_cast<QFormLayout*>(layout())->addRow(text, made);
  fields_.push_back(std::move(field));
}

std::vector<std::string> EditorForm::keys() const {
  std::vector<std::string> keys;
  keys.reserve(fields_.size());
  for (const Field& field : fields_) keys.push_back(field.name.toStdString());
  return keys;
}

void EditorForm::show_values(const std::vector<std::optional<std::string>>& values) {
  for (std::size_t k = 0; k < fields_.size(); ++k) {
    const Field& field = fields_[k];
    const QString value = bare(values[k]);
    if (field.line && !(field.line->hasFocus() && field.line->isModified())) {
      field.line->setPlaceholderText(field.usual);
      if (field.line->text() != value) field.line->setText(value);
      if (!field.line->hasFocus()) field.line->setCursorPosition(0);
    } else if (field.box) {
      field.box->setCurrentText(value.isEmpty() ? field.usual : value);
    }
  }
}

}  // namespace skein::ui
