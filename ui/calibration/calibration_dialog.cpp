#include "ui/calibration/calibration_dialog.h"
#include "app/experiment/experiment.h"

#include <QEvent>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QVBoxLayout>
#include <cmath>

#include "app/tools/camera_words.h"
#include "ui/base/dialogs.h"
#include "ui/base/number_text.h"

namespace skein::ui {
namespace {

constexpr int picture_ms = 50;
constexpr double good_error = 0.5;      // [px]: a lens and a flat board do better
constexpr double enough_covered = 0.6;  // of the picture: distortion is a guess elsewhere

NumberField* number(QWidget* parent, const QString& name, const QString& spoken, double least, double most,
                    double value) {
  auto* box = new NumberField(parent);
  box->setObjectName(name);
  box->setAccessibleName(spoken);
  box->setRange(least, most);
  box->setValue(value);
  return box;
}

}  // namespace

void ViewModel::show(const std::vector<app::CalibrationProgress::View>& views) {
  const auto same_size = views.size() == views_.size();
  if (!same_size) beginResetModel();
  views_ = views;
  if (!same_size)
    endResetModel();
  else if (!views_.empty())
    emit dataChanged(index(0, 0), index(rowCount() - 1, columns - 1));
}

int ViewModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(views_.size());
}

QVariant ViewModel::data(const QModelIndex& index, int role) const {
  if (!index.isValid()) return {};
  const auto& view = views_[static_cast<std::size_t>(index.row())];
  if (role == Qt::TextAlignmentRole && index.column() != name)
    return static_cast<int>(Qt::AlignRight | Qt::AlignVCenter);
  if (role == Qt::ForegroundRole && view.left_out) return colours_.alarm;
  if (role == Qt::ToolTipRole && view.left_out)
    return tr("It fits three times worse than the others, and is rejected: remove it, or show the board again");
  if (role != Qt::DisplayRole) return {};
  switch (index.column()) {
    case name:
      return QString::fromStdString(view.name);
    case corners:
      return view.outliers > 0 ? tr("%1, %2 left out").arg(view.corners).arg(view.outliers)
                               : QString::number(view.corners);
    default:
      return !std::isfinite(view.rms) ? QStringLiteral("–")
             : view.left_out          ? tr("%1 px, left out").arg(view.rms, 0, 'f', 2)
                                      : tr("%1 px").arg(view.rms, 0, 'f', 2);
  }
}

QVariant ViewModel::headerData(int section, Qt::Orientation orientation, int role) const {
  if (orientation != Qt::Horizontal || role != Qt::DisplayRole) return {};
  return section == name ? tr("View") : section == corners ? tr("Corners") : tr("Error");
}

CalibrationDialog::CalibrationDialog(const app::CalibratedCamera& camera, const QString& file, QWidget* parent)
    : QDialog(parent),
      picture_(new CalibrationPicture(this)),
      settings_(camera.settings),
      source_(new QLineEdit(QString::fromStdString(camera.source), this)),
      size_(new QLineEdit(QString::fromStdString(camera.size), this)),
      file_(new QLineEdit(file, this)),
      look_(new QPushButton(this)),
      remove_(new QPushButton(tr("Remove view"), this)),
      save_(new QPushButton(tr("Save"), this)),
      advice_(new QLabel(this)),
      result_(new QLabel(this)),
      table_(new QTableView(this)),
      tabs_(new QTabWidget(this)),
      floor_(new FloorPage(this)) {
  setObjectName(QStringLiteral("calibration_dialog"));
  setWindowTitle(tr("Calibrate a camera"));
  setAttribute(Qt::WA_DeleteOnClose);
  setModal(false);  // STOP can be clicked beside it
  advice_->setObjectName(QStringLiteral("calibration_advice"));
  advice_->setWordWrap(true);
  advice_->setTextFormat(Qt::PlainText);
  result_->setObjectName(QStringLiteral("calibration_result"));
  result_->setWordWrap(true);
  result_->setTextFormat(Qt::PlainText);

  auto* left = new QVBoxLayout;
  left->addWidget(picture_, 1);
  left->addWidget(advice_);
  auto* right = new QVBoxLayout;
  source_->setObjectName(QStringLiteral("calibration_source"));
  source_->setAccessibleName(tr("Camera"));
  source_->setToolTip(QString::fromStdString(app::source_forms()));
  file_->setObjectName(QStringLiteral("calibration_file"));
  file_->setAccessibleName(tr("Calibration file"));
  file_->setToolTip(tr("Its name goes into the experiment file, as camera.calibration"));
  size_->setObjectName(QStringLiteral("calibration_size"));
  size_->setAccessibleName(tr("Size of the pictures"));
  size_->setPlaceholderText(tr("the camera's setting"));
  size_->setToolTip(
      tr("Such as 1280x960: a calibration holds for this size, and for this focus. Exposure, gain and focus "
         "are set as the experiment says."));
  auto* shared = new QFormLayout;
  shared->addRow(tr("Camera"), source_);
  shared->addRow(tr("Size"), size_);
  shared->addRow(tr("File"), file_);
  right->addLayout(shared);
  tabs_->setObjectName(QStringLiteral("calibration_tabs"));
  tabs_->setAccessibleName(tr("Lens and floor"));
  tabs_->addTab(build_lens(), tr("1  Lens"));
  tabs_->addTab(floor_, tr("2  Floor"));
  tabs_->setTabToolTip(0, tr("The lens: once for a camera, a lens, a focus and a resolution"));
  tabs_->setTabToolTip(1, tr("The camera's pose: after every move of the camera"));
  right->addWidget(tabs_, 1);
  auto* layout = new QHBoxLayout(this);
  layout->addLayout(left, 1);
  layout->addLayout(right);

  connect(floor_, &FloorPage::camera_wanted, this, [this] {
    if (calibration_) calibration_->end();
    wants_floor_ = true;
    emit camera_wanted();
  });
  connect(floor_, &FloorPage::saved, this, [this] { emit saved(file_->text().trimmed()); });
  connect(look_, &QPushButton::clicked, this, &CalibrationDialog::press_look);
  connect(remove_, &QPushButton::clicked, this, [this] {
    if (calibration_ && table_->currentIndex().isValid())
      calibration_->forget(static_cast<std::size_t>(table_->currentIndex().row()));
  });
  connect(save_, &QPushButton::clicked, this, &CalibrationDialog::save);
  connect(&timer_, &QTimer::timeout, this, &CalibrationDialog::refresh);
  connect(kind_, &QComboBox::currentIndexChanged, this, [this](int kind) { marker_->setEnabled(kind == 0); });
  views_.set_colours(colours(palette()));
  if (const auto known = app::known_floor(file.toStdString())) floor_->show_known(*known);
  resize(fitting({940, 600}, parent));
  close_by_key(this);
  dress({});
}

