#pragma once

#include <string>

namespace skein::vision {

/// Something on the floor whose place is known.
struct FloorMark {
  std::string name{};  // for people: "tag 3", "point 2"
  int tag = -1;        // id of a tag that lies there; -1: a point that was measured in the picture
  double x = 0.0;      // of the tag's middle or of the point, in the world [m]
  double y = 0.0;
  double z = 0.0;           // above the floor [m]
  double u = 0.0, v = 0.0;  // where the picture shows it [px]; of a tag: as it was seen
  bool seen = false;
  double size = 0.0;  // of a tag: edge of its black square [m]; 0: not known

  friend bool operator==(const FloorMark&, const FloorMark&) = default;
};

}  // namespace skein::vision
