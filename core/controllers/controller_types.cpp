#include "core/controllers/controller_types.h"

#include <array>

#include "core/controllers/independent.h"
#include "core/controllers/kostic.h"
#include "core/controllers/leader_follower.h"
#include "core/controllers/virtual_structure.h"
#include "core/words.h"

namespace skein::core {
namespace {

template <typename Law>
std::unique_ptr<Controller> make(std::size_t robots) {
  return std::make_unique<Law>(robots);
}

const std::array types{
    ControllerType{
        ControllerKind::kostic, "(15): saturated tracking with mutual coupling", {}, {}, make<KosticController>},
    ControllerType{ControllerKind::virtual_structure,
                   "virtual structure with mutual coupling (van den Broek 2009)",
                   VirtualStructureController::parameters,
                   {},
                   make<VirtualStructureController>},
    ControllerType{ControllerKind::leader_follower, "leader and followers by distance and bearing (Desai 2001)",
                   LeaderFollowerController::parameters, LeaderFollowerController::logs,
                   make<LeaderFollowerController>},
    ControllerType{
        ControllerKind::independent, "every robot tracks its own reference", {}, {}, make<IndependentController>},
};
static_assert(std::tuple_size_v<decltype(types)> == all_of<ControllerKind>().size(), "one row a kind, in their order");

}  // namespace

const ControllerType& controller_type(ControllerKind kind) noexcept {
  return types[static_cast<std::size_t>(kind)];
}

}  // namespace skein::core
