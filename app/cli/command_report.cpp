#include <fmt/format.h>

#include <filesystem>

#include "app/cli/command_runs.h"
#include "app/cli/same_file.h"
#include "app/record/disk_writer.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/runs/find_run.h"
#include "app/runs/kept_run.h"
#include "app/runs/run_page.h"

namespace skein::app {
namespace fs = std::filesystem;

int write_page(const PageRequest& request) {
  const auto refused = [](const std::string& sentence) {
    complain(sentence);
    return wrong_input;
  };
  const auto record = record_of(request.run, request.directory);
  if (!record) return refused(record.error());
  const auto page = page_of_run(record->csv, record->folder);
  if (!page) return refused(page.error());
  for (const std::string& warning : page->warnings) complain(warning);

  const std::string out = request.out.empty() ? fs::path(record->name).replace_extension("html").string() : request.out;
  if (same_file(out, record->csv))
    return refused(fmt::format("{}: is the record that is to be converted, allowed: another name", out));
  if (is_of_run(record->folder, out))
    return refused(fmt::format("{}: is a file of the kept run, allowed: another name", out));
  constexpr double patience = 60.0;  // [s]
  auto disk = DiskWriter::open(out, {.force = request.force, .whole = true});
  if (!disk) return refused(disk.error());
  if (!disk->write(page->html)) return refused(disk->failure());
  disk->publish();
  if (const auto written = disk->finish(patience); !written) return refused(written.error());
  if (const auto added = add_if_inside(record->folder, out); !added) return refused(added.error());
  if (!is_stdout(out)) print_out(fmt::format("file: {}\n", shown(out)));
  return done;
}

}  // namespace skein::app
