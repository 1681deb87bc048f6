#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "app/cli/command_line_runs.h"
#include "app/cli/same_file.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/runs/find_run.h"
#include "app/runs/kept_run.h"

namespace skein::app {

int export_file(const ExportRequest& request) {
  const auto record = record_of(request.run, request.directory);
  if (!record) {
    complain(record.error());
    return wrong_input;
  }
  std::ifstream csv(record->csv, std::ios::binary);
  if (!csv) {
    complain(fmt::format("{}: cannot be opened: {}", record->csv, std::strerror(errno)));
    return wrong_input;
  }
  const std::string out = request.out.empty() ? export_name(record->name, request.options.format) : request.out;
  if (same_file(out, record->csv)) {
    complain(fmt::format("{}: is the record that is to be converted, allowed: another name", out));
    return wrong_input;
  }
  if (is_of_run(record->folder, out)) {
    complain(fmt::format("{}: is a file of the kept run, allowed: another name", out));
    return wrong_input;
  }
  const auto exported = export_run(csv, record->csv, out, request.options);
  if (!exported) {
    if (interrupted()) end_by_interrupts();
    complain(exported.error());
    return wrong_input;
  }
  if (const auto added = add_if_inside(record->folder, out); !added) {
    complain(added.error());
    return wrong_input;
  }
  if (exported->torn) complain(*exported->torn);
  if (!is_stdout(out)) print_out(fmt::format("file: {}\nrows: {}\n", shown(out), exported->rows));
  return done;
}

}  // namespace skein::app
