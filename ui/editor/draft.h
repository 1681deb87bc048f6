#pragma once

#include <QDateTime>
#include <QString>
#include <optional>

namespace skein::ui {

/// A text that is not saved yet, kept with the user's data until it is: it survives a killed program and a power
/// failure.
class Draft final {
 public:
  /// `of`: the file to which it will be saved, or anything else that identifies the text.
  explicit Draft(const QString& of);
  struct Kept {
    QString text;
    QDateTime at;
  };
  std::optional<Kept> kept() const;
  /// Fails silently: the operator did not ask for it.
  void keep(const QString& text) const;
  void forget() const;

 private:
  QString file_;
};

}  // namespace skein::ui
