#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace skein::app {

/// The commands below this one, without those that no help shows.
std::vector<std::string> names_of_commands(const CLI::App& command);

/// What is wrong with a command line: the command, the place, what was found there and what is allowed, in one line.
/// `error` is what parsing it threw.
std::string what_is_wrong(const CLI::App& program, const CLI::ParseError& error);

/// An option or word that was read before the name of a command and that the command never sees, as in
/// `skein --seed 3 run FILE`; none: there is none. Call it after parsing. Words of a command that the one below it has
/// as well, such as `skein tags --out FILE board`, are for both, but not those of the program itself.
std::optional<std::string> misplaced(const CLI::App& program);

/// Makes the program report errors with what_is_wrong(), and refuse values of a flag other than true and false.
void say_mistakes_plainly(CLI::App& program);

}  // namespace skein::app
