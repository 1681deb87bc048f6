#pragma once

#include <string>
#include <vector>

#include "vision/frames/frame.h"
#include "vision/modules/page.h"

namespace skein::vision {

/// See Boards.
std::string draw_sheet(const std::vector<Page>& pages, bool pdf, std::string& file);
std::string rasterise_sheet(const Page& page, double px_per_mm, Frame& frame);

}  // namespace skein::vision
