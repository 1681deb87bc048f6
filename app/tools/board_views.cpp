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

tl::expected<BoardViews::Look, std::string> BoardViews::look(const vision::Frame& frame) {
  ++frames_;
  newest_.clear();
  if (!coverage_) coverage_.emplace(frame.width, frame.height);
  if (frame.width != coverage_->width || frame.height != coverage_->height) return Look::other_size;
  auto corners = vision::find_board(frame, board_);
  if (!corners) return tl::unexpected(corners.error());
  if (corners->empty()) return Look::no_board;
  newest_ = *corners;
  vision::BoardView view{frame.source, std::move(*corners)};
  if (step_ > 0.0 && !vision::is_new_view(views_, view, step_ * frame.width)) return Look::known;
  coverage_->add(view);
  views_.push_back(std::move(view));
  return Look::view;
}

}  // namespace skein::app
