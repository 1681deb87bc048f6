#include "app/tools/board_views.h"

#include <utility>

namespace skein::app {
namespace {

// Of the picture's width: how far the board has moved since all other views. A picture that is there twice, or shows a
// board that nobody has moved, says nothing new: counted as a view, it would only make the deviations too small.
constexpr double live_step = 0.03, film_step = 0.0025, still_step = 0.0002;

}  // namespace

BoardViews::BoardViews(const vision::Board& board, const vision::FrameSource& source, bool live)
    : board_(board),
      step_(source.stills() ? still_step
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
  if (!vision::is_new_view(views_, view, step_ * frame.width)) return FrameKind::known;
  coverage_->add(view);
  views_.push_back(std::move(view));
  return FrameKind::view;
}

}  // namespace skein::app
