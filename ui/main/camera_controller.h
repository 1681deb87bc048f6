#pragma once

#include <QPointer>

#include "ui/camera/camera_page.h"
#include "ui/main/messages.h"

namespace skein::ui {

class EditorController;

/// The page of the cameras: shows a free camera, or the pictures of the run that uses it.
class CameraController final : public QObject {
  Q_OBJECT

 public:
  CameraController(Runs& runs, EditorController& editor, const Messages& messages, QObject* parent = nullptr);
  void show();
  /// A session is about to be opened, which may want the camera.
  void let_go();
  bool wants_picture() const { return page_ && page_->wants_run(); }  ///< of the run
  void show_picture(const app::Picture& picture);

 private:
  void show_camera();
  void put(const CameraPage::Values& values);
  bool run_has_picture() const;

  Runs& runs_;
  LiveRun& live_;
  EditorController& editor_;
  const Messages& messages_;
  QPointer<CameraPage> page_;
};

}  // namespace skein::ui
