#pragma once

namespace skein::app {

/// From now on a closed reader of the program's output, a file at its size limit and a terminal that blocks writing
/// from the background are write errors, which neither end nor block the program.
void ignore_output_signals() noexcept;

/// From now on SIGINT, SIGTERM, SIGHUP and other signals that would end the program silently only set `interrupted`;
/// and ignore_output_signals().
void catch_interrupts() noexcept;

/// For a command that drives no robots, and of which no more than a draft is left, which the next one replaces: such
/// signals end it at once, as they end any program; so does one that has come already. After `catch_interrupts`.
void end_by_interrupts() noexcept;

/// Acts as if such a signal had come when the other end of this pipe is closed: the program that started this one has
/// ended, for whatever reason. False: it is not an open descriptor. After `catch_interrupts`.
bool interrupt_when_closed(int pipe) noexcept;

/// As if such a signal had come. Async-signal-safe.
void interrupt() noexcept;

/// True from the first such signal after `catch_interrupts` on. Any thread.
bool interrupted() noexcept;

}  // namespace skein::app
