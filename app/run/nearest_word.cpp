#include "app/run/nearest_word.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace skein::app {
namespace {

/// How many letters must be typed, dropped, changed or exchanged with their neighbours to make one word of the other
/// (Damerau and Levenshtein, no letter touched twice).
std::size_t letters_apart(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::swap(before, last);
    std::swap(last, row);
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({last[j + 1] + 1, row[j] + 1, last[j] + (a[i] == b[j] ? 0 : 1)});
      if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j]) row[j + 1] = std::min(row[j + 1], before[j - 1] + 1);
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string> nearest_word(std::string_view written, const std::vector<std::string>& words) {
  const auto nearest = std::min_element(words.begin(), words.end(), [&](const auto& a, const auto& b) {
    return letters_apart(written, a) < letters_apart(written, b);
  });
  const std::size_t close_enough = std::max<std::size_t>(1, written.size() / 3);
  if (nearest == words.end() || letters_apart(written, *nearest) > close_enough) return {};
  return *nearest;
}

std::string did_you_mean(std::string_view written, const std::vector<std::string>& words) {
  const auto meant = nearest_word(written, words);
  return meant ? "; did you mean " + *meant + "?" : ",";
}

}  // namespace skein::app
