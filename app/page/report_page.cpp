#include "app/page/report_page.h"

#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/embedded/embedded.h"
#include "app/record/csv_reader.h"
#include "app/record/report.h"
#include "app/record/statistics.h"
#include "core/avoidance/obstacle.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

constexpr double frame_rate = 10.0;        // of the animation at most [Hz]
constexpr std::size_t most_frames = 1500;  // about 1 MB for 30 robots
constexpr std::size_t most_events = 500;

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  return result;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string result;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) result += i + k <= bytes.size() ? letters[group >> (18 - 6 * k) & 0x3FU] : '=';
  }
  return result;
}

/// mm and mrad, which the page's script expects; null for what is not known.
std::string thousandths(double value) {
  return std::isfinite(value) ? fmt::format("{}", std::llround(1e3 * value)) : "null";
}

/// What the animation shows, gathered row by row in a memory that does not grow with the run.
class Film {
 public:
  explicit Film(const Experiment& experiment)
      : stride_(std::max(1, static_cast<int>(std::lround(experiment.rate / frame_rate)))),
        step_(stride_ / experiment.rate),
        left_(-0.5 * experiment.arena_width),
        right_(0.5 * experiment.arena_width),
        bottom_(-0.5 * experiment.arena_height),
        top_(0.5 * experiment.arena_height) {}

  void add(const TickRecord& row) {
    for (const RobotRecord& robot : row.robots) include(place(robot).x, place(robot).y);
    if (seen_++ % stride_ != 0) return;
    std::string frame = fmt::format("[{:.3f},[", row.t);
    for (const RobotRecord& robot : row.robots) {
      const core::Pose pose = place(robot);
      for (const double value : {pose.x, pose.y, pose.theta, robot.nominal.pose.x, robot.nominal.pose.y})
        frame += thousandths(value) + ',';
    }
    frame.back() = ']';
    frames_.push_back(frame + ']');
    if (frames_.size() < most_frames) return;
    for (std::size_t k = 1; 2 * k < frames_.size(); ++k) frames_[k] = std::move(frames_[2 * k]);  // every other one
    frames_.resize((frames_.size() + 1) / 2);
    stride_ *= 2;
    step_ *= 2.0;
  }

  double grid() const noexcept { return std::max(right_ - left_, top_ - bottom_) > 5.0 ? 1.0 : 0.25; }  // [m]

  std::string json(const Experiment& experiment) const {
    const double margin = 0.05 * std::max(right_ - left_, top_ - bottom_);
    std::string obstacles;
    for (const core::Obstacle& o : experiment.obstacles)
      obstacles += fmt::format("{}[{},{},{}]", obstacles.empty() ? "" : ",", thousandths(o.x), thousandths(o.y),
                               thousandths(o.radius));
    std::string radii;
    for (const RobotSpec& robot : experiment.robots)
      radii += fmt::format("{}{}", radii.empty() ? "" : ",", thousandths(robot.radius));
    std::string frames;
    for (const std::string& frame : frames_) frames += (frames.empty() ? "" : ",\n") + frame;
    return fmt::format(
        R"({{"robots":{},"radii":[{}],"grid":{},"arena":[{},{}],"view":[{},{},{},{}],"step":{},"obstacles":[{}],"frames":[{}]}})",
        experiment.robots.size(), radii, thousandths(grid()), thousandths(experiment.arena_width),
        thousandths(experiment.arena_height), thousandths(left_ - margin), thousandths(-top_ - margin),
        thousandths(right_ - left_ + 2 * margin), thousandths(top_ - bottom_ + 2 * margin), step_, obstacles, frames);
  }

 private:
  void include(double x, double y) {
    if (!std::isfinite(x + y)) return;
    left_ = std::min(left_, x), right_ = std::max(right_, x);
    bottom_ = std::min(bottom_, y), top_ = std::max(top_, y);
  }
  int stride_;  // rows a frame
  double step_;
  double left_, right_, bottom_, top_;
  std::int64_t seen_ = 0;
  std::vector<std::string> frames_;
};

