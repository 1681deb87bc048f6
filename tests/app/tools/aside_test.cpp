// Work that may hang, on a thread that nobody waits for.
#include "app/tools/aside.h"

#include <gtest/gtest.h>

#include <future>
#include <memory>

namespace skein::app {
namespace {

TEST(Aside, IsNotWaitedForByWhoeverAsked) {
  std::promise<void> camera_answers;
  std::promise<int> done;
  std::future<int> result = done.get_future();
  // Waiting here for the work would be for ever: what it waits for comes after.
  run_aside(
      [answer = camera_answers.get_future().share(), promise = std::make_shared<std::promise<int>>(std::move(done))] {
        answer.wait();
        promise->set_value(7);
      });
  camera_answers.set_value();
  EXPECT_EQ(result.get(), 7);
}

TEST(Aside, LetsGoOfWhatItOwnsAtItsEnd) {
  auto owned = std::make_shared<std::promise<void>>();
  std::future<void> gone = owned->get_future();
  run_aside([owned = std::move(owned)] {});
  EXPECT_THROW(gone.get(), std::future_error) << "the promise is broken once its owner is gone";
}

TEST(Aside, IsOverWhenAllOfItHasEnded) {
  std::promise<void> camera_answers;
  run_aside([answer = camera_answers.get_future().share()] { answer.wait(); });
  EXPECT_FALSE(aside_is_over(0.0));
  camera_answers.set_value();
  EXPECT_TRUE(aside_is_over(60.0));
}

}  // namespace
}  // namespace skein::app
