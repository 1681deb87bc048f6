#pragma once

#include <cstdlib>

/// Whether this fault is switched on: SKEIN_MUTANT=7 in the environment is the seventh. Only in scripts/mutants'
/// scratch copy.
inline bool skein_mutant(int number) noexcept {
  static const int chosen = [] {
    const char* const text = std::getenv("SKEIN_MUTANT");
    return text ? std::atoi(text) : 0;
  }();
  return chosen == number;
}
