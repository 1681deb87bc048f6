#include "app/tools/camera_calibration.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "app/calibration/calibration_file.h"
#include "app/session/picture_copy.h"
#include "app/tools/board_views.h"
#include "app/tools/camera_words.h"
#include "vision/calibrate/intrinsics.h"
#include "vision/calibration/calibration.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

static_assert(CalibrationProgress::columns == vision::Coverage::columns);
static_assert(CalibrationProgress::rows == vision::Coverage::rows);

constexpr std::size_t fewest_views = 4;  // before the first attempt to solve
constexpr std::size_t most_views = 80;   // more only take time

vision::Board board_of(const CalibrationBoard& board) {
  vision::Board all;
  all.kind = board.chessboard ? vision::Board::Kind::chessboard : vision::Board::Kind::charuco;
  all.columns = board.columns;
  all.rows = board.rows;
  all.square = board.square;
  all.marker = board.marker;
  return all;
}

}  // namespace

struct CameraCalibration::Work {
  Work(const CalibratedCamera& camera, const vision::Board& shown)
      : source(camera.source), words{.size = camera.size, .settings = camera.settings}, board(shown) {}

  /// Looks at pictures until they end or are no longer wanted.
  void look(const std::stop_token& stop) {
    if (const std::string wrong = vision::check(board); !wrong.empty()) return end(wrong);
    if (const std::string wrong = wrong_source(source); !wrong.empty()) return end(wrong);
    auto options = words.read(source);
    if (!options) return end(options.error());
    options->keep_waiting = [&stop] { return !stop.stop_requested(); };
    auto opened = vision::open_source(source, *options);
    if (!opened) return end(opened.error());
    BoardViews seen(board, **opened, vision::is_camera(source));
    vision::Frame frame;
    while (!stop.stop_requested()) {
      const auto more = (*opened)->read(frame);
      if (!more) return end(more.error());
      if (!*more) break;
      const auto found = seen.add(frame);
      if (!found) return end(found.error());
      const std::lock_guard lock(mutex);
      copy_pixels(frame, newest);
      fresh = true;
      width = seen.coverage()->width;
      height = seen.coverage()->height;
      frames = seen.frames();
      corners.clear();
      for (const vision::BoardCorner& corner : seen.newest()) corners.push_back({corner.u, corner.v});
      if (BoardViews::is_kept(*found) && views.size() < most_views) {
        views.push_back(seen.views().back());
        changed.notify_all();
      }
    }
    end({});
  }

  void end(const std::string& reason) {
    const std::lock_guard lock(mutex);
    problem = reason;
    over = true;
    changed.notify_all();
  }

  /// Solves again whenever there are other views than at the last time.
  void solve(const std::stop_token& stop) {
    std::unique_lock lock(mutex);
    while (changed.wait(lock, stop, [this] { return solved_of != revision(); })) {
      const auto of = revision();
      const std::vector<vision::BoardView> now = views;
      tl::expected<vision::Intrinsics, std::string> found =
          tl::unexpected(std::string("show the board from more sides"));
      if (now.size() >= fewest_views) {
        const int columns = width, rows = height;
        lock.unlock();
        found = vision::solve_intrinsics(now, columns, rows);
        if (const std::string why = found ? vision::equal_tilts(*found) : ""; !why.empty()) found = tl::unexpected(why);
        lock.lock();
      }
      solved_of = of;
      solved = std::move(found);
      changed.notify_all();
    }
  }

  /// Changes with the views.
  std::pair<std::size_t, int> revision() const { return {views.size(), forgotten}; }

  const std::string source;
  const CameraWords words;
  const vision::Board board;
  mutable std::mutex mutex;  // of all that follows
  std::condition_variable_any changed;
  int width = 0, height = 0, forgotten = 0;
  std::int64_t frames = 0;
  std::vector<std::array<double, 2>> corners;
  std::vector<vision::BoardView> views;
  tl::expected<vision::Intrinsics, std::string> solved = tl::unexpected(std::string("no board has been seen yet"));
  std::pair<std::size_t, int> solved_of{0, 0};
  std::string problem;
  bool over = false, fresh = false;
  Picture newest;
  std::jthread looker, solver;  // last: they use the rest
};

CameraCalibration::CameraCalibration(const CalibratedCamera& camera, const CalibrationBoard& board)
    : work_(std::make_unique<Work>(camera, board_of(board))) {
  Work& work = *work_;
  work.looker = std::jthread([&work](const std::stop_token& stop) {
    try {
      work.look(stop);
    } catch (const std::exception& error) {
      work.end(error.what());
    }
  });
  work.solver = std::jthread([&work](const std::stop_token& stop) { work.solve(stop); });
}

CameraCalibration::~CameraCalibration() = default;

void CameraCalibration::end() {
  work_->looker.request_stop();
  if (work_->looker.joinable()) work_->looker.join();
}

CalibrationProgress CameraCalibration::progress() const {
  const std::lock_guard lock(work_->mutex);
  const Work& work = *work_;
  CalibrationProgress now;
  now.width = work.width;
  now.height = work.height;
  now.frames = work.frames;
  now.corners = work.corners;
  now.problem = work.problem;
  now.over = work.over;
  vision::Coverage coverage(std::max(1, work.width), std::max(1, work.height));
  for (const vision::BoardView& view : work.views) {
    coverage.add(view);
    now.views.push_back({view.source, static_cast<int>(view.corners.size())});
  }
  now.coverage = coverage.corners;
  now.covered = coverage.share();
  if (!work.solved) {
    now.unsolved = work.solved.error();
    return now;
  }
  const vision::Calibration& c = work.solved->calibration;
  now.result = {work.solved->rms, c.fx, c.fy, c.cx, c.cy, work.solved->focal_sigma, work.solved->centre_sigma};
  for (CalibrationProgress::View& view : now.views)
    for (const vision::BoardView& judged : work.solved->views)
      if (judged.source == view.name) {
        view.rms = judged.rms;
        view.outliers = judged.outliers;
        view.left_out = judged.rejected;
      }
  return now;
}

bool CameraCalibration::picture(Picture& out) {
  const std::lock_guard lock(work_->mutex);
  if (!work_->fresh) return false;
  work_->fresh = false;
  out = work_->newest;
  return true;
}

void CameraCalibration::forget(std::size_t view) {
  const std::lock_guard lock(work_->mutex);
  if (view >= work_->views.size()) return;
  work_->views.erase(work_->views.begin() + static_cast<std::ptrdiff_t>(view));
  ++work_->forgotten;
  work_->changed.notify_all();
}

tl::expected<void, std::string> CameraCalibration::save(const std::string& path) const {
  const std::lock_guard lock(work_->mutex);
  if (!work_->solved) return tl::unexpected(work_->solved.error());
  return save_calibration(work_->solved->calibration, path);
}

}  // namespace skein::app
