#include "ui/calibration/floor_page.h"

#include <QFormLayout>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QVBoxLayout>
#include <chrono>
#include <cmath>

#include "ui/base/number_text.h"

namespace skein::ui {
namespace {

constexpr int survey_ms = 100;

QPushButton* button(QWidget* parent, const QString& text, const QString& name, const QString& tip) {
  auto* made = new QPushButton(text, parent);
  made->setObjectName(name);
  made->setAccessibleName(text);
  made->setToolTip(tip);
  made->setAutoDefault(false);
  return made;
}

NumberField* millimetres(QWidget* parent, const QString& name, const QString& spoken, double least, double value) {
  auto* box = new NumberField(parent);
  box->setObjectName(name);
  box->setAccessibleName(spoken);
  box->setRange(least, 1e4);  // as in a file of a calibration
  box->setDecimals(1);
  box->setValue(value);
  box->setSuffix(FloorPage::tr(" mm"));
  return box;
}

}  // namespace

FloorModel::FloorModel(QObject* parent) : QAbstractTableModel(parent) {
  int number = 20;  // robots have the low ones
  for (const auto& [x_sign, y_sign] : {std::pair{-1, 1}, {1, 1}, {1, -1}, {-1, -1}})
    tags_.push_back({.id = number++, .x = 0.9 * x_sign, .y = 0.6 * y_sign});
}

void FloorModel::show(const std::vector<app::FloorTag>& tags) {
  beginResetModel();
  tags_ = tags;
  endResetModel();
}

void FloorModel::add() {
  beginInsertRows({}, rowCount(), rowCount());
  tags_.push_back({.id = tags_.empty() ? 20 : tags_.back().id + 1});
  endInsertRows();
}

void FloorModel::remove(int row) {
  if (row < 0 || row >= rowCount()) return;
  beginRemoveRows({}, row, row);
  tags_.erase(tags_.begin() + row);
  endRemoveRows();
}

int FloorModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(tags_.size());
}

QVariant FloorModel::data(const QModelIndex& index, int role) const {
  if (!index.isValid()) return {};
  const app::FloorTag& tag = tags_[static_cast<std::size_t>(index.row())];
  if (role == Qt::TextAlignmentRole) return static_cast<int>(Qt::AlignRight | Qt::AlignVCenter);
  if (role != Qt::DisplayRole && role != Qt::EditRole) return {};
  switch (index.column()) {
    case id:
      return tag.id;
    case x:
      return QString::number(tag.x);
    case y:
      return QString::number(tag.y);
    case z:
      return QString::number(tag.z);
    default:
      return std::isfinite(tag.off_x) ? tr("%1 mm").arg(1000 * std::hypot(tag.off_x, tag.off_y), 0, 'f', 1)
                                      : QStringLiteral("–");
  }
}

bool FloorModel::setData(const QModelIndex& index, const QVariant& value, int role) {
  if (!index.isValid() || role != Qt::EditRole) return false;
  const auto typed = parse_number(value.toString());
  const double number = typed.value_or(0.0);
  constexpr double farthest = 100.0;  // [m]
  const bool is_id = index.column() == id;
  if (!typed || std::abs(number) > (is_id ? app::FloorTag::largest_id : farthest) ||
      (is_id && (number < 0 || number != std::floor(number)))) {
    const QString allowed = is_id ? tr("a whole number from 0 to %1").arg(app::FloorTag::largest_id)
                                  : tr("a number from -%1 to %1").arg(farthest);
    const QString column = headerData(index.column(), Qt::Horizontal, Qt::DisplayRole).toString();
    emit refused(tr("%1: %2").arg(column, why_refused(value.toString(), allowed)));
    return false;
  }
  app::FloorTag& tag = tags_[static_cast<std::size_t>(index.row())];
  if (is_id)
    tag.id = static_cast<int>(number);
  else
    (index.column() == x ? tag.x : index.column() == y ? tag.y : tag.z) = number;
  tag.off_x = tag.off_y = app::none;
  emit dataChanged(index.siblingAtColumn(0), index.siblingAtColumn(off));
  return true;
}

QVariant FloorModel::headerData(int section, Qt::Orientation orientation, int role) const {
  if (orientation != Qt::Horizontal || role != Qt::DisplayRole) return {};
  const QStringList words{tr("Tag"), tr("x [m]"), tr("y [m]"), tr("z [m]"), tr("Off by")};
  return words.value(section);
}

Qt::ItemFlags FloorModel::flags(const QModelIndex& index) const {
  const Qt::ItemFlags usual = QAbstractTableModel::flags(index);
  return index.column() == off ? usual : usual | Qt::ItemIsEditable;
}

