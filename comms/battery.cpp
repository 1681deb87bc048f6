#include "comms/battery.h"

#include <fmt/format.h>

#include <cmath>

namespace skein::comms {

Battery battery_of(int raw) noexcept {
  Battery battery;
  if (raw == 0 || raw == 1) {
    battery.low = raw == 0;
    battery.good = raw == 1;
    return battery;
  }
  if (raw >= 2000 && raw <= 2600)
    battery.volts = 3.4 + (raw - 2070) * (4.2 - 3.4) / (2560 - 2070);
  else if (raw > 2600 && raw <= 4095)
    battery.volts = raw / 819.2;
  battery.low = battery.volts < epuck_charge_below;
  return battery;
}

std::string to_text(const Battery& battery) {
  if (!std::isnan(battery.volts)) return fmt::format("{:.2f} V{}", battery.volts, battery.low ? " (low)" : "");
  if (battery.low) return "low";
  return battery.good ? "good" : "unknown";
}

}  // namespace skein::comms
