// A file that grows while a run goes on: its name, its draft, disks that stall or are full.
#include "app/record/disk_writer.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "tests/app/folder.h"
#include "tests/eventually.h"
#include "tests/files.h"
#include "tests/small_disk.h"

namespace {
std::atomic<off_t> synced_size{-1};  // of the file that was given to the disk last [bytes]
}

/// The C library's, which this program's writer calls instead.
extern "C" int fdatasync(int file) {
  struct stat found {};
  if (::fstat(file, &found) == 0) synced_size = found.st_size;
  return static_cast<int>(::syscall(SYS_fdatasync, file));
}

namespace skein::app {
namespace {

namespace fs = std::filesystem;

class DiskWriting : public testing::Test {
 protected:
  std::string operator/(const char* name) const { return (folder_ / name).string(); }
  static std::string text(const std::string& path) { return test::read_file(path); }
  const test::Folder own_folder_;
  const fs::path folder_ = own_folder_.path;
};

TEST_F(DiskWriting, AFileHasItsNameWhenItIsPublished) {
  auto disk = DiskWriter::open(*this / "run.csv");
  ASSERT_TRUE(disk) << disk.error();
  EXPECT_TRUE(disk->write("head\n"));
  ASSERT_TRUE(disk->flush(10.0));
  EXPECT_FALSE(fs::exists(*this / "run.csv"));
  disk->publish();
  EXPECT_TRUE(disk->write("row\n"));
  ASSERT_TRUE(disk->finish(10.0));
  EXPECT_EQ(text(*this / "run.csv"), "head\nrow\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(DiskWriting, ARunThatNeverBeganLeavesNothing) {
  {
    auto disk = DiskWriter::open(*this / "run.csv");
    ASSERT_TRUE(disk);
    disk->write("head\n");
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(DiskWriting, AnOlderRunIsNotOverwrittenAndAFreeNameIsOffered) {
  std::ofstream(*this / "run.csv") << "yesterday";
  const auto refused = DiskWriter::open(*this / "run.csv");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().find("run-2.csv"), std::string::npos) << refused.error();
  auto forced = DiskWriter::open(*this / "run.csv", {.force = true});
  ASSERT_TRUE(forced);
  forced->write("today");
  ASSERT_TRUE(forced->flush(10.0));
  EXPECT_EQ(text(*this / "run.csv"), "yesterday") << "until the run begins";
  forced->publish();
  ASSERT_TRUE(forced->finish(10.0));
  EXPECT_EQ(text(*this / "run.csv"), "today");
}

/// Before, the run was recorded as run.csv.part: "run.csv: File exists".
TEST_F(DiskWriting, ALinkLeadsToAFileThatIsNotThereYet) {
  fs::create_directory(*this / "disk");
  fs::create_symlink("disk/today.csv", *this / "run.csv");
  fs::create_symlink("run.csv", *this / "last.csv");
  for (const bool whole : {false, true}) {
    auto disk = DiskWriter::open(*this / "last.csv", {.whole = whole});
    ASSERT_TRUE(disk) << disk.error();
    disk->write("rows");
    disk->publish();
    const auto finished = disk->finish(10.0);
    ASSERT_TRUE(finished) << finished.error();
    EXPECT_TRUE(fs::is_symlink(*this / "run.csv"));
    EXPECT_EQ(text(*this / "disk/today.csv"), "rows");
    fs::remove(*this / "disk/today.csv");
  }
  fs::remove(*this / "disk");
  EXPECT_FALSE(DiskWriter::open(*this / "run.csv")) << "there is no such folder";
}

TEST_F(DiskWriting, LinksThatLeadInACircleAreRefused) {
  fs::create_symlink("b.csv", *this / "a.csv");
  fs::create_symlink("a.csv", *this / "b.csv");
  const auto refused = DiskWriter::open(*this / "a.csv", {.force = true});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().find("a.csv: "), std::string::npos) << refused.error();
  EXPECT_NE(refused.error().find("symbolic links"), std::string::npos) << refused.error();
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
}

TEST_F(DiskWriting, AFileThatAppearsMeanwhileIsNotOverwrittenEither) {
  auto disk = DiskWriter::open(*this / "run.csv");
  ASSERT_TRUE(disk);
  std::ofstream(*this / "run.csv") << "another's";
  disk->write("mine");
  disk->publish();
  const auto finished = disk->finish(10.0);
  ASSERT_FALSE(finished);
  EXPECT_EQ(text(*this / "run.csv"), "another's");
  EXPECT_EQ(text(*this / "run.csv.part"), "mine") << finished.error();
}

TEST_F(DiskWriting, TwoProgramsDoNotWriteOneFile) {
  const auto one = DiskWriter::open(*this / "run.csv");
  ASSERT_TRUE(one);
  const auto two = DiskWriter::open(*this / "run.csv");
  ASSERT_FALSE(two);
  EXPECT_NE(two.error().find("another program"), std::string::npos) << two.error();
}

TEST_F(DiskWriting, ARunThatGoesOnIsNotOverwrittenEvenByForce) {
  auto one = DiskWriter::open(*this / "run.csv");
  ASSERT_TRUE(one);
  one->write("head\n");
  one->publish();
  ASSERT_TRUE(one->flush(10.0));
  const auto two = DiskWriter::open(*this / "run.csv", {.force = true});
  ASSERT_FALSE(two);
  EXPECT_NE(two.error().find("another program is writing it now"), std::string::npos) << two.error();
  one->write("row\n");
  ASSERT_TRUE(one->finish(10.0));
  EXPECT_EQ(text(*this / "run.csv"), "head\nrow\n");
  EXPECT_TRUE(DiskWriter::open(*this / "run.csv", {.force = true})) << "once it has ended";
}

TEST_F(DiskWriting, AStalledReaderHoldsUpNobodyAndWhatIsNotWrittenIsSaid) {
  const std::string fifo = *this / "fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const int reader = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  auto disk = DiskWriter::open(fifo);
  ASSERT_TRUE(disk) << disk.error();
  EXPECT_TRUE(disk->write(std::string(1 << 20, 'x'))) << "taken, though a pipe holds 64 kB";
  const auto finished = disk->finish(0.1);
  ASSERT_FALSE(finished);
  EXPECT_NE(finished.error().find("NOT written"), std::string::npos) << finished.error();
  ::close(reader);
}

// What only the kernel knows is lost at a power cut.
TEST_F(DiskWriting, RowsAreGivenToTheDiskWhileTheRunGoesOn) {
  auto disk = DiskWriter::open(*this / "run.csv");
  ASSERT_TRUE(disk) << disk.error();
  for (off_t rows = 1; rows <= 3; ++rows) {
    ASSERT_TRUE(disk->write("row\n"));
    EXPECT_TRUE(test::eventually([rows] { return synced_size == 4 * rows; })) << synced_size;
  }
  ASSERT_TRUE(disk->finish(10.0));
}

TEST_F(DiskWriting, WhatIsWrittenOverAFileHasItsRights) {
  std::ofstream(*this / "run.csv") << "yesterday";
  fs::permissions(*this / "run.csv", fs::perms::owner_read | fs::perms::owner_write);
  for (const bool whole : {false, true}) {
    auto disk = DiskWriter::open(*this / "run.csv", {.force = true, .whole = whole});
    ASSERT_TRUE(disk) << disk.error();
    disk->write("today\n");
    disk->publish();
    ASSERT_TRUE(disk->finish(10.0));
    EXPECT_EQ(text(*this / "run.csv"), "today\n");
    EXPECT_EQ(fs::status(*this / "run.csv").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  }
}

/// The head and some rows are worth more than nothing; a head alone must not replace an older run.
TEST_F(DiskWriting, WhatAFullDiskHasTakenOfARunIsKept) {
  for (const bool all_at_once : {true, false}) {
    for (const rlim_t room : {9, 3}) {
      std::ofstream(*this / "run.csv") << "yesterday";
      std::optional<test::SmallDisk> little(std::in_place, room);
      auto disk = DiskWriter::open(*this / "run.csv", {.force = true});
      disk->write("head\n");
      disk->publish();
      if (!all_at_once) (void)disk->flush(10.0);
      disk->write("row 1\nrow 2\n");
      const auto finished = disk->finish(10.0);
      little.reset();
      ASSERT_FALSE(finished);
      EXPECT_NE(finished.error().find("File too large"), std::string::npos) << finished.error();
      EXPECT_EQ(text(*this / "run.csv"), room > 5 ? "head\nrow " : "yesterday");
      EXPECT_FALSE(fs::exists(*this / "run.csv.part"));
    }
  }
}

TEST_F(DiskWriting, AFullDiskIsAnError) {
  auto disk = DiskWriter::open("/dev/full");
  ASSERT_TRUE(disk) << disk.error();
  disk->write("x");
  const auto finished = disk->finish(10.0);
  ASSERT_FALSE(finished);
  EXPECT_NE(finished.error().find("No space left"), std::string::npos) << finished.error();
}

}  // namespace
}  // namespace skein::app
