#include "ui/status/check_list.h"

#include <QEvent>
#include <QGridLayout>
#include <QKeyEvent>
#include <QResizeEvent>
#include <QScrollBar>
#include <QTimer>
#include <QVBoxLayout>
#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "ui/base/flow_layout.h"
#include "ui/base/palette.h"
#include "ui/base/picture.h"

namespace skein::ui {
namespace {

using What = app::Check::What;

struct Entry {
  const char *name, *title, *mend, *tip;
};

/// In the order of `Check::What`.
constexpr std::array entries{
    Entry{"camera", QT_TRANSLATE_NOOP("CheckList", "Camera calibrated"), QT_TRANSLATE_NOOP("CheckList", "Calibrate …"),
          QT_TRANSLATE_NOOP("CheckList", "Calibrates the camera with a board, and writes the calibration file")},
    Entry{"settings", QT_TRANSLATE_NOOP("CheckList", "Camera settings fixed"),
          QT_TRANSLATE_NOOP("CheckList", "Camera …"),
          QT_TRANSLATE_NOOP("CheckList",
                            "Looks through the camera: automatic exposure, gain and focus are switched off there")},
    Entry{"tags", QT_TRANSLATE_NOOP("CheckList", "All tags seen"), QT_TRANSLATE_NOOP("CheckList", "Show picture"),
          QT_TRANSLATE_NOOP("CheckList", "Shows the camera's picture, to find the robot that is missing in it")},
    Entry{"links", QT_TRANSLATE_NOOP("CheckList", "Links up"), QT_TRANSLATE_NOOP("CheckList", "Connect"),
          QT_TRANSLATE_NOOP("CheckList", "Sets the experiment up again, and connects to every robot anew")},
    Entry{"batteries", QT_TRANSLATE_NOOP("CheckList", "Batteries"), QT_TRANSLATE_NOOP("CheckList", "Show robot"),
          QT_TRANSLATE_NOOP("CheckList", "Selects the robot whose battery is low: change it, and connect again")},
    Entry{"gains", QT_TRANSLATE_NOOP("CheckList", "Gains certified"), QT_TRANSLATE_NOOP("CheckList", "Show gains"),
          QT_TRANSLATE_NOOP("CheckList", "Shows the gains and what they leave to tracking")},
    Entry{"reference", QT_TRANSLATE_NOOP("CheckList", "Reference feasible"), QT_TRANSLATE_NOOP("CheckList", "Edit …"),
          QT_TRANSLATE_NOOP("CheckList", "Opens the experiment: a slower reference, or a larger path")},
    Entry{"places", QT_TRANSLATE_NOOP("CheckList", "Robots in their places"), QT_TRANSLATE_NOOP("CheckList", "Place"),
          QT_TRANSLATE_NOOP("CheckList", "Brings every robot to its start")},
};

constexpr int picture_height = 56;  // of a tag [px]

/// Pages by the keyboard, from whatever has it in the list, and no line of pictures falls between two pages.
class Pages final : public QScrollArea {
 public:
  using QScrollArea::QScrollArea;

