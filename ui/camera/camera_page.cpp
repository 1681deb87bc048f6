#include "ui/camera/camera_page.h"

#include <QEvent>
#include <QFormLayout>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "app/experiment/toml_places.h"
#include "ui/base/dialogs.h"
#include "ui/base/number_text.h"

namespace skein::ui {
namespace {

constexpr int look_ms = 60;
constexpr double longest_exposure = 10.0;     // that [camera] takes [s]
const QString apart = QStringLiteral(" – ");  // between an address and what is there

QString number(double value) {
  return QString::number(value, 'g', 4);
}

/// Digits behind the point that tell one step from the next.
int decimals_for(const app::CameraSetting& setting) {
  constexpr int most = 6;
  if (setting.step <= 0.0) return setting.name == "exposure" ? most : 2;
  return std::clamp(static_cast<int>(std::ceil(-std::log10(setting.step) - 1e-9)), 0, most);
}

/// Its value is not known.
void show_nothing(NumberField* field) {
  field->setSpecialValueText(QStringLiteral("–"));
  field->setValue(field->minimum());
}

}  // namespace

void CameraTagModel::show(const std::vector<app::WatchedTag>& tags) {
  const bool same_size = tags.size() == tags_.size();
  if (!same_size) beginResetModel();
  tags_ = tags;
  if (!same_size)
    endResetModel();
  else if (!tags_.empty())
    emit dataChanged(index(0, 0), index(rowCount() - 1, columns - 1));
}

int CameraTagModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(tags_.size());
}

QVariant CameraTagModel::data(const QModelIndex& index, int role) const {
  if (!index.isValid()) return {};
  const app::WatchedTag& of = tags_[static_cast<std::size_t>(index.row())];
  if (role == Qt::TextAlignmentRole && index.column() != verdict)
    return static_cast<int>(Qt::AlignRight | Qt::AlignVCenter);
  if (role == Qt::ForegroundRole && index.column() == verdict) return colour_of(of.state, colours_);
  if (role == Qt::ToolTipRole) return tr("Tag %1, %2: %3").arg(of.tag).arg(size_of(of), verdict_on(of));
  if (role != Qt::DisplayRole) return {};
  switch (index.column()) {
    case tag:
      return of.tag;
    case size:
      return size_of(of);
    default:
      return verdict_on(of);
  }
}

QVariant CameraTagModel::headerData(int section, Qt::Orientation orientation, int role) const {
  if (orientation != Qt::Horizontal || role != Qt::DisplayRole) return {};
  return section == tag ? tr("Tag") : section == size ? tr("Edge") : tr("Taken for, or why not");
}

