#include "vision/tags/tag_pattern.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <cstdint>
#include <cstdlib>

namespace skein::vision::detail {

std::vector<TagPattern> tag_patterns() {
  apriltag_family_t* family = tag36h11_create();
  std::vector<TagPattern> result(family->ncodes);
  for (std::uint32_t id = 0; id < family->ncodes; ++id) {
    image_u8_t* image = apriltag_to_image(family, static_cast<int>(id));
    for (int i = 0; i < pattern_cells * pattern_cells; ++i) {
      result[id][static_cast<std::size_t>(i)] =
          image->buf[(i / pattern_cells) * image->stride + i % pattern_cells] > 127;
    }
    std::free(image->buf);  // Debian's library keeps its image_u8_destroy to itself
    std::free(image);
  }
  tag36h11_destroy(family);
  return result;
}

}  // namespace skein::vision::detail