 protected:
  void keyPressEvent(QKeyEvent* event) override {
    if (event->key() != Qt::Key_PageDown && event->key() != Qt::Key_PageUp) return QScrollArea::keyPressEvent(event);
    constexpr int kept = picture_height + 16;
    const int page = std::max(viewport()->height() - kept, kept / 3);
    QScrollBar* const bar = verticalScrollBar();
    bar->setSliderPosition(bar->sliderPosition() + (event->key() == Qt::Key_PageDown ? page : -page));
  }
};

/// Of a check; the line below it is free.
int line_of(std::size_t check) {
  return 2 * static_cast<int>(check);
}

}  // namespace

CheckList::CheckList(QWidget* parent)
    : QWidget(parent),
      pictures_(new QWidget(this)),
      tag_size_(new QPushButton(tr("Set tag size"), this)),
      folded_text_(new QLabel(this)),
      anyway_text_(new QLabel(tr("What is marked ! can be overruled."), this)),
      anyway_(new QPushButton(tr("Start anyway"), this)),
      scroll_(new Pages(this)),
      list_(new QWidget) {
  setObjectName(QStringLiteral("check_list"));
  setAccessibleName(tr("Before the start"));
  setAutoFillBackground(true);
  scroll_->setWidget(list_);
  scroll_->setWidgetResizable(true);
  scroll_->setFrameShape(QFrame::NoFrame);
  scroll_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll_->setFocusPolicy(Qt::NoFocus);
  auto* outer = new QVBoxLayout(this);
  outer->setContentsMargins(0, 0, 0, 0);
  outer->addWidget(scroll_);
  setSizePolicy(QSizePolicy::Preferred, QSizePolicy::Maximum);
  connect(scroll_->verticalScrollBar(), &QScrollBar::actionTriggered, this, [this] { scrolled_ = true; });
  auto* layout = new QGridLayout(list_);
  layout->setContentsMargins(10, 6, 10, 6);
  layout->setHorizontalSpacing(10);
  layout->setVerticalSpacing(2);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const Entry& w = entries[k];
    const QString name = QString::fromLatin1(w.name);
    Row row{new QLabel(this), new QLabel(tr(w.title), this), new QLabel(this), new QPushButton(tr(w.mend), this)};
    row.mark->setObjectName(QStringLiteral("check_mark_") + name);
    row.mark->setAlignment(Qt::AlignCenter);
    row.mark->setMinimumWidth(fontMetrics().height());
    row.reason->setObjectName(QStringLiteral("check_") + name);
    row.reason->setTextFormat(Qt::PlainText);
    row.reason->setWordWrap(true);
    row.reason->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
    const int line = line_of(k);
    // Beside the first line of a long reason.
    layout->addWidget(row.mark, line, 0, Qt::AlignTop);
    layout->addWidget(row.title, line, 1, Qt::AlignTop);
    layout->addWidget(row.reason, line, 2);
    row.mend->setObjectName(QStringLiteral("mend_") + name);
    row.mend->setAccessibleName(tr("%1: %2").arg(tr(w.title), tr(w.mend)));
    row.mend->setToolTip(tr(w.tip));
    connect(row.mend, &QPushButton::clicked, this, [this, k] { emit mend(static_cast<What>(k)); });
    layout->addWidget(row.mend, line, 3, Qt::AlignTop);
    for (QLabel* beside : {row.mark, row.title}) beside->setMinimumHeight(row.mend->sizeHint().height());
    show_line(row, true);
    rows_.push_back(row);
    if (static_cast<What>(k) != What::tags) continue;
    layout->addWidget(pictures_, line + 1, 1, 1, 2);
    layout->addWidget(tag_size_, line + 1, 3, Qt::AlignTop);
    QWidget::setTabOrder(row.mend, tag_size_);
  }
  pictures_->setObjectName(QStringLiteral("tag_pictures"));
  pictures_->hide();
  auto* pictures = new FlowLayout(pictures_);
  pictures->setContentsMargins(0, 0, 0, 4);
  pictures->setSpacing(6);
  tag_size_->setObjectName(QStringLiteral("mend_tag_size"));
  tag_size_->hide();
  connect(tag_size_, &QPushButton::clicked, this, [this] { emit tag_size_wanted(size_); });
  layout->setColumnStretch(2, 1);
  anyway_->setObjectName(QStringLiteral("start_anyway"));
  anyway_->setAccessibleName(anyway_->text());
  anyway_->setToolTip(tr("Starts although a check has failed; only failures without danger can be overridden"));
  connect(anyway_, &QPushButton::clicked, this, &CheckList::start_anyway);
  const auto add_below = [&](QLabel* text, const char* name, int line) {
    text->setObjectName(QLatin1String(name));
    text->setForegroundRole(QPalette::PlaceholderText);
    text->hide();
    layout->addWidget(text, line, 1, 1, 2);
  };
  const int below = line_of(entries.size());
  add_below(folded_text_, "checks_folded", below);
  add_below(anyway_text_, "start_anyway_text", below + 1);
  anyway_->hide();
  layout->addWidget(anyway_, below + 1, 3);
}

/// High enough for reasons of several lines, also beside a scroll bar: else one that is there would stay for ever.
QSize CheckList::sizeHint() const {
  const QSize hint = list_->sizeHint();
  const int beside_bar = width() - scroll_->verticalScrollBar()->sizeHint().width();
  return {hint.width(), beside_bar > 0 ? list_->layout()->totalHeightForWidth(beside_bar) : hint.height()};
}