/// A folder for gnuplot, gone afterwards: signals that end the program wait for that.
class Workshop {
 public:
  Workshop() {
    sigset_t endings;
    sigemptyset(&endings);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&endings, signal);
    pthread_sigmask(SIG_BLOCK, &endings, &before_);
    std::error_code unknown;
    const char* const asked = std::getenv("TMPDIR");
    place_ = fs::temp_directory_path(unknown).string();
    if (unknown) place_ = asked != nullptr ? std::string("TMPDIR, ") + asked : "/tmp";  // it is no folder
    std::string name = unknown ? std::string() : place_ + "/skein-page-XXXXXX";
    if (unknown)
      why_ = unknown.message();
    else if (::mkdtemp(name.data()))
      path_ = name;
    else
      why_ = std::strerror(errno);
  }
  ~Workshop() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;
  const fs::path& path() const noexcept { return path_; }
  /// Why there is none, where the path is empty.
  std::string problem() const { return fmt::format("no folder for them can be made in {}: {}", place_, why_); }

 private:
  sigset_t before_{};
  fs::path path_;
  std::string place_, why_;
};

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The figures as pictures within the page, so that no name in one of them is another's.
tl::expected<std::string, std::string> figures(const Experiment& experiment, const Statistics::Summary& summary,
                                               const FigureData& data) {
  const Workshop workshop;
  if (workshop.path().empty()) return tl::unexpected(workshop.problem());
  if (const auto possible = check_report(workshop.path().string()); !possible) return tl::unexpected(possible.error());
  if (const auto drawn = write_report(workshop.path().string(), experiment, summary, data); !drawn)
    return tl::unexpected(drawn.error());
  std::string html;
  for (const auto& [name, heading, caption] :
       {std::tuple("figure3.svg", "Paths",
                   "References of the robots (solid) and their paths (dotted); arrows: moved by hand."),
        std::tuple("figure4.svg", "Errors",
                   "Tracking errors of the robots, and errors of the distances between neighbours (37).")})
    html += fmt::format(
        "<h2>{0}</h2>\n<figure><img alt=\"{0}\" "
        "src=\"data:image/svg+xml;base64,{1}\"><figcaption>{2}</figcaption></figure>\n",
        heading, base64(read_file(workshop.path() / name)), caption);
  return html;
}

std::string seconds(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f} s", *value) : "not";
}

std::string perturbations(const Statistics::Summary& summary) {
  if (summary.perturbations.empty()) return {};
  std::string html =
      "<h2>Perturbations</h2>\n<table><thead><tr><th>at</th><th>what</th><th>distances within 1 cm "
      "after</th><th>relative "
      "positions</th><th>tracking</th></tr></thead><tbody>\n";
  for (const PerturbationResult& p : summary.perturbations)
    html += fmt::format("<tr><td>{:.2f} s</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", p.t,
                        escaped(p.what), seconds(p.settling.formation_1cm), seconds(p.settling.relative_1cm),
                        seconds(p.settling.tracking_1cm));
  return html + "</tbody></table>\n";
}

std::string tags_not_seen(const std::vector<PageCrop>& crops) {
  if (crops.empty()) return {};
  std::string html = "<h2>Tags not seen</h2>\n<div class=\"tags\">\n";
  for (const PageCrop& crop : crops)
    html += fmt::format("<figure>{}<figcaption>Robot {}: {}</figcaption></figure>\n",
                        crop.png.empty()
                            ? std::string()
                            : fmt::format("<img alt=\"The camera's picture of it\" src=\"data:image/png;base64,{}\">",
                                          base64(crop.png)),
                        crop.robot + 1, escaped(crop.sentence));
  return html + "</div>\n";
}

