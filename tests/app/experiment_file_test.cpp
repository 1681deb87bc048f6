#include "app/experiment_file.h"

#include "tests/property.h"

namespace skein::app {
namespace {

TEST(ExperimentFile, ThePaperIsBuiltIn) {
  const Experiment e = paper_experiment();
  EXPECT_EQ(e.robots.size(), 4u);
  EXPECT_EQ(e.ticks(), 2100);
}

}  // namespace
}  // namespace skein::app
