#pragma once

#include <QPointer>
#include <functional>
#include <memory>
#include <optional>

#include "app/tools/robot_setup_work.h"
#include "ui/connect/connect_page.h"
#include "ui/main/messages.h"

namespace skein::ui {

class EditorController;

/// The page on which robots are set up, and the work that it requests. A robot has one user at a time: the open
/// experiment releases its robots before the page takes them, and is opened again when the page is closed and its work
/// has ended.
class ConnectController final : public QObject {
  Q_OBJECT

 public:
  ConnectController(Runs& runs, EditorController& editor, const Messages& messages, QObject* parent = nullptr);
  ~ConnectController() override;  ///< stops robots that drive, and waits for them

  void show();
  /// Ends whatever is under way; robots that drive are stopped at once.
  void stop() noexcept;
  bool is_working() const { return work_ || waiting_; }
  /// Stops, and calls this once no robot is in use: at once if none is.
  void end_then(std::function<void()> next);
  /// The window closes: the experiment is not opened again.
  void close(std::function<void()> next);
  /// Without a window: stops, and waits for the robots.
  void close_now();
  void refresh();  ///< thirty times a second

 signals:
  void session_ends();  ///< references to its parts must be dropped
  void experiment_wanted(const skein::app::Experiment& experiment);

 private:
  void begin(app::SetupTask::Kind kind);
  void start(app::SetupTask task);
  void show_news(const app::SetupNews& news);
  void tell_end(const app::SetupNews& news);
  void give_back();
  void add();
  void save();
  void show_experiment();
  void show_robots();
  void say(const QString& text, Severity severity);
  /// The chosen rows for which this is possible; `why`: the reason if there are none.
  std::vector<std::pair<std::size_t, app::RobotSetup>> chosen_for(app::SetupTask::Kind kind, QString& why) const;

  Runs& runs_;
  LiveRun& live_;
  EditorController& editor_;
  const Messages& messages_;
  QPointer<ConnectPage> page_;
  std::vector<app::RobotSetup> robots_;
  std::optional<app::SetupTask> waiting_;  // until the session has released the robots
  std::unique_ptr<app::SetupWork> work_;
  app::SetupTask::Kind kind_ = app::SetupTask::Kind::scan;
  std::size_t asked_ = 0, good_ = 0;  // robots of this work
  bool stopped_ = false;              // by the operator
  bool borrowed_ = false;             // the experiment was ended for the page
  std::function<void()> next_;
};

}  // namespace skein::ui
