// When it is asked why a tag is not seen.
#include "vision/diagnosis/tag_absence.h"

#include <gtest/gtest.h>

namespace skein::vision {
namespace {

constexpr double frame = 0.04;  // [s]

TEST(TagAbsence, IsDueOnceEachTimeThatItLasts) {
  TagAbsence absence;
  int asked = 0, lasted = 0;
  for (int k = 0; k < 250; ++k) {
    const double t = 100.0 + k * frame;
    const bool seen = k == 0 || (k >= 100 && k < 150);  // for four seconds each before and after it is absent
    if (seen) absence.seen(t);
    EXPECT_FALSE(seen && (absence.lasts(t) || absence.due(t)));
    lasted += absence.lasts(t);
    if (!absence.due(t)) continue;
    EXPECT_TRUE(k == 13 || k == 162) << k << ": the first frame more than half a second after it was seen";
    absence.ask();
    EXPECT_TRUE(absence.asked());
    ++asked;
  }
  EXPECT_EQ(asked, 2);
  EXPECT_EQ(lasted, 99 - 12 + 100 - 12);
}

TEST(TagAbsence, OfATagThatIsNotExpectedYetIsNone) {
  TagAbsence absence;
  EXPECT_FALSE(absence.lasts(1e9));
  EXPECT_FALSE(absence.due(1e9));
  absence.seen(3.0);  // expected from then on
  EXPECT_FALSE(absence.due(3.5));
  EXPECT_TRUE(absence.due(3.6));
}

TEST(TagAbsence, ThatIsShortIsForgotten) {
  TagAbsence absence;
  for (int k = 0; k < 1000; ++k) {
    if (k % 12 == 0) absence.seen(k * frame);
    EXPECT_FALSE(absence.due(k * frame)) << k;
  }
}

}  // namespace
}  // namespace skein::vision
