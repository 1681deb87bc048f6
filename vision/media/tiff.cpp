#include "vision/media/tiff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace skein::vision::media {
namespace {

/// The tables of a TIFF, one for each picture: its values by their numbers. TIFF 6.0, and BigTIFF with its longer ones.
class Tables {
 public:
  explicit Tables(std::span<std::uint8_t> bytes) : bytes_(bytes) {
    const std::string_view first(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 2));
    little_ = first == "II";
    const std::uint64_t version = little_ || first == "MM" ? number(2, 2) : 0;
    big_ = version == 43;
    if (version == 42 || big_) table_ = number(big_ ? 8 : 4, word());
  }

  bool any() const { return table_ != 0; }

  void next() { table_ = number(first_entry() + entries() * entry_size(), word()); }

  /// The first value of this number in the present table, or `otherwise`.
  std::uint64_t value(int tag, std::uint64_t otherwise) const {
    const Place place = find(tag);
    return place.size == 0 ? otherwise : number(place.at, place.size);
  }

  void set_if_there(int tag, std::uint8_t value) {
    const Place place = find(tag);
    if (place.at > bytes_.size() || place.size > bytes_.size() - place.at) return;
    const auto bytes = bytes_.subspan(place.at, place.size);
    if (bytes.empty()) return;
    std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
    (little_ ? bytes.front() : bytes.back()) = value;
  }

 private:
  struct Place {
    std::uint64_t at = 0;
    std::size_t size = 0;  // of one value [bytes]; 0: not there
  };

  std::size_t word() const { return big_ ? 8 : 4; }
  std::size_t entry_size() const { return big_ ? 20 : 12; }
  std::uint64_t first_entry() const { return table_ + (big_ ? 8 : 2); }
  std::uint64_t entries() const { return std::min<std::uint64_t>(number(table_, big_ ? 8 : 2), 0xffff); }

  /// 0 beyond the file's end.
  std::uint64_t number(std::uint64_t at, std::size_t size) const {
    if (at > bytes_.size() || size > bytes_.size() - at) return 0;
    std::uint64_t number = 0;
    for (std::size_t k = 0; k < size; ++k) number = number << 8 | bytes_[at + (little_ ? size - 1 - k : k)];
    return number;
  }

  Place find(int tag) const {
    const std::uint64_t end = first_entry() + entries() * entry_size();
    for (std::uint64_t entry = first_entry(); entry < end; entry += entry_size()) {
      if (number(entry, 2) != static_cast<std::uint64_t>(tag)) continue;
      const std::size_t size = number(entry + 2, 2) == 3 ? 2 : 4;  // SHORT, LONG
      const std::uint64_t at = entry + 4 + word();
      const bool elsewhere = number(entry + 4, word()) * size > word();
      return {elsewhere ? number(at, word()) : at, size};
    }
    return {};
  }

  std::span<std::uint8_t> bytes_;
  bool little_ = false, big_ = false;
  std::uint64_t table_ = 0;  // where it begins; 0: there are no more
};

}  // namespace

std::string prepare_tiff(std::span<std::uint8_t> bytes) {
  constexpr int kind = 254, bits = 258, orientation = 274, colours = 277, planes = 284;
  constexpr std::uint64_t preview_or_mask = 1 | 4;
  constexpr int most_tables = 1000;  // a damaged one may lead back to itself
  Tables tables(bytes);
  if (!tables.any()) return {};
  tables.set_if_there(orientation, 1);
  if (tables.value(kind, 0) & preview_or_mask)
    return "begins with a preview, which would be read in place of the picture: save it as PNG";
  if (tables.value(planes, 1) == 2 && tables.value(colours, 1) > 1 && tables.value(bits, 1) > 8)
    return "has its colours of 16 bits in separate planes, which cannot be read: save it as PNG, or its colours "
           "together";
  int pages = 0;
  for (int k = 0; tables.any() && k < most_tables; tables.next(), ++k)
    if (!(tables.value(kind, 0) & preview_or_mask)) ++pages;
  return pages > 1 ? fmt::format("has {} pages, allowed: one: save each as a file of its own", pages) : std::string();
}

}  // namespace skein::vision::media
