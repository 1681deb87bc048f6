#include "ui/connect/connect_page.h"

#include <QAccessible>
#include <QEvent>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QStyledItemDelegate>
#include <QVBoxLayout>
#include <algorithm>

#include "ui/base/dialogs.h"

namespace skein::ui {
namespace {

/// Room around each text; the next step keeps its colour and its background in a row that is chosen, to be read.
class Roomy final : public QStyledItemDelegate {
 public:
  using QStyledItemDelegate::QStyledItemDelegate;
  QSize sizeHint(const QStyleOptionViewItem& option, const QModelIndex& index) const override {
    constexpr int beside = 8, above = 8;
    return QStyledItemDelegate::sizeHint(option, index) + QSize(beside, above);
  }

 protected:
  void initStyleOption(QStyleOptionViewItem* option, const QModelIndex& index) const override {
    QStyledItemDelegate::initStyleOption(option, index);
    if (index.column() == ConnectModel::verdict && (option->state & QStyle::State_Selected) != 0) {
      option->state &= ~QStyle::State_Selected;
      option->backgroundBrush = option->palette.base();
    }
    option->palette.setBrush(QPalette::HighlightedText, option->palette.brush(QPalette::Text));
  }
};

}  // namespace

ConnectPage::ConnectPage(QWidget* parent)
    : QDialog(parent),
      table_(new QTableView(this)),
      adapter_(new QLineEdit(this)),
      scan_(
          button(tr("Scan"), "connect_scan", tr("Searches for e-pucks by Bluetooth, 12 s, as skein robots scan does"))),
      pair_(button(tr("Pair"), "connect_pair", tr("Pairs this PC with the chosen robots, and enters their PIN"))),
      ping_(button(tr("Ping"), "connect_ping",
                   tr("Asks the chosen robots for 4 s whether and how soon they answer, and for battery and firmware; "
                      "no robot drives"))),
      test_(button(tr("Test wheels and tag …"), "connect_test",
                   tr("Drives the chosen robots, one after the other, and tests wheels and tag; asks first"))),
      stop_(button(tr("Stop"), "connect_stop", tr("Ends what is being done; robots that drive are stopped at once"))),
      add_(button(tr("Add to the experiment …"), "connect_add",
                  tr("Opens the experiment in the editor with the chosen robots that are not in it yet"))),
      save_(button(tr("Save to the file of robots"), "connect_save",
                   tr("Adds the chosen real robots to robots.toml, with what their test has measured"))),
      question_(new QFrame(this)),
      details_(new QLabel(this)),
      status_(new QLabel(this)) {
  setObjectName(QStringLiteral("connect_page"));
  setWindowTitle(tr("Connect robots"));
  setAttribute(Qt::WA_DeleteOnClose);
  setModal(false);  // STOP can be clicked beside it
  adapter_->setObjectName(QStringLiteral("connect_adapter"));
  adapter_->setAccessibleName(tr("Bluetooth adapter"));
  adapter_->setPlaceholderText(tr("all"));
  adapter_->setToolTip(tr("Of this PC, for Scan and Pair: hci1, or its address; empty: all"));
  adapter_->setMaximumWidth(fontMetrics().horizontalAdvance(QStringLiteral("00:00:00:00:00:00")) + 16);
  table_->setObjectName(QStringLiteral("connect_robots"));
  table_->setAccessibleName(tr("Robots, what is known of each, and its next step"));
  table_->setModel(&robots_);
  table_->setItemDelegate(new Roomy(table_));
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setSelectionMode(QAbstractItemView::ExtendedSelection);
  table_->setTabKeyNavigation(false);
  table_->setAlternatingRowColors(true);
  table_->setShowGrid(false);
  table_->verticalHeader()->hide();
  table_->verticalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);  // the next step is a sentence
  table_->horizontalHeader()->setHighlightSections(false);
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
  table_->horizontalHeader()->setSectionResizeMode(ConnectModel::verdict, QHeaderView::Stretch);
  details_->setObjectName(QStringLiteral("connect_details"));
  status_->setObjectName(QStringLiteral("connect_status"));
  for (QLabel* label : {details_, status_}) {
    label->setWordWrap(true);
    label->setTextFormat(Qt::PlainText);
  }
  build_question();

  auto* top = new QHBoxLayout;
  auto* adapter_label = new QLabel(tr("Bluetooth adapter"), this);
  adapter_label->setBuddy(adapter_);
  top->addWidget(adapter_label);
  top->addWidget(adapter_);
  for (QPushButton* next : {scan_, pair_, ping_, test_}) top->addWidget(next);
  top->addStretch();
  top->addWidget(stop_);
  auto* bottom = new QHBoxLayout;
  bottom->addWidget(add_);
  bottom->addWidget(save_);
  bottom->addStretch();
  auto* layout = new QVBoxLayout(this);
  layout->addLayout(top);
  layout->addWidget(question_);
  layout->addWidget(table_, 1);
  layout->addWidget(details_);
  layout->addWidget(status_);
  layout->addLayout(bottom);

