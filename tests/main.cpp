// The main function of every test program: properties run 1,000 cases from a fixed seed unless RC_PARAMS says
// otherwise.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

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
  std::string folder = (std::filesystem::temp_directory_path() / "skein-tests-XXXXXX").string();
  if (mkdtemp(folder.data()) != nullptr) setenv("TEST_TMPDIR", (folder + "/").c_str(), /*overwrite=*/1);
  const int status = RUN_ALL_TESTS();
  std::error_code gone;
  std::filesystem::remove_all(folder, gone);
  return status;
}
