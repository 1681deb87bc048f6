#include "ui/robots/robots_model.h"

#include <QFont>
#include <algorithm>
#include <cmath>

#include "ui/base/modes.h"
#include "ui/base/number_text.h"
#include "ui/base/sentence.h"
#include "ui/base/signal_drag.h"
#include "ui/base/why.h"

namespace skein::ui {
namespace {

/// Words to the left, numbers to the right, names in the middle; the header stands over them.
int alignment(int column) {
  if (column <= RobotsModel::tag) return Qt::AlignCenter;
  const bool words = column == RobotsModel::link || column == RobotsModel::mode || column == RobotsModel::found ||
                     column == RobotsModel::firmware;
  return static_cast<int>(Qt::AlignVCenter | (words ? Qt::AlignLeft : Qt::AlignRight));
}

/// The plots that have what a column shows.
QStringList plotted(int column) {
  switch (column) {
    case RobotsModel::round_trip:
      return {QStringLiteral("link_rtt")};
    case RobotsModel::battery:
      return {QStringLiteral("battery")};
    case RobotsModel::tag_age:
      return {QStringLiteral("pose_age")};
    case RobotsModel::wheels:
      return {QStringLiteral("wheel_left"), QStringLiteral("wheel_right")};
    default:
      return {};
  }
}

}  // namespace

void RobotsModel::show_experiment(const app::Experiment& experiment) {
  beginResetModel();
  specs_ = experiment.robots;
  robots_.clear();
  known_ = {};
  endResetModel();
}

void RobotsModel::show_record(const app::TickRecord& record, const Known& known) {
  robots_ = record.robots;
  known_ = known;
  why_.clear();
  for (std::size_t i = 0; i < record.robots.size(); ++i) why_ << why(record, i, known_.circumstances);
  if (!specs_.empty()) emit dataChanged(index(0, 0), index(rowCount() - 1, columns - 1));
}

void RobotsModel::set_colours(const Colours& colours) {
  colours_ = colours;
  if (!specs_.empty()) emit dataChanged(index(0, 0), index(rowCount() - 1, columns - 1));
}

bool RobotsModel::has_links() const {
  return std::any_of(specs_.begin(), specs_.end(), [](const app::RobotSpec& robot) { return robot.has_link(); });
}

int RobotsModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(specs_.size());
}

int RobotsModel::columnCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : columns;
}

QVariant RobotsModel::data(const QModelIndex& index, int role) const {
  const auto i = static_cast<std::size_t>(index.row());
  if (!index.isValid() || i >= specs_.size()) return {};
  switch (role) {
    case Qt::DisplayRole:
      return text(i, index.column());
    case Qt::ToolTipRole:
      return tip(i, index.column());
    case Qt::ForegroundRole:
      return ink(i, index.column());
    case Qt::BackgroundRole:
      return index.column() == robot ? QVariant(colours_.robot(i)) : QVariant();
    case Qt::FontRole:
      if (index.column() == robot) {
        QFont bold;
        bold.setBold(true);
        return bold;
      }
      return {};
    case Qt::TextAlignmentRole:
      return alignment(index.column());
    case plotted_role:
      return plotted(index.column());
    default:
      return {};
  }
}

QString RobotsModel::text(std::size_t i, int column) const {
  if (column == robot) return QString::number(i + 1);
  if (column == tag) return QString::number(specs_[i].tag);
  if (column == link || column == round_trip || column == battery || column == firmware) {
    if (i >= known_.links.size()) return nothing();
    const app::RobotStatus& status = known_.links[i];
    if (column == firmware) {
      const QString version = QString::fromStdString(status.version);  // the tip has all of it
      return version.isEmpty() ? nothing() : version_number(version);
    }
    if (column == battery) {
      const QString volts = std::isfinite(status.battery) ? tr("%1 V").arg(status.battery, 0, 'f', 2) : QString();
      if (status.battery_low) return volts.isEmpty() ? tr("low!") : tr("%1 !").arg(volts);
      return volts.isEmpty() ? nothing() : volts;
    }
    if (column == link) {
      const QString state = QString::fromLatin1(app::word(status.link).data());
      const bool told = known_.stop_asked && specs_[i].has_link();
      return told && status.stop_acknowledged ? tr("%1, stopped").arg(state) : state;
    }
    return std::isfinite(status.round_trip) ? tr("%1 ms").arg(status.round_trip * 1000, 0, 'f', 1) : nothing();
  }
  if (i >= robots_.size()) return nothing();
  const app::RobotRecord& record = robots_[i];
  if (column == mode && may_be_driving(i)) return may_be_driving_style(colours_).name;
  if (column == mode) return mode_text(record.mode, known_.circumstances.held.contains(static_cast<int>(i)));
  if (column == found) return found_text(record);
  if (column == tag_age) {
    if (!(record.pose_age < 1e6)) return nothing();
    return record.pose_age < 10 ? tr("%1 ms").arg(record.pose_age * 1000, 0, 'f', 0)
                                : tr("%1 s").arg(record.pose_age, 0, 'f', 0);
  }
  return QStringLiteral("%1 / %2").arg(fixed(record.wheels.left, 0), fixed(record.wheels.right, 0));
}