  connect(scan_, &QPushButton::clicked, this, &ConnectPage::scan_wanted);
  connect(adapter_, &QLineEdit::returnPressed, this, [this] {
    if (scan_->isEnabled()) emit scan_wanted();
  });
  connect(pair_, &QPushButton::clicked, this, &ConnectPage::pair_wanted);
  connect(ping_, &QPushButton::clicked, this, &ConnectPage::ping_wanted);
  connect(test_, &QPushButton::clicked, this, [this] { ask(true); });
  connect(stop_, &QPushButton::clicked, this, &ConnectPage::stop_wanted);
  connect(add_, &QPushButton::clicked, this, &ConnectPage::add_wanted);
  connect(save_, &QPushButton::clicked, this, &ConnectPage::save_wanted);
  connect(table_->selectionModel(), &QItemSelectionModel::currentRowChanged, this, &ConnectPage::show_details);
  connect(&robots_, &QAbstractItemModel::dataChanged, this, &ConnectPage::show_details);
  robots_.set_colours(colours(palette()));
  show_details();
  set_working(false);
  resize(fitting({1000, 560}, parent));
  close_by_key(this);
  table_->setFocus();
}

QPushButton* ConnectPage::button(const QString& text, const char* name, const QString& tip) {
  auto* made = new QPushButton(text, this);
  made->setObjectName(QLatin1String(name));
  made->setAccessibleName(text);
  made->setToolTip(tip);
  made->setAutoDefault(false);
  return made;
}

/// In the page and not in front of it: it takes neither keyboard nor mouse from STOP.
void ConnectPage::build_question() {
  question_->setObjectName(QStringLiteral("connect_question"));
  question_->setFrameShape(QFrame::StyledPanel);
  auto* text =
      new QLabel(tr("The chosen robots will drive, one after the other: each turns its wheels by 1 cm and, before a "
                    "camera, drives "
                    "6 cm ahead and back and turns by 110 degrees and back. Clear 10 cm around each robot first."),
                 question_);
  text->setObjectName(QStringLiteral("connect_question_text"));
  text->setWordWrap(true);
  drive_ = button(tr("It is clear: drive"), "connect_drive", text->text());
  not_now_ = button(tr("Not now"), "connect_not_now", tr("Nobody drives"));
  for (QPushButton* answer : {drive_, not_now_}) answer->setAccessibleDescription(text->text());
  auto* layout = new QHBoxLayout(question_);
  layout->addWidget(text, 1);
  layout->addWidget(drive_);
  layout->addWidget(not_now_);
  connect(drive_, &QPushButton::clicked, this, [this] {
    ask(false);
    emit test_wanted();
  });
  connect(not_now_, &QPushButton::clicked, this, [this] { ask(false); });
  question_->hide();
}

void ConnectPage::ask(bool on) {
  if (on && chosen().empty())
    return say(tr("Choose robots in the table first (Ctrl+A: all of them)"), Severity::notice);
  question_->setVisible(on);
  if (on)
    not_now_->setFocus();  // who presses a key twice does not drive by it
  else
    table_->setFocus();
}

void ConnectPage::show_robots(const std::vector<app::RobotSetup>& robots, bool camera) {
  robots_.show(robots, camera);
  if (!table_->currentIndex().isValid() && !robots.empty()) choose_all();
}

void ConnectPage::choose_all() {
  table_->setCurrentIndex(robots_.index(0, 0));
  table_->selectAll();
}

void ConnectPage::set_working(bool working) {
  const QWidget* focus = focusWidget();
  if (working) question_->hide();
  if (working) stop_->setEnabled(true);
  if (working && focus != table_) stop_->setFocus();
  if (!working && focus == stop_) table_->setFocus();  // before it is disabled, which would send the keyboard anywhere
  for (QPushButton* next : {scan_, pair_, ping_, test_, add_, save_}) next->setEnabled(!working);
  stop_->setEnabled(working);
}

void ConnectPage::say(const QString& text, Severity severity) {
  said_ = severity;
  QPalette coloured = palette();
  if (severity != Severity::note) coloured.setColor(QPalette::WindowText, colour(severity, colours(palette())));
  status_->setPalette(coloured);
  if (text == status_->text()) return;
  status_->setText(text);
  QAccessibleEvent news(status_, QAccessible::Alert);
  QAccessible::updateAccessibility(&news);
}

std::vector<std::size_t> ConnectPage::chosen() const {
  std::vector<std::size_t> rows;
  for (const QModelIndex& row : table_->selectionModel()->selectedRows())
    rows.push_back(static_cast<std::size_t>(row.row()));
  std::sort(rows.begin(), rows.end());
  return rows;
}

void ConnectPage::show_details() {
  const QString details = robots_.details(table_->currentIndex().row());
  details_->setText(details);
  details_->setVisible(!details.isEmpty());
}

void ConnectPage::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) {
    robots_.set_colours(colours(palette()));
    say(status_->text(), said_);
  }
  QDialog::changeEvent(event);
}

}  // namespace skein::ui
