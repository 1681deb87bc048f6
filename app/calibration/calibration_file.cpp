#include "app/calibration/calibration_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cerrno>
#include <cstring>

#include "app/calibration/floor_mark_keys.h"
#include "app/experiment/file_change.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_table.h"

// The file:
//   [camera]   width, height, fx, fy, cx, cy, distortion = [k1, k2, p1, p2, k3], row_time (0 if missing)
//   [world]    rotation = three rows of three, position = [x, y, z]   (may be missing: intrinsics only)
//   [tags]     height, size                                           (may be missing: 0.06 m and 0.04 m)
//   [[mark]]   tag, x, y, z = 0, size, pixel = [u, v]                 (of a tag that was not seen, the last two may be
//              x, y, z = 0, pixel = [u, v]                             missing; without a tag: a point)

namespace skein::app {
namespace {

using vision::Calibration;
using vision::CameraPose;
using vision::FloorMark;

constexpr int smallest = 16, largest = 32768;  // edges of a picture [px]

void read_camera(TomlTable t, Calibration& c) {
  for (const auto& [key, target] : {std::pair("width", &c.width), std::pair("height", &c.height)}) {
    t.require(key, "a whole number of pixels");
    t.integer(key, *target, smallest, largest);
  }
  // A size that was refused bounds nothing: what any picture allows is allowed.
  const auto sizes = [&t](const char* key, int size) {
    return t.sound(t.full(key)) ? std::pair(size, size) : std::pair(smallest, largest);
  };
  const auto [narrowest, widest] = sizes("width", c.width);
  const auto [lowest, highest] = sizes("height", c.height);
  // A focal length of under a tenth of the picture would be a fish-eye, which this model does not describe.
  t.needed("fx", c.fx, between(0.1 * narrowest, 1e6, "px"));
  t.needed("fy", c.fy, between(0.1 * lowest, 1e6, "px"));
  t.needed("cx", c.cx, between(-1.0 * widest, 2.0 * widest, "px"));
  t.needed("cy", c.cy, between(-1.0 * highest, 2.0 * highest, "px"));
  t.needed("distortion", c.distortion, between(-1000.0, 1000.0));
  t.number("row_time", c.row_time, between(0.0, 0.001, "s"));
  t.finish();
}

void read_rotation(TomlTable& t, Eigen::Matrix3d& rotation, Problems& problems) {
  const std::string allowed = "3 rows of 3 numbers";
  t.require("rotation", allowed);
  const toml::node* const found = t.node("rotation");
  if (!found) return;
  const toml::array* const rows = found->as_array();
  if (!rows || rows->size() != 3) return t.refuse("rotation", *found, allowed);
  for (std::size_t r = 0; r < 3; ++r) {
    const auto row = numbers_of<3>(*rows->get(r));
    if (!row) return t.refuse("rotation", *found, allowed);
    rotation.row(static_cast<Eigen::Index>(r)) << (*row)[0], (*row)[1], (*row)[2];
  }
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error < 1e-6) || rotation.determinant() < 0.0)
    problems.add(found->source(), fmt::format("{}: found a matrix R with R R' off the identity by {:.2g} and det R = "
                                              "{:.6g}, allowed: a rotation, off by 1e-6 at most, det R = 1 (write all "
                                              "digits)",
                                              t.full("rotation"), error, rotation.determinant()));
}

/// A camera that cannot see the tags would give no pose, and no reason.
void check_world(const Calibration& c, Problems& problems) {
  const double height = c.world_from_camera->position.z(), down = c.world_from_camera->rotation(2, 2);
  if (const double lowest = std::max(0.0, c.tag_height); !(height > lowest))
    problems.add("world.position",
                 fmt::format("found a camera at a height of {} m, allowed: above {} m, over the floor "
                             "and the tags (z points from the floor to the camera)",
                             height, lowest));
  if (!(down < 0.0))
    problems.add("world.rotation",
                 fmt::format("found a camera that looks up (the last number is {}), allowed: one that "
                             "looks down on the floor, so that this is below 0",
                             down));
}

