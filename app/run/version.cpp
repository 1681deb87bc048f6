#include "app/run/version.h"

namespace skein::app {
namespace {

std::string_view built_from;

}  // namespace

std::string_view commit() noexcept {
  return built_from;
}

void set_commit(std::string_view text) noexcept {
  built_from = text;
}

std::string version_and_commit() {
  std::string text(version);
  if (!built_from.empty()) text.append(" (").append(built_from).append(")");
  return text;
}

}  // namespace skein::app
