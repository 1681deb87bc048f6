#include <fmt/format.h>

#include <toml++/toml.h>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "vision/calibration/calibration.h"
#include "vision/calibration/toml_reader.h"

// The file:
//   [camera]   width, height, fx, fy, cx, cy, distortion = [k1, k2, p1, p2, k3], row_time (0 if missing)
//   [world]    rotation = three rows of three, position = [x, y, z]   (may be missing: intrinsics only)
//   [tags]     height, size                                           (may be missing: 0.06 m and 0.04 m)

namespace skein::vision {
namespace {

using detail::Problem;
using detail::Reader;

CameraPose read_world(const Reader& reader, const toml::table& table) {
  reader.only(table, "world.", {"rotation", "position"});
  CameraPose pose;
  const toml::node& rotation = reader.need(table, "world.", "rotation");
  const toml::array* rows = rotation.as_array();
  if (rows == nullptr || rows->size() != 3) {
    reader.fail(rotation.source(), reader.wrong("world.rotation", rotation, "3 rows of 3 numbers"));
  }
  for (int r = 0; r < 3; ++r) {
    const auto row =
        reader.numbers<3>(*rows->get(static_cast<std::size_t>(r)), fmt::format("world.rotation[{}]", r), {-1.0, 1.0});
    pose.rotation.row(r) << row[0], row[1], row[2];
  }
  const double error = (pose.rotation * pose.rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error < 1e-6) || pose.rotation.determinant() < 0.0) {
    reader.fail(rotation.source(),
                fmt::format("world.rotation is not a rotation: R R' differs from the identity by {:.2g}, det R = "
                            "{:.6g}; allowed: 1e-6, det R = 1 (write all the digits)",
                            error, pose.rotation.determinant()));
  }
  const auto position = reader.numbers<3>(reader.need(table, "world.", "position"), "world.position", {-100.0, 100.0});
  pose.position << position[0], position[1], position[2];
  return pose;
}

Calibration read(const Reader& reader, const toml::table& root) {
  Calibration result;
  reader.only(root, "", {"camera", "world", "tags"});

  const toml::table* camera = reader.table(root, "camera");
  if (camera == nullptr) reader.fail(root.source(), "the table [camera] is missing");
  reader.only(*camera, "camera.", {"width", "height", "fx", "fy", "cx", "cy", "distortion", "row_time"});
  result.width = reader.integer(*camera, "camera.", "width", {16, 32768});
  result.height = reader.integer(*camera, "camera.", "height", {16, 32768});
  // A focal length of under a tenth of the picture would be a fish-eye, which this model does not describe.
  result.fx = reader.number(*camera, "camera.", "fx", {0.1 * result.width, 1e6});
  result.fy = reader.number(*camera, "camera.", "fy", {0.1 * result.height, 1e6});
  result.cx = reader.number(*camera, "camera.", "cx", {-1.0 * result.width, 2.0 * result.width});
  result.cy = reader.number(*camera, "camera.", "cy", {-1.0 * result.height, 2.0 * result.height});
  result.distortion =
      reader.numbers<5>(reader.need(*camera, "camera.", "distortion"), "camera.distortion", {-1000.0, 1000.0});

  if (camera->contains("row_time")) result.row_time = reader.number(*camera, "camera.", "row_time", {0.0, 0.001});

  if (const toml::table* world = reader.table(root, "world")) result.world_from_camera = read_world(reader, *world);

  if (const toml::table* tags = reader.table(root, "tags")) {
    reader.only(*tags, "tags.", {"height", "size"});
    result.tag_height = reader.number(*tags, "tags.", "height", {-10.0, 10.0});
    result.tag_size = reader.number(*tags, "tags.", "size", {1e-3, 10.0});
  }
  return result;
}

}  // namespace

tl::expected<Calibration, std::string> parse_calibration(std::string_view text, const std::string& name) {
  const Reader reader(name);
  try {
    return read(reader, toml::parse(text, name));
  } catch (const toml::parse_error& error) {
    return tl::unexpected(
        fmt::format("{}:{}:{}: {}", name, error.source().begin.line, error.source().begin.column, error.description()));
  } catch (const Problem& problem) {
    return tl::unexpected(problem.text);
  }
}

tl::expected<Calibration, std::string> load_calibration(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) {
    return tl::unexpected(fmt::format("{}: the calibration file cannot be read", path.string()));
  }
  return parse_calibration(text.str(), path.string());
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
  return text;
}

tl::expected<std::filesystem::path, std::string> replace_calibration(const Calibration& calibration,
                                                                     const std::filesystem::path& path) {
  std::filesystem::path old;
  std::ostringstream before;
  if (std::ifstream file(path, std::ios::binary); file) before << file.rdbuf();
  if (!before.str().empty() && before.str() != format_calibration(calibration)) {
    old = path;
    old += ".old";
    std::error_code error;
    std::filesystem::copy_file(path, old, std::filesystem::copy_options::overwrite_existing, error);
    if (error)
      return tl::unexpected(
          fmt::format("{}: the previous contents of {} cannot be saved there ({}); nothing was written", old.string(),
                      path.string(), error.message()));
  }
  if (auto saved = save_calibration(calibration, path); !saved) return tl::unexpected(saved.error());
  return old;
}

tl::expected<void, std::string> save_calibration(const Calibration& calibration, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << format_calibration(calibration);
  file.close();
  if (!file) return tl::unexpected(fmt::format("{}: the calibration file cannot be written", path.string()));
  return {};
}

}  // namespace skein::vision