void read_mark(TomlTable& t, std::vector<FloorMark>& marks, Problems& problems) {
  FloorMark mark;
  const bool is_tag = t.has("tag");
  const auto points = std::count_if(marks.begin(), marks.end(), [](const FloorMark& m) { return m.tag < 0; });
  mark.name = fmt::format("point {}", points + 1);
  read_tag(t, "tag", marks, mark, problems);
  read_place(t, mark);
  if (is_tag) t.number("size", mark.size, between(1e-3, 10.0, "m"));
  mark.seen = t.has("pixel");
  std::array<double, 2> pixel{};
  if (mark.seen || !is_tag) t.needed("pixel", pixel, pixel_range);
  mark.u = pixel[0], mark.v = pixel[1];
  t.finish();
  marks.push_back(mark);
}

}  // namespace

tl::expected<Calibration, std::string> parse_calibration(std::string_view text, const std::string& name) {
  const auto document = parse_toml(text, name, FileKind::calibration);
  if (!document) return tl::unexpected(messages(document.error()));
  Problems problems(*document, name);
  TomlTable root(&*document, "", problems);
  Calibration result;
  root.require("camera", "the table [camera]");
  if (TomlTable camera = root.table("camera"); root.has("camera") && problems.empty()) read_camera(camera, result);
  if (TomlTable t = root.table("world"); root.has("world")) {
    CameraPose pose;
    std::array<double, 3> position{};
    read_rotation(t, pose.rotation, problems);
    t.needed("position", position, between(-100.0, 100.0, "m"));
    t.finish();
    pose.position << position[0], position[1], position[2];
    result.world_from_camera = pose;
  }
  if (TomlTable t = root.table("tags"); root.has("tags")) {
    t.needed("height", result.tag_height, between(-10.0, 10.0, "m"));
    t.needed("size", result.tag_size, between(1e-3, 10.0, "m"));
    t.finish();
  }
  if (result.world_from_camera && problems.empty()) check_world(result, problems);
  for (TomlTable& t : root.tables("mark")) read_mark(t, result.marks, problems);
  root.finish();
  if (!problems.empty()) return tl::unexpected(messages(std::move(problems).sorted()));
  return result;
}

tl::expected<Calibration, std::string> load_calibration(const std::filesystem::path& path) {
  const auto text = read_text(path.string());
  if (!text) return tl::unexpected(messages(text.error()));
  return parse_calibration(*text, path.string());
}

std::string format_calibration(const Calibration& calibration) {
  const Calibration& c = calibration;
  std::string text = fmt::format(
      "# Camera calibration: lengths in m unless px is said, pixel (0, 0) at the centre of the top-left one.\n\n"
      "[camera]\n"
      "width = {}  # px\n"
      "height = {}\n"
      "fx = {}  # focal length [px]\n"
      "fy = {}\n"
      "cx = {}  # principal point [px]\n"
      "cy = {}\n"
      "distortion = [{}]  # k1, k2, p1, p2, k3 (OpenCV's)\n",
      c.width, c.height, c.fx, c.fy, c.cx, c.cy, fmt::join(c.distortion, ", "));
  if (c.row_time != 0.0)
    text += fmt::format("row_time = {}  # of a rolling shutter, from row to row [s]\n", c.row_time);
  if (c.world_from_camera) {
    const Eigen::Matrix3d& r = c.world_from_camera->rotation;
    const Eigen::Vector3d& p = c.world_from_camera->position;
    text +=
        "\n# p_world = rotation * p_camera + position; world: x right, y up on the floor, z to the camera\n[world]\n";
    text += "rotation = [\n";
    for (int i = 0; i < 3; ++i) text += fmt::format("  [{}, {}, {}],\n", r(i, 0), r(i, 1), r(i, 2));
    text += fmt::format("]\nposition = [{}, {}, {}]\n", p.x(), p.y(), p.z());
  }
  text += fmt::format(
      "\n[tags]\n"
      "height = {}  # of the tags' plane above the floor\n"
      "size = {}  # edge of the black square\n",
      c.tag_height, c.tag_size);
  if (!c.marks.empty())
    text +=
        "\n# The marks on the floor by which [world] was found. A run with this camera looks whether its tags still "
        "lie "
        "where\n# they were, at this pixel.\n";
  for (const FloorMark& mark : c.marks) {
    text += "\n[[mark]]\n";
    if (mark.tag >= 0) text += fmt::format("tag = {}\n", mark.tag);
    text += fmt::format("x = {}\ny = {}\nz = {}\n", mark.x, mark.y, mark.z);
    if (mark.size > 0.0) text += fmt::format("size = {}\n", mark.size);
    if (mark.seen) text += fmt::format("pixel = [{}, {}]\n", mark.u, mark.v);
  }
  return text;
}

