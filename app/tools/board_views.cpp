#include "app/tools/board_views.h"

#include <utility>

namespace skein::app {
namespace {

constexpr double live_step = 0.03, film_step = 0.0025;

}  // namespace

BoardViews::BoardViews(const vision::Board& board, const vision::FrameSource& source, bool live)
    : board_(board),
      step_(source.stills() ? 0.0
            : live          ? live_step
                            : film_step) {}

tl::expected<BoardViews::FrameKind, std::string> BoardViews::add(const vision::Frame& frame) {
  ++frames_;
  newest_.clear();
  if (!coverage_) coverage_.emplace(frame.width, frame.height);
  const bool other_size = frame.width != coverage_->width || frame.height != coverage_->height;
  if (other_size && !views_.empty()) return FrameKind::other_size;
  auto corners = vision::find_board(frame, board_);
  if (!corners) return tl::unexpected(corners.error());
  if (corners->empty()) return FrameKind::no_board;
  if (other_size) coverage_.emplace(frame.width, frame.height);  // until now no picture showed the board
  newest_ = *corners;
  vision::BoardView view{frame.source, std::move(*corners)};
  if (step_ > 0.0 && !vision::is_new_view(views_, view, step_ * frame.width)) return FrameKind::known;
  coverage_->add(view);
  views_.push_back(std::move(view));
  return FrameKind::view;
}

}  // namespace skein::app
