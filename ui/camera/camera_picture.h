#pragma once

#include <QImage>
#include <QWidget>
#include <vector>

#include "app/tools/camera_viewer.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// To which robot a tag belongs and whether it is taken, in a few words or, if it is not taken, in a sentence.
QString verdict_on(const app::WatchedTag& tag);
/// "38 px, 40.1 mm".
QString size_of(const app::WatchedTag& tag);
QColor colour_of(app::WatchedTag::State state, const Colours& colours);

/// A camera's picture with every tag in it outlined.
class CameraPicture final : public QWidget {
  Q_OBJECT

 public:
  explicit CameraPicture(QWidget* parent = nullptr);
  void show_view(const app::CameraView& view);
  void clear(const QString& why);      ///< no picture, and the text in its place
  void set_note(const QString& note);  ///< across the picture; empty: nothing
  QSize sizeHint() const override { return {560, 420}; }
  QSize minimumSizeHint() const override { return {280, 210}; }

  struct Text {
    int tag;
    QRectF place;
  };
  const std::vector<Text>& texts() const { return texts_; }  ///< beside the tags, in the last picture

 protected:
  void paintEvent(QPaintEvent*) override;

 private:
  QString told() const;

  QImage picture_;
  std::vector<app::WatchedTag> tags_;
  std::vector<Text> texts_;
  QString why_, note_;
};

}  // namespace skein::ui