tl::expected<void, std::string> check_calibration_target(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  const auto refuse = [&](std::string_view why) {
    return tl::unexpected(fmt::format("{}: the calibration cannot be written there: {}", path.string(), why));
  };
  std::error_code ignored;
  const fs::file_status there = fs::status(path, ignored);
  if (fs::is_directory(there)) return refuse("it is a folder, allowed: the name of a file");
  if (fs::exists(there) && !fs::is_regular_file(there)) return refuse("it is a device or a FIFO, allowed: a file");
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored)) return refuse(fmt::format("there is no folder {}", folder.string()));
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    return refuse(fmt::format("nothing can be written to the folder {} ({})", folder.string(), std::strerror(errno)));
  // As it will be written: a name may be too long for its draft, and a folder of the kernel's takes no file of anybody.
  if (const auto change = FileChange::begin(path.string()); !change) return tl::unexpected(change.error());
  return {};
}

namespace {

/// What would be written; what no command could read again is not.
tl::expected<std::string, std::string> readable_text(const Calibration& calibration,
                                                     const std::filesystem::path& path) {
  std::string text = format_calibration(calibration);
  if (const auto again = parse_calibration(text, path.string()); !again)
    return tl::unexpected(
        fmt::format("{}: the calibration is not written, since it is none: {}", path.string(), again.error()));
  return text;
}

/// Where the previous contents of a file go: beside it, as ".old", or ".old-2" where that is a link or a file to be
/// left.
std::filesystem::path name_for_old(const std::filesystem::path& path, std::span<const std::string> leave) {
  for (int number = 1;; ++number) {
    std::filesystem::path old = path;
    old += number == 1 ? ".old" : fmt::format(".old-{}", number);
    std::error_code ignored;
    const bool left = std::any_of(leave.begin(), leave.end(), [&](const std::string& file) {
      return !file.empty() && std::filesystem::equivalent(old, file, ignored);
    });
    if (!left && !std::filesystem::is_symlink(old, ignored)) return old;
  }
}

}  // namespace

tl::expected<std::filesystem::path, std::string> replace_calibration(const Calibration& calibration,
                                                                     const std::filesystem::path& path,
                                                                     std::span<const std::string> leave) {
  if (auto possible = check_calibration_target(path); !possible) return tl::unexpected(possible.error());
  const auto text = readable_text(calibration, path);
  if (!text) return tl::unexpected(text.error());
  std::filesystem::path old;
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) {
    const auto before = read_text(path.string());
    if (!before) return tl::unexpected(before.error().front().message() + "; nothing was written");
    if (!before->empty() && *before != *text) {
      old = name_for_old(path, leave);
      auto kept = FileChange::begin(old.string());
      if (const auto saved = kept ? kept->save(*before) : tl::unexpected(kept.error()); !saved)
        return tl::unexpected(fmt::format("{} (the previous contents of {} are to be saved there); nothing was written",
                                          saved.error(), path.string()));
    }
  }
  if (auto saved = save_calibration(calibration, path); !saved) return tl::unexpected(saved.error());
  return old;
}

tl::expected<void, std::string> save_calibration(const Calibration& calibration, const std::filesystem::path& path) {
  if (auto possible = check_calibration_target(path); !possible) return possible;
  const auto text = readable_text(calibration, path);
  if (!text) return tl::unexpected(text.error());
  auto change = FileChange::begin(path.string());
  if (!change) return tl::unexpected(change.error());
  return change->save(*text);
}

}  // namespace skein::app
