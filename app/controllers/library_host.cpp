#include "app/controllers/library_host.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#define SKEIN_CLIENT
#include "app/controllers/skein_controller.h"
#include "app/run/exit_status.h"

namespace skein::app {
namespace {

int refuse(skein_memory& memory, const std::string& why) {
  std::memset(memory.refusal, 0, sizeof memory.refusal);
  std::memcpy(memory.refusal, why.data(), std::min(why.size(), sizeof memory.refusal - 1));
  skein_ready();
  return wrong_input;
}

}  // namespace

int host_library(const std::string& path) {
  skein_memory* const memory = skein_attach();
  if (!memory) {
    fmt::print(stderr, "skein: controller-host is started by a run, with its memory as file {}\n", SKEIN_MEMORY_FD);
    return wrong_input;
  }
  void* const library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) return refuse(*memory, fmt::format("controller.library: {}", ::dlerror()));
  const auto function = reinterpret_cast<skein_controller_function>(::dlsym(library, "skein_controller_v1"));
  if (!function)
    return refuse(*memory, fmt::format("controller.library: {} has no function skein_controller_v1", path));
  const skein_controller* const controller = function();
  if (!controller || controller->version != SKEIN_CONTROLLER_VERSION || !controller->step)
    return refuse(*memory, fmt::format("controller.library: {} is not for version {}", path, SKEIN_CONTROLLER_VERSION));

  // More than there is room for is refused by the run, which sees the numbers.
  if (controller->parameters) {
    memory->parameters = controller->parameter_count;
    std::copy_n(controller->parameters, std::min<std::uint32_t>(memory->parameters, SKEIN_PARAMETERS),
                memory->parameter);
    memory->declared = 1;
  }
  if (controller->logs) {
    memory->logs = controller->log_count;
    for (std::uint32_t k = 0; k < std::min<std::uint32_t>(memory->logs, SKEIN_LOGS); ++k)
      std::strncpy(memory->log_name[k], controller->logs[k], sizeof memory->log_name[k] - 1);
  }
  skein_ready();
  void* state = nullptr;
  bool open = false;
  while (const std::uint64_t question = skein_wait(memory)) {
    if (!open && controller->open) state = controller->open(memory);
    open = true;
    controller->step(state, memory);
    skein_answer(memory, question);
  }
  if (open && controller->close) controller->close(state);
  return done;
}

}  // namespace skein::app
