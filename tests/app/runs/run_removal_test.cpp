#include "app/runs/run_removal.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>
#include <limits>

#include "app/runs/run_folder.h"
#include "app/runs/run_index.h"
#include "tests/app/folder.h"

namespace skein::app {
namespace {

using test::Folder;

namespace fs = std::filesystem;

/// A run with a record of a megabyte and a figure in a folder below.
std::string kept(const Folder& runs, const std::string& id) {
  fs::create_directories(runs / (id + "/inputs"));
  const std::string folder = runs / id;
  std::ofstream(folder + "/" + run_files::story) << R"({"id":")" << id << R"(","state":"finished"})";
  std::ofstream(folder + "/" + run_files::record) << std::string(1'000'000, 'x');
  std::ofstream(folder + "/inputs/trajectory-1.csv") << std::string(500'000, 'x');
  return folder;
}

TEST(RunRemoval, TakesTheWholeFolderAndNoOther) {
  const Folder runs;
  const std::string first = kept(runs, "first"), second = kept(runs, "second");
  const auto removed = remove_run(first);
  EXPECT_TRUE(removed) << removed.error();
  EXPECT_FALSE(fs::exists(first));
  EXPECT_TRUE(fs::exists(second + "/run.csv"));
  auto index = RunIndex::open(runs.path).value();
  EXPECT_EQ(index.size(), 1u);
}

TEST(RunRemoval, TheIndexKnowsTheRoomThatARunTakes) {
  const Folder runs;
  const std::string folder = kept(runs, "first");
  EXPECT_GE(bytes_of_run(folder), 1'500'000u);
  auto index = RunIndex::open(runs.path).value();
  const auto large = index.find(parse_query("megabytes >= 1.5").value(), {"megabytes"});
  ASSERT_TRUE(large) << large.error();
  ASSERT_EQ(large->size(), 1u);
  EXPECT_DOUBLE_EQ(std::get<double>(large->front().facts.at("megabytes")), 1.5);
}

/// Of a run that has ended run.json says it: the other files need not be looked at, which takes long for many runs.
TEST(RunRemoval, TheRoomThatARunTakesIsInItsRunJson) {
  const Folder runs;
  fs::create_directories(runs / "whole");
  fs::create_directories(runs / "edited");
  std::ofstream(runs / "whole/run.json") << R"({"files":{"run.csv":{"bytes":2000000},"film.mkv":{"bytes":100000000}}})";
  std::ofstream(runs / "edited/run.json") << R"({"files":{"run.csv":{"bytes":-2000000},"film.mkv":7}})";
  auto index = RunIndex::open(runs.path).value();
  EXPECT_DOUBLE_EQ(std::get<double>(index.facts("whole").at("megabytes")), 102.0);
  EXPECT_DOUBLE_EQ(std::get<double>(index.facts("edited").at("megabytes")), 0.0) << "then the files are looked at";
}

TEST(RunRemoval, ARunThatAProgramIsWritingStays) {
  const Folder runs;
  const std::string folder = kept(runs, "first"), record = folder + "/" + run_files::record;
  const int writer = ::open(record.c_str(), O_WRONLY);
  ASSERT_EQ(::flock(writer, LOCK_EX), 0);
  const auto removed = remove_run(folder);
  ASSERT_FALSE(removed);
  EXPECT_EQ(removed.error(), folder + ": is not removed: a program is writing run.csv");
  EXPECT_TRUE(fs::exists(folder + "/inputs/trajectory-1.csv"));
  ::close(writer);
  EXPECT_TRUE(remove_run(folder));
}

TEST(RunRemoval, AFolderThatIsNoRunIsRefused) {
  const Folder runs;
  kept(runs, "first");
  const auto removed = remove_run(runs.path);
  ASSERT_FALSE(removed);
  EXPECT_EQ(removed.error(), runs.path + ": is not removed: it has no run.json, allowed: the folder of a kept run");
  EXPECT_TRUE(fs::exists(runs / "first/run.csv"));
}

TEST(RunRemoval, FilesOutsideThatARunLinksToStay) {
  const Folder runs, outside;
  const std::string folder = kept(runs, "first");
  std::ofstream(outside / "mine.toml") << "mine";
  fs::create_directory_symlink(outside.path, folder + "/link");
  EXPECT_TRUE(remove_run(folder));
  EXPECT_TRUE(fs::exists(outside / "mine.toml"));
}

/// A run of another folder, such as an archive, which is listed here as well by a link.
TEST(RunRemoval, OfALinkToARunOnlyTheLinkIsRemoved) {
  const Folder runs, archive;
  const std::string elsewhere = kept(archive, "first"), link = runs / "linked";
  fs::create_directory_symlink(elsewhere, link);
  const auto removed = remove_run(link);
  EXPECT_TRUE(removed) << removed.error();
  EXPECT_FALSE(fs::exists(fs::symlink_status(link)));
  EXPECT_EQ(files_of_run(elsewhere), (std::vector<std::string>{"inputs/trajectory-1.csv", "run.csv", "run.json"}));
}

TEST(LittleRoom, IsSaidWithTheWayOut) {
  const Folder runs;
  EXPECT_FALSE(little_room(runs.path, 0));
  const auto sentence = little_room(runs / "not/made/yet", std::numeric_limits<std::uintmax_t>::max());
  ASSERT_TRUE(sentence);
  EXPECT_NE(sentence->find("skein runs remove"), std::string::npos) << *sentence;
}

}  // namespace
}  // namespace skein::app