FloorPage::FloorPage(QWidget* parent)
    : QWidget(parent),
      table_(new QTableView(this)),
      size_(millimetres(this, QStringLiteral("floor_tag_size"), tr("Edge of the robots' tags in millimetres"), 1, 40)),
      height_(millimetres(this, QStringLiteral("floor_tag_height"), tr("Height of the robots' tags in millimetres"),
                          -1e4, 60)),
      add_(button(this, tr("Add tag"), QStringLiteral("floor_add"), tr("Adds a tag on the floor"))),
      remove_(button(this, tr("Remove"), QStringLiteral("floor_remove"), tr("Removes the selected tag"))),
      look_(button(this, tr("Look and save"), QStringLiteral("floor_look"),
                   tr("Measures the tags on the floor, and writes the camera's pose to the calibration file"))),
      result_(new QLabel(this)) {
  setObjectName(QStringLiteral("floor_page"));
  auto* what =
      new QLabel(tr("Put at least four tags, better six, onto the floor, spread over the arena. Measure the positions "
                    "of their centres (x right, y up, origin in the middle of the arena), and enter them here."),
                 this);
  what->setWordWrap(true);
  result_->setObjectName(QStringLiteral("floor_result"));
  result_->setWordWrap(true);
  result_->setTextFormat(Qt::PlainText);
  table_->setObjectName(QStringLiteral("floor_tags"));
  table_->setAccessibleName(tr("Tags on the floor"));
  table_->setModel(&tags_);
  table_->setTabKeyNavigation(false);
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setSelectionMode(QAbstractItemView::SingleSelection);
  table_->verticalHeader()->hide();
  table_->verticalHeader()->setDefaultSectionSize(fontMetrics().height() + 8);
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::Stretch);
  auto* form = new QFormLayout;
  form->addRow(tr("Robots' tags, edge"), size_);
  form->addRow(tr("Robots' tags, height"), height_);
  auto* row = new QHBoxLayout;
  row->addWidget(add_);
  row->addWidget(remove_);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(what);
  layout->addWidget(table_, 1);
  layout->addLayout(row);
  layout->addLayout(form);
  layout->addWidget(look_);
  layout->addWidget(result_);
  connect(add_, &QPushButton::clicked, this, [this] { tags_.add(); });
  connect(&tags_, &FloorModel::refused, result_, &QLabel::setText);
  for (const NumberField* field : {size_, height_})
    connect(field, &NumberField::refused, this,
            [this, field](const QString& why) { result_->setText(tr("%1: %2").arg(field->accessibleName(), why)); });
  connect(remove_, &QPushButton::clicked, this, [this] { tags_.remove(table_->currentIndex().row()); });
  connect(look_, &QPushButton::clicked, this, [this] {
    look_->setEnabled(false);
    result_->setText(tr("Looking …"));
    emit camera_wanted();
  });
  connect(&timer_, &QTimer::timeout, this, &FloorPage::settle);
}

FloorPage::~FloorPage() {
  ends_ = true;
}

void FloorPage::use_camera(const app::CalibratedCamera& camera, const QString& calibration) {
  app::FloorQuestion question;
  question.source = camera.source;
  question.settings = camera.settings;
  question.calibration = calibration.toStdString();
  question.tags = tags_.tags();
  question.tag_size = 1e-3 * size_->value();
  question.tag_height = 1e-3 * height_->value();
  survey_ = std::async(std::launch::async, [question, this] { return app::survey_floor(question, ends_); });
  timer_.start(survey_ms);
}

void FloorPage::show_known(const app::KnownFloor& floor) {
  tags_.show(floor.tags);
  size_->setValue(1000 * floor.tag_size);
  height_->setValue(1000 * floor.tag_height);
}

void FloorPage::refuse(const QString& why) {
  look_->setEnabled(true);
  result_->setText(why);
}

void FloorPage::settle() {
  if (!survey_.valid() || survey_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  timer_.stop();
  const auto survey = survey_.get();
  if (!survey) return refuse(QString::fromStdString(survey.error()));
  tags_.show(survey->tags);
  QString text = tr("Written. Error %1 mm (rms), %2 mm at most. The camera is at x %3, y %4, z %5 m.")
                     .arg(1000 * survey->rms, 0, 'f', 1)
                     .arg(1000 * survey->worst, 0, 'f', 1)
                     .arg(fixed(survey->camera[0], 3), fixed(survey->camera[1], 3), fixed(survey->camera[2], 3));
  if (std::isfinite(survey->poses_move))
    text += tr(" Poses move by %1 mm (rms).").arg(1000 * survey->poses_move, 0, 'f', 1);
  for (const std::string& why : survey->unseen) text += QStringLiteral(" %1.").arg(QString::fromStdString(why));
  if (!survey->suspect.empty())
    text += tr(" %1: the others agree without it: check its position.").arg(QString::fromStdString(survey->suspect));
  refuse(text);
  emit saved();
}

}  // namespace skein::ui
