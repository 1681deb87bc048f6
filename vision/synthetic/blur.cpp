#include "vision/synthetic/painter.h"

namespace skein::vision::detail {

Blur::Blur(double sigma_px) {
  const int reach = sigma_px > 0.0 ? static_cast<int>(std::ceil(3.0 * sigma_px)) : 0;
  double sum = 0.0;
  std::vector<double> weights;
  for (int i = 0; i <= reach; ++i) {
    weights.push_back(i == 0 ? 1.0 : std::exp(-0.5 * i * i / (sigma_px * sigma_px)));
    sum += (i == 0 ? 1.0 : 2.0) * weights.back();
  }
  for (const double weight : weights) weights_.push_back(static_cast<float>(weight / sum));
}

void Blur::weigh(const float* __restrict middle, std::ptrdiff_t step, int width, float* __restrict to) const {
  // Every sum from the middle outwards, whole rows at a time: so the compiler has vector instructions for it.
  for (int i = 0; i < width; ++i) to[i] = weights_[0] * middle[i];
  for (int k = 1; k <= reach(); ++k) {
    const float weight = weights_[static_cast<std::size_t>(k)];
    const float* before = middle - k * step;
    const float* after = middle + k * step;
    for (int i = 0; i < width; ++i) to[i] += weight * (before[i] + after[i]);
  }
}

void Blur::apply(const Canvas& from, const Box& box, std::uint8_t* to) {
  if (box.empty()) return;
  const int width = box.right - box.left;
  const int rows = box.bottom - box.top + 2 * reach();
  const auto at = [](std::vector<float>& floats, int i) { return floats.begin() + i; };
  padded_.resize(static_cast<std::size_t>(width) + 2 * static_cast<std::size_t>(reach()));
  across_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(rows));
  down_.resize(static_cast<std::size_t>(width));
  const int first = box.left - reach();
  const int left = std::max(first, 0);
  const int right = std::min(box.right + reach(), from.width);
  for (int r = 0; r < rows; ++r) {
    const float* row = from.row(std::clamp(box.top - reach() + r, 0, from.height - 1));
    std::fill(at(padded_, 0), at(padded_, left - first), row[0]);
    std::copy(row + left, row + right, at(padded_, left - first));
    std::fill(at(padded_, right - first), padded_.end(), row[from.width - 1]);
    weigh(padded_.data() + reach(), 1, width, across_.data() + static_cast<std::ptrdiff_t>(r) * width);
  }
  for (int v = box.top; v < box.bottom; ++v) {
    weigh(across_.data() + static_cast<std::ptrdiff_t>(v - box.top + reach()) * width, width, width, down_.data());
    std::transform(down_.begin(), down_.end(), to + static_cast<std::ptrdiff_t>(v) * from.width + box.left,
                   [](float sum) { return static_cast<std::uint8_t>(std::clamp(sum + 0.5F, 0.0F, 255.0F)); });
  }
}

}  // namespace skein::vision::detail
