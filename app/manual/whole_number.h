#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <string>

#include <CLI/CLI.hpp>

namespace skein::app {

/// Accepts only a whole number from `low` to `high`: CLI11 itself reads "-1" as a huge number if the type is unsigned.
inline CLI::Validator whole_number(std::int64_t low, std::int64_t high) {
  return {[low, high](const std::string& text) -> std::string {
            std::int64_t value = 0;
            const char* const end = text.data() + text.size();
            const auto [stop, error] = std::from_chars(text.data(), end, value);
            if (error == std::errc{} && stop == end && value >= low && value <= high) return {};
            return fmt::format("found {}, allowed: a whole number from {} to {}", text, low, high);
          },
          fmt::format("INT in [{} - {}]", low, high)};
}

/// Accepts only a number from `low` to `high`: CLI::Range accepts "nan", which is neither below nor above.
inline CLI::Validator number_within(double low, double high) {
  return {[low, high](const std::string& text) -> std::string {
            double value = 0.0;
            const char* const end = text.data() + text.size();
            const auto [stop, error] = std::from_chars(text.data(), end, value);
            if (error == std::errc{} && stop == end && value >= low && value <= high) return {};
            return fmt::format("found {}, allowed: a number from {:g} to {:g}", text, low, high);
          },
          fmt::format("FLOAT in [{:g} - {:g}]", low, high)};
}

}  // namespace skein::app
