#pragma once

#include <string>
#include <string_view>

namespace skein::app {

inline constexpr std::string_view version = SKEIN_VERSION;  ///< as released: "0.1.0"

/// The commit that the program was built from, "549ce1f0a1b2"; with "+changes" if files differed from it, empty if not
/// known. Only programs (app/program) set it, so that a commit does not recompile the rooms.
std::string_view commit() noexcept;
/// `text` outlives the program. Before any thread.
void set_commit(std::string_view text) noexcept;

/// "0.1.0 (549ce1f0a1b2)".
std::string version_and_commit();

}  // namespace skein::app
