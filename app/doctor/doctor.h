#pragma once

#include <string>
#include <vector>

#include "app/doctor/finding.h"
#include "app/doctor/machine.h"

namespace skein::app {

/// All checks, in the order in which problems should be fixed. Takes slightly longer than `seconds`.
std::vector<Finding> examine(const Machine& machine, const Examination& examination);

/// A line: "well  real-time priority: up to 25".
std::string as_line(const Finding& finding);

}  // namespace skein::app
