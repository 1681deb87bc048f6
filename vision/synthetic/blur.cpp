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

void Blur::apply(const Canvas& from, const Box& box, std::uint8_t* to) {
  if (box.empty()) return;
  const int width = box.right - box.left;
  const int rows = box.bottom - box.top + 2 * reach();
  padded_.resize(static_cast<std::size_t>(width + 2 * reach()));
  across_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(rows));
  for (int r = 0; r < rows; ++r) {
    const float* row = from.row(std::clamp(box.top - reach() + r, 0, from.height - 1));
    for (int i = 0; i < width + 2 * reach(); ++i) {
      padded_[static_cast<std::size_t>(i)] = row[std::clamp(box.left - reach() + i, 0, from.width - 1)];
    }
    float* out = across_.data() + static_cast<std::ptrdiff_t>(r) * width;
    const float* middle = padded_.data() + reach();
    for (int i = 0; i < width; ++i) {
      float sum = weights_[0] * middle[i];
      for (int k = 1; k <= reach(); ++k) sum += weights_[static_cast<std::size_t>(k)] * (middle[i - k] + middle[i + k]);
      out[i] = sum;
    }
  }
  for (int v = box.top; v < box.bottom; ++v) {
    const float* middle = across_.data() + static_cast<std::ptrdiff_t>(v - box.top + reach()) * width;
    std::uint8_t* out = to + static_cast<std::ptrdiff_t>(v) * from.width + box.left;
    for (int i = 0; i < width; ++i) {
      float sum = weights_[0] * middle[i];
      for (int k = 1; k <= reach(); ++k) {
        sum += weights_[static_cast<std::size_t>(k)] * (middle[i - k * width] + middle[i + k * width]);
      }
      out[i] = static_cast<std::uint8_t>(std::clamp(sum + 0.5F, 0.0F, 255.0F));
    }
  }
}

}  // namespace skein::vision::detail