CameraPage::CameraPage(const QString& source, const QString& calibration, QWidget* parent)
    : QDialog(parent),
      picture_(new CameraPicture(this)),
      cameras_(new QComboBox(this)),
      calibration_(new QLineEdit(calibration, this)),
      search_(new QPushButton(tr("Search"), this)),
      look_(new QPushButton(this)),
      put_(new QPushButton(tr("Into the experiment …"), this)),
      status_(new QLabel(this)),
      settings_note_(new QLabel(this)),
      table_(new QTableView(this)),
      controls_{{{"exposure", tr("Exposure")}, {"gain", tr("Gain")}, {"focus", tr("Focus")}}} {
  setObjectName(QStringLiteral("camera_page"));
  setWindowTitle(tr("Camera"));
  setAttribute(Qt::WA_DeleteOnClose);
  setModal(false);  // STOP can be clicked beside it
  cameras_->setObjectName(QStringLiteral("camera_source"));
  cameras_->setAccessibleName(tr("Camera"));
  cameras_->setToolTip(tr("One of those that are connected, or images:DIRECTORY, video:FILE"));
  cameras_->setEditable(true);
  cameras_->setInsertPolicy(QComboBox::NoInsert);
  cameras_->setMinimumContentsLength(18);
  cameras_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  cameras_->setEditText(source);
  cameras_->lineEdit()->setAccessibleName(tr("Camera"));
  calibration_->setObjectName(QStringLiteral("camera_calibration"));
  calibration_->setAccessibleName(tr("Calibration file"));
  calibration_->setToolTip(tr("Of this camera: with it sizes are in millimetres, and robots' tags are judged"));
  calibration_->setPlaceholderText(tr("none: sizes in px only"));
  search_->setObjectName(QStringLiteral("camera_search"));
  search_->setToolTip(tr("Searches for connected cameras, as skein camera list does"));
  look_->setObjectName(QStringLiteral("camera_look"));
  put_->setObjectName(QStringLiteral("camera_put"));
  put_->setToolTip(tr("Opens the experiment in the editor with this camera and its present settings in [camera]"));
  for (QPushButton* button : {search_, look_, put_}) {
    button->setAutoDefault(false);
    button->setAccessibleName(button->text());
  }
  status_->setObjectName(QStringLiteral("camera_status"));
  settings_note_->setObjectName(QStringLiteral("camera_settings_note"));
  for (QLabel* label : {status_, settings_note_}) {
    label->setWordWrap(true);
    label->setTextFormat(Qt::PlainText);
  }
  table_->setObjectName(QStringLiteral("camera_tags"));
  table_->setAccessibleName(tr("Tags, and why they are not taken for a robot"));
  table_->setModel(&tags_);
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setSelectionMode(QAbstractItemView::SingleSelection);
  table_->setTabKeyNavigation(false);
  table_->verticalHeader()->hide();
  table_->verticalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);  // a reason is a sentence
  table_->horizontalHeader()->setHighlightSections(false);
  table_->setColumnWidth(CameraTagModel::tag, fontMetrics().horizontalAdvance(QStringLiteral("0000")) + 12);
  table_->setColumnWidth(CameraTagModel::size, fontMetrics().horizontalAdvance(tr("000 px, 000.0 mm")) + 12);
  table_->horizontalHeader()->setSectionResizeMode(CameraTagModel::verdict, QHeaderView::Stretch);

  auto* left = new QVBoxLayout;
  left->addWidget(picture_, 1);
  left->addWidget(status_);
  auto* right = new QVBoxLayout;
  auto* shared = new QFormLayout;
  auto* which = new QHBoxLayout;
  which->addWidget(cameras_, 1);
  which->addWidget(search_);
  shared->addRow(tr("Camera"), which);
  shared->addRow(tr("Calibration"), calibration_);
  right->addLayout(shared);
  right->addWidget(look_);
  right->addWidget(build_controls());
  right->addWidget(settings_note_);
  right->addWidget(table_, 1);
  right->addWidget(put_);
  auto* layout = new QHBoxLayout(this);
  layout->addLayout(left, 1);
  layout->addLayout(right, 1);

  connect(search_, &QPushButton::clicked, this, &CameraPage::search);
  connect(cameras_->lineEdit(), &QLineEdit::returnPressed, this, &CameraPage::look_wanted);
  connect(look_, &QPushButton::clicked, this, [this] { watch_ ? end(tr("Nobody looks")) : emit look_wanted(); });
  connect(put_, &QPushButton::clicked, this, [this] { emit values_wanted(values()); });
  connect(&timer_, &QTimer::timeout, this, &CameraPage::refresh);
  tags_.set_colours(colours(palette()));
  settings_note_->hide();
  end(tr("Choose a camera and press Look"));
  resize(fitting({980, 640}, parent));
  close_by_key(this);
  timer_.start(look_ms);
  search();
}

CameraPage::~CameraPage() = default;

QWidget* CameraPage::build_controls() {
  auto* box = new QWidget(this);
  auto* grid = new QGridLayout(box);
  grid->setContentsMargins(0, 0, 0, 0);
  grid->setColumnStretch(3, 1);
  int row = 0;
  for (Control& control : controls_) {
    const QString name = QLatin1String(control.name);
    control.label = new QLabel(control.shown, box);
    control.field = new NumberField(box);
    control.field->setObjectName(QStringLiteral("camera_") + name);
    control.field->setAccessibleName(control.shown);
    show_nothing(control.field);
    control.range = new QLabel(box);
    control.range->setObjectName(QStringLiteral("camera_range_") + name);
    control.range->hide();
    control.label->setBuddy(control.field);
    grid->addWidget(control.label, row, 0);
    grid->addWidget(control.field, row, 1);
    grid->addWidget(control.range, row, 3);
    if (row == 0) {
      control.automatic = new QCheckBox(tr("automatic"), box);
      control.automatic->setObjectName(QStringLiteral("camera_automatic"));
      control.automatic->setAccessibleName(tr("Automatic exposure"));
      grid->addWidget(control.automatic, row, 2);
      connect(control.automatic, &QCheckBox::toggled, this, [this, field = control.field](bool on) {
        if (watch_) watch_->set("exposure", on ? 0.0 : field->value());
      });
    }
    connect(control.field, &NumberField::valueChanged, this, [this, of = control.name](double value) {
      refused_.clear();
      if (watch_) watch_->set(of, value);
    });
    connect(control.field, &NumberField::refused, this,
            [this, shown = control.shown](const QString& why) { refused_ = QStringLiteral("%1: %2").arg(shown, why); });
    ++row;
  }
  return box;
}

