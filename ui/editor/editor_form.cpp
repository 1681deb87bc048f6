#include "ui/editor/editor_form.h"

#include <QComboBox>
#include <QFormLayout>
#include <QLabel>
#include <QLineEdit>
#include <optional>

#include "app/experiment/toml_edit.h"

namespace skein::ui {
namespace {

using app::Experiment;

QString number(double value) {
  return QString::number(value);
}

QString bare(const std::optional<std::string>& literal) {
  QString text = QString::fromStdString(literal.value_or(std::string()));
  const bool quoted = text.size() >= 2 && (text.front() == QLatin1Char('"') || text.front() == QLatin1Char('\''));
  return quoted ? text.mid(1, text.size() - 2) : text;
}

}  // namespace

EditorForm::EditorForm(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("editor_form"));
  auto* layout = new QFormLayout(this);
  layout->setContentsMargins(10, 8, 10, 8);
  layout->setVerticalSpacing(4);
  const auto add = [&](const char* key, const QString& label, bool is_text, const QStringList& choices,
                       std::function<QString(const Experiment&)> usual) {
    Field field{QString::fromLatin1(key), is_text, nullptr, nullptr, std::move(usual)};
    const std::size_t index = fields_.size();
    const auto wanted = [this, index](const QString& text) {
      const Field& f = fields_[index];
      if (text.isEmpty()) return;
      emit set_wanted(f.key, f.is_text ? QStringLiteral("\"%1\"").arg(text) : text);
    };
    QWidget* made = nullptr;
    if (choices.isEmpty()) {
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
    made->setObjectName(QStringLiteral("form_") + field.key);
    made->setAccessibleName(label);
    made->setToolTip(field.key);
    layout->addRow(label, made);
    fields_.push_back(std::move(field));
  };
  const auto heading = [&](const QString& text) {
    auto* label = new QLabel(QStringLiteral("<b>%1</b>").arg(text), this);
    layout->addRow(label);
  };
  const QStringList yes_no{QStringLiteral("true"), QStringLiteral("false")};
  const auto yes = [](bool on) { return on ? QStringLiteral("true") : QStringLiteral("false"); };
  add("name", tr("Name"), true, {}, [](const Experiment& e) { return QString::fromStdString(e.name); });
  add("duration", tr("Duration [s]"), false, {}, [](const Experiment& e) { return number(e.duration); });
  add("rate", tr("Ticks a second"), false, {}, [](const Experiment& e) { return number(e.rate); });
  add("seed", tr("Seed"), false, {}, [](const Experiment& e) { return QString::number(e.seed); });
  heading(tr("Reference"));
  add("reference.speed", tr("Speed [m/s]"), false, {}, [](const Experiment& e) { return number(e.reference.speed); });
  add("reference.spacing", tr("Spacing [m]"), false, {},
      [](const Experiment& e) { return number(e.reference.spacing); });
  heading(tr("Controller"));
  add("controller.saturation", tr("Saturation"), true, {QStringLiteral("tanh"), QStringLiteral("algebraic")},
      [](const Experiment& e) {
        return e.controller.saturation == core::Saturation::tanh ? QStringLiteral("tanh") : QStringLiteral("algebraic");
      });
  add("controller.coupling", tr("Coupling"), true, {QStringLiteral("paper"), QStringLiteral("bounded")},
      [](const Experiment& e) {
        return e.controller.coupling == core::Coupling::paper ? QStringLiteral("paper") : QStringLiteral("bounded");
      });
  add("controller.v_max", tr("v limit [m/s]"), false, {},
      [](const Experiment& e) { return number(e.controller.v_max); });
  add("controller.omega_max", tr("ω limit [rad/s]"), false, {},
      [](const Experiment& e) { return number(e.controller.omega_max); });
  add("controller.gains.k_xx", tr("k_xx [m/s]"), false, {},
      [](const Experiment& e) { return number(e.controller.gains.k_xx.largest()); });
  add("controller.gains.k_tt", tr("k_θθ [rad/s]"), false, {},
      [](const Experiment& e) { return number(e.controller.gains.k_tt.largest()); });
  add("controller.gains.k_yy", tr("k_yy [rad/s]"), false, {},
      [](const Experiment& e) { return number(e.controller.gains.k_yy.largest()); });
  heading(tr("Safety"));
  add("avoidance.enabled", tr("Avoidance"), false, yes_no,
      [yes](const Experiment& e) { return yes(e.avoidance.enabled); });
  add("shield.enabled", tr("Shield"), false, yes_no, [yes](const Experiment& e) { return yes(e.shield.enabled); });
  add("shield.distance", tr("Shield distance [m]"), false, {},
      [](const Experiment& e) { return number(e.shield.distance); });
  heading(tr("Simulation"));
  add("simulation.pose_noise", tr("Pose noise [m]"), false, {},
      [](const Experiment& e) { return number(e.simulation.pose_noise); });
  add("simulation.heading_noise", tr("Heading noise [rad]"), false, {},
      [](const Experiment& e) { return number(e.simulation.heading_noise); });
  add("simulation.latency", tr("Latency [s]"), false, {},
      [](const Experiment& e) { return number(e.simulation.latency); });
}

void EditorForm::show_text(const QString& text) {
  static const Experiment defaults;
  const std::string toml = text.toStdString();
  for (const Field& field : fields_) {
    const QString value = bare(app::toml_value(toml, field.key.toStdString()));
    if (field.line && !(field.line->hasFocus() && field.line->isModified())) {
      field.line->setPlaceholderText(field.usual(defaults));
      if (field.line->text() != value) field.line->setText(value);
      if (!field.line->hasFocus()) field.line->setCursorPosition(0);
    } else if (field.box) {
      field.box->setCurrentText(value.isEmpty() ? field.usual(defaults) : value);
    }
  }
}

}  // namespace skein::ui
