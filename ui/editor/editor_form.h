#pragma once

#include <QWidget>
#include <functional>
#include <vector>

#include "app/experiment/experiment.h"

class QComboBox;
class QLineEdit;

namespace skein::ui {

/// The common keys of an experiment as fields. A field that is empty leaves its key to the default, which it shows.
class EditorForm final : public QWidget {
  Q_OBJECT

 public:
  explicit EditorForm(QWidget* parent = nullptr);
  /// What the text says; the fields that are being edited are left alone.
  void show_text(const QString& text);

 signals:
  void set_wanted(const QString& key, const QString& value);  ///< as TOML

 private:
  struct Field {
    QString key;
    bool is_text;  // a TOML string
    QLineEdit* line;
    QComboBox* box;  // one of the two
    std::function<QString(const app::Experiment&)> usual;
  };
  std::vector<Field> fields_;
};

}  // namespace skein::ui
