#pragma once

#include <QAbstractTableModel>
#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QSortFilterProxyModel>
#include <QTableView>
#include <QTimer>
#include <deque>
#include <vector>

#include "app/run/status.h"
#include "app/run/tick_record.h"
#include "ui/base/modes.h"

namespace skein::ui {

/// What happened, newest last: in sentences, with the CSV's word in the tip.
class EventModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  static constexpr int capacity = 2000;
  enum Column { time, level, event, columns };
  enum Role { time_role = Qt::UserRole, severity_role };

  using QAbstractTableModel::QAbstractTableModel;
  void clear();
  /// `word`: as the CSV has it; empty: it is not in the CSV.
  void add(double t, const QString& text, Severity severity, const QString& word);
  void set_colours(const Colours& colours) { colours_ = colours; }

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override { return parent.isValid() ? 0 : columns; }
  QVariant data(const QModelIndex& index, int role) const override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;

 private:
  struct Line {
    double t;
    QString text;
    Severity severity;
    QString word;
  };
  std::deque<Line> lines_;
  Colours colours_;
};

/// Filters events by severity and by the words searched for.
class EventFilter final : public QSortFilterProxyModel {
  Q_OBJECT

 public:
  using QSortFilterProxyModel::QSortFilterProxyModel;
  void set_least(Severity least);
  void set_words(const QString& words);

 protected:
  bool filterAcceptsRow(int row, const QModelIndex& parent) const override;

 private:
  void begin_change();
  void end_change();

  Severity least_ = Severity::note;
  QString words_;
};

/// The log as a list that follows its end, unless the operator has scrolled up to read. A long sentence takes several
/// lines: none is cut off.
class EventLog final : public QTableView {
  Q_OBJECT

 public:
  explicit EventLog(QWidget* parent = nullptr);
  void note(double t, const QString& text, Severity severity, const QString& word = {});
  void clear() { model_.clear(); }
  EventFilter& filter() { return filter_; }
  const EventModel& events() const { return model_; }
  QSize sizeHint() const override { return {300, 120}; }
  QSize minimumSizeHint() const override { return {120, 40}; }

 signals:
  void time_picked(double t);  ///< of the event that was double-clicked, or on which Return was pressed [s]

 protected:
  void changeEvent(QEvent*) override;
  void keyPressEvent(QKeyEvent*) override;

 private:
  void fit_rows(int first, int last);  // their heights to their sentences

  EventModel model_;
  EventFilter filter_;
  QTimer narrowed_;  // or widened, a moment ago
};

/// The log with its filter above it.
class EventPanel final : public QWidget {
  Q_OBJECT

 public:
  explicit EventPanel(QWidget* parent = nullptr);
  void show_record(const app::TickRecord& record, const std::vector<app::RobotStatus>& robots = {});
  void note(double t, const QString& text, Severity severity) { log_->note(t, text, severity); }
  void clear() { log_->clear(); }

 signals:
  void time_picked(double t);

 private:
  QComboBox* level_;
  QLineEdit* words_;
  EventLog* log_;
};

}  // namespace skein::ui