/// Why a cell about the link has a dash.
QString RobotsModel::why_nothing(std::size_t i, int column) const {
  if (!specs_[i].has_link()) return tr("Robot %1 is simulated without a link: there is nothing to measure").arg(i + 1);
  if (known_.recorded && column == firmware) return tr("The rows of a recording do not have it");
  if (column == round_trip)
    return known_.recorded ? tr("The recording has none at this time: no answer had come yet, or the run was on the "
                                "virtual clock, which measures none")
                           : tr("No answer has come yet");
  if (column == battery)
    return known_.recorded ? tr("The recording has none at this time: the robot had not reported its battery yet")
                           : tr("Not reported yet; an old e-puck1 reports only whether it is low");
  return tr("Not reported yet");
}

QString RobotsModel::tip(std::size_t i, int column) const {
  const bool of_link = column == round_trip || column == battery || column == firmware;
  if (of_link && text(i, column) == nothing()) return why_nothing(i, column);
  if ((column == link || column == round_trip || column == firmware) && i < known_.links.size()) {
    const app::RobotStatus& status = known_.links[i];
    QString tip = status.reason.empty() ? QString() : QString::fromStdString(status.reason) + QLatin1Char('\n');
    if (specs_[i].is_real()) tip += QString::fromStdString(specs_[i].address) + QLatin1Char('\n');
    if (!status.version.empty()) tip += QString::fromStdString(status.version) + QLatin1Char('\n');
    if (status.exchanges > 0)
      tip += tr("%1 exchanges, %2 timeouts, %3 reconnects")
                 .arg(status.exchanges)
                 .arg(status.timeouts)
                 .arg(status.reconnects);
    return tip.trimmed();
  }
  if (column == mode && may_be_driving(i))
    return tr("It was told to stop and has not acknowledged it: it is not known to stand");
  if (column == mode && static_cast<qsizetype>(i) < why_.size()) return why_[static_cast<qsizetype>(i)];
  if (column == robot) return tr("Robot %1, tag %2").arg(i + 1).arg(specs_[i].tag);
  return text(i, column);
}

bool RobotsModel::may_be_driving(std::size_t i) const {
  return std::find(known_.may_be_driving.begin(), known_.may_be_driving.end(), i) != known_.may_be_driving.end();
}

QVariant RobotsModel::ink(std::size_t i, int column) const {
  if (column == robot) return ink_on(colours_.robot(i));
  if (column == battery && i < known_.links.size() && known_.links[i].battery_low) return colours_.alarm;
  if (column == link && i < known_.links.size()) {
    const app::LinkState state = known_.links[i].link;
    if (!app::reachable(state) && state != app::LinkState::recorded) return colours_.alarm;
  }
  if (i >= robots_.size()) return {};
  if (column == mode && may_be_driving(i)) return colours_.alarm;
  if (column == mode && !mode_style(robots_[i].mode, colours_).symbol.isEmpty()) {
    // The colour of a ring is too pale for text on white; the gravest two are not.
    if (robots_[i].is(app::lost)) return colours_.alarm;
    if (robots_[i].is(app::avoiding) || robots_[i].is(app::shielded)) return colours_.warning;
  }
  if ((column == tag_age || column == found) && !(robots_[i].pose_age <= old_pose)) return colours_.alarm;
  return {};
}

QVariant RobotsModel::headerData(int section, Qt::Orientation orientation, int role) const {
  if (orientation != Qt::Horizontal) return {};
  if (role == Qt::TextAlignmentRole) return alignment(section);
  if (role == Qt::DisplayRole) switch (section) {
      case robot:
        return tr("#");
      case tag:
        return tr("Tag");
      case link:
        return tr("Link");
      case round_trip:
        return tr("Reply");
      case battery:
        return tr("Battery");
      case mode:
        return tr("Mode");
      case found:
        return tr("Found");
      case tag_age:
        return tr("Age");
      case wheels:
        return tr("Wheels");
      case firmware:
        return tr("Firmware");
      default:
        return {};
    }
  if (role == Qt::ToolTipRole) switch (section) {
      case robot:
        return tr("Robot");
      case round_trip:
        return tr("Round trip: from a command to the robot's answer, median");
      case battery:
        return tr("Reported by the robot, about every 10 s");
      case mode:
        return tr("What governs the robot now");
      case found:
        return tr(
            "Where its pose comes from: acquired (seen for the first time), tracked (where it was "
            "expected),\nrecovered (found again), bridged (not seen for a moment, and predicted), lost, or a "
            "simulation");
      case tag_age:
        return tr("Age of the pose in use, since its capture");
      case firmware:
        return tr("Reported by the robot");
      case wheels:
        return tr("Left / right wheel, motor steps per second");
      default:
        return {};
    }
  return {};
}

}  // namespace skein::ui
