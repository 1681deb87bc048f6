// The files of `skein export` in the programs that people open them with. A case whose reader is not installed is
// skipped and says which package has it; CI installs them all.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/exchange/export.h"
#include "tests/app/exchange/recorded.h"
#include "tests/files.h"
#include "tests/places.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using test::Recorded;

struct Said {
  int status;
  std::string out;
};

Said shell(const Folder& folder, const std::string& command) {
  const std::string out = folder / "out";
  const int status = std::system(("cd '" + folder.path + "' && (" + command + ") > '" + out + "' 2>&1").c_str());
  return {status, test::read_file(out)};
}

void export_as(const Recorded& run, const std::string& to, ExportOptions options) {
  std::istringstream in(run.csv);
  const auto exported = export_run(in, "run.csv", to, options);
  ASSERT_TRUE(exported) << exported.error();
}

/// What the readers below print of a run: rows, the sum of t, r4's last x, the sum of what r1_y has, and how many rows
/// r1 tracks in.
std::string expected(const Recorded& run) {
  double t = 0.0, y = 0.0;
  int tracking_rows = 0;
  for (const TickRecord& row : run.rows) {
    t += row.t;
    y += row.robots[0].pose.y;
    tracking_rows += row.robots[0].is(tracking) ? 1 : 0;
  }
  char text[200];
  std::snprintf(text, sizeof text, "%zu %.6f %.12g %.9f %d\n", run.rows.size(), t, run.rows.back().robots[3].pose.x, y,
                tracking_rows);
  return text;
}

/// The system's own, which Debian's packages are for, before any other on the path.
std::string python() {
  return fs::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
}

TEST(Readers, PandasReadsThePlainCsv) {
  const Folder folder;
  if (shell(folder, python() + " -c 'import pandas'").status != 0) GTEST_SKIP() << "no pandas: install python3-pandas";
  const Recorded run;
  export_as(run, folder / "run.csv", {.format = ExportFormat::csv});
  const Said said = shell(folder, python() + R"( -c '
import pandas
run = pandas.read_csv("run.csv")
print("%d %.6f %.12g %.9f %d" % (len(run), run.t.sum(), run.r4_x.iloc[-1], run.r1_y.sum(), run.r1_mode.str.contains("tracking").sum()))')");
  EXPECT_EQ(said.out, expected(run));
}

TEST(Readers, OctaveLoadsTheMatFile) {
  const Folder folder;
  if (shell(folder, "octave-cli --version").status != 0) GTEST_SKIP() << "no Octave: install octave";
  const Recorded run;
  export_as(run, folder / "run.mat", {.format = ExportFormat::mat});
  const Said said = shell(folder, R"(octave-cli --no-gui --norc --eval '
load run.mat
printf("%d %.6f %.12g %.9f %d\n", numel(run.t), sum(run.t), run.r4_x(end), sum(run.r1_y), sum(!cellfun(@isempty, strfind(run.r1_mode, "tracking"))))
assert(ischar(run.experiment) && !isempty(strfind(run.experiment, "[controller]")))
assert(all(isnan(run.compute_time)))' 2>/dev/null)");
  EXPECT_EQ(said.status, 0);
  EXPECT_EQ(said.out, expected(run));
}

/// @mcap/core is Foxglove's own reader. CI puts it into build/readers (npm); SKEIN_READERS names another folder.
TEST(Readers, FoxglovesReaderReadsTheMcapFile) {
  const Folder folder;
  const char* const asked = std::getenv("SKEIN_READERS");
  const fs::path readers =
      asked ? fs::path(asked) : fs::path(skein::test::program()).parent_path().parent_path() / "readers";
  const fs::path modules = readers / "node_modules";
  if (shell(folder, "node --version").status != 0 || !fs::exists(modules / "@mcap/core") ||
      !fs::exists(modules / "@mcap/support"))
    GTEST_SKIP() << "no reader of MCAP: npm install --prefix " << readers.string() << " @mcap/core @mcap/support";
  const Recorded run;
  std::ofstream(folder / "read.js") << R"JS(
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { loadDecompressHandlers } = require("@mcap/support");
const fs = require("fs");
async function main(name) {
  const bytes = fs.readFileSync(name), decompressHandlers = await loadDecompressHandlers();
  const readable = { size: async () => BigInt(bytes.length),
                     read: async (offset, size) => new Uint8Array(bytes.buffer, bytes.byteOffset + Number(offset), Number(size)) };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  let rows = 0, t = 0, x = 0, y = 0, tracking = 0, last = -1n, frames = 0;
  const topics = new Map([...reader.channelsById.values()].map((c) => [c.id, c.topic]));
  for await (const message of reader.readMessages()) {
    if (message.logTime < last) throw new Error("not in order");
    last = message.logTime;
    const value = JSON.parse(new TextDecoder().decode(message.data)), topic = topics.get(message.channelId);
    if (topic === "/group") { rows++; t += value.t; }
    if (topic === "/r4") x = value.x;
    if (topic === "/r1") { y += value.y; tracking += value.mode.includes("tracking") ? 1 : 0; }
    if (topic === "/tf") frames += value.transforms.length;
  }
  console.log(rows, t.toFixed(6), Number(x.toPrecision(12)), y.toFixed(9), tracking);
  if (frames !== 4 * rows) throw new Error("transforms: " + frames);
  for (const schema of reader.schemasById.values()) JSON.parse(new TextDecoder().decode(schema.data));
  let attached = "";
  for await (const a of reader.readAttachments()) attached += a.name + " " + a.data.byteLength;
  console.log(attached);
  // The other reader goes from front to end and checks every checksum.
  const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  stream.append(new Uint8Array(bytes));
  let messages = 0, ended = false;
  for (let record; (record = stream.nextRecord()); ) {
    messages += record.type === "Message" ? 1 : 0;
    ended = ended || record.type === "Footer";
  }
  if (!ended || BigInt(messages) !== reader.statistics.messageCount) throw new Error("stream: " + messages);
}
main(process.argv[2]);
)JS";
  for (const bool compressed : {true, false}) {
    const std::string name = compressed ? "packed.mcap" : "plain.mcap";
    export_as(run, folder / name, {.format = ExportFormat::mcap, .compressed = compressed});
    const Said said = shell(folder, "NODE_PATH='" + modules.string() + "' node read.js " + name);
    EXPECT_EQ(said.status, 0);
    EXPECT_EQ(said.out, expected(run) + "experiment.toml " + std::to_string(run.experiment.source.size()) + "\n");
  }
}

}  // namespace
}  // namespace skein::app
