#include "app/experiment/controller_spec.h"

#include "core/controllers/controller_types.h"

namespace skein::app {

std::vector<std::string> log_names(const LawSpec& law) {
  if (law.own()) return law.log;
  const auto names = core::controller_type(law.kind).logs;
  return {names.begin(), names.end()};
}

}  // namespace skein::app
