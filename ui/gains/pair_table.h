#pragma once

#include <QAbstractTableModel>
#include <QComboBox>
#include <QTableView>
#include <QWidget>
#include <algorithm>
#include <functional>
#include <vector>

#include "core/control/gain_schedule.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// One gain of every pair of robots, as a square: (i, j) and (j, i) are the same cell, as (18c) requires. A cell is
/// ticked if the two are coupled.
class PairModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  struct Pair {
    double target = 0.0, limit = 0.0;
    bool coupled = true;
    friend bool operator==(const Pair&, const Pair&) = default;
  };
  using Ask = std::function<Pair(core::GainName, std::size_t, std::size_t)>;

  using QAbstractTableModel::QAbstractTableModel;
  void show_robots(std::size_t robots);
  void show_gain(core::GainName gain);
  core::GainName gain() const { return gain_; }
  bool refresh(const Ask& ask);  ///< updates every pair's values; whether one has changed
  void set_colours(const Colours& colours);
  void set_fixed(bool fixed) { fixed_ = fixed; }

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override { return rowCount(parent); }
  QVariant data(const QModelIndex& index, int role) const override;
  bool setData(const QModelIndex& index, const QVariant& value, int role) override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;
  Qt::ItemFlags flags(const QModelIndex& index) const override;

 signals:
  void gain_wanted(skein::core::GainName gain, int i, int j, double value);
  void couple_wanted(int i, int j, bool on);
  void refused(const QString& why);

 private:
  Pair& at(std::size_t i, std::size_t j) { return pairs_[std::min(i, j) * robots_ + std::max(i, j)]; }
  const Pair& at(std::size_t i, std::size_t j) const { return pairs_[std::min(i, j) * robots_ + std::max(i, j)]; }

  std::size_t robots_ = 0;
  core::GainName gain_ = core::GainName::k_xx;
  std::vector<Pair> pairs_;
  Colours colours_;
  bool fixed_ = false;
};

/// The square with a choice of the gain above it.
class PairTable final : public QWidget {
  Q_OBJECT

 public:
  explicit PairTable(QWidget* parent = nullptr);
  void show_robots(std::size_t robots);
  void refresh(const PairModel::Ask& ask);
  QAbstractItemView* cells() const { return table_; }
  void set_fixed(bool fixed) { model_.set_fixed(fixed); }  ///< the values can be read, not changed

 signals:
  void gain_wanted(skein::core::GainName gain, int i, int j, double value);
  void couple_wanted(int i, int j, bool on);
  void refused(const QString& why);

 protected:
  void changeEvent(QEvent*) override;
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void keep_values_whole();

  PairModel model_;
  QComboBox* gain_;
  QTableView* table_;
};

}  // namespace skein::ui