void CheckList::show_checks(const std::vector<app::Check>& checks, bool every_line) {
  checks_ = checks;
  every_line_ = every_line;
  dress();
}

/// Whether the list with every line would take half of the room that it has with the arena. Reasons wrap.
bool CheckList::is_crowded() const {
  const auto* grid = static_cast<QGridLayout*>(list_->layout());
  const int least = anyway_->sizeHint().height();
  int height = least + grid->verticalSpacing();  // the button below
  int beside = 0;
  for (const Row& row : rows_) beside = std::max(beside, row.title->sizeHint().width() + row.mend->sizeHint().width());
  const QMargins around = grid->contentsMargins();
  const int width = this->width() - beside - rows_.front().mark->minimumWidth() - 3 * grid->horizontalSpacing() -
                    around.left() - around.right();
  for (const Row& row : rows_)
    height += std::max(least, row.reason->heightForWidth(std::max(1, width))) + grid->verticalSpacing();
  return parentWidget() && 2 * height > parentWidget()->height();
}

/// A line that holds, in little room.
void CheckList::show_line(const Row& row, bool shown) {
  for (QLabel* label : {row.mark, row.title, row.reason}) label->setVisible(shown);
  QSizePolicy policy = row.mend->sizePolicy();
  if (policy.retainSizeWhenHidden() == shown) return;
  policy.setRetainSizeWhenHidden(shown);
  row.mend->setSizePolicy(policy);
}

void CheckList::show_tags(const std::vector<app::UnseenTag>& tags, std::optional<double> size) {
  const bool had_button = tag_size_->isVisibleTo(this);
  tag_size_->setVisible(size.has_value());
  if (size && size_ != *size) {
    size_ = *size;
    const QString edge = QString::number(1000 * size_);
    tag_size_->setText(tr("Set tag size %1 mm").arg(edge));
    tag_size_->setAccessibleName(tr("%1: %2").arg(tr("All tags seen"), tag_size_->text()));
    tag_size_->setToolTip(
        tr("Measure the black edge of a tag first. If it has %1 mm: writes size = %2 below [tags] into "
           "the experiment's file, and sets the experiment up again; the editor opens, where that can "
           "be undone")
            .arg(edge)
            .arg(size_));
  }
  std::vector<std::shared_ptr<const app::Picture>> now;
  now.reserve(tags.size());
  for (const app::UnseenTag& tag : tags) now.push_back(tag.picture);
  if (now != pictured_) {
    pictured_ = std::move(now);
    show_pictures(tags);
  }
  if (had_button == tag_size_->isVisibleTo(this)) return;
  keep_lines_whole();
  updateGeometry();
}

/// A picture and the number of its robot for each of these.
void CheckList::lay_out_pictures(const std::vector<std::size_t>& robots) {
  QLayout* const layout = pictures_->layout();
  while (QLayoutItem* const old = layout->takeAt(0)) {
    delete old->widget();
    delete old;
  }
  tag_pictures_.clear();
  for (const std::size_t robot : robots) {
    auto* cell = new QWidget(pictures_);
    auto* picture = new QLabel(cell);
    picture->setObjectName(QStringLiteral("tag_picture_%1").arg(robot + 1));
    auto* whose = new QLabel(QString::number(robot + 1), cell);
    whose->setForegroundRole(QPalette::PlaceholderText);
    auto* beside = new QHBoxLayout(cell);
    beside->setContentsMargins(0, 0, 0, 0);
    beside->addWidget(picture);
    beside->addWidget(whose);
    layout->addWidget(cell);
    tag_pictures_.push_back({robot, picture});
  }
}

/// They are taken anew every few seconds: where it is the same robots that are not seen, nothing moves.
void CheckList::show_pictures(const std::vector<app::UnseenTag>& tags) {
  std::vector<std::size_t> robots, shown;
  for (std::size_t i = 0; i < tags.size(); ++i)
    if (tags[i].picture) robots.push_back(i);
  for (const TagPicture& one : tag_pictures_) shown.push_back(one.robot);
  if (robots != shown) lay_out_pictures(robots);
  for (const auto& [robot, picture] : tag_pictures_) {
    const app::UnseenTag& tag = tags[robot];
    picture->setPixmap(QPixmap::fromImage(image_of(tag, picture_height)));
    const bool there = tag.why != core::NotSeen::not_found;
    const QString what =
        (there ? tr("Tag %1 of robot %2, as the camera shows it") : tr("Where tag %1 of robot %2 was last seen"))
            .arg(tag.tag)
            .arg(robot + 1);
    picture->setAccessibleName(what);
    picture->setToolTip(QStringLiteral("<b>%1</b><br>%2").arg(what.toHtmlEscaped(), html_of(tag)));
  }
  pictures_->setVisible(!robots.empty());
  keep_lines_whole();
  updateGeometry();
  if (shown.empty()) scroll_to_amiss();
}

