#include "app/controllers/adversary.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <optional>

#define SKEIN_CLIENT
#include "app/controllers/skein_controller.h"
#include "app/run/exit_status.h"
#include "core/geometry/pose.h"
#include "core/math/elementary.h"
#include "core/simulation/random.h"
#include "core/words.h"

namespace skein::app {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Full speed at a point, backwards where that is nearer, whatever stands in the way.
skein_command charge(const skein_robot& robot, double x, double y) {
  const double bearing = core::wrap_angle(core::math::atan2(y - robot.y, x - robot.x) - robot.theta);
  const bool ahead = std::abs(bearing) < 0.5 * core::pi;
  const double turn = ahead ? bearing : core::wrap_angle(bearing + core::pi);
  return {(ahead ? 1.0 : -1.0) * robot.v_max, std::clamp(8.0 * turn, -robot.omega_max, robot.omega_max)};
}

/// What an honest one would do.
void track(skein_memory& memory) {
  for (std::uint32_t i = 0; i < std::min<std::uint32_t>(memory.robots, SKEIN_ROBOTS); ++i) {
    const skein_robot& robot = memory.robot[i];
    memory.command[i] = {robot.reference[3] + 2.0 * robot.error[0],
                         robot.reference[4] + 2.0 * robot.error[2] + 10.0 * robot.error[1]};
  }
}

class Worst {
 public:
  Worst(skein_memory& memory, std::uint64_t seed)
      : memory_(memory), kind_(adversary_of(seed)), random_(seed, 0), begins_(static_cast<int>(50.0 * uniform())) {}

  void answer(std::uint64_t question) {
    track(memory_);
    if (++ticks_ > begins_) attack(question);
  }

 private:
  double uniform() { return random_.uniform(); }

  template <typename Command>
  void all(Command&& command) {
    for (std::uint32_t i = 0; i < memory_.robots; ++i) memory_.command[i] = command(memory_.robot[i], i);
  }

  void attack(std::uint64_t question) {
    switch (kind_) {
      case Adversary::no_number:
        return all([&](const skein_robot&, std::uint32_t) {
          return uniform() < 0.5 ? skein_command{nan, 0.0} : skein_command{0.1, nan};
        });
      case Adversary::infinite:
        return all([&](const skein_robot&, std::uint32_t) {
          const double worst[] = {infinity, -infinity, 1e300, -1e12, 1e5};
          return skein_command{worst[static_cast<int>(5.0 * uniform())], worst[static_cast<int>(5.0 * uniform())]};
        });
      case Adversary::collide:
        return all([&](const skein_robot& robot, std::uint32_t i) { return charge_at_nearest(robot, i); });
      case Adversary::walls:
        return all([&](const skein_robot& robot, std::uint32_t) {
          const bool side = memory_.half_width - std::abs(robot.x) < memory_.half_height - std::abs(robot.y);
          return side ? charge(robot, std::copysign(10.0, robot.x), robot.y)
                      : charge(robot, robot.x, std::copysign(10.0, robot.y));
        });
      case Adversary::obstacles:
        return all([&](const skein_robot& robot, std::uint32_t i) {
          const skein_obstacle* nearest = nullptr;
          double distance = infinity;
          for (std::uint32_t k = 0; k < memory_.obstacles; ++k)
            if (const double d = core::math::hypot(memory_.obstacle[k].x - robot.x, memory_.obstacle[k].y - robot.y);
                d < distance)
              nearest = &memory_.obstacle[k], distance = d;
          return nearest ? charge(robot, nearest->x, nearest->y) : charge_at_nearest(robot, i);
        });
      case Adversary::erratic:
        return all([&](const skein_robot& robot, std::uint32_t) {
          return skein_command{uniform() < 0.5 ? robot.v_max : -robot.v_max, (2.0 * uniform() - 1.0) * robot.omega_max};
        });
      case Adversary::late:
        if (uniform() < 0.3) ::usleep(static_cast<useconds_t>(20'000.0 * uniform()));
        return all([&](const skein_robot& robot, std::uint32_t i) { return charge_at_nearest(robot, i); });
      case Adversary::crash: {
        const int way = static_cast<int>(4.0 * uniform());
        if (way == 0) std::abort();
        if (way == 1) ::_exit(3);
        if (way == 2) ::raise(SIGKILL);
        ::raise(SIGSEGV);
        return;
      }
      case Adversary::hang:
        for (volatile bool busy = uniform() < 0.5;;)
          if (!busy) ::pause();
      case Adversary::stop_itself:
        ::raise(SIGSTOP);
        return;
      case Adversary::flood:
        for (int k = 0; k < 5000; ++k) {
          std::fputs("flood flood flood flood flood flood flood flood\n", stderr);
          (void)!::write(SKEIN_ANSWER_FD, "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa", 32);
        }
        return;
      case Adversary::scribble:
        for (char *byte = reinterpret_cast<char*>(&memory_), *end = byte + sizeof memory_; byte < end; ++byte)
          *byte = static_cast<char>(256.0 * uniform());
        memory_.robots = 4;
        memory_.answer = question + (uniform() < 0.5 ? 0 : 1);
        return;
      case Adversary::allocate:
        // NOLINTNEXTLINE(clang-analyzer-unix.Malloc): it never gives memory back.
        while (void* const more = std::malloc(std::size_t{64} << 20)) std::memset(more, 1, 4096);
        return;
      case Adversary::fork:
        for (; forks_ < 64; ++forks_)  // an honest machine is spared: what holds is that they end with the run
          if (::fork() == 0) {
            ::setsid();
            for (;;) ::pause();
          }
        if (uniform() < 0.1) ::_exit(0);
        return;
    }
  }

  skein_command charge_at_nearest(const skein_robot& robot, std::uint32_t own) {
    const skein_robot* nearest = nullptr;
    double distance = infinity;
    for (std::uint32_t j = 0; j < memory_.robots; ++j)
      if (const double d = core::math::hypot(memory_.robot[j].x - robot.x, memory_.robot[j].y - robot.y);
          j != own && d < distance)
        nearest = &memory_.robot[j], distance = d;
    return nearest ? charge(robot, nearest->x, nearest->y) : skein_command{robot.v_max, 0.0};
  }

  skein_memory& memory_;
  const Adversary kind_;
  core::Random random_;
  const int begins_;
  int ticks_ = 0, forks_ = 0;
};

}  // namespace

Adversary adversary_of(std::uint64_t seed) noexcept {
  constexpr auto all = core::all_of<Adversary>();
  return all[seed % all.size()];
}

namespace {

template <typename Answer>
int serve(Answer&& answer) {
  skein_memory* const memory = skein_attach();
  if (!memory) return wrong_input;
  skein_ready();
  while (const std::uint64_t question = skein_wait(memory)) {
    answer(*memory, question);
    skein_answer(memory, question);
  }
  return done;
}

}  // namespace

int be_adversary(std::uint64_t seed) {
  std::optional<Worst> worst;
  return serve([&](skein_memory& memory, std::uint64_t question) {
    if (!worst) worst.emplace(memory, seed);
    worst->answer(question);
  });
}

int be_honest() {
  return serve([](skein_memory& memory, std::uint64_t) { track(memory); });
}

}  // namespace skein::app
