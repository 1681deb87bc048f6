#pragma once

#include "app/page/report_page.h"

namespace skein::app {

/// The page of a recorded run; a kept run's also says when, where and by which program it was made. `folder`: of the
/// kept run, empty for a CSV. The error as report_page's.
tl::expected<Page, std::string> page_of_run(const std::string& csv, const std::string& folder);

}  // namespace skein::app
