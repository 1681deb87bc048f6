#pragma once

#include <QAbstractTableModel>
#include <QTableView>
#include <deque>

#include "app/tick_record.h"
#include "ui/modes.h"

namespace skein::ui {

/// What happened, newest last.
class EventModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  static constexpr int capacity = 2000;

  using QAbstractTableModel::QAbstractTableModel;
  void clear();
  void add(double t, const QString& text, Severity severity);
  void set_colours(const Colours& colours) { colours_ = colours; }

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override { return parent.isValid() ? 0 : 2; }
  QVariant data(const QModelIndex& index, int role) const override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;

 private:
  struct Line {
    double t;
    QString text;
    Severity severity;
  };
  std::deque<Line> lines_;
  Colours colours_;
};

/// The log as a list that follows its end, unless the operator has scrolled up to read.
class EventLog final : public QTableView {
  Q_OBJECT

 public:
  explicit EventLog(QWidget* parent = nullptr);
  void take(const app::TickRecord& record);
  void note(double t, const QString& text, Severity severity);
  void clear() { model_.clear(); }
  QSize sizeHint() const override { return {300, 120}; }
  QSize minimumSizeHint() const override { return {180, 70}; }

 protected:
  void changeEvent(QEvent*) override;
  void keyPressEvent(QKeyEvent*) override;

 private:
  EventModel model_;
};

}  // namespace skein::ui
