#pragma once

#include <QDialog>
#include <QFrame>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTableView>
#include <vector>

#include "ui/base/modes.h"
#include "ui/connect/connect_model.h"

namespace skein::ui {

/// Sets robots up: a table of them with all findings, and buttons for the next step. It does nothing with a robot
/// itself: its signals are requests.
class ConnectPage final : public QDialog {
  Q_OBJECT

 public:
  explicit ConnectPage(QWidget* parent);

  /// `camera`: the experiment has one.
  void show_robots(const std::vector<app::RobotSetup>& robots, bool camera);
  void choose_all();
  /// Something is being done: only Stop can be pressed.
  void set_working(bool working);
  void say(const QString& text, Severity severity);
  std::vector<std::size_t> chosen() const;  ///< rows, in their order
  QString adapter() const { return adapter_->text().trimmed(); }

 signals:
  void scan_wanted();
  void pair_wanted();
  void ping_wanted();
  void test_wanted();  ///< and the operator has confirmed that there is room to drive
  void stop_wanted();
  void add_wanted();
  void save_wanted();

 protected:
  void changeEvent(QEvent*) override;

 private:
  QPushButton* button(const QString& text, const char* name, const QString& tip);
  void build_question();
  void ask(bool on);
  void show_details();

  ConnectModel robots_;
  QTableView* table_;
  QLineEdit* adapter_;
  QPushButton *scan_, *pair_, *ping_, *test_, *stop_, *add_, *save_;
  QFrame* question_;
  QPushButton *drive_ = nullptr, *not_now_ = nullptr;
  QLabel *details_, *status_;
  Severity said_ = Severity::note;
};

}  // namespace skein::ui
