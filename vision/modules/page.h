#pragma once

#include <string>
#include <vector>

namespace skein::vision {

/// Something to be printed: pages of black shapes and words. Millimetres, (0, 0) at the page's top left, y down.
struct Page {
  struct Rectangle {
    double x, y, width, height;
  };
  struct Line {
    double x1, y1, x2, y2, width;
    bool dashed;
  };
  struct Triangle {
    double x[3], y[3];
  };
  struct Words {
    double x, y, size;  // of the first letter's foot; height of a capital is 0.7 size
    std::string text;
  };
  double width = 210.0, height = 297.0;
  std::vector<Rectangle> rectangles{};
  std::vector<Line> lines{};
  std::vector<Triangle> triangles{};
  std::vector<Words> words{};
};

}  // namespace skein::vision
