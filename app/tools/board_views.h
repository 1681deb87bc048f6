#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/calibrate/intrinsics.h"
#include "vision/calibration/board.h"
#include "vision/frames/frame_source.h"

namespace skein::app {

/// Views of a calibration board, collected frame by frame: those that show the board in a new place or orientation.
/// Of single images that is every one but copies, and those between which nobody moved the board.
class BoardViews {
 public:
  /// `live`: a camera, which is watched until there are enough views. From a film, which ends by itself, more views are
  /// kept.
  BoardViews(const vision::Board& board, const vision::FrameSource& source, bool live);

  enum class FrameKind {
    view,        ///< kept
    known,       ///< the board as in an earlier view
    no_board,    ///< none is seen
    other_size,  ///< not of the size of the first frame with a board: skipped
  };
  static constexpr bool is_kept(FrameKind kind) noexcept {
    switch (kind) {
      case FrameKind::view:
        return true;
      case FrameKind::known:
      case FrameKind::no_board:
      case FrameKind::other_size:
        return false;
    }
    return false;
  }
  /// The error: the board detector's module is missing.
  tl::expected<FrameKind, std::string> add(const vision::Frame& frame);

  const std::vector<vision::BoardCorner>& newest() const noexcept { return newest_; }  ///< corners of the last frame
  std::vector<vision::BoardView>& views() noexcept { return views_; }
  const std::optional<vision::Coverage>& coverage() const noexcept { return coverage_; }  ///< none before any frame
  std::int64_t frames() const noexcept { return frames_; }

 private:
  vision::Board board_;
  double step_;  // from one view to the next, in picture widths
  std::vector<vision::BoardCorner> newest_;
  std::vector<vision::BoardView> views_;
  std::optional<vision::Coverage> coverage_;
  std::int64_t frames_ = 0;
};

}  // namespace skein::app
