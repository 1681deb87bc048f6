#include "app/record/report.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <tuple>

#include "app/embedded/embedded.h"
#include "app/experiment/text_file.h"
#include "app/record/csv_reader.h"
#include "app/record/gnuplot.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using Done = tl::expected<void, std::string>;

/// gnuplot's variables NAME_low and NAME_high.
std::string variables(const char* name, const Extent& extent, const char* meaning) {
  const bool any = !std::isnan(extent.low);  // nothing was seen: an empty figure needs a range as well
  return fmt::format("{0}_low = {1:.9g}; {0}_high = {2:.9g}  # {3}\n", name, any ? extent.low : -1.0,
                     any ? extent.high : 1.0, meaning);
}

/// What a figure's script needs to know of this run, as gnuplot's variables.
std::string script_head(const char* figure, const Experiment& experiment, const Statistics::Summary& summary,
                        const FigureData::Extents& extents) {
  std::string perturbed, settled;
  for (const PerturbationResult& p : summary.perturbations) {
    perturbed += fmt::format("{}{:.6g}", perturbed.empty() ? "" : " ", p.t);
    if (p.settling.formation_1cm)
      settled += fmt::format("{}{:.6g}", settled.empty() ? "" : " ", p.t + *p.settling.formation_1cm);
  }
  return fmt::format(
             "# Experiment \"{0}\", drawn by skein {1} from {2}.dat. To draw it again, edit this and run: gnuplot "
             "{2}.gp\n"
             "n = {3}  # robots\n"
             "perturbed = \"{4}\"  # when a robot was put elsewhere [s]\n"
             "settled = \"{5}\"  # when the largest formation error had come back to 1 cm for good [s]\n",
             experiment.name, SKEIN_VERSION, figure, experiment.robots.size(), perturbed, settled) +
         variables("t", extents.t, "of the run [s]") + variables("x", extents.x, "of robots and references [m]") +
         variables("y", extents.y, "[m]") + variables("e_xy", extents.e_xy, "of the errors [m]") +
         variables("e_theta", extents.e_theta, "[rad]") + variables("delta", extents.delta, "[m]") + '\n';
}

Done write_summary(const fs::path& folder, const Statistics::Summary& summary) {
  return write_file(folder / "summary.json", as_json(summary) + '\n');
}

Done draw(const fs::path& folder, const Experiment& experiment, const Statistics::Summary& summary,
          const FigureData& figures) {
  for (const auto& [figure, body, data] : {std::tuple("figure3", embedded::figure3_gp, figures.paths()),
                                           {"figure4", embedded::figure4_gp, figures.errors()}}) {
    const fs::path script = folder / fmt::format("{}.gp", figure);
    const std::string head = script_head(figure, experiment, summary, figures.extents());
    Done done = write_file(folder / fmt::format("{}.dat", figure), data);
    if (done) done = write_file(script, head + std::string(body));
    if (!done) return done;
    if (done = draw_figure(folder, figure); !done)
      return tl::unexpected(fmt::format("{}: {}", script.string(), done.error()));
  }
  return {};
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

Done write_report(const std::string& directory, const Experiment& experiment, const Statistics::Summary& summary,
                  const FigureData& figures) {
  if (Done written = write_summary(directory, summary); !written) return written;
  return draw(directory, experiment, summary, figures);
}

Done write_report(const std::string& directory, const Experiment& experiment, const Statistics::Summary& summary) {
  if (Done written = write_summary(directory, summary); !written) return written;
  const std::string csv = fs::path(directory) / "run.csv";
  std::ifstream in(csv, std::ios::binary);
  if (!in) return tl::unexpected(fmt::format("{}: cannot be opened: {}", csv, std::strerror(errno)));
  auto reader = CsvReader::open(in, csv);
  if (!reader) return tl::unexpected(reader.error());
  FigureData figures(experiment);
  for (TickRecord row;;) {
    const auto more = reader->next(row);
    if (!more) return tl::unexpected(more.error());
    if (!*more) return draw(directory, experiment, summary, figures);
    find_end(experiment, row);
    figures.record(row);
  }
}

}  // namespace skein::app
