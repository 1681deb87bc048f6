// Mistakes of a command line and of a study: each is refused before any work is done, with a sentence.
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/places.h"

namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// A shell in a folder of its own, with `$skein`, and the paper's experiment as e.toml.
class Mistakes : public ::testing::Test {
 protected:
  Mistakes() {
    std::filesystem::create_directories(folder_);
    std::filesystem::copy_file(skein::test::in_source("resources/experiments/platoon.toml"), folder_ / "e.toml");
  }
  ~Mistakes() override { std::filesystem::remove_all(folder_); }

  std::string read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(folder_ / name, std::ios::binary).rdbuf();
    return text.str();
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }
  void study(const std::string& more) const {
    write("s.toml", "experiment = \"e.toml\"\nset = [\"duration=4\", \"perturb=[]\"]\nruns = 2\n" + more);
  }
  /// A kept run without anything but its story.
  void keep_run(const std::string& id, const std::string& began, int collisions) const {
    std::filesystem::create_directories(folder_ / "runs" / id);
    write("runs/" + id + "/run.json", R"({"id":")" + id + R"(","state":"finished","began":")" + began +
                                          R"(","summary":{"collisions":)" + std::to_string(collisions) + "}}");
  }
  /// Their exit status; what they say is in `said` (stderr) and `out`.
  int shell(const std::string& lines) {
    const std::string all = "exec > out 2> said; skein='" + skein::test::program() + "'; " + lines;
    const int status = std::system(("cd '" + folder_.string() + "' && { " + all + "\n}").c_str());
    said = read("said"), out = read("out");
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }

  std::string said, out;
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("skein-mistakes-" + std::to_string(::getpid()));
};

TEST_F(Mistakes, RunsAreRemovedWhereNameAndConditionHold) {
  keep_run("a", "2026-11-01T12:00:00.000+01:00", 0);
  keep_run("b", "2026-11-02T12:00:00.000+01:00", 3);
  keep_run("c", "2026-11-03T12:00:00.000+01:00", 3);
  EXPECT_EQ(shell("$skein runs remove a b --where 'collisions > 0' --runs-dir runs --yes"), 0) << said;
  EXPECT_TRUE(exists("runs/a")) << "named, but the condition does not hold";
  EXPECT_FALSE(exists("runs/b"));
  EXPECT_TRUE(exists("runs/c")) << "the condition holds, but it is not named";
  EXPECT_EQ(shell("mkdir other && cp -r runs/c other/c && $skein runs remove other/c --where 'collisions > 0' "
                  "--runs-dir runs --yes"),
            2);
  EXPECT_THAT(said, HasSubstr("other/c: is not in "));
  EXPECT_EQ(shell("$skein runs remove --where 'collisions > 0' --runs-dir runs --yes"), 0) << said;
  EXPECT_FALSE(exists("runs/c"));
}

TEST_F(Mistakes, ListsOfRunsSayWhatIsWrong) {
  keep_run("a", "2026-11-01T12:00:00.000+01:00", 0);
  for (const char* number : {"-1", "0"}) {
    EXPECT_EQ(shell(std::string("$skein runs list --runs-dir runs --newest ") + number), 2) << number;
    EXPECT_THAT(said, HasSubstr("allowed: a whole number from 1"));
  }
  EXPECT_EQ(shell("$skein runs list --runs-dir runs --show nosuch"), 2);
  EXPECT_THAT(said, HasSubstr("nosuch: no run has such a key"));
  EXPECT_EQ(shell("$skein runs list --runs-dir runs --show collisions --newest 1"), 0) << said;
}

TEST_F(Mistakes, WithoutAHomeTheUserDatabaseSaysWhere) {
  EXPECT_EQ(shell("unset XDG_DATA_HOME SKEIN_RUNS HOME; $skein runs show no-such-run"), 2);
  EXPECT_THAT(said, AnyOf(HasSubstr("/.local/share/skein/runs"), HasSubstr("SKEIN_RUNS")));
  EXPECT_THAT(said, Not(HasSubstr(" /.local/share")));
}

}  // namespace
