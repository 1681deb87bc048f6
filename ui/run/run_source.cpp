#include "ui/run/run_source.h"

#include <algorithm>
#include <limits>

namespace skein::ui {

void note_parameters(const app::TickRecord& record, std::vector<app::LawParameter>& parameters) {
  constexpr double any = std::numeric_limits<double>::infinity();
  for (const app::Event& event : record.events) {
    const auto* const change = std::get_if<app::events::Parameter>(&event);
    if (!change) continue;
    const auto known = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const app::LawParameter& p) { return p.name == change->name.text(); });
    if (known != parameters.end())
      known->value = change->to;
    else
      parameters.push_back({std::string(change->name.text()), {}, {}, -any, any, change->to});
  }
}

}  // namespace skein::ui