QString CameraPage::source() const {
  return cameras_->currentText().section(apart, 0, 0).trimmed();
}

void CameraPage::search() {
  if (found_.valid()) return;
  search_->setEnabled(false);
  found_ = app::find_cameras_aside();
}

void CameraPage::show_camera(const app::Experiment& experiment, const app::WatchedCamera& camera) {
  of_run_ = camera.of_run;
  watched_ = QString::fromStdString(camera.source);
  present_.clear();
  refused_.clear();
  calibration_->setPlaceholderText(of_run_ ? tr("that of the run") : tr("none: sizes in px only"));
  watch_ = std::make_unique<app::CameraViewer>(experiment, camera);
  pictured_at_ = app::none;
  picture_->clear(tr("Waiting for a picture"));
  show_settings({});
  show_status({});
  look_->setText(tr("Stop looking"));
  look_->setAccessibleName(look_->text());
}

void CameraPage::show_picture(const app::Picture& picture) {
  if (wants_run()) watch_->hand(picture);
}

void CameraPage::let_go(const QString& why) {
  if (watch_ && !of_run_) end(why);
}

void CameraPage::refuse(const QString& why) {
  end(why);
}

void CameraPage::end(const QString& why) {
  watch_.reset();
  picture_->clear(why);
  show_status_text({});  // the picture's place says it
  look_->setText(tr("Look"));
  look_->setAccessibleName(look_->text());
  tags_.show({});
  for (Control& control : controls_) control.field->setEnabled(false);
  controls_.front().automatic->setEnabled(false);
}

void CameraPage::refresh() {
  if (found_.valid() && found_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const app::FoundCameras found = found_.get();
    search_->setEnabled(true);
    const QString text = cameras_->currentText();
    cameras_->clear();
    for (const app::FoundCamera& camera : found.cameras)
      cameras_->addItem(QString::fromStdString(camera.address) + apart + QString::fromStdString(camera.what));
    if (text.isEmpty() && cameras_->count() > 0)
      cameras_->setCurrentIndex(0);
    else
      cameras_->setEditText(text);
    const QString count = found.cameras.empty() ? tr("No camera is connected.")
                                                : tr("%1 connected.").arg(counted(cameras_->count(), "camera"));
    search_->setToolTip(found.problem.empty() ? count
                                              : count + QLatin1Char(' ') + QString::fromStdString(found.problem));
  }
  app::CameraView view;
  const bool news = watch_ && watch_->view(view);
  if (watch_) show_age(news ? &view : nullptr);
  if (!news) return;
  picture_->show_view(view);
  tags_.show(view.tags);
  show_settings(view);
  show_status(view);
  newest_ = view;
  if (!view.over) return;
  // The last picture stays.
  const QString why = QString::fromStdString(view.problem);
  if (view.picture.width == 0) {
    picture_->clear(why);
    show_status_text({});
  }
  watch_.reset();
  look_->setText(tr("Look"));
  look_->setAccessibleName(look_->text());
}

/// A camera that is frozen, or lost, leaves its last picture here, which looks like any other.
void CameraPage::show_age(const app::CameraView* view) {
  constexpr qint64 old_ms = 2000;  // searching takes a while
  if (view && view->picture.captured_at != pictured_at_) {
    pictured_at_ = view->picture.captured_at;
    comes_again_and_again_ = of_run_ || !std::isnan(view->rate);
    shown_for_.restart();
  }
  const bool old =
      comes_again_and_again_ && !std::isnan(pictured_at_) && shown_for_.isValid() && shown_for_.elapsed() > old_ms;
  picture_->set_note(old ? tr("No new picture has come for %1 s").arg(shown_for_.elapsed() / 1000) : QString());
  if (!old || std::isnan(newest_.rate)) return;
  newest_.rate = app::none;  // of before
  show_status(newest_);
}

