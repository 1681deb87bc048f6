#pragma once

#include <QDateTime>
#include <QString>
#include <optional>

namespace skein::ui {

/// A text that nobody has saved yet, kept beside the user's data until somebody does: it outlives a program that is
/// killed, and a machine that loses its power.
class Draft final {
 public:
  /// `of`: the file that it will be saved to, or anything else that says which text it is.
  explicit Draft(const QString& of);
  struct Kept {
    QString text;
    QDateTime at;
  };
  std::optional<Kept> kept() const;
  /// Without a word where that is not possible: nobody asked for it.
  void keep(const QString& text) const;
  void forget() const;

 private:
  QString file_;
};

}  // namespace skein::ui
