#include "app/runs/run_index.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <memory>

#include "app/runs/find_run.h"
#include "app/runs/run_folder.h"
#include "tests/app/folder.h"

namespace skein::app {
namespace {

using test::Folder;

void keep_run(const Folder& runs, const std::string& id, const std::string& story) {
  std::filesystem::create_directories(runs / id);
  std::ofstream(runs / (id + "/" + run_files::story)) << story;
}

void keep_run(const Folder& runs, int number, double k_xx, int collisions) {
  const std::string id = "2026-11-0" + std::to_string(number) + "_120000_platoon";
  keep_run(runs, id,
           R"({"id":")" + id + R"(","state":"finished","began":"2026-11-0)" + std::to_string(number) +
               R"(T12:00:00.000+01:00","machine":{"host":"lab)" + std::to_string(number % 2) +
               R"("},"experiment":{"controller.gains.k_xx":)" + std::to_string(k_xx) +
               R"(,"robot.1.v_max":1,"controller.v_max":0.1,"controller.saturation":"tanh"},"summary":{"collisions":)" +
               std::to_string(collisions) + R"(,"arrived":null,"stopped":false}})");
}

std::vector<std::string> found(RunIndex& index, const std::string& text) {
  const auto query = parse_query(text);
  EXPECT_TRUE(query) << query.error();
  const auto runs = index.find(*query, {});
  EXPECT_TRUE(runs) << runs.error();
  std::vector<std::string> days;
  if (runs)
    for (const RunIndex::Run& run : *runs) days.push_back(run.id.substr(9, 1));
  return days;
}

using Days = std::vector<std::string>;

struct FourRuns {
  Folder runs;
  FourRuns() {
    keep_run(runs, 1, 0.005, 0);
    keep_run(runs, 2, 0.02, 0);
    keep_run(runs, 3, 0.03, 2);
    keep_run(runs, 4, 0.01, 0);
  }
};

TEST(RunIndex, FindsRunsByWhatTheyWereAndWhatCameOfThem) {
  FourRuns four;
  auto index = RunIndex::open(four.runs.path).value();
  EXPECT_EQ(index.size(), 4u);
  EXPECT_EQ(found(index, "k_xx > 0.008 and collisions = 0"), (Days{"2", "4"}));
  EXPECT_EQ(found(index, "controller.gains.k_xx >= 0.02 or began < 2026-11-02"), (Days{"1", "2", "3"}));
  EXPECT_EQ(found(index, "not collisions = 0"), (Days{"3"}));
  EXPECT_EQ(found(index, "machine.host = lab1 and not (k_xx = 0.03)"), (Days{"1"}));
  EXPECT_EQ(found(index, "host ~ 'ab0'"), (Days{"2", "4"}));
  EXPECT_EQ(found(index, "stopped = false and saturation = tanh and collisions != 0"), (Days{"3"}));
  EXPECT_EQ(found(index, "v_max = 0.1").size(), 4u) << "keys of single robots stand behind that of the group";
}

std::string refusal(RunIndex& index, const std::string& text) {
  const auto runs = index.find(parse_query(text).value(), {});
  return runs ? "" : runs.error();
}

/// Else `remove --where 'began < 2026-9-1'` would remove the runs of November.
TEST(RunIndex, TimesAreComparedAsTimes) {
  FourRuns four;
  auto index = RunIndex::open(four.runs.path).value();
  EXPECT_EQ(found(index, "began = 2026-11-02"), (Days{"2"})) << "as exactly as it is written";
  EXPECT_EQ(found(index, "began <= 2026-11-02"), (Days{"1", "2"}));
  EXPECT_EQ(found(index, "began < 2026-11-02"), (Days{"1"}));
  EXPECT_EQ(found(index, "began > 2026-11-02"), (Days{"3", "4"}));
  EXPECT_EQ(found(index, "began = 2026-11").size(), 4u);
  EXPECT_EQ(found(index, "began = 2026 and began > 2025").size(), 4u) << "no number, but a year";
  EXPECT_EQ(found(index, "began > '2026-11-02 11:30' and began < '2026-11-03 12:00'"), (Days{"2"}));
  EXPECT_EQ(found(index, "began > 2026-11-02T13:00"), (Days{"3", "4"}));
  EXPECT_EQ(found(index, "began >= 2026-11-03T12:00:00.000+01:00"), (Days{"3", "4"}));
  EXPECT_EQ(found(index, "began > 2026-11-03T10:30:00Z"), (Days{"3", "4"})) << "half an hour before 12:00+01:00";
  EXPECT_EQ(found(index, "began > 2026-11-03T13:30+02:00"), (Days{"4"}));
  for (const char* const bad :
       {"2026-9-1", "yesterday", "01.11.2026", "11/01/2026", "2026-13-01", "2026-11-20T8:15", "2026-11-20T20:15+1",
        "2026-11-2", "''", "2026-11-20T20:15:00.0001", "2026-02-30", "2026-11-31T20:15", "2027-02-29T20:15:00Z"})
    EXPECT_NE(refusal(index, std::string("began < ") + bad).find("allowed: a date such as 2026-11-20"),
              std::string::npos)
        << bad;
  EXPECT_EQ(found(index, "began ~ '11-04'"), (Days{"4"}));
  EXPECT_EQ(found(index, "began > 2024-02-29").size(), 4u) << "the control: a leap day";
}

/// camera.source = "none" says that there is no camera; run.json has it as null, as it has results that are none.
TEST(RunIndex, TheWordNoneOfAnExperimentIsFound) {
  FourRuns four;
  keep_run(four.runs, "2026-11-05_120000_a",
           R"({"experiment":{"camera.source":null},"summary":{"arrived":null,"collisions":0}})");
  keep_run(four.runs, "2026-11-06_120000_a", R"({"experiment":{"camera.source":"synthetic"}})");
  auto index = RunIndex::open(four.runs.path).value();
  EXPECT_EQ(found(index, "camera.source = none"), (Days{"5"}));
  EXPECT_EQ(found(index, "camera.source != none"), (Days{"6"}));
  EXPECT_NE(refusal(index, "arrived = none").find("no run has such a key"), std::string::npos) << "the control";
}

TEST(RunIndex, ATextIsNoNumberAndIsRefusedWhereAllRunsHaveOne) {
  FourRuns four;
  auto index = RunIndex::open(four.runs.path).value();
  for (const char* const bad : {"k_xx > 0,01", "k_xx < 1e400", "collisions != none", "not k_xx = '0.01'"})
    EXPECT_NE(refusal(index, bad).find("allowed: a number"), std::string::npos) << bad << ": " << refusal(index, bad);
  for (const char* const bad : {"saturation > 5", "host = 7", "began < 2026.5"})
    EXPECT_NE(refusal(index, bad).find("allowed: a text"), std::string::npos) << bad << ": " << refusal(index, bad);
  keep_run(four.runs, "2026-11-05_120000_a", R"({"experiment":{"controller.saturation":5}})");
  auto with_both = RunIndex::open(four.runs.path).value();
  EXPECT_EQ(found(with_both, "saturation > 4"), (Days{"5"})) << "a text is not larger than a number";
  EXPECT_EQ(found(with_both, "saturation > a").size(), 4u);
  std::filesystem::remove_all(four.runs / "2026-11-05_120000_a");
  auto again = RunIndex::open(four.runs.path).value();
  EXPECT_NE(refusal(again, "saturation > 4").find("allowed: a text"), std::string::npos) << "the number is gone";
}

TEST(RunIndex, SeedsThatNoDoubleHoldsAreToldApart) {
  const Folder runs;
  keep_run(runs, "2026-11-01_120000_a", R"({"experiment":{"experiment.seed":9007199254740992}})");
  keep_run(runs, "2026-11-02_120000_a", R"({"experiment":{"experiment.seed":9007199254740993}})");
  keep_run(runs, "2026-11-03_120000_a", R"({"experiment":{"experiment.seed":9223372036854775807}})");
  RunIndex index = RunIndex::open(runs.path).value();
  EXPECT_EQ(found(index, "seed = 9007199254740993"), Days({"2"}));
  EXPECT_EQ(found(index, "seed = 9007199254740992"), Days({"1"}));
  EXPECT_EQ(found(index, "seed > 9007199254740992"), Days({"2", "3"}));
  EXPECT_EQ(found(index, "seed >= 9223372036854775807 or seed < 1e16"), Days({"1", "2", "3"}));
}

/// Wherever in the file it is: nobody has to delete it by hand.
TEST(RunIndex, AnIndexThatIsDamagedInTheMidstIsMadeAnew) {
  const Folder runs;
  for (int run = 0; run < 60; ++run)
    keep_run(runs,
             std::string("2026-11-01_1200") + static_cast<char>('0' + run / 10) + static_cast<char>('0' + run % 10),
             R"({"experiment":{"k_xx":0.01,"name":")" + std::string(200, 'x') + R"("}})");
  const std::string file = runs / ".index.sqlite";
  const auto query = parse_query("k_xx = 0.01").value();
  std::filesystem::remove(file);
  ASSERT_EQ(RunIndex::open(runs.path)->find(query, {})->size(), 60u);
  const auto size = std::filesystem::file_size(file);
  for (std::uintmax_t at = 100; at < size; at += 1024) {
    {
      std::fstream damaged(file, std::ios::binary | std::ios::in | std::ios::out);
      damaged.seekp(static_cast<std::streamoff>(at));
      damaged << std::string(512, '\xa5');
    }
    auto index = RunIndex::open(runs.path);
    ASSERT_TRUE(index) << at;
    const auto matching = index->find(query, {"name"});
    ASSERT_TRUE(matching) << at << ": " << matching.error();
    EXPECT_EQ(index->all({"name"}).size(), 60u) << at;
    EXPECT_EQ(index->newest(), "2026-11-01_120059") << at;
    std::filesystem::remove(file);
    ASSERT_EQ(RunIndex::open(runs.path)->size(), 60u);
  }
}

TEST(RunIndex, ShowsWhatIsAskedForByItsShortName) {
  FourRuns four;
  auto index = RunIndex::open(four.runs.path).value();
  const auto runs = index.all({"k_xx", "nonsense"});
  ASSERT_EQ(runs.size(), 4u);
  EXPECT_EQ(std::get<double>(runs[2].facts.at("k_xx")), 0.03);
  EXPECT_FALSE(runs[2].facts.contains("nonsense"));
}

TEST(RunIndex, TheNewestIsTheOneThatBeganLastWhateverTheTimeZone) {
  Folder runs;
  const auto keep = [&](const std::string& id, const std::string& began) {
    keep_run(runs, id, R"({"began":")" + began + R"("})");
  };
  keep("2026-10-25_025900_a", "2026-10-25T02:59:00.000+02:00");  // then the clocks go back
  keep("2026-10-25_020500_b", "2026-10-25T02:05:00.500+01:00");
  keep("2026-10-24_200600_c", "2026-10-24T20:06:00.000-05:00");  // on a journey
  EXPECT_EQ(find_run("last", runs.path).value(), runs / "2026-10-24_200600_c");
  auto index = RunIndex::open(runs.path).value();
  std::vector<std::string> ids;
  for (const RunIndex::Run& run : index.all({})) ids.push_back(run.id.substr(18));
  EXPECT_EQ(ids, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_FALSE(index.knows({"began", "nosuch"}));
  EXPECT_TRUE(index.knows({"began"}));
}

TEST(RunIndex, AMinuteThatTheClockShowsTwiceIsToldApartByItsZone) {
  Folder runs;
  keep_run(runs, "2026-10-25_023010_a", R"({"began":"2026-10-25T02:30:10.437+02:00"})");
  keep_run(runs, "2026-10-26_023005_b", R"({"began":"2026-10-25T02:30:05.495+01:00"})");  // clocks went back
  auto index = RunIndex::open(runs.path).value();
  EXPECT_EQ(found(index, "began = 2026-10-25T02:30"), (Days{"5", "6"}));
  EXPECT_EQ(found(index, "began = 2026-10-25T02:30+02:00"), (Days{"5"}));
  EXPECT_EQ(found(index, "began = 2026-10-25T02:30+01:00"), (Days{"6"}));
  EXPECT_EQ(found(index, "began = 2026-10-25T01:30Z"), (Days{"6"}));
  EXPECT_EQ(found(index, "began = 2026-10-25T01:30:05Z"), (Days{"6"}));
  EXPECT_EQ(found(index, "began = 2026-10-25T01:30:05.495Z"), (Days{"6"}));
  EXPECT_EQ(found(index, "began > 2026-10-25T02:30+02:00"), (Days{"6"})) << "after that minute";
  EXPECT_EQ(found(index, "began < 2026-10-25T01:30:05Z"), (Days{"5"}));
}

TEST(RunIndex, TheFolderOfARunGetsNoIndex) {
  Folder runs;
  keep_run(runs, "2026-11-05_120000_a", R"({"began":"2026-11-05T12:00:00.000+01:00"})");
  const auto index = RunIndex::open(runs / "2026-11-05_120000_a");
  ASSERT_FALSE(index);
  EXPECT_NE(index.error().find("allowed: the folder that has the runs"), std::string::npos) << index.error();
  EXPECT_EQ(files_of_run(runs / "2026-11-05_120000_a"), std::vector<std::string>{"run.json"});
}

TEST(RunIndex, TheNewestMayBeOfBefore1970) {
  Folder runs;
  keep_run(runs, "a", R"({"began":"1965-10-25T02:59:00.000+02:00"})");
  keep_run(runs, "b", R"({"began":"1966-10-25T02:59:00.000+02:00"})");
  EXPECT_EQ(find_run("last", runs.path).value(), runs / "b");
}

TEST(RunIndex, ARunThatSaysNoTimeIsAsOldAsItsFile) {
  for (const char* began :
       {"", "yesterday", "2026-10-25T02:59", "2026-13-45T02:59:00.000+02:00", "9999-10-25T02:59:00.000+02:00",
        "0001-10-25T02:59:00.000+02:00", "2026-10-25T02:59:1e300+02:00", "2026-10-25T02:59:-1.00+02:00",
        "2026-10-25T25:59:00.000+02:00", "2026-10-25T02:75:00.000+02:00", "2026-10-25T02:59:00.000+99:00",
        "2026-10-25T02:59:nan+02:00"})
    EXPECT_FALSE(began_at(nlohmann::ordered_json{{"began", began}})) << began;
  Folder runs;
  keep_run(runs, "a", R"({"began":"2001-10-25T02:59:00.000+02:00"})");
  keep_run(runs, "0", R"({"began":"yesterday"})");
  EXPECT_EQ(find_run("last", runs.path).value(), runs / "0");
  std::filesystem::remove_all(runs / "0");
  keep_run(runs, "00", "{");
  EXPECT_EQ(find_run("last", runs.path).value(), runs / "00") << "no older one takes its place";
}

/// Of a machine whose clock is wrong: ns since 1970 end in 2262.
TEST(RunIndex, ATimeFarAheadIsLaterThanAllOthers) {
  EXPECT_GT(began_at(nlohmann::ordered_json{{"began", "2261-12-31T23:59:59.000+00:00"}}),
            began_at(nlohmann::ordered_json{{"began", "2200-12-31T23:59:59.000+00:00"}}));
  const Folder runs;
  keep_run(runs, "a", R"({"began":"2261-12-31T23:59:59.000+00:00"})");
  keep_run(runs, "0", R"({"began":"yesterday"})");
  constexpr time_t year_2300 = 10'413'792'000;
  const std::array<timespec, 2> times{{{year_2300, 0}, {year_2300, 0}}};
  ASSERT_EQ(::utimensat(AT_FDCWD, (runs / "0/run.json").c_str(), times.data(), 0), 0);
  EXPECT_EQ(find_run("last", runs.path).value(), runs / "0");
}

TEST(RunIndex, AKeyThatIsNotThereIsRefusedWithSimilarOnes) {
  FourRuns four;
  auto index = RunIndex::open(four.runs.path).value();
  const auto runs = index.find(parse_query("collision = 0").value(), {});
  ASSERT_FALSE(runs);
  EXPECT_NE(runs.error().find("collisions"), std::string::npos) << runs.error();
}

TEST(RunIndex, FollowsTheFoldersAndMayBeThrownAway) {
  FourRuns four;
  { const auto index = RunIndex::open(four.runs.path).value(); }
  std::filesystem::remove_all(four.runs / "2026-11-02_120000_platoon");
  keep_run(four.runs, 5, 0.5, 0);
  keep_run(four.runs, 4, 0.4, 7);  // has come to its end meanwhile
  const auto look = [&] {
    auto index = RunIndex::open(four.runs.path).value();
    EXPECT_EQ(found(index, "k_xx > 0.008"), (Days{"3", "4", "5"}));
    EXPECT_EQ(found(index, "collisions = 7"), (Days{"4"}));
    EXPECT_EQ(std::get<double>(index.facts("2026-11-05_120000_platoon").at("controller.gains.k_xx")), 0.5);
  };
  look();
  std::filesystem::remove(four.runs / ".index.sqlite");
  look();
  std::ofstream(four.runs / ".index.sqlite") << "no database, " << std::string(10'000, 'x');
  look();
  EXPECT_GT(std::filesystem::file_size(four.runs / ".index.sqlite"), 0u);
}

TEST(RunIndex, ARunThatCannotBeReadIsNamedAndHidesNoOther) {
  FourRuns four;
  keep_run(four.runs, "2026-11-06_120000_torn", "{\"id\":");
  auto index = RunIndex::open(four.runs.path).value();
  EXPECT_EQ(index.size(), 4u);
  ASSERT_EQ(index.problems().size(), 1u);
  EXPECT_NE(index.problems().front().find("torn/run.json"), std::string::npos);
}

/// Reading a FIFO would wait for ever.
TEST(RunIndex, WhatIsNoFileIsNamedAndHidesNoRun) {
  FourRuns four;
  std::filesystem::create_directories(four.runs / "fifo");
  ASSERT_EQ(::mkfifo((four.runs / "fifo/run.json").c_str(), 0600), 0);
  std::filesystem::create_directories(four.runs / "folder/run.json");
  auto index = RunIndex::open(four.runs.path).value();
  EXPECT_EQ(index.size(), 4u);
  ASSERT_EQ(index.problems().size(), 2u);
  for (const std::string& problem : index.problems())
    EXPECT_NE(problem.find("allowed: a file"), std::string::npos) << problem;
}

TEST(RunIndex, AFolderThatMayNotBeLookedIntoIsNamed) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may look into every folder";
  FourRuns four;
  std::filesystem::permissions(four.runs / "2026-11-02_120000_platoon", std::filesystem::perms::none);
  auto index = RunIndex::open(four.runs.path).value();
  std::filesystem::permissions(four.runs / "2026-11-02_120000_platoon", std::filesystem::perms::owner_all);
  EXPECT_EQ(index.size(), 3u);
  ASSERT_EQ(index.problems().size(), 1u);
  EXPECT_NE(index.problems()[0].find("2026-11-02_120000_platoon/run.json: cannot be read: Permission denied"),
            std::string::npos)
      << index.problems()[0];
}

/// What a program leaves that is killed while it writes the index.
TEST(RunIndex, AWriterThatIsKilledHidesNoRun) {
  const Folder runs;
  const auto keep = [&](int number, int collisions) {
    std::string story = R"({"summary":{"collisions":)" + std::to_string(collisions);
    for (int key = 0; key < 40; ++key)
      story += ",\"value_" + std::to_string(key) + "\":\"" + std::string(50, 'x') + std::to_string(collisions) + '"';
    keep_run(runs, "run_" + std::to_string(100 + number), story + "}}");
  };
  constexpr int all = 60;
  for (int number = 0; number < all; ++number) keep(number, 0);
  const std::string file = runs / ".index.sqlite", before = runs / "before";
  ASSERT_EQ(RunIndex::open(runs.path)->size(), std::size_t{all});
  std::filesystem::copy_file(file, before);
  keep(all / 2, 17);
  const auto size = std::filesystem::file_size(file);
  const auto query = parse_query("collisions = 17 and value_0 ~ x and value_39 ~ x").value();
  constexpr std::uintmax_t page = 4096;
  for (std::uintmax_t most = page; most < size; most += page) {
    const pid_t writer = ::fork();
    if (writer == 0) {  // the system kills it when it writes beyond `most`
      const rlimit none{0, 0}, limit{most, most};
      ::setrlimit(RLIMIT_CORE, &none);
      ::setrlimit(RLIMIT_FSIZE, &limit);
      ::signal(SIGXFSZ, SIG_DFL);
      (void)RunIndex::open(runs.path);
      ::_exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(writer, &status, 0), writer);
    auto index = RunIndex::open(runs.path);
    ASSERT_TRUE(index) << most;
    const auto matching = index->find(query, {});
    ASSERT_TRUE(matching) << most << ": " << matching.error();
    EXPECT_EQ(matching->size(), 1u) << most;
    EXPECT_EQ(index->all({}).size(), std::size_t{all}) << most;
    std::filesystem::remove(file);
    std::filesystem::remove(file + "-journal");
    std::filesystem::copy_file(before, file);
  }
}

/// The index as another program has it open.
struct OtherProgram {
  explicit OtherProgram(const std::string& file) {
    sqlite3* opened = nullptr;
    EXPECT_EQ(sqlite3_open(file.c_str(), &opened), SQLITE_OK);
    database.reset(opened);
  }
  void does(const char* sql) const {
    EXPECT_EQ(sqlite3_exec(database.get(), sql, nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database.get());
  }
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> database{nullptr, sqlite3_close};
};

/// It is on a disk that takes nothing, belongs to somebody else, or another program is writing it: it is sound all the
/// same, and making it anew takes long.
TEST(RunIndex, OneThatCannotBeWrittenStaysAndIsUsed) {
  FourRuns four;
  const std::string file = four.runs / ".index.sqlite";
  ASSERT_EQ(RunIndex::open(four.runs.path)->size(), 4u);
  const OtherProgram other(file);
  other.does("UPDATE fact SET value = 17 WHERE value = 0.005");  // shows that the index is what is asked
  other.does("BEGIN IMMEDIATE");
  keep_run(four.runs, 5, 0.5, 0);
  struct stat before {
  }, after{};
  ASSERT_EQ(::stat(file.c_str(), &before), 0);
  auto index = RunIndex::open(four.runs.path, std::chrono::milliseconds(0)).value();
  EXPECT_EQ(found(index, "k_xx = 17"), (Days{"1"})) << "the index was thrown away";
  EXPECT_EQ(found(index, "k_xx = 0.5"), (Days{"5"})) << "what is new is known as well";
  ASSERT_EQ(::stat(file.c_str(), &after), 0);
  EXPECT_EQ(before.st_ino, after.st_ino);
  other.does("ROLLBACK");
}

/// A run that has only begun: what it is expected to give is not what it gave.
TEST(RunIndex, AnExpectationIsNotTakenForAResult) {
  const Folder runs;
  keep_run(runs, "2026-11-06_120000_begun", R"({"state":"begun","experiment":{"expect.final_error":0.002}})");
  auto index = RunIndex::open(runs.path).value();
  EXPECT_TRUE(index.all({"final_error"}).front().facts.empty());
  EXPECT_EQ(refusal(index, "final_error < 1"),
            "final_error: no run has such a key; similar ones are expect.final_error");
  EXPECT_EQ(index.find(parse_query("expect.final_error < 1").value(), {})->size(), 1u);
}

/// What may not be looked into has runs, maybe.
TEST(RunIndex, OfADirectoryThatCannotBeReadTheReasonIsSaid) {
  const Folder folder;
  std::filesystem::create_symlink("runs", folder / "runs");  // this stops root as well
  EXPECT_EQ(RunIndex::open(folder / "runs").error(),
            folder / "runs" + ": cannot be read: Too many levels of symbolic links");
  EXPECT_NE(RunIndex::open(folder / "none").error().find("no run has been kept there"), std::string::npos);
}

/// A run.json from elsewhere: what is nested so deep cannot be written, since that recurses.
TEST(RunIndex, ARunJsonThatIsNestedTooDeepIsNamed) {
  FourRuns four;
  const std::string deep(1'000'000, '[');
  keep_run(four.runs, "2026-11-06_120000_deep", R"({"x":)" + deep + std::string(deep.size(), ']') + "}");
  auto index = RunIndex::open(four.runs.path).value();
  EXPECT_EQ(index.size(), 4u);
  EXPECT_EQ(index.problems().size(), 1u);
}

TEST(RunFolder, IsFoundByNameBeginningPathAndLast) {
  FourRuns four;
  const std::string second = four.runs / "2026-11-02_120000_platoon";
  EXPECT_EQ(find_run("2026-11-02_120000_platoon", four.runs.path).value(), second);
  EXPECT_EQ(find_run("2026-11-02", four.runs.path).value(), second);
  EXPECT_EQ(find_run(second, "/nowhere").value(), second);
  EXPECT_EQ(find_run("last", four.runs.path).value(), four.runs / "2026-11-04_120000_platoon");
  EXPECT_NE(find_run("2026", four.runs.path).error().find("4 runs"), std::string::npos);
  EXPECT_FALSE(find_run("2027", four.runs.path));
  EXPECT_FALSE(find_run("../x", four.runs.path));
  // Of a folder that was named, what it lacks is said, and not what is in that of all runs.
  std::filesystem::create_directories(four.runs / "elsewhere/mine");
  for (const std::string& runs : {four.runs.path, four.runs / "elsewhere"})
    EXPECT_EQ(find_run(four.runs / "elsewhere/mine", runs).error(),
              four.runs / "elsewhere/mine" + ": is not the folder of a kept run: it has no file run.json");
}

}  // namespace
}  // namespace skein::app
