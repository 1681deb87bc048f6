#include "app/page/report_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>

#include "tests/app/exchange/recorded.h"
#include "tests/files.h"

namespace skein::app {
namespace {

using test::Folder;
using test::Recorded;

Page page_of(const std::string& csv, const PageOrigin& origin = {}) {
  std::istringstream in(csv);
  auto page = report_page(in, "run.csv", origin);
  EXPECT_TRUE(page) << page.error();
  return page ? *page : Page{};
}

using test::read_file;

TEST(ReportPage, NeedsNothingFromOutside) {
  const Page page = page_of(Recorded().csv);
  EXPECT_TRUE(page.warnings.empty()) << page.warnings.front();
  EXPECT_EQ(page.html.find("http://", page.html.find("<body>")), page.html.find("http://www.w3.org/2000/svg"))
      << "a name of a language, no address";
  EXPECT_EQ(page.html.find("https://"), std::string::npos);
  EXPECT_EQ(page.html.find("{{"), std::string::npos) << "a place that nothing was put into";
  EXPECT_NE(page.html.find("default-src 'none'"), std::string::npos);
}

TEST(ReportPage, ColumnsOfMoreRobotsThanTheExperimentHasAreRefused) {
  std::string csv = Recorded({"duration=1"}).csv;
  const std::size_t robot = csv.rfind("[[robot]]");
  const std::size_t begin = csv.rfind('\n', robot), next = csv.find("\n", csv.find("tag", robot));
  csv.erase(begin, next - begin);
  std::istringstream in(csv);
  const auto page = report_page(in, "run.csv", {});
  ASSERT_FALSE(page);
  EXPECT_EQ(page.error(), "run.csv: 3 robots in its experiment, but 4 in its columns");
}

TEST(ReportPage, TextsOfTheExperimentAreNoMarkup) {
  const Page page =
      page_of(Recorded({"duration=1", "name=<script>alert(1)</script> & co"}).csv, {"<b>origin</b>", {"a < b"}});
  EXPECT_EQ(page.html.find("<script>alert"), std::string::npos);
  EXPECT_EQ(page.html.find("<b>origin"), std::string::npos);
  EXPECT_NE(page.html.find("&lt;script&gt;alert(1)&lt;/script&gt; &amp; co"), std::string::npos);
  EXPECT_NE(page.html.find("a &lt; b"), std::string::npos);
}

TEST(ReportPage, ALongRunHasFewerFramesASecondNotMoreOfThem) {
  const Page page = page_of(Recorded({"duration=200"}).csv);
  const std::size_t begin = page.html.find("\"frames\":");
  const std::string frames = page.html.substr(begin, page.html.find("</script>", begin) - begin);
  EXPECT_GT(std::count(frames.begin(), frames.end(), '\n'), 700);
  EXPECT_LT(std::count(frames.begin(), frames.end(), '\n'), 1500);
  EXPECT_TRUE(frames.starts_with("\"frames\":[[0.000,[")) << "from the beginning: " << frames.substr(0, 40);
  EXPECT_NE(frames.find("[199."), std::string::npos) << "up to the end";
}

TEST(ReportPage, WhatIsNoRunIsRefused) {
  std::istringstream in("a,b\n1,2\n");
  const auto page = report_page(in, "run.csv", {});
  ASSERT_FALSE(page);
  EXPECT_NE(page.error().find("run.csv:1"), std::string::npos);
}

/// As after a power cut: the figures show the complete rows.
TEST(ReportPage, DrawsTheFiguresOfATornRecord) {
  const std::string csv = Recorded({"duration=10"}).csv;
  for (const std::string& torn : {csv.substr(0, csv.size() - 1000), csv + std::string(512, '\0'), csv + "10,250,0.0"}) {
    const Page page = page_of(torn);
    ASSERT_EQ(page.warnings.size(), 1u) << page.warnings.back();
    EXPECT_NE(page.warnings[0].find("torn here"), std::string::npos) << page.warnings[0];
    EXPECT_NE(page.html.find("alt=\"Errors\""), std::string::npos);
  }
}

/// In a real browser: no word on the console, every figure drawn, and the animation plays.
TEST(ReportPage, OpensInABrowser) {
  if (std::system("chromium --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no Chromium: install chromium";
  const Folder folder;
  std::string html = page_of(Recorded({"duration=30", "arena.width=6"}).csv).html;
  const auto put = [&](const std::string& before, const std::string& script) {
    html.insert(html.rfind(before), "<script>" + script + "</script>\n");
  };
  put("<title>", "window.addEventListener('error', (e) => { document.documentElement.dataset.errors = e.message; });");
  put("</body>", R"(
    window.addEventListener("load", () => {
      const said = document.documentElement.dataset, slider = document.getElementById("time");
      said.figures = [...document.images].map((image) => image.complete && image.naturalWidth > 100 ? "drawn" : "missing").join(" ");
      said.number = String(document.querySelector("#floor text").getBoundingClientRect().height > 9);
      const first = document.querySelector("#floor g").getAttribute("transform");
      document.getElementById("speed").value = "16";
      document.getElementById("play").click();
      let looks = 0;
      const wait = setInterval(() => {  // frames come when the browser has time to draw
        const moved = Number(slider.value) > 0 && document.querySelector("#floor g").getAttribute("transform") !== first;
        if (!moved && ++looks < 100) return;
        clearInterval(wait);
        said.moved = String(moved);
        document.querySelectorAll("#events tr")[1].click();
        said.jumped = document.getElementById("clock").textContent;
      }, 100);
    });)");
  std::ofstream(folder / "page.html") << html;
  const std::string command =
      "timeout 60 chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync "
      "--disable-dev-shm-usage --user-data-dir='" +
      (folder / "profile") + "' --enable-logging=stderr --virtual-time-budget=12000 --dump-dom 'file://" +
      (folder / "page.html") + "' > '" + (folder / "dom") + "' 2> '" + (folder / "log") + "'";
  ASSERT_EQ(std::system(command.c_str()), 0) << read_file(folder / "log");
  const std::string dom = read_file(folder / "dom"), log = read_file(folder / "log");
  const auto said = [&](const std::string& name) {
    std::smatch found;
    const bool there = std::regex_search(dom, found, std::regex("<html[^>]* data-" + name + "=\"([^\"]*)\""));
    return there ? found[1].str() : std::string("nothing");
  };
  EXPECT_EQ(log.find("CONSOLE"), std::string::npos) << log;
  EXPECT_EQ(said("errors"), "nothing");
  EXPECT_EQ(said("ready"), "250");
  EXPECT_EQ(said("figures"), "drawn drawn");
  EXPECT_EQ(said("number"), "true") << "a robot's number can be read";
  EXPECT_EQ(said("moved"), "true");
  EXPECT_NE(said("jumped"), "0.0 s");
}

}  // namespace
}  // namespace skein::app
