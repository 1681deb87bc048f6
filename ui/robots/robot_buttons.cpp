#include "ui/robots/robot_buttons.h"

#include <QHBoxLayout>
#include <algorithm>

namespace skein::ui {
namespace {

constexpr const char* action_ending = "_action";  // the button itself is named without

void say(QAction* action, const QString& text, const QString& tip, bool enabled) {
  action->setText(text);
  action->setToolTip(tip);
  action->setEnabled(enabled);
}

/// A screen reader says what the action says.
class NamedButton final : public QToolButton {
 public:
  NamedButton(QAction* action, QWidget* parent) : QToolButton(parent) {
    setDefaultAction(action);
    setObjectName(action->objectName().chopped(QLatin1String(action_ending).size()));
    setFocusPolicy(Qt::StrongFocus);
    setAutoRaise(false);
    const auto name = [this, action] {
      setAccessibleName(action->text());
      setVisible(action->isVisible());
    };
    name();
    QObject::connect(action, &QAction::changed, this, name);
  }
};

}  // namespace

RobotButtons::RobotButtons(QWidget* parent)
    : QWidget(parent),
      hold_(make(QStringLiteral("hold_robot"))),
      test_(make(QStringLiteral("test_robot"))),
      connect_(make(QStringLiteral("connect_robot"))) {
  setObjectName(QStringLiteral("robot_buttons"));
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(6, 2, 6, 2);
  for (QAction* action : {hold_, test_, connect_}) layout->addWidget(new NamedButton(action, this));
  layout->addStretch();
  connect(hold_, &QAction::triggered, this, [this] { emit hold(selected_, !state_.held.contains(selected_)); });
  connect(test_, &QAction::triggered, this, [this] { emit test(selected_); });
  connect(connect_, &QAction::triggered, this, &RobotButtons::connect_again);
  dress();
}

QAction* RobotButtons::make(const QString& name) {
  auto* action = new QAction(this);
  action->setObjectName(name + QLatin1String(action_ending));
  addAction(action);
  return action;
}

void RobotButtons::show_experiment(const app::Experiment& experiment) {
  specs_ = experiment.robots;
  state_ = {};
  if (selected_ >= static_cast<int>(specs_.size())) selected_ = -1;
  dress();
}

void RobotButtons::show_state(const State& state) {
  state_ = state;
  dress();
}

void RobotButtons::show_testing(bool testing) {
  testing_ = testing;
  dress();
}

void RobotButtons::select_robot(int robot) {
  selected_ = robot;
  dress();
}

void RobotButtons::dress() {
  const bool over = state_.phase == app::Phase::stopped || state_.phase == app::Phase::finished;
  const bool is_held = state_.held.contains(selected_);
  say(hold_,
      selected_ < 0 ? tr("Hold a robot")
      : is_held     ? tr("Let robot %1 go").arg(selected_ + 1)
                    : tr("Hold robot %1").arg(selected_ + 1),
      selected_ < 0 ? tr("Select a robot first: here, or in the arena")
                    : tr("Holds this robot, out of the group; the others drive on. In danger: STOP."),
      state_.open && selected_ >= 0 && !over);
  dress_test();
  const bool any_link = std::any_of(specs_.begin(), specs_.end(), [](const auto& spec) { return spec.has_link(); });
  connect_->setVisible(any_link);
  const bool rests = !state_.open || state_.phase == app::Phase::ready || over;
  say(connect_, tr("Connect again"),
      rests ? tr("Sets the experiment up again, and connects to every robot anew; a lost link reconnects by itself")
            : tr("A lost link reconnects by itself; this is possible only before a start, or after STOP"),
      rests && !state_.busy);
}

void RobotButtons::dress_test() {
  const auto i = static_cast<std::size_t>(selected_);
  const bool none = selected_ < 0 || i >= specs_.size();
  const bool simulated = !none && !specs_[i].has_link();
  const bool up = !none && i < state_.links.size() && state_.links[i].link == app::LinkState::up;
  const bool ready = state_.phase == app::Phase::ready;
  const QString text = none ? tr("Test a robot") : tr("Test robot %1").arg(selected_ + 1);
  const QString why_not = none           ? tr("Select a robot first: here, or in the arena")
                          : simulated    ? tr("This robot is simulated: it has neither link nor battery")
                          : testing_     ? tr("One at a time")
                          : !state_.open ? tr("No experiment is open")
                          : !ready       ? tr("Robots can be tested only before a start, while they stand")
                          : !up          ? tr("Its link is not up")
                                         : QString();
  say(test_, testing_ ? tr("Testing …") : text,
      why_not.isEmpty() ? tr("Turns each wheel about 1 cm forward, and reports whether the robot executes its commands")
                        : why_not,
      why_not.isEmpty());
}

}  // namespace skein::ui
