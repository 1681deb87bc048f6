#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <toml++/toml.h>

#include "app/experiment/problem.h"

namespace skein::app {

/// What users write in TOML.
enum class FileKind { experiment, study, calibration, robots, marks, faults };

constexpr std::string_view word(FileKind kind) noexcept {
  switch (kind) {
    case FileKind::experiment:
      return "an experiment (`skein run`)";
    case FileKind::study:
      return "a study (`skein sweep`)";
    case FileKind::calibration:
      return "a calibration (`skein calibrate`)";
    case FileKind::robots:
      return "a file of robots (`skein robots`)";
    case FileKind::marks:
      return "marks on the floor (`skein calibrate floor`)";
    case FileKind::faults:
      return "faults (`skein emulate`)";
  }
  return {};
}

/// The one problem of a document that is plainly of another kind than the one that it is read as, such as a study that
/// `skein run` is given: without it each of its keys would be unknown. None: its own reader says what is wrong.
std::optional<Problem> check_kind(const toml::table& document, const std::string& file, FileKind read_as);

}  // namespace skein::app
