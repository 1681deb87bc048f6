#include "app/exchange/datagrams.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/record/csv_reader.h"
#include "tests/app/exchange/recorded.h"

namespace skein::app {
namespace {

using Json = nlohmann::json;

TEST(Datagrams, EachIsAnObjectWithItsTimeAndTogetherTheyAreTheRow) {
  const test::Recorded run({"duration=1", "simulation.dropout=0.2", "simulation.pose_noise=0.001"});
  Datagrams datagrams(run.experiment);
  std::istringstream in(run.csv);
  auto reader = CsvReader::open(in, "run.csv").value();
  TickRecord read;
  for (const TickRecord& row : run.rows) {
    ASSERT_TRUE(reader.next(read).value());
    Json all = Json::object();
    for (const std::string& datagram : datagrams.of(row)) {
      EXPECT_LE(datagram.size(), Datagrams::largest);
      const Json object = Json::parse(datagram);
      EXPECT_EQ(object.at("timestamp").get<double>(), row.now);
      all.merge_patch(object);
    }
    std::size_t values = 0;
    for (std::size_t i = 0; i < reader.columns().size(); ++i) {
      const std::string name = reader.columns()[i], cell(reader.cells()[i]);
      const bool of_robot = name.starts_with('r') && std::isdigit(name[1]) != 0;
      const Json& object = of_robot ? all[name.substr(0, 2)] : all;
      const std::string key = of_robot ? name.substr(3) : name;
      ASSERT_EQ(object.contains(key), !cell.empty()) << name;
      if (cell.empty()) continue;
      ++values;
      if (object[key].is_string())
        ASSERT_EQ(object[key], cell);
      else
        ASSERT_EQ(object[key].get<double>(), std::stod(cell)) << name;
    }
    EXPECT_GT(values, 100u);
  }
}

TEST(Datagrams, ALargeGroupTakesMoreOfThemNotLargerOnes) {
  std::vector<std::string> sets{"duration=0.2"};
  for (int i = 5; i <= 30; ++i) sets.push_back("robot." + std::to_string(i) + ".tag=" + std::to_string(i));
  for (const char* const gain : {"k_xx", "k_tt", "k_yy"})
    sets.push_back(std::string("controller.gains.") + gain + "=0.0002");
  sets.insert(sets.end(), {"arena.width=20", "arena.height=20", "reference.path.width=12", "reference.path.height=12"});
  for (int i = 1; i <= 4; ++i) sets.push_back("robot." + std::to_string(i) + ".tag=" + std::to_string(i));
  const auto experiment = parse_experiment(paper_experiment().source, "platoon.toml", sets);
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  TickRecord row;
  row.robots.resize(experiment->robots.size());
  row.delta.resize(experiment->robots.size() - 1, 1.0 / 3.0);
  row.pair_gains.fill(core::PairTable(experiment->robots.size(), 0.008));
  for (RobotRecord& robot : row.robots) robot.pose = robot.truth = {1.0 / 3.0, -1.0 / 3.0, 1.0 / 7.0};
  Datagrams datagrams(*experiment);
  const auto& all = datagrams.of(row);
  EXPECT_GE(all.size(), 31u);
  for (const std::string& datagram : all) {
    EXPECT_LE(datagram.size(), Datagrams::largest);
    EXPECT_TRUE(Json::accept(datagram)) << datagram;
  }
}

}  // namespace
}  // namespace skein::app
