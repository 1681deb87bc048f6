// The house rules of ARCHITECTURE.md, checked against the sources: which folder may include which, what stays private
// to a room, and that nothing includes itself in a circle.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "rules.h"
#include "tests/places.h"

namespace skein::test {
namespace {

const Arrows& architecture() {
  static const Arrows arrows = arrows_of(text_of("ARCHITECTURE.md"));
  return arrows;
}

class Room : public ::testing::TestWithParam<const char*> {};

TEST_P(Room, KeepsTheHouseRules) {
  const std::vector<SourceFile> files = sources_of(GetParam());
  EXPECT_FALSE(files.empty()) << "no sources in " << GetParam() << ": is the root right?";
  for (const SourceFile& file : files)
    for (const std::string& broken : broken_rules(file, architecture())) ADD_FAILURE() << broken;
}

INSTANTIATE_TEST_SUITE_P(Of, Room, ::testing::Values("core", "vision", "comms", "app", "ui"),
                         [](const auto& room) { return std::string(room.param); });

TEST(House, HasNoCycles) {
  std::vector<SourceFile> all;
  for (const char* room : {"core", "vision", "comms", "app", "ui"})
    for (SourceFile& file : sources_of(room)) all.push_back(std::move(file));
  for (const std::string& cycle : cycles_in(all)) ADD_FAILURE() << cycle;
}

/// Where the question is only whether it is that one ("while it is paused"), a bool with a name says so.
TEST(House, ChoosesByEnumeratorsWithSwitches) {
  std::vector<SourceFile> all;
  for (const char* room : {"core", "vision", "comms", "app", "ui"})
    for (SourceFile& file : sources_of(room)) all.push_back(std::move(file));
  for (const std::string& choice : choices_by_one_enumerator(all)) ADD_FAILURE() << choice;
}

/// Sources of a folder are compiled together, in other batches by each preset (cmake/skein.cmake).
TEST(House, NamesWithinARoomDiffer) {
  for (const char* room : {"core", "vision", "comms", "app", "ui", "tests"})
    for (const std::string& meeting : definitions_that_meet(sources_of(room))) ADD_FAILURE() << meeting;
}

/// Somebody sets the clock, or the network does, in the middle of a run: nothing that waits or judges may notice.
TEST(House, OnlyNamesAndStampsOfFilesAskTheClockThatPeopleSet) {
  const std::regex asks(
      "system_clock::now|std::time\\(|[^_]CLOCK_REALTIME\\b|gettimeofday|(QDateTime|QTime|QDate)::current|"
      "pthread_cond_timedwait");
  const std::set<std::string> allowed{"app/runs/kept_run.cpp", "app/guard/run_marker.cpp",
                                      "ui/main/recording_controller.cpp"};
  std::set<std::string> found;
  for (const char* room : {"core", "vision", "comms", "app", "ui"})
    for (const SourceFile& file : sources_of(room))
      if (std::regex_search(file.text, asks)) found.insert(file.path);
  EXPECT_EQ(found, allowed);
}

/// fmt::format calls fmt's library. fmt::format_to compiles the formatting of every type into each unit that calls it:
/// 75 kB, which take a compiler 2.5 s.
TEST(House, LeavesFormattingToTheLibrary) {
  for (const char* room : {"core", "vision", "comms", "app", "ui"})
    for (const SourceFile& file : sources_of(room))
      EXPECT_EQ(file.text.find("fmt::format_to("), std::string::npos)
          << file.path << ": write text += fmt::format(...)";
}

TEST(House, ArchitectureNamesOnlyFoldersThatExist) {
  const auto exists = [](const std::string& folder) { return std::filesystem::is_directory(test::in_source(folder)); };
  for (const auto& [folder, allowed] : architecture()) {
    EXPECT_TRUE(exists(folder)) << folder;
    for (const std::string& to : allowed) EXPECT_TRUE(to == "Eigen" || exists(to)) << folder << " -> " << to;
  }
}

TEST(House, ArchitectureNamesTheFirstFileToReadOfEveryFolder) {
  const std::string page = text_of("ARCHITECTURE.md");
  for (const auto& [folder, allowed] : architecture()) {
    const std::string name = folder.substr(folder.rfind('/') + 1);
    const std::regex entry("[ (]" + name + "/ [^\\[\n]*\\[([a-z0-9_]+(?:/[a-z0-9_]+)?\\.(?:h|cpp))\\]");
    // Rooms share names (vision/bench, app/bench): one of the entries must name a file of this folder.
    const auto begin = std::sregex_iterator(page.begin(), page.end(), entry);
    EXPECT_TRUE(std::any_of(begin, std::sregex_iterator(),
                            [&](const std::smatch& found) {
                              return std::filesystem::exists(test::in_source(folder + "/" + found[1].str()));
                            }))
        << folder << " has no entry of the form \"" << name << "/ what it is [first_file.h]\" with a file that exists";
  }
}

/// No library carries a fuzzer's sources: each lists them, and only scripts/fuzz links them.
TEST(House, FuzzersListTheSourceOfEveryHeaderThatTheirSourcesInclude) {
  const std::string cmake = text_of("tests/fuzz/CMakeLists.txt");
  const std::regex list("\\n(set\\(robots|skein_fuzz\\([a-z]+ SOURCES) ([^$()]*?)(?= LINK|\\n +LINK|\\))"),
      word("[a-z_/]+\\.cpp"), include("#include \"([a-z_/]+)\\.h\"");
  int lists = 0;
  for (std::sregex_iterator at(cmake.begin(), cmake.end(), list), end; at != end; ++at, ++lists) {
    const std::string words = (*at)[2];
    const std::set<std::string> listed(std::sregex_token_iterator(words.begin(), words.end(), word),
                                       std::sregex_token_iterator());
    EXPECT_GT(listed.size(), 3U) << words;
    for (const std::string& source : listed) {
      const std::string text = text_of(source);
      for (std::sregex_iterator one(text.begin(), text.end(), include); one != end; ++one) {
        const std::string needed = (*one)[1].str() + ".cpp";
        if (!std::filesystem::exists(test::in_source(needed))) continue;
        EXPECT_TRUE(listed.contains(needed)) << "tests/fuzz/CMakeLists.txt: " << source << " needs " << needed;
      }
    }
  }
  EXPECT_EQ(lists, 4);
}

TEST(Rules, SeeTheIncludesOfRealFiles) {
  // A reader that sees no includes would pass everything. Real files under a wrong name: core's may stand in any room,
  // but what of vision's sources includes OpenCV may stand in no other.
  int opencv = 0;
  for (const SourceFile& file : sources_of("vision")) {
    if (file.text.find("\n#include <opencv2/") == std::string::npos) continue;
    ++opencv;
    EXPECT_FALSE(broken_rules({"app/run/x.cpp", file.text}, architecture()).empty()) << file.path;
    EXPECT_FALSE(broken_rules({"core/x.cpp", file.text}, architecture()).empty()) << file.path;
  }
  EXPECT_GT(opencv, 0);
  for (const SourceFile& file : sources_of("core"))
    for (const char* folder : {"vision/fit", "comms", "app/tick", "ui/main"})
      EXPECT_TRUE(broken_rules({std::string(folder) + "/x.h", file.text}, architecture()).empty()) << file.path;
}

struct Case {
  const char *path, *line;  // a hundred std::string in one list cost the compiler a gigabyte
};

TEST(Rules, ReportWhatIsForbidden) {
  for (const Case& c : std::initializer_list<Case>{
           // arrows
           {"core/a.h", "#include \"vision/frames/frame.h\""},
           {"core/a.cpp", "#include \"app/session/session.h\""},
           {"core/a.cpp", "#include <comms/link.h>"},
           {"vision/track/a.cpp", "#include \"comms/link.h\""},
           {"vision/track/a.h", "#include \"app/session/session.h\""},
           {"comms/a.cpp", "#include \"vision/track/track.h\""},
           {"comms/a.cpp", "#include \"ui/window.h\""},
           {"app/session/a.cpp", "#include \"ui/window.h\""},
           {"ui/a.cpp", "#include \"vision/track/track.h\""},
           {"ui/a.cpp", "#include \"comms/link.h\""},
           {"app/session/a.cpp", "#include \"vision/fit/sampling.h\""},
           {"app/session/a.cpp", "#include \"vision/modules/boards.h\""},
           {"vision/track/a.cpp", "#include \"../comms/link.h\""},
           {"app/run/a.cpp", "#include \"app/tick/control_tick.h\""},
           {"app/tick/a.cpp", "#include \"app/session/session.h\""},
           {"app/experiment/a.cpp", "#include \"vision/tracker/tracker.h\""},
           {"vision/fit/a.cpp", "#include \"vision/tracker/tracker.h\""},
           // another room's names, whichever header they come by
           {"vision/fit/a.cpp", "comms::LinkState state;"},
           {"core/a.h", "const app::Event& event;"},
           {"app/tick/a.cpp", "  if (x) return vision::TagPose{};"},
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
           {"vision/track/a.h", "#include <opencv2/core.hpp>"},
           {"vision/track/a.h", "#include <apriltag/apriltag.h>"},
           {"app/session/a.cpp", "#include <opencv2/core.hpp>"},
           {"ui/a.cpp", "#include <apriltag/tag36h11.h>"},
           {"comms/a.h", "#include <bluetooth/bluetooth.h>"},
           {"app/session/a.cpp", "#include <bluetooth/rfcomm.h>"},
           {"app/session/a.cpp", "#include <systemd/sd-bus.h>"},
           {"app/session/a.cpp", "#include <QObject>"},
           {"app/program/main.cpp", "#include <QApplication>"},
           {"comms/a.cpp", "#include <QtDBus/QDBusConnection>"},
           {"vision/track/a.cpp", "#include <qcustomplot.h>"},
           {"core/control/a.cpp", "#include <sleef.h>"},
           {"core/control/a.cpp", "double y = std::sin(x);"},
           {"app/tools/a.h", "double y = 2.0 * std::atan2(y, x);"},
       }) {
    const auto broken = broken_rules({c.path, std::string("#pragma once\n\n") + c.line + "\nint x;\n"}, architecture());
    ASSERT_EQ(broken.size(), 1u) << c.path << " " << c.line;
    EXPECT_TRUE(broken[0].starts_with(std::string(c.path) + ":3:")) << broken[0];
  }
}

TEST(Rules, LetThroughWhatIsAllowed) {
  for (const Case& c : std::initializer_list<Case>{
           {"core/a.h", "#include <vector>"},
           {"core/a.h", "#include <Eigen/Dense>"},
           {"core/a.cpp", "double y = std::sqrt(math::exp(x));  // not std::exp(x)"},
           {"core/math/elementary.cpp", "#include <sleef.h>"},
           {"core/a.cpp", "#include \"core/geometry/pose.h\""},
           {"vision/track/a.cpp", "#include <opencv2/core.hpp>"},
           {"vision/boards/a.h", "#include <opencv2/core.hpp>"},
           {"vision/fit/a.h", "#include <apriltag/apriltag.h>"},
           {"vision/media/a.h", "#include <opencv2/videoio.hpp>"},
           {"vision/bench/a.h", "#include \"vision/synthetic/painter.h\""},
           {"vision/track/a.cpp", "#include <thread>"},
           {"comms/a.cpp", "#include <bluetooth/rfcomm.h>"},
           {"comms/a.h", "#include \"core/kinematics/step_rate.h\""},
           {"app/session/a.cpp", "#include \"vision/track/track.h\""},
           {"app/session/a.cpp", "#include \"comms/link.h\""},
           {"app/program/main.cpp", "#include \"ui/window.h\""},
           {"ui/a.h", "#include <QWidget>"},
           {"ui/main/a.h", "#include \"app/session/session.h\""},
           {"ui/main/a.h", "#include \"core/geometry/pose.h\""},
           {"core/a.h", "// #include <thread> in a comment"},
           {"core/a.h", "// like app::Event, but smaller"},
           {"vision/fit/a.cpp", "say(\"comms::LinkState\");"},
           {"app/session/a.cpp", "comms::LinkState state;"},
       })
    EXPECT_TRUE(broken_rules({c.path, std::string(c.line) + "\n"}, architecture()).empty()) << c.path << " " << c.line;
}

TEST(Rules, ReportCyclesOfUnitsAndOfFolders) {
  const SourceFile a{"core/a/one.h", "#include \"core/b/two.h\"\n"};
  const SourceFile b{"core/b/two.cpp", "#include \"core/a/one.h\"\n"};
  const SourceFile header{"core/b/two.h", ""}, other{"core/b/three.cpp", "#include \"core/a/four.h\"\n"};
  const SourceFile four{"core/a/four.h", ""};
  EXPECT_EQ(cycles_in({a, header}).size(), 0u);
  EXPECT_EQ(cycles_in({a, b, header}).size(), 2u) << "a unit is a header with its source";
  EXPECT_EQ(cycles_in({a, header, other, four}).size(), 1u) << "folders alone";
}

TEST(Rules, ReportChoicesByOneEnumerator) {
  const SourceFile header{"core/a/colour.h", "enum class Colour : int {\n  red,  // or green?\n  blue = 2\n};\n"};
  const auto found = [&](const char* text) { return choices_by_one_enumerator({header, {"app/b/c.cpp", text}}); };
  EXPECT_EQ(found("int x = c == Colour::red ? 1 : 2;").size(), 1U);
  EXPECT_EQ(found("int x = (c.of() !=\n core::Colour::blue) ? 1 : 2;").size(), 1U);
  EXPECT_EQ(found("\nint x = c == Colour::red\n ? 1 : 2;").at(0).substr(0, 14), "app/b/c.cpp:2:");
  EXPECT_TRUE(found("const bool red = c == Colour::red;\nint x = red ? 1 : 2;").empty());
  EXPECT_TRUE(found("int x = n == Limits::most ? 1 : 2;").empty()) << "no enumerator";
}

TEST(Rules, ReportDefinitionsThatMeet) {
  const auto found = [](const char* one, const char* other) {
    return definitions_that_meet({{"app/a/b.cpp", one}, {"app/a/c.cpp", other}});
  };
  EXPECT_EQ(found("\nconstexpr double patience = 1;  // [s]\n", "constexpr int patience{2};\n").size(), 1U);
  EXPECT_EQ(found("constexpr int sizes[2] = {1, 2};\n", "const std::string sizes = \"all\";\n").size(), 1U);
  EXPECT_EQ(found("int half(int a) {\n  return a / 2;\n}\n", "int half(int a) {\n  return a >> 1;\n}\n").size(), 1U);
  EXPECT_TRUE(found("int half(int a) {\n", "double half(double a) {\n").empty()) << "two that may stand together";
  EXPECT_TRUE(found("  constexpr int n = 1;\n", "  constexpr int n = 2;\n").empty()) << "local";
  EXPECT_TRUE(
      definitions_that_meet({{"app/a/b.cpp", "constexpr int n = 1;\n"}, {"app/b/b.cpp", "constexpr int n = 1;\n"}})
          .empty());
}

TEST(Rules, ReadTheTable) {
  const Arrows arrows = arrows_of("text\n```arrows\na -> b, c/d\nb ->\n```\nmore -> text\n");
  EXPECT_EQ(arrows, (Arrows{{"a", {"b", "c/d"}}, {"b", {}}}));
  EXPECT_THROW(arrows_of("a -> b\n"), std::runtime_error);
  EXPECT_THROW(arrows_of("```arrows\na b\n```\n"), std::runtime_error);
}

}  // namespace
}  // namespace skein::test
