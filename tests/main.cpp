// The main function of every test program: properties run 1,000 cases from a fixed seed unless RC_PARAMS says
// otherwise.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <string>
#include <string_view>

#include "tests/app/folder.h"
#include "tests/places.h"

int main(int argc, char** argv) {
  // What drives real robots starts this program as its guard: let that be the program, not the tests once more.
  if (argc > 1 && std::string_view(argv[1]) == "guard") {
    const std::string program = skein::test::program();
    execv(program.c_str(), argv);
    return 1;
  }
  setenv("RC_PARAMS", "seed=20101208 max_success=1000", /*overwrite=*/0);
  ::testing::InitGoogleTest(&argc, argv);
  // testing::TempDir() of this process alone: another checkout's tests, or another user's, may run at the same time.
  const skein::test::Folder folder;
  setenv("TEST_TMPDIR", (folder.path + "/").c_str(), /*overwrite=*/1);
  return RUN_ALL_TESTS();
}
