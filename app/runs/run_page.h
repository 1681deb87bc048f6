#pragma once

#include <vector>

#include "app/page/report_page.h"
#include "app/session/tag_crops.h"

namespace skein::app {

/// The page of a recorded run; a kept run's also says when, where and by which program it was made. `folder`: of the
/// kept run, empty for a CSV. `crops`: those of a run that is not kept, whose files are beside its CSV. The error as
/// report_page's.
tl::expected<Page, std::string> page_of_run(const std::string& csv, const std::string& folder,
                                            const std::vector<TagCrop>& crops = {});

}  // namespace skein::app
