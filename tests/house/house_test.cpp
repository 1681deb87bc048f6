// The house rules of ARCHITECTURE.md, read off the sources themselves: which room may know which, and what stays
// private to one.
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "rules.h"
#include "tests/places.h"

namespace skein::test {
namespace {

class Room : public ::testing::TestWithParam<const char*> {};

TEST_P(Room, KeepsTheHouseRules) {
  const std::vector<SourceFile> files = sources_of(GetParam());
  EXPECT_FALSE(files.empty()) << "no sources in " << GetParam() << ": is the root right?";
  for (const SourceFile& file : files)
    for (const std::string& broken : broken_rules(file)) ADD_FAILURE() << broken;
}

INSTANTIATE_TEST_SUITE_P(Of, Room, ::testing::Values("core", "vision", "comms", "app", "ui"),
                         [](const auto& room) { return std::string(room.param); });

TEST(Rules, SeeTheIncludesOfRealFiles) {
  // A reader that sees no includes would pass everything. Real files under a wrong name: core's may stand in any room,
  // but what of vision's sources includes OpenCV may stand in no other.
  int opencv = 0;
  for (const SourceFile& file : sources_of("vision")) {
    if (file.text.find("\n#include <opencv2/") == std::string::npos) continue;
    ++opencv;
    EXPECT_FALSE(broken_rules({"app/x.cpp", file.text}).empty()) << file.path;
    EXPECT_FALSE(broken_rules({"core/x.cpp", file.text}).empty()) << file.path;
  }
  EXPECT_GT(opencv, 0);
  for (const SourceFile& file : sources_of("core"))
    for (const char* room : {"vision", "comms", "app", "ui"})
      EXPECT_TRUE(broken_rules({std::string(room) + "/x.h", file.text}).empty()) << file.path;
}

struct Case {
  const char *path, *line;  // a hundred std::string in one list cost the compiler a gigabyte
};

TEST(Rules, ReportWhatIsForbidden) {
  for (const Case& c : std::initializer_list<Case>{
           // arrows
           {"core/a.h", "#include \"vision/frame.h\""},
           {"core/a.cpp", "#include \"app/session.h\""},
           {"core/a.cpp", "#include <comms/link.h>"},
           {"vision/a.cpp", "#include \"comms/link.h\""},
           {"vision/a.h", "#include \"app/session.h\""},
           {"comms/a.cpp", "#include \"vision/track.h\""},
           {"comms/a.cpp", "#include \"ui/window.h\""},
           {"app/session.cpp", "#include \"ui/window.h\""},
           {"ui/a.cpp", "#include \"vision/track.h\""},
           {"ui/a.cpp", "#include \"comms/link.h\""},
           {"app/a.cpp", "#include \"vision/fit/sampling.h\""},
           {"app/a.cpp", "#include \"vision/modules/boards.h\""},
           {"vision/a.cpp", "#include \"../comms/link.h\""},
           // core
           {"core/a.h", "#include <thread>"},
           {"core/a.h", "#include <mutex>"},
           {"core/a.h", "#include <iostream>"},
           {"core/a.h", "#include <fstream>"},
           {"core/a.h", "#include <chrono>"},
           {"core/a.h", "#include <fmt/format.h>"},
           {"core/a.h", "#include <boost/lockfree/queue.hpp>"},
           {"core/a.h", "#include <opencv2/core.hpp>"},
           {"core/a.h", "#include <QString>"},
           {"core/a.h", "#include <unistd.h>"},
           {"core/a.h", "  #  include   <thread>  // with spaces"},
           // what stays private
           {"vision/a.h", "#include <opencv2/core.hpp>"},
           {"vision/a.h", "#include <apriltag/apriltag.h>"},
           {"app/a.cpp", "#include <opencv2/core.hpp>"},
           {"ui/a.cpp", "#include <apriltag/tag36h11.h>"},
           {"comms/a.h", "#include <bluetooth/bluetooth.h>"},
           {"app/a.cpp", "#include <bluetooth/rfcomm.h>"},
           {"app/a.cpp", "#include <systemd/sd-bus.h>"},
           {"app/a.cpp", "#include <QObject>"},
           {"app/program/main.cpp", "#include <QApplication>"},
           {"comms/a.cpp", "#include <QtDBus/QDBusConnection>"},
           {"vision/a.cpp", "#include <qcustomplot.h>"},
       }) {
    const auto broken = broken_rules({c.path, std::string("#pragma once\n\n") + c.line + "\nint x;\n"});
    ASSERT_EQ(broken.size(), 1u) << c.path << " " << c.line;
    EXPECT_TRUE(broken[0].starts_with(std::string(c.path) + ":3:")) << broken[0];
  }
}

TEST(Rules, LetThroughWhatIsAllowed) {
  for (const Case& c : std::initializer_list<Case>{
           {"core/a.h", "#include <vector>"},
           {"core/a.h", "#include <Eigen/Dense>"},
           {"core/a.cpp", "#include \"core/geometry/pose.h\""},
           {"vision/a.cpp", "#include <opencv2/core.hpp>"},
           {"vision/boards/a.h", "#include <opencv2/core.hpp>"},
           {"vision/fit/a.h", "#include <apriltag/apriltag.h>"},
           {"vision/media/a.h", "#include <opencv2/videoio.hpp>"},
           {"vision/a.h", "#include \"vision/synthetic/painter.h\""},
           {"vision/a.cpp", "#include <thread>"},
           {"comms/a.cpp", "#include <bluetooth/rfcomm.h>"},
           {"comms/a.h", "#include \"core/kinematics/step_rate.h\""},
           {"app/a.cpp", "#include \"vision/track.h\""},
           {"app/a.cpp", "#include \"comms/link.h\""},
           {"app/program/main.cpp", "#include \"ui/window.h\""},
           {"ui/a.h", "#include <QWidget>"},
           {"ui/a.h", "#include \"app/session.h\""},
           {"ui/a.h", "#include \"core/geometry/pose.h\""},
           {"core/a.h", "// #include <thread> in a comment"},
       })
    EXPECT_TRUE(broken_rules({c.path, std::string(c.line) + "\n"}).empty()) << c.path << " " << c.line;
}

}  // namespace
}  // namespace skein::test
