// The timing certificate of a run.
#include <gtest/gtest.h>

#include "app/experiment/experiment_file.h"
#include "app/session/bare_thread.h"
#include "app/session/session.h"

namespace skein::app {
namespace {

Experiment a_second() {
  Experiment experiment = paper_experiment();
  experiment.duration = 1.0;
  experiment.perturbations.clear();
  return experiment;
}

TEST(Timing, EveryRunInRealTimeHasACertificate) {
  auto session = Session::open(a_second(), Session::Clock::wall);
  ASSERT_TRUE(session);
  (*session)->run();
  EXPECT_FALSE((*session)->timing()) << "not before the end";
  (*session)->close();
  const auto timing = (*session)->timing();
  ASSERT_TRUE(timing);
  EXPECT_GE(timing->tick.total(), 10u);
  EXPECT_GE(timing->bare.total(), 10u);
  EXPECT_GT(timing->tick.largest(), 0.0);
  EXPECT_GT(timing->bare.largest(), 0.0);
  EXPECT_EQ(timing->priority > 0, timing->no_priority.empty()) << "no priority without a reason";
}

TEST(Timing, VirtualTimeHasNone) {
  auto session = Session::open(a_second(), Session::Clock::virtual_);
  ASSERT_TRUE(session);
  (*session)->run();
  (*session)->close();
  EXPECT_FALSE((*session)->timing());
}

TEST(Timing, ABareThreadWakesAtEveryDeadlineAndEnds) {
  BareThread thread(0.01, 0);
  EXPECT_EQ(thread.priority(), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const Histogram late = thread.end();
  EXPECT_GE(late.total(), 3u);
  EXPECT_LE(late.total(), 32u);
}

TEST(Timing, APriorityThatIsNotGrantedHasAReason) {
  EXPECT_NE(ask_for_priority(1000), "") << "there is no such priority";
}

}  // namespace
}  // namespace skein::app
