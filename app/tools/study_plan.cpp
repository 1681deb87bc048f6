#include "app/tools/study_plan.h"
#include "app/run/clocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <thread>
#include <vector>

#include "app/run/resources.h"
#include "app/tools/sweep.h"

namespace skein::app {
namespace {

/// What each run with all its drives takes of its thread [s]; those that were not begun are left out.
std::vector<double> times_of(const std::vector<Study>& variants, bool control, std::int64_t sample, unsigned threads,
                             const std::function<bool()>& keep_going) {
  std::vector<double> times(static_cast<std::size_t>(sample), -1.0);
  std::atomic<std::int64_t> next{0};
  const auto work = [&] {
    for (std::int64_t k = 0; (k = next.fetch_add(1)) < sample && keep_going();) {
      const double began = thread_seconds();
      const std::uint64_t seed = variants.front().seed + static_cast<std::uint64_t>(k);
      for (const Study& variant : variants) (void)run_one(variant, seed);
      if (control) (void)run_one(variants.front(), seed, true);
      times[static_cast<std::size_t>(k)] = thread_seconds() - began;
    }
  };
  {
    std::vector<std::jthread> others;
    others.reserve(threads);
    for (unsigned k = 1; k < threads; ++k) others.emplace_back(work);
    work();
  }
  std::erase_if(times, [](double time) { return time < 0.0; });
  return times;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

}  // namespace

std::int64_t StudyPlan::parts() const noexcept {
  constexpr double most = 1000.0;  // the size of an array that Slurm takes by default
  const double spread = std::min(64.0, std::floor(60.0 * core_hours()));
  return static_cast<std::int64_t>(std::clamp(std::max(std::ceil(core_hours()), spread), 1.0, most));
}

StudyPlan plan_study(const Study& study, std::int64_t sample, unsigned threads,
                     const std::function<bool()>& keep_going) {
  std::vector<Study> variants{study};
  for (const auto& [name, sets] : study.compare) variants.push_back(compared_study(study, name));
  const bool control = !study.control.empty();
  StudyPlan plan;
  plan.runs = study.runs;
  plan.drives = static_cast<std::int64_t>(variants.size()) + (control ? 1 : 0);
  plan.threads = std::max(1U, threads);
  sample = std::min(sample, study.runs);
  plan.alone = mean(times_of(variants, control, sample, 1, keep_going));
  const std::vector<double> busy = times_of(variants, control, sample, plan.threads, keep_going);
  plan.sampled = static_cast<std::int64_t>(busy.size());
  plan.busy = mean(busy);
  double squares = 0.0;
  for (const double time : busy) squares += (time - plan.busy) * (time - plan.busy);
  constexpr double two_sided = 1.96;
  if (const auto n = static_cast<double>(busy.size()); n > 1.0)
    plan.interval = two_sided * std::sqrt(squares / (n - 1.0) / n);
  return plan;
}

std::string as_lines(const StudyPlan& plan, const Study& study, const StudyWords& words) {
  std::string text = fmt::format(
      "study: {}\nruns: {}\ndrives_per_run: {}\nsampled_runs: {}\nseconds_per_run: {:.4g}\n"
      "seconds_per_run_interval: {:.2g}\nseconds_per_run_alone: {:.4g}\nthreads: {}\ncore_hours: {:.3g}\n",
      study.name, plan.runs, plan.drives, plan.sampled, plan.busy, plan.interval, plan.alone, plan.threads,
      plan.core_hours());
  for (const int cores : {1, 16, 64})
    text += fmt::format("hours_on_{}_core{}: {:.3g}\n", cores, cores == 1 ? "" : "s", plan.core_hours() / cores);
  const std::string folder = resource_folder("slurm");
  text += fmt::format("parts: {}\nslurm: STUDY={} PARTS={} WORDS={} sbatch --array=1-{} --export=ALL {}\n",
                      plan.parts(), words.file, plan.parts(), words.options, plan.parts(),
                      folder.empty() ? "sweep.sbatch" : (std::filesystem::path(folder) / "sweep.sbatch").string());
  return text + fmt::format("merge: {} --merge parts\n", words.command);
}

}  // namespace skein::app
