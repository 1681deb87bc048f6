#include "app/manual/manual.h"
#include "app/manual/mistakes.h"
#include "app/manual/whole_number.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

namespace skein::app {
namespace {

/// A program with a bit of everything.
class Manual : public testing::Test {
 protected:
  Manual() {
    CLI::App& run = *program.add_subcommand("run", "Runs an experiment");
    run.add_option("experiment", text, "which")->required();
    run.add_option("--set", texts, "key=value")->type_name("KEY=VALUE");
    run.add_option("--speed", text, "how fast")->check(CLI::IsMember({"max", "realtime"}));
    run.add_flag("--quiet", flag, "says nothing");
    program.add_subcommand("replay", "Runs it again");
    CLI::App& robots = *program.add_subcommand("robots", "Real ones");
    robots.require_subcommand(1);
    robots.add_subcommand("scan", "Looks for them\nwith Bluetooth");
    program.add_subcommand("secret", "hidden")->group("");
  }
  std::string after(const std::vector<std::string>& words) const {
    return completions(program, words,
                       [](const std::string& name, const Typed& typed) -> std::optional<std::vector<Candidate>> {
                         if (name == "--set")
                           return {{{"rate=", "ticks"},
                                    {"avoidance.kind=", "how"},
                                    {"avoidance.kind=plan", {}},
                                    {"avoidance.kind=field", {}}}};
                         if (name == "experiment")
                           return {{{"platoon", {}}, {"parking", {}}, {"pa\nlast", {}}, {"--yes", {}}}};
                         if (name == "robot") return {{{typed.options.at("--file"), {}}}};
                         return {};
                       });
  }
  CLI::App program{"Says what it does", "skein"};
  std::string text;
  std::vector<std::string> texts;
  bool flag = false;
};

TEST_F(Manual, AnOptionIsNotTheValueOfAnotherOne) {
  refuse_missing_values(program);
  const auto said = [&](std::string words) -> std::string {
    try {
      program.parse(std::move(words));
    } catch (const CLI::ParseError& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_EQ(said("run x --speed --set a=1"), "--speed: --set not in {max,realtime}");
  EXPECT_EQ(said("run x --set --quiet"), "--set: KEY=VALUE is missing before --quiet");
  EXPECT_EQ(said("run x --set --speed=max"), "--set: KEY=VALUE is missing before --speed=max");
  EXPECT_EQ(said("run x --set -1 --quiet"), "") << "a negative number is a value";
  for (const char* const words : {"run x --set -", "run x --set=- --quiet"})
    EXPECT_EQ(said(words), "--set: found -, allowed: for a pipe /dev/stdout or /dev/stdin, for a file of this name ./-")
        << "by which other programs mean a pipe";
  EXPECT_EQ(said("run x --set ./-"), "");
  EXPECT_EQ(said("run --quiet -- --odd"), "") << "a file may be called so, behind --";
  EXPECT_EQ(text, "--odd");
}

TEST_F(Manual, AMistakeIsSaidWithItsPlaceAndWhatIsAllowed) {
  refuse_missing_values(program);
  say_mistakes_plainly(program);
  program.require_subcommand(0, 1);
  int size = 0;
  program.get_subcommand("replay")->add_option("--size", size, "how large")->check(whole_number(1, 9));
  const auto said = [&](std::string words) -> std::string {
    try {
      program.parse(std::move(words));
    } catch (const CLI::ParseError& error) {
      return what_is_wrong(program, error);
    }
    return misplaced(program).value_or("");
  };
  EXPECT_EQ(said("run x --speed max --quiet"), "");
  EXPECT_EQ(said("run"), "skein run: experiment: missing, allowed: which (skein run --help)");
  EXPECT_EQ(said("run x --speed slow"), "skein run: --speed: found slow, allowed: max, realtime (skein run --help)");
  EXPECT_EQ(said("run x --speed max --speed max"), "skein run: --speed: found twice, allowed: once (skein run --help)");
  EXPECT_EQ(said("run x --set"), "skein run: --set: found no value, allowed: KEY=VALUE (skein run --help)");
  EXPECT_EQ(said("run x --quiet=3"), "skein run: --quiet: found 3, allowed: no value (skein run --help)");
  EXPECT_EQ(said("run x --quiet=true"), "");
  EXPECT_EQ(said("run x --sed a=1"),
            "skein run: found --sed, a=1; did you mean --set? allowed: --help, --set, --speed, --quiet (skein run "
            "--help)");
  EXPECT_EQ(said("run x y"), "skein run: found y at the end, allowed: no more than experiment (skein run --help)");
  EXPECT_EQ(said("replay x"), "skein replay: found x at the end, allowed: options only (skein replay --help)");
  EXPECT_EQ(said("replay --size 3mm"),
            "skein replay: --size: found 3mm, allowed: a whole number from 1 to 9 (skein replay --help)");
  EXPECT_EQ(said("robots"), "skein robots: found no command, allowed: scan (skein robots --help)");
  EXPECT_EQ(said("robots scn"), "skein robots: found scn; did you mean scan? allowed: scan (skein robots --help)");
  EXPECT_EQ(said("rnu"), "skein: found rnu; did you mean run? allowed: run, replay, robots (skein --help)");
}

TEST_F(Manual, EveryCommandHasAPageAndHiddenOnesHaveNone) {
  std::vector<std::string> names;
  for (const ManualPage& page : manual_pages(program, "1.2")) names.push_back(page.name);
  EXPECT_EQ(names,
            (std::vector<std::string>{"skein", "skein-run", "skein-replay", "skein-robots", "skein-robots-scan"}));
}

TEST_F(Manual, APageHasTheWordsOfHelp) {
  const std::string page = manual_pages(program, "1.2")[1].text;
  EXPECT_NE(page.find(".SH NAME\nskein\\-run \\- runs an experiment\n"), std::string::npos) << page;
  EXPECT_NE(page.find("\\fB\\-\\-set\\fR \\fIKEY=VALUE"), std::string::npos) << page;
  EXPECT_NE(page.find("\\fB\\-\\-quiet\\fR\nsays nothing"), std::string::npos) << page;
  EXPECT_NE(page.find("\\fIEXPERIMENT\\fR\nwhich"), std::string::npos) << page;
}

TEST_F(Manual, NoLineOfAPageIsTakenForARequest) {
  CLI::App odd("What it says\n.so /etc/passwd\n'quoted'", "odd");
  const std::string page = manual_pages(odd, "1")[0].text;
  EXPECT_EQ(page.find("\n.so"), std::string::npos) << page;
  EXPECT_EQ(page.find("\n'"), std::string::npos) << page;
}

TEST_F(Manual, CompletesCommandsAndOptions) {
  EXPECT_EQ(after({"r"}), "run\tRuns an experiment\nreplay\tRuns it again\nrobots\tReal ones\n");
  EXPECT_EQ(after({"robots", ""}), "scan\tLooks for them\n");
  EXPECT_EQ(after({"run", "--s"}), "--set\tkey=value\n--speed\thow fast\n");
  EXPECT_EQ(after({"sec"}), "") << "hidden";
  EXPECT_EQ(after({"run", "x", "run", "scan"}), "") << "neither is a command there";
}

TEST_F(Manual, CompletesValues) {
  EXPECT_EQ(after({"run", "--speed", ""}), "max\t\nrealtime\t\n");
  EXPECT_EQ(after({"run", "--quiet", "pl"}), "@files\nplatoon\t\n") << "a flag takes no value";
  EXPECT_EQ(after({"run", "--speed", "max", "pa"}), "@files\nparking\t\n");
  EXPECT_EQ(after({"run", ""}), "@files\nplatoon\t\nparking\t\n")
      << "what the shell would take for other words is left out";
  EXPECT_EQ(after({"run", "platoon", "pa"}), "") << "there is one experiment";
  EXPECT_EQ(after({"run", "--set", "avo"}), "avoidance.kind=\thow\n") << "keys first";
  EXPECT_EQ(after({"run", "--set", "avoidance.kind="}), "avoidance.kind=plan\t\navoidance.kind=field\t\n");
}

TEST(Completions, KnowTheValuesOfOptionsBeforeTheWord) {
  CLI::App program{"Says what it does", "skein"};
  std::string text;
  CLI::App& verify = *program.add_subcommand("verify", "Looks");
  verify.add_option("run", text, "which");
  verify.add_option("-d,--runs-dir", text, "where");
  const auto after = [&](const std::vector<std::string>& words) {
    return completions(program, words, [](const std::string& name, const Typed& typed) {
      const auto given = typed.options.find("--runs-dir");
      return std::optional(std::vector<Candidate>{
          {name + " in " + (given == typed.options.end() ? "the usual place" : given->second), {}}});
    });
  };
  EXPECT_EQ(after({"verify", ""}), "@files\nrun in the usual place\t\n");
  EXPECT_EQ(after({"verify", "--runs-dir", "a b", ""}), "@files\nrun in a b\t\n");
  EXPECT_EQ(after({"verify", "-d", "a b", ""}), "@files\nrun in a b\t\n");
  EXPECT_EQ(after({"verify", "--runs-dir=a b", "run"}), "@files\nrun in a b\t\n");
}

}  // namespace
}  // namespace skein::app
