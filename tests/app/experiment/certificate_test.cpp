// What is said of an experiment before it runs follows its gains wherever they go.
#include "app/experiment/certificate.h"

#include <gtest/gtest.h>

#include "app/experiment/experiment_file.h"

namespace skein::app {
namespace {

/// The paper's experiment without the changes of its gains.
Experiment steady() {
  Experiment e = paper_experiment();
  e.gain_changes.clear();
  return e;
}

TEST(Certificate, JudgesTheDelayWithTheGainsOfEveryChange) {
  Experiment e = steady();
  const double coupled = smallest_delay_margin(e).margin.delay;
  GainChange couple;
  couple.t = 40.0;
  couple.ramp = 2.0;
  for (const core::GainName name : core::gain_names) {
    couple[name] = core::table(e.controller.gains, name);
    core::table(e.controller.gains, name).fill(0.0);
  }
  const double uncoupled = smallest_delay_margin(e).margin.delay;
  ASSERT_GT(uncoupled, 1.1 * coupled);
  e.gain_changes.assign(1, couple);
  EXPECT_DOUBLE_EQ(smallest_delay_margin(e).margin.delay, coupled);
}

TEST(Certificate, LooksAtTheMarginsWhereChangesEnd) {
  Experiment e = steady();
  const Certificate before = certify(e);
  ASSERT_TRUE(before.holds());
  GainChange change;
  change.t = 10.0;
  change.ramp = 5.0;
  change[core::GainName::k_xx] = core::PairTable(e.robots.size(), e.controller.v_max);
  e.gain_changes.assign(1, change);
  const Certificate after = certify(e);
  EXPECT_FALSE(after.holds());
  EXPECT_LT(after.robots[0].k_x.value, before.robots[0].k_x.value);
  EXPECT_GT(after.robots[0].k_x.t, 10.0);
}

TEST(Certificate, RefusesALoopThatSamplingMakesUnstable) {
  EXPECT_TRUE(certify(steady()).sound());
  for (const auto& [gain, value] : {std::pair{&ControllerSpec::c_theta, 500.0}, std::pair{&ControllerSpec::c_x, 2000.0},
                                    std::pair{&ControllerSpec::k, 20000.0}}) {
    Experiment e = steady();
    e.controller.*gain = value;
    const Certificate certificate = certify(e);
    EXPECT_TRUE(certificate.holds()) << "(18) says nothing of sampling";
    EXPECT_FALSE(certificate.sampled_loop_stable()) << value;
    EXPECT_FALSE(certificate.sound()) << value;
    EXPECT_NE(as_lines(certificate).find("sampled_loop: UNSTABLE at 25 Hz"), std::string::npos);
  }
}

TEST(Certificate, RefusesGainsThatLeaveTrackingNextToNothing) {
  Experiment e = steady();
  // v_max 0.1 - v_ref 0.05 - 3 k_xx leaves 0.2 um/s.
  core::table(e.controller.gains, core::GainName::k_xx).fill((0.05 - 2e-7) / 3.0);
  const Certificate certificate = certify(e);
  EXPECT_TRUE(certificate.holds());
  EXPECT_FALSE(certificate.keeps_tracking());
  EXPECT_FALSE(certificate.sound());
}

TEST(Certificate, SaysThatThePapersCouplingsDoNotImplyTheLimits) {
  Experiment e = steady();
  EXPECT_NE(as_lines(certify(e)).find("limits_14: do NOT follow"), std::string::npos);
  e.controller.coupling = core::Coupling::bounded;
  EXPECT_NE(as_lines(certify(e)).find("limits_14: follow from (18f, g)"), std::string::npos);
}

}  // namespace
}  // namespace skein::app
