#include "app/exchange/mat_writer.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>

#include "app/run/utf8.h"

namespace skein::app {
namespace {

enum Type : std::uint32_t { mi_int8 = 1, mi_uint16 = 4, mi_int32 = 5, mi_uint32 = 6, mi_double = 9, mi_matrix = 14 };
enum Class : std::uint32_t { mx_cell = 1, mx_struct = 2, mx_char = 4, mx_double = 6 };

void append(std::string& out, std::uint32_t value) {
  for (int byte = 0; byte < 4; ++byte) out += static_cast<char>(static_cast<unsigned char>(value >> (8 * byte)));
}

void append_tag(std::string& out, Type type, std::size_t size) {
  if (size > largest_mat_element)
    throw std::length_error("more than 2 GB in one variable, the limit of MATLAB's format");
  append(out, type);
  append(out, static_cast<std::uint32_t>(size));
}

/// Type, size, data, padded to 8 bytes.
std::string element(Type type, std::string_view data) {
  std::string result;
  result.reserve(data.size() + 16);
  append_tag(result, type, data.size());
  result += data;
  result.append((8 - data.size() % 8) % 8, '\0');
  return result;
}

std::string words(Type type, std::initializer_list<std::uint32_t> values) {
  std::string data;
  for (const std::uint32_t value : values) append(data, value);
  return element(type, data);
}

/// The head of a matrix element; only the variable of a file has a name.
std::string head(Class kind, std::size_t rows, std::size_t columns, std::string_view name = {}) {
  return words(mi_uint32, {kind, 0}) +
         words(mi_int32, {static_cast<std::uint32_t>(rows), static_cast<std::uint32_t>(columns)}) +
         element(mi_int8, name);
}

/// UTF-8 as UTF-16, little-endian; what is no UTF-8 becomes a question mark.
std::string utf16(std::string_view text) {
  std::string result;
  const auto unit = [&](std::uint32_t value) {
    result += static_cast<char>(static_cast<unsigned char>(value));
    result += static_cast<char>(static_cast<unsigned char>(value >> 8));
  };
  while (!text.empty()) {
    const auto [letter, bytes] = first_letter(text);
    text.remove_prefix(bytes.size());
    const std::uint32_t code = letter.value_or(U'?');
    if (code >= 0x10000) {
      unit(0xD800 + ((code - 0x10000) >> 10));
      unit(0xDC00 + ((code - 0x10000) & 0x3FFU));
    } else {
      unit(code);
    }
  }
  return result;
}

}  // namespace

std::string mat_column(std::span<const double> values) {
  static_assert(std::endian::native == std::endian::little);
  const std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  return element(mi_matrix, head(mx_double, values.size(), 1) + element(mi_double, bytes));
}

std::string mat_text(std::string_view text) {
  const std::string units = utf16(text);
  return element(mi_matrix, head(mx_char, units.empty() ? 0 : 1, units.size() / 2) + element(mi_uint16, units));
}

std::string mat_cells(std::span<const std::string> texts) {
  std::string cells = head(mx_cell, texts.size(), 1);
  for (const std::string& text : texts) cells += mat_text(text);
  return element(mi_matrix, cells);
}

std::string mat_file_head(std::string_view variable, const std::vector<std::pair<std::string, std::string>>& fields) {
  std::size_t longest = 31;  // older programs expect 32 bytes a name
  for (const auto& [name, value] : fields) longest = std::max(longest, name.size());
  std::string names;
  std::size_t values = 0;  // bytes
  for (const auto& [name, value] : fields) {
    names += name;
    names.append(longest + 1 - name.size(), '\0');
    values += value.size();
  }
  // The length of a name is a small element: type, size and data in 8 bytes.
  std::string length;
  append(length, mi_int32 | 4U << 16);
  append(length, static_cast<std::uint32_t>(longest + 1));
  const std::string fields_head = head(mx_struct, 1, 1, variable) + length + element(mi_int8, names);
  std::string file = "MATLAB 5.0 MAT-file, written by skein " SKEIN_VERSION;
  file.resize(124, ' ');
  file += {'\x00', '\x01', 'I', 'M'};  // version 0x0100, little-endian
  append_tag(file, mi_matrix, fields_head.size() + values);
  return file + fields_head;
}

}  // namespace skein::app
