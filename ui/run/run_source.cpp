#include "ui/run/run_source.h"

namespace skein::ui {

void note_holds(const app::TickRecord& record, std::set<int>& held) {
  for (const app::Event& event : record.events) {
    if (const auto* const hold = std::get_if<app::events::Hold>(&event)) held.insert(static_cast<int>(hold->robot));
    if (const auto* const released = std::get_if<app::events::Release>(&event))
      held.erase(static_cast<int>(released->robot));
  }
}

}  // namespace skein::ui
