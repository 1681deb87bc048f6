#include "app/record/report.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "app/embedded/embedded.h"
#include "app/experiment/text_file.h"
#include "app/record/gnuplot.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using Done = tl::expected<void, std::string>;

/// What a figure's script needs to know of this run, as gnuplot's variables.
std::string script_head(const char* figure, const Experiment& experiment, const Statistics::Summary& summary) {
  std::string perturbed, settled;
  for (const PerturbationResult& p : summary.perturbations) {
    perturbed += fmt::format("{}{:.6g}", perturbed.empty() ? "" : " ", p.t);
    if (p.settling.formation_1cm)
      settled += fmt::format("{}{:.6g}", settled.empty() ? "" : " ", p.t + *p.settling.formation_1cm);
  }
  return fmt::format(
      "# Experiment \"{}\", drawn by skein {} from run.csv. To draw it again, edit this and run: gnuplot {}.gp\n"
      "n = {}  # robots\n"
      "perturbed = \"{}\"  # when a robot was put elsewhere [s]\n"
      "settled = \"{}\"  # when the largest formation error had come back to 1 cm for good [s]\n\n",
      experiment.name, SKEIN_VERSION, figure, experiment.robots.size(), perturbed, settled);
}

}  // namespace

Done check_report(const std::string& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) return tl::unexpected(fmt::format("{}: cannot be made: {}", directory, error.message()));
  const fs::path probe = fs::path(directory) / ".skein-can-write-here";
  if (!check_can_write(probe))
    return tl::unexpected(fmt::format("{}: cannot be written to: {}", directory, std::strerror(errno)));
  return gnuplot(directory, "--version");
}

Done write_report(const std::string& directory, const Experiment& experiment, const Statistics::Summary& summary) {
  const fs::path folder(directory);
  if (Done written = write_file(folder / "summary.json", as_json(summary) + '\n'); !written) return written;
  for (const auto& [figure, body] : {std::pair("figure3", embedded::figure3_gp), {"figure4", embedded::figure4_gp}}) {
    const fs::path script = folder / fmt::format("{}.gp", figure);
    if (Done done = write_file(script, script_head(figure, experiment, summary) + std::string(body)); !done)
      return done;
    if (Done done = draw_figure(directory, figure); !done)
      return tl::unexpected(fmt::format("{}: {}", script.string(), done.error()));
  }
  return {};
}

}  // namespace skein::app
