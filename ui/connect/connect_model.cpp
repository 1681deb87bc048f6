#include "ui/connect/connect_model.h"

#include "ui/base/modes.h"
#include "ui/base/number_text.h"
#include "ui/base/sentence.h"

namespace skein::ui {
namespace {

const QString none_here = QStringLiteral("–");

QString text_of(const std::string& text) {
  return QString::fromStdString(text);
}

QString milliseconds(double seconds) {
  return QString::number(1e3 * seconds, 'f', seconds < 0.01 ? 1 : 0);
}

Severity severity(app::SetupVerdict::State state) {
  switch (state) {
    case app::SetupVerdict::State::ready:
      return Severity::good;
    case app::SetupVerdict::State::missing:
      return Severity::notice;
    case app::SetupVerdict::State::wrong:
      return Severity::alarm;
  }
  return Severity::note;
}

}  // namespace

void ConnectModel::show(const std::vector<app::RobotSetup>& robots, bool camera) {
  const bool same_size = robots.size() == robots_.size();
  const bool grown = robots.size() > robots_.size() && !robots_.empty();
  if (grown)
    beginInsertRows({}, rowCount(), static_cast<int>(robots.size()) - 1);
  else if (!same_size)
    beginResetModel();
  robots_ = robots;
  camera_ = camera;
  if (grown)
    endInsertRows();
  else if (!same_size)
    endResetModel();
  if (!robots_.empty()) emit dataChanged(index(0, 0), index(rowCount() - 1, columns - 1));
}

int ConnectModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(robots_.size());
}

ConnectModel::Cell ConnectModel::cell(const app::RobotSetup& of, int column) const {
  if (column == robot) {
    const QString link = of.spec.is_real()    ? text_of(of.spec.address)
                         : of.spec.has_link() ? tr("emulated")
                                              : tr("simulated");
    const QString where =
        of.number < 0 ? tr("Found by the scan; it is not in the experiment") : tr("In the experiment");
    return {text_of(of.name) + QLatin1Char('\n') + link,
            of.spec.adapter.empty() ? where : tr("%1. Over the adapter %2").arg(where, text_of(of.spec.adapter))};
  }
  if (column == verdict) {
    const QString sentence = text_of(app::verdict_on(of, camera_).sentence);
    return {sentence, sentence};
  }
  if (!of.spec.has_link())
    return {none_here, tr("It is simulated: it has neither link nor battery, and no wheels to test")};
  return linked(of, column);
}

/// Of a robot that has a link.
ConnectModel::Cell ConnectModel::linked(const app::RobotSetup& of, int column) const {
  const QString unknown = tr("not known"), untested = tr("not tested");
  switch (column) {
    case paired:
      if (!of.is_bluetooth()) return {none_here, tr("It is not reached by Bluetooth: there is nothing to pair")};
      if (!of.paired) return {unknown, tr("Scan asks the Bluetooth daemon")};
      return {*of.paired ? tr("yes") : tr("no"), *of.paired ? tr("With this PC") : tr("Pair does it")};
    case answers:
      if (!of.pinged) return {untested, tr("Ping asks it some questions")};
      if (!of.answers) return {tr("no"), text_of(of.silence)};
      if (std::isnan(of.round_trip)) return {tr("yes"), tr("Ping measures how soon")};
      return {tr("%1 / %2 ms").arg(milliseconds(of.round_trip), milliseconds(of.round_trip_p99)),
              tr("Round trips of %1 questions: half of them are shorter than the first number, 99 % than the second")
                  .arg(of.exchanges)};
    case battery:
      if (of.battery.empty()) return {unknown, tr("Ping asks for it")};
      return {text_of(of.battery), of.battery_low ? tr("Charge it") : tr("As the robot says")};
    case firmware:
      if (of.version.empty()) return {unknown, of.answers ? tr("The robot did not say") : tr("Ping asks for it")};
      return {version_number(text_of(of.version)), text_of(of.version)};
    case wheels: {
      if (!of.test) return {untested, tr("The test turns them")};
      const int faults = static_cast<int>(of.test->faults.size()) - (of.test->tag_fault ? 1 : 0);
      if (faults == 0) return {tr("good"), tr("They turn as commanded")};
      return {counted(faults, "fault"), details_of(of).empty() ? QString() : tr("Named below the table")};
    }
    case tag:
      if (!camera_) return {none_here, tr("The experiment has no camera, which a test of tags needs")};
      if (!of.test)
        return {untested, of.spec.tag < 0 ? tr("The test finds out which it carries")
                                          : tr("It should carry tag %1; the test finds out").arg(of.spec.tag)};
      if (of.test->tag < 0) return {tr("none"), tr("No tag was seen that turned with it")};
      return {of.test->tag_fault ? tr("%1 wrong").arg(of.test->tag) : QString::number(of.test->tag),
              of.spec.tag < 0 ? tr("It carries tag %1").arg(of.test->tag)
                              : tr("It carries tag %1, and should carry tag %2").arg(of.test->tag).arg(of.spec.tag)};
    default:
      return {};
  }
}

QVariant ConnectModel::data(const QModelIndex& index, int role) const {
  if (!index.isValid()) return {};
  const app::RobotSetup& of = robots_[static_cast<std::size_t>(index.row())];
  const int column = index.column();
  if (role == Qt::DisplayRole) return cell(of, column).text;
  if (role == Qt::ToolTipRole) return cell(of, column).tip;
  if (role == Qt::TextAlignmentRole)
    return static_cast<int>(Qt::AlignVCenter |
                            (column == robot || column == verdict ? Qt::AlignLeft : Qt::AlignHCenter));
  if (role == Qt::ForegroundRole && column == verdict)
    return colour(severity(app::verdict_on(of, camera_).state), colours_);
  return {};
}

QVariant ConnectModel::headerData(int section, Qt::Orientation orientation, int role) const {
  if (orientation != Qt::Horizontal || role != Qt::DisplayRole) return {};
  switch (section) {
    case robot:
      return tr("Robot");
    case paired:
      return tr("Paired");
    case answers:
      return tr("Answers");
    case battery:
      return tr("Battery");
    case firmware:
      return tr("Firmware");
    case wheels:
      return tr("Wheels");
    case tag:
      return tr("Tag");
    case verdict:
      return tr("Next step");
    default:
      return {};
  }
}

QString ConnectModel::details(int row) const {
  if (row < 0 || row >= rowCount()) return {};
  const app::RobotSetup& of = robots_[static_cast<std::size_t>(row)];
  QStringList lines;
  for (const std::string& line : details_of(of)) lines << text_of(line);
  return lines.isEmpty() ? QString() : tr("Of %1. ").arg(text_of(of.name)) + lines.join(QLatin1Char(' '));
}

}  // namespace skein::ui
