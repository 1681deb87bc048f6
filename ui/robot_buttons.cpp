#include "ui/robot_buttons.h"

#include <QHBoxLayout>

namespace skein::ui {

RobotButtons::RobotButtons(QWidget* parent)
    : QWidget(parent), hold_(new QPushButton(this)), connect_(new QPushButton(tr("Connect again"), this)) {
  setObjectName(QStringLiteral("robot_buttons"));
  hold_->setObjectName(QStringLiteral("hold_robot"));
  connect_->setObjectName(QStringLiteral("connect_robot"));
  connect_->setAccessibleName(connect_->text());
  connect_->setToolTip(tr("Ends this run, and connects to every robot anew"));
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(6, 2, 6, 2);
  layout->addWidget(hold_);
  layout->addWidget(connect_);
  layout->addStretch();
  connect(hold_, &QPushButton::clicked, this, [this] { emit hold(selected_, !held_.contains(selected_)); });
  connect(connect_, &QPushButton::clicked, this, &RobotButtons::connect_again);
  dress();
}

void RobotButtons::show_experiment(const app::Experiment& experiment) {
  specs_ = experiment.robots;
  links_.clear();
  held_.clear();
  if (selected_ >= static_cast<int>(specs_.size())) selected_ = -1;
  dress();
}

void RobotButtons::take(const app::TickRecord& record) {
  for (const app::Event& event : record.events) {
    if (event.kind == app::Event::Kind::hold) held_.insert(event.robot);
    if (event.kind == app::Event::Kind::release) held_.erase(event.robot);
  }
}

void RobotButtons::show_state(const std::vector<app::RobotStatus>& links, app::Phase phase, bool open) {
  links_ = links;
  phase_ = phase;
  open_ = open;
  dress();
}

void RobotButtons::select_robot(int robot) {
  selected_ = robot;
  dress();
}

void RobotButtons::dress() {
  const bool over = phase_ == app::Phase::stopped || phase_ == app::Phase::finished;
  const bool is_held = held_.contains(selected_);
  hold_->setText(selected_ < 0 ? tr("Hold a robot")
                 : is_held     ? tr("Let robot %1 go").arg(selected_ + 1)
                               : tr("Hold robot %1").arg(selected_ + 1));
  hold_->setAccessibleName(hold_->text());
  hold_->setToolTip(selected_ < 0
                        ? tr("Select a robot first: here, or in the arena")
                        : tr("Makes this one stand, out of the group; the others drive on. In danger: STOP."));
  hold_->setEnabled(open_ && selected_ >= 0 && !over);
  const bool any_link = std::any_of(specs_.begin(), specs_.end(),
                                    [](const auto& spec) { return spec.link != app::RobotSpec::Link::sim; });
  connect_->setVisible(any_link);
  connect_->setEnabled(open_ && (phase_ == app::Phase::ready || over));
}

}  // namespace skein::ui
