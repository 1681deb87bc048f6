#pragma once

#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

namespace skein::fuzz {

/// What must hold whatever the bytes; a broken promise ends the program, which is how a fuzzer learns of it.
inline void must(bool holds) {
  if (!holds) std::abort();
}

/// Stops a robot that listens, over a session in whatever state, within a few time-outs. `now` goes on [s].
template <typename Session, typename Robot>
void stop(Session& session, Robot& robot, double& now) {
  session.stop(now);
  for (int turn = 0; turn < 200 && !(session.up() && session.stop_acknowledged()); ++turn) {
    while (!session.output().empty()) {
      const std::vector<std::uint8_t> request(session.output().begin(), session.output().end());
      session.sent(request.size(), now);
      std::vector<std::uint8_t> answer;
      robot.receive(request, answer);
      session.received(answer, now);
    }
    now += 0.25;
    session.advance(now);
  }
}

/// `use(chunk, place)` for each chunk of the bytes: odd bytes decide where chunks end. `place` is that of its last
/// byte.
template <typename Use>
void for_chunks(std::span<const std::uint8_t> bytes, Use&& use) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (bytes[i] % 2 == 0 && i + 1 < bytes.size()) continue;
    use(bytes.subspan(begin, i + 1 - begin), i);
    begin = i + 1;
  }
}

}  // namespace skein::fuzz
