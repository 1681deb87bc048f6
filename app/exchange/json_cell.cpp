#include "app/exchange/json_cell.h"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace skein::app {

std::string json_cell(std::string_view cell, bool words) {
  double value = 0.0;
  const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  const bool number = error == std::errc{} && stop == cell.data() + cell.size() && std::isfinite(value);
  if (number && !words) return std::string(cell);
  return nlohmann::json(cell).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace skein::app
