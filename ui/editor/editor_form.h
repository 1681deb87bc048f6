#pragma once

#include <QWidget>
#include <optional>
#include <string>
#include <vector>

class QComboBox;
class QLineEdit;

namespace skein::ui {

/// The common keys of an experiment as fields. A field that is empty leaves its key to the default, which it shows.
class EditorForm final : public QWidget {
  Q_OBJECT

 public:
  explicit EditorForm(QWidget* parent = nullptr);
  /// The keys of its fields, dotted.
  std::vector<std::string> keys() const;
  /// Shows the keys' values as a text has them; fields being edited are not changed.
  void show_values(const std::vector<std::optional<std::string>>& values);

 signals:
  void set_wanted(const QString& key, const QString& value);  ///< as TOML

 private:
  struct Field {
    QString name;   // of the key, dotted
    bool is_text;   // a TOML string
    QString usual;  // its default
    QLineEdit* line;
    QComboBox* box;  // one of the two
  };
  /// `label` without the unit; `usual` and `unit` are those of the table of keys where the key stands there.
  void add(const char* name, const QString& label, const QString& usual = {}, const QString& unit = {});
  std::vector<Field> fields_;
};

}  // namespace skein::ui
