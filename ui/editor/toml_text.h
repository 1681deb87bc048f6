#pragma once

#include <QPlainTextEdit>
#include <QSyntaxHighlighter>
#include <vector>

#include "app/experiment/problem.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// Colours of TOML: tables, keys, strings, numbers, comments.
class TomlColours final : public QSyntaxHighlighter {
  Q_OBJECT

 public:
  explicit TomlColours(QTextDocument* document) : QSyntaxHighlighter(document) {}
  void set_colours(const Colours& colours);

 protected:
  void highlightBlock(const QString& text) override;

 private:
  Colours colours_;
};

/// A TOML text: coloured, with a wavy line under mistakes and their reasons as tool tips.
class TomlText final : public QPlainTextEdit {
  Q_OBJECT

 public:
  explicit TomlText(QWidget* parent = nullptr);
  void show_problems(const std::vector<app::Problem>& problems);
  void go_to(int line, int column);  ///< from 1
  /// How many places have a wavy line.
  int marked() const { return static_cast<int>(marks_.size()); }

 protected:
  bool event(QEvent*) override;
  void changeEvent(QEvent*) override;

 private:
  struct Mark {
    QTextCursor where;
    QString why;
  };
  void draw_marks();

  TomlColours* highlighter_;
  std::vector<Mark> marks_;
};

}  // namespace skein::ui