void CameraPage::show_settings(const app::CameraView& view) {
  present_ = view.settings;
  const bool settable = !of_run_ || app::settable_during_run(watched_.toStdString());
  for (Control& control : controls_) {
    const auto has = std::find_if(present_.begin(), present_.end(),
                                  [&](const app::CameraSetting& setting) { return setting.name == control.name; });
    const bool is_there = has != present_.end();
    control.field->setEnabled(is_there && settable && !view.over);
    if (control.automatic) control.automatic->setEnabled(is_there && settable && !view.over);
    control.range->setVisible(is_there);
    const QSignalBlocker quiet(control.field);
    if (!is_there) {
      show_nothing(control.field);
      continue;
    }
    if (!control.field->specialValueText().isEmpty()) control.field->setSpecialValueText({});  // it rewrites the text
    const bool seconds = has->name == "exposure" && !has->counted;
    control.field->setDecimals(decimals_for(*has));
    control.field->setStepType(QAbstractSpinBox::AdaptiveDecimalStepType);
    control.field->setSuffix(seconds ? tr(" s") : QString());
    if (!control.field->is_being_typed()) control.field->setValue(has->value);
    QString range = tr("%1 to %2").arg(number(has->least), number(has->most));
    if (has->automatic && !control.automatic) range += tr(", automatic");
    control.range->setText(range);
    control.range->setToolTip(tr("Allowed. A value switches the camera's own automatic off."));
    if (control.automatic) {
      const QSignalBlocker also_quiet(control.automatic);
      control.automatic->setChecked(has->automatic);
    }
  }
  QStringList lines;
  if (!refused_.isEmpty()) lines << refused_;
  for (const std::string& notice : view.notices) lines << QString::fromStdString(notice);
  if (of_run_ && !settable)
    lines << tr("The run reads this camera, and its settings cannot be changed meanwhile.");
  else if (of_run_)
    lines << tr("The run reads this camera: what is set here changes for the run as well, until it is opened again.");
  else if (watch_ && present_.empty() && view.picture.width > 0)
    lines << tr("It has none of exposure, gain and focus.");
  settings_note_->setText(lines.join(QLatin1Char('\n')));
  settings_note_->setVisible(!lines.isEmpty());
}

void CameraPage::show_status(const app::CameraView& view) {
  QStringList lines;
  if (!view.problem.empty()) lines << QString::fromStdString(view.problem);
  QString line = of_run_ ? tr("The run's camera, %1").arg(watched_) : QString::fromStdString(view.camera);
  if (!std::isnan(view.rate))
    line += of_run_ ? tr("; %1 frames/s reach the window").arg(view.rate, 0, 'f', 1)
                    : tr("; %1 frames/s come").arg(view.rate, 0, 'f', 1);
  if (!line.isEmpty()) lines << line;
  if (!std::isnan(view.tag_size)) lines << tr("Tags should have %1 mm.").arg(1e3 * view.tag_size, 0, 'g', 4);
  if (!view.note.empty()) lines << QString::fromStdString(view.note);
  if (view.over && view.problem.empty()) lines << tr("There are no more pictures.");
  show_status_text(lines.join(QLatin1Char('\n')));
}

void CameraPage::show_status_text(const QString& text) {
  status_->setText(text);
  status_->setVisible(!text.isEmpty());
}

CameraPage::Values CameraPage::values() const {
  Values values{{QStringLiteral("source"), QString::fromStdString(app::toml_string(source().toStdString()))}};
  if (!calibration().isEmpty()) values.emplace_back(QStringLiteral("calibration"), calibration());
  if (source() != watched_) return values;  // the settings are another camera's
  for (const app::CameraSetting& setting : present_) {
    const bool exposure = setting.name == "exposure";
    if (exposure && (setting.counted || setting.value > longest_exposure)) continue;  // not in seconds
    values.emplace_back(QString::fromStdString(setting.name),
                        exposure && setting.automatic ? QStringLiteral("0") : QString::number(setting.value, 'g', 10));
  }
  return values;
}

void CameraPage::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) tags_.set_colours(colours(palette()));
  QDialog::changeEvent(event);
}

}  // namespace skein::ui
