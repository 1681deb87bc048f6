// skein run whose camera is a film: nothing is written over the film, whatever is forced.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "app/calibration/calibration_file.h"
#include "app/cli/commands.h"
#include "tests/app/folder.h"
#include "tests/files.h"
#include "vision/calibration/calibration.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::app {
namespace {

/// `--video` and `--csv` with `--force` replaced the film that the run was reading.
TEST(Run, WritesNothingOverItsFilm) {
  const test::Folder folder;
  const std::string film = folder / "film.mkv", text = "a film";
  std::ofstream(film) << text;
  ASSERT_TRUE(save_calibration(vision::overhead_calibration(2.0, 1.5), folder / "cal.toml"));
  std::ofstream(folder / "e.toml") << "[camera]\nsource = \"video:" << film
                                   << "\"\ncalibration = \"cal.toml\"\n[[robot]]\nlink = \"serial:/dev/nowhere\"\n";
  for (std::string RunRequest::*output : {&RunRequest::video, &RunRequest::csv}) {
    RunRequest request;
    request.experiment.file = folder / "e.toml";
    request.*output = film;
    request.force = true;
    testing::internal::CaptureStderr();
    EXPECT_EQ(run(request), 2);
    EXPECT_THAT(testing::internal::GetCapturedStderr(),
                testing::HasSubstr(film + ": is a file that the run is read from, allowed: another file"));
    EXPECT_EQ(skein::test::read_file(film), text);
  }
}

}  // namespace
}  // namespace skein::app