CalibrationDialog::~CalibrationDialog() = default;

QWidget* CalibrationDialog::build_lens() {
  auto* page = new QWidget(this);
  auto* layout = new QVBoxLayout(page);
  layout->addWidget(build_form());
  table_->setObjectName(QStringLiteral("calibration_views"));
  table_->setAccessibleName(tr("Views of the board, with their errors"));
  table_->setModel(&views_);
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setSelectionMode(QAbstractItemView::SingleSelection);
  table_->setTabKeyNavigation(false);
  table_->verticalHeader()->hide();
  table_->verticalHeader()->setDefaultSectionSize(fontMetrics().height() + 6);
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::Stretch);
  layout->addWidget(table_, 1);
  layout->addWidget(result_);
  auto* buttons = new QHBoxLayout;
  for (QPushButton* button : {remove_, save_}) {
    button->setAutoDefault(false);
    button->setAccessibleName(button->text());
    buttons->addWidget(button);
  }
  layout->addLayout(buttons);
  remove_->setObjectName(QStringLiteral("calibration_remove"));
  remove_->setToolTip(tr("Solves again without the selected view"));
  save_->setObjectName(QStringLiteral("calibration_save"));
  return page;
}

QWidget* CalibrationDialog::build_form() {
  auto* box = new QWidget(this);
  auto* form = new QFormLayout(box);
  form->setContentsMargins(0, 0, 0, 0);
  kind_ = new QComboBox(box);
  kind_->setObjectName(QStringLiteral("calibration_board"));
  kind_->setAccessibleName(tr("Kind of board"));
  kind_->addItems({tr("ChArUco"), tr("Chessboard")});
  const app::CalibrationBoard usual;
  columns_ = number(box, QStringLiteral("calibration_columns"), tr("Columns of squares"), 3, 100, usual.columns);
  rows_ = number(box, QStringLiteral("calibration_rows"), tr("Rows of squares"), 3, 100, usual.rows);
  square_ = number(box, QStringLiteral("calibration_square"), tr("Edge of a square in millimetres"), 1, 500,
                   1000 * usual.square);
  marker_ = number(box, QStringLiteral("calibration_marker"), tr("Edge of a marker in millimetres"), 1, 500,
                   1000 * usual.marker);
  for (NumberField* squares : {columns_, rows_}) squares->setDecimals(0);
  for (NumberField* millimetres : {square_, marker_}) {
    millimetres->setSuffix(tr(" mm"));
    millimetres->setToolTip(tr("As measured on the printed sheet, see skein tags board"));
  }
  for (NumberField* field : {columns_, rows_, square_, marker_})
    connect(field, &NumberField::refused, this,
            [this, field](const QString& why) { advice_->setText(tr("%1: %2").arg(field->accessibleName(), why)); });
  look_->setObjectName(QStringLiteral("calibration_look"));
  look_->setAutoDefault(false);
  form->addRow(tr("Board"), kind_);
  auto* squares = new QHBoxLayout;
  squares->addWidget(columns_, 1);
  squares->addWidget(new QLabel(QStringLiteral("×"), box));
  squares->addWidget(rows_, 1);
  form->addRow(tr("Squares"), squares);
  form->addRow(tr("Square"), square_);
  form->addRow(tr("Marker"), marker_);
  form->addRow(look_);
  return box;
}