void CheckList::dress() {
  const Colours c = colours(palette());
  for (const app::Check& check : checks_)
    if (QLabel* reason = rows_[static_cast<std::size_t>(check.what)].reason;
        reason->text() != QString::fromStdString(check.reason))
      reason->setText(QString::fromStdString(check.reason));
  crowded_ = is_crowded();
  const bool all_lines = every_line_ || app::all_hold(checks_) || !crowded_;
  int folded = 0;
  for (const app::Check& check : checks_) {
    const Row& row = rows_[static_cast<std::size_t>(check.what)];
    using State = app::Check::State;
    const auto [colour, mark, verdict, fails] = [&]() -> std::tuple<QColor, QString, QString, bool> {
      switch (check.state) {
        case State::holds:
          return {c.good, QStringLiteral("✓"), tr("holds"), false};
        case State::waits:
          return {c.faint_text, QStringLiteral("…"), tr("waits"), false};
        case State::fails:
          break;
      }
      return check.hard ? std::tuple(c.alarm, QStringLiteral("✗"), tr("fails"), true)
                        : std::tuple(c.warning, QStringLiteral("!"), tr("may be overruled"), true);
    }();
    const QString shown = QStringLiteral("<b style=\"color:%1\">%2</b>").arg(colour.name(), mark);
    if (row.mark->text() != shown) row.mark->setText(shown);
    const QString reason = QString::fromStdString(check.reason);
    const QString told = QStringLiteral("%1, %2: %3").arg(row.title->text(), verdict, reason);
    if (row.reason->accessibleName() != told) row.reason->setAccessibleName(told);
    if (row.reason->toolTip() != reason) row.reason->setToolTip(reason);
    row.mend->setVisible(fails && check.button);
    const bool is_folded = !all_lines && check.state == State::holds;
    show_line(row, !is_folded);
    if (is_folded) ++folded;
  }
  folded_text_->setText(tr("%1 other checks hold (Ctrl+L shows them)").arg(folded));
  folded_text_->setVisible(folded > 0);
  const bool may_be_overruled = app::may_start(checks_) && !app::all_hold(checks_);
  anyway_text_->setVisible(may_be_overruled);
  anyway_->setVisible(may_be_overruled);
  keep_lines_whole();
  updateGeometry();
  const auto fails = [](const app::Check& check) { return check.state == app::Check::State::fails; };
  const auto first = std::find_if(checks_.begin(), checks_.end(), fails);
  const auto amiss = first == checks_.end() ? std::nullopt : std::optional(first->what);
  if (amiss == std::exchange(amiss_, amiss)) return;
  scrolled_ = false;
  scroll_to_amiss();
}

/// Once the rows have their places.
void CheckList::scroll_to_amiss() {
  if (!amiss_ || scrolled_) return;
  const Row& row = rows_[static_cast<std::size_t>(*amiss_)];
  QWidget* const highest = row.mend;
  QTimer::singleShot(0, this, [this, highest] {
    if (amiss_ == What::tags && !pictures_->isHidden()) scroll_->ensureWidgetVisible(pictures_, 0, 4);
    scroll_->ensureWidgetVisible(highest, 0, 4);
  });
}

/// What has no room is scrolled to: without this the lines would be squeezed, since they wrap.
void CheckList::keep_lines_whole() {
  const int width = scroll_->viewport()->width();
  list_->setMinimumHeight(std::max(0, list_->layout()->totalHeightForWidth(width)));
}

void CheckList::resizeEvent(QResizeEvent* event) {
  if (crowded_ != is_crowded()) dress();
  keep_lines_whole();
  if (event->size().width() != event->oldSize().width()) updateGeometry();
  scroll_to_amiss();
  QWidget::resizeEvent(event);
}

void CheckList::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) dress();
  QWidget::changeEvent(event);
}

}  // namespace skein::ui
