#include "ui/editor/toml_text.h"

#include <QFontDatabase>
#include <QHelpEvent>
#include <QRegularExpression>
#include <QTextBlock>
#include <QToolTip>
#include <algorithm>

namespace skein::ui {

void TomlColours::set_colours(const Colours& colours) {
  colours_ = colours;
  rehighlight();
}

void TomlColours::highlightBlock(const QString& text) {
  // The first that fits at a place wins: a # in a string is no comment.
  static const QRegularExpression token(QStringLiteral(
      "(?<string>\"(?:[^\"\\\\]|\\\\.)*\"|'[^']*')|(?<comment>#.*$)|(?<table>^\\s*\\[\\[?[^\\]#]*\\]\\]?)"
      "|(?<key>[A-Za-z_][\\w.-]*(?=\\s*=))|(?<number>(?<![\\w.])[+-]?\\d[\\d_.]*(?:[eE][+-]?\\d+)?)"
      "|(?<word>\\b(?:true|false|inf|nan)\\b)"));
  const auto dress = [this](const QRegularExpressionMatch& match, const char* name, const QColor& colour, bool bold) {
    const auto group = QString::fromLatin1(name);
    if (match.capturedStart(group) < 0) return;
    QTextCharFormat format;
    format.setForeground(colour);
    if (bold) format.setFontWeight(QFont::Bold);
    setFormat(static_cast<int>(match.capturedStart(group)), static_cast<int>(match.capturedLength(group)), format);
  };
  for (auto matches = token.globalMatch(text); matches.hasNext();) {
    const QRegularExpressionMatch match = matches.next();
    dress(match, "comment", colours_.faint_text, false);
    dress(match, "string", colours_.good, false);
    dress(match, "table", colours_.notice, true);
    dress(match, "key", colours_.text, true);
    dress(match, "number", colours_.warning, false);
    dress(match, "word", colours_.warning, true);
  }
}

TomlText::TomlText(QWidget* parent) : QPlainTextEdit(parent), highlighter_(new TomlColours(document())) {
  QFont fixed = QFontDatabase::systemFont(QFontDatabase::FixedFont);
  fixed.setPointSizeF(std::max(9.0, font().pointSizeF()));
  setFont(fixed);
  setLineWrapMode(NoWrap);
  setTabChangesFocus(true);
  highlighter_->set_colours(colours(palette()));
}

void TomlText::show_problems(const std::vector<app::Problem>& problems) {
  marks_.clear();
  for (const app::Problem& problem : problems) {
    if (problem.line < 1) continue;
    const QTextBlock block = document()->findBlockByNumber(std::min(problem.line, document()->blockCount()) - 1);
    const int start = std::clamp(problem.column - 1, 0, std::max(0, block.length() - 1));
    QTextCursor where(block);
    where.movePosition(QTextCursor::NextCharacter, QTextCursor::MoveAnchor, start);
    // To the end of the word, or of what stands before a comment.
    static const QRegularExpression stretch(QStringLiteral("\"[^\"]*\"?|[^\\s,#\\]}]+"));
    const auto match = stretch.match(block.text(), start);
    const auto length = match.hasMatch() ? match.capturedEnd() - start : 1;
    where.movePosition(QTextCursor::NextCharacter, QTextCursor::KeepAnchor, static_cast<int>(length));
    if (!where.hasSelection()) {  // at the end of a line: the character before it
      where.movePosition(QTextCursor::PreviousCharacter, QTextCursor::KeepAnchor);
    }
    marks_.push_back({where, QString::fromStdString(problem.text)});
  }
  draw_marks();
}

void TomlText::draw_marks() {
  const Colours c = colours(palette());
  QList<QTextEdit::ExtraSelection> selections;
  for (const Mark& mark : marks_) {
    QTextEdit::ExtraSelection selection;
    selection.cursor = mark.where;
    selection.format.setUnderlineStyle(QTextCharFormat::WaveUnderline);
    selection.format.setUnderlineColor(c.alarm);
    QColor tint = c.alarm;
    tint.setAlpha(40);
    selection.format.setBackground(tint);
    selections << selection;
  }
  setExtraSelections(selections);
}

void TomlText::go_to(int line, int column) {
  QTextCursor cursor(document()->findBlockByNumber(std::max(0, line - 1)));
  cursor.movePosition(QTextCursor::NextCharacter, QTextCursor::MoveAnchor, std::max(0, column - 1));
  setTextCursor(cursor);
  centerCursor();
  setFocus();
}

bool TomlText::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QPlainTextEdit::event(event);
  const auto* help = static_cast<QHelpEvent*>(event);
  const int position = cursorForPosition(viewport()->mapFromGlobal(help->globalPos())).position();
  QString why;
  for (const Mark& mark : marks_)
    if (position >= mark.where.selectionStart() && position <= mark.where.selectionEnd()) why = mark.why;
  QToolTip::showText(help->globalPos(), why, this);
  return true;
}

void TomlText::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) {
    highlighter_->set_colours(colours(palette()));
    draw_marks();
  }
  QPlainTextEdit::changeEvent(event);
}

}  // namespace skein::ui