std::string facts(const Experiment& experiment, const Statistics::Summary& summary) {
  std::string html;
  const auto add = [&](const char* what, const std::string& value) {
    html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", what, escaped(value));
  };
  const auto millimetres = [](double metres) {
    return std::isfinite(metres) ? fmt::format("{:.1f} mm", 1e3 * metres) : std::string("none");
  };
  add("robots", fmt::format("{}", experiment.robots.size()));
  add("lasted", fmt::format("{:g} s", summary.duration));
  add("collisions", fmt::format("{}", summary.collisions));
  add("smallest distance", millimetres(summary.min_distance));
  add("error at the end", millimetres(summary.final_error));
  add("missed ticks", fmt::format("{}", summary.missed_deadlines));
  return html;
}

/// The template with what stands for each {{name}}.
std::string filled(std::string_view text, const std::map<std::string, std::string, std::less<>>& values) {
  std::string html;
  while (true) {
    const std::size_t begin = text.find("{{"), end = text.find("}}", std::min(begin, text.size()));
    if (end == std::string_view::npos) return html += text;
    html += text.substr(0, begin);
    const auto value = values.find(text.substr(begin + 2, end - begin - 2));
    if (value != values.end()) html += value->second;
    text.remove_prefix(end + 2);
  }
}

}  // namespace

tl::expected<Page, std::string> report_page(std::istream& csv, const std::string& file, const PageOrigin& origin) {
  auto reader = CsvReader::open(csv, file);
  if (!reader) return tl::unexpected(reader.error());
  const auto experiment = reader->experiment();
  if (!experiment) return tl::unexpected(experiment.error());
  Statistics statistics(*experiment);
  FigureData for_figures(*experiment);
  Film film(*experiment);
  TickRecord row;
  while (true) {
    const auto more = reader->next(row);
    if (!more) return tl::unexpected(more.error());
    if (!*more) break;
    find_end(*experiment, row);
    statistics.record(row);
    for_figures.record(row);
    film.add(row);
  }
  const Statistics::Summary summary = statistics.summary();
  if (summary.ticks == 0) return tl::unexpected(fmt::format("{}: it has no rows", file));

  Page page;
  if (reader->torn()) page.warnings.push_back(*reader->torn());
  auto drawn = figures(*experiment, summary, for_figures);
  if (!drawn) {
    page.warnings.push_back("the page has no figures: " + drawn.error());
    drawn = fmt::format("<p class=\"bad\">The figures could not be drawn: {}</p>", escaped(drawn.error()));
  }
  std::string events, values, problems;
  for (std::size_t i = 0; i < std::min(most_events, summary.events.size()); ++i)
    events += fmt::format("<tr data-t=\"{0:.3f}\"><td>{0:.2f} s</td><td>{1}</td></tr>\n", summary.events[i].first,
                          escaped(summary.events[i].second));
  if (summary.events.size() > most_events)
    events += fmt::format("<tr><td></td><td>and {} more</td></tr>\n", summary.events.size() - most_events);
  const std::string lines = as_lines(summary);
  for (std::size_t at = 0; at < lines.size();) {
    const std::size_t end = lines.find('\n', at), colon = lines.find(": ", at);
    if (colon < end)
      values += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", escaped(lines.substr(at, colon - at)),
                            escaped(lines.substr(colon + 2, end - colon - 2)));
    at = end + 1;
  }
  for (const std::string& problem : origin.problems)
    problems += fmt::format("<p class=\"bad\">{}</p>\n", escaped(problem));
  const std::string sentence =
      origin.sentence.empty() ? fmt::format("Recorded by skein {}.", reader->head().version) : origin.sentence;
  page.html = filled(embedded::page_html, {{"title", escaped(reader->head().name)},
                                           {"origin", escaped(sentence)},
                                           {"problems", problems},
                                           {"facts", facts(*experiment, summary)},
                                           {"grid", fmt::format("{:g} m", film.grid())},
                                           {"figures", *drawn},
                                           {"perturbations", perturbations(summary)},
                                           {"not_seen", tags_not_seen(origin.crops)},
                                           {"events", events},
                                           {"summary", values},
                                           {"experiment_name", escaped(reader->head().name + ".toml")},
                                           {"experiment", escaped(reader->head().source)},
                                           {"data", film.json(*experiment)}});
  return page;
}

}  // namespace skein::app
