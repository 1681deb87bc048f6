#pragma once

#include <string>

namespace skein::app {

/// `skein controller-host LIBRARY`: the process in which a controller that is a shared library runs. Started by a run,
/// never by hand. Returns an ExitStatus.
int host_library(const std::string& path);

}  // namespace skein::app
