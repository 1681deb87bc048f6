#pragma once

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <utility>

namespace skein::test {

/// Runs a RapidCheck property (1,000 seeded cases, see tests/main.cpp) as a GoogleTest expectation.
template <typename Property>
void holds(const char* what, Property&& property) {
  EXPECT_TRUE(rc::check(what, std::forward<Property>(property)));
}

}  // namespace skein::test
