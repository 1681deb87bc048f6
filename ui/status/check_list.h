#pragma once

#include <QLabel>
#include <QPushButton>
#include <QScrollArea>
#include <QWidget>
#include <memory>
#include <optional>
#include <vector>

#include "app/session/readiness.h"

namespace skein::ui {

/// The checks before a start, each with its reason and a way to fix it; and the button that overrules those that may be
/// overruled.
class CheckList final : public QWidget {
  Q_OBJECT

 public:
  explicit CheckList(QWidget* parent = nullptr);
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override { return {200, 60}; }
  /// In little room, lines that hold are counted instead of shown, unless `every_line`.
  void show_checks(const std::vector<app::Check>& checks, bool every_line = false);
  /// By robot: its tag that the camera does not see, an empty one where it does. `size`: the tag size that would mend
  /// it [m], see app::fitting_tag_size.
  void show_tags(const std::vector<app::UnseenTag>& tags, std::optional<double> size);

 signals:
  void mend(skein::app::Check::What what);
  void tag_size_wanted(double size);  ///< [m]
  void start_anyway();

 protected:
  void changeEvent(QEvent*) override;
  void resizeEvent(QResizeEvent*) override;

 private:
  struct Row {
    QLabel *mark, *title, *reason;
    QPushButton* mend;
  };
  void dress();
  bool is_crowded() const;
  static void show_line(const Row& row, bool shown);
  struct TagPicture {
    std::size_t robot;
    QLabel* picture;
  };
  void show_pictures(const std::vector<app::UnseenTag>& tags);
  void lay_out_pictures(const std::vector<std::size_t>& robots);
  void keep_lines_whole();
  void scroll_to_amiss();

  std::vector<app::Check> checks_;
  std::vector<Row> rows_;
  QWidget* pictures_;  // of tags that are not seen, below the sentences
  std::vector<std::shared_ptr<const app::Picture>> pictured_;
  std::vector<TagPicture> tag_pictures_;
  QPushButton* tag_size_;
  double size_ = 0.0;  // that it would set [m]
  QLabel *folded_text_, *anyway_text_;
  QPushButton* anyway_;
  bool every_line_ = false, crowded_ = false;
  QScrollArea* scroll_;  // if there is little room
  QWidget* list_;
  std::optional<app::Check::What> amiss_;  // the first failed check, to which the list scrolls
  bool scrolled_ = false;                  // by the operator since: it stays there
};

}  // namespace skein::ui