void CalibrationDialog::press_look() {
  if (looks_) return calibration_->end();  // the camera is let go; the views stay, and may be saved
  look_->setEnabled(false);                // until the camera is free
  emit camera_wanted();
}

app::CalibratedCamera CalibrationDialog::camera() const {
  const std::string source = source_->text().trimmed().toStdString();
  const bool is_camera = app::camera_kind(source) == app::CameraKind::live;
  return {source, size_->text().trimmed().toStdString(), is_camera ? settings_ : std::vector<std::string>{}};
}

void CalibrationDialog::use_camera() {
  if (wants_floor_) return floor_->use_camera(camera(), file_->text().trimmed());
  app::CalibrationBoard board;
  board.chessboard = kind_->currentIndex() == 1;
  board.columns = static_cast<int>(columns_->value());
  board.rows = static_cast<int>(rows_->value());
  board.square = 1e-3 * square_->value();
  board.marker = 1e-3 * marker_->value();
  calibration_.reset();  // before the new one: both want the same camera
  calibration_ = std::make_unique<app::CameraCalibration>(camera(), board);
  note_.clear();
  timer_.start(picture_ms);
  refresh();
}

void CalibrationDialog::refuse(const QString& why) {
  if (wants_floor_) return floor_->refuse(why);
  look_->setEnabled(true);
  advice_->setText(why);
}

void CalibrationDialog::refresh() {
  if (!calibration_) return;
  if (app::Picture picture; calibration_->picture(picture)) picture_->set_picture(picture);
  const app::CalibrationProgress progress = calibration_->progress();
  picture_->show_progress(progress);
  views_.show(progress.views);
  dress(progress);
}

QString CalibrationDialog::advice(const app::CalibrationProgress& progress) const {
  if (!progress.problem.empty()) return QString::fromStdString(progress.problem);
  if (progress.frames == 0)
    return tr(
        "Show the board from all sides, tilted up to 45°, near and far, out to the picture's corners. Shaded parts "
        "have not been covered yet.");
  const QString place = next_place(progress);
  QString text = tr("%1, %2 % of the picture covered. ")
                     .arg(counted(static_cast<qsizetype>(progress.views.size()), "view"))
                     .arg(100 * progress.covered, 0, 'f', 0);
  if (progress.over) return text + tr("There are no more images.");
  text += progress.corners.empty() ? tr("No board is seen: more light, nearer, or other squares? ") : QString();
  return place.isEmpty() ? text + tr("All of it is covered: tilt the board, and save.")
                         : text + tr("Show it %1, tilted.").arg(place);
}

void CalibrationDialog::dress(const app::CalibrationProgress& progress) {
  looks_ = calibration_ && !progress.over;
  look_->setText(looks_ ? tr("Stop looking") : tr("Look"));
  look_->setAccessibleName(look_->text());
  look_->setToolTip(looks_ ? tr("Closes the camera; the views are kept")
                           : tr("Searches the camera's images for the board. An open experiment is ended first."));
  look_->setEnabled(true);
  advice_->setText(advice(progress));
  const auto& r = progress.result;
  QString text = tr("Not solved yet: %1").arg(QString::fromStdString(progress.unsolved));
  if (r) {
    text = tr("Error %1 px over all. Focal length %2 ± %3 px, centre %4, %5 ± %6 px.")
               .arg(r->rms, 0, 'f', 3)
               .arg(0.5 * (r->fx + r->fy), 0, 'f', 1)
               .arg(r->focal_sigma, 0, 'f', 1)
               .arg(r->cx, 0, 'f', 1)
               .arg(r->cy, 0, 'f', 1)
               .arg(r->centre_sigma, 0, 'f', 1);
    if (r->rms > good_error) text += tr(" That is large: is the board flat, and are its squares described correctly?");
    if (progress.covered < enough_covered) text += tr(" Where no board was seen, distortion is extrapolated.");
  }
  result_->setText(!note_.isEmpty() ? note_ : calibration_ ? text : QString());
  save_->setEnabled(r.has_value());
  save_->setToolTip(r ? tr("Writes the calibration file. The next step is the camera's pose: the floor.")
                      : tr("There is nothing to save yet"));
  remove_->setEnabled(!progress.views.empty());
}

void CalibrationDialog::save() {
  const QString file = file_->text().trimmed();
  const auto done = calibration_->save(file.toStdString());
  if (done) emit saved(file);
  note_ = done ? tr("Written: %1. Next: the floor.").arg(file) : QString::fromStdString(done.error());
  refresh();
}

void CalibrationDialog::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) views_.set_colours(colours(palette()));
  QDialog::changeEvent(event);
}

}  // namespace skein::ui
