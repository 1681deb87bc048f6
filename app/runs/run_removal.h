#pragma once

#include <string>

#include <tl/expected.hpp>

namespace skein::app {

/// Removes a kept run with all its files, run.json last: a run that could be removed in part only is still listed. The
/// error says what cannot be removed, or that a program is writing the run. Of a link to a run only the link is
/// removed.
tl::expected<void, std::string> remove_run(const std::string& folder);

}  // namespace skein::app
