#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

namespace CLI {
class App;
}

namespace skein::app {

/// A page of section 1 of the manual: "skein-run", and its text for man(1).
struct ManualPage {
  std::string name, text;
};

/// The pages of a program and of every command below it, made from the texts of --help. Hidden commands have none.
/// `version` is in their footer.
std::vector<ManualPage> manual_pages(const CLI::App& program, const std::string& version);

/// Writes each page as NAME.1 into a folder, which is made. The error is a sentence.
tl::expected<void, std::string> write_manual(const CLI::App& program, const std::string& version,
                                             const std::string& folder);

/// Makes it an error if an option stands in place of the missing value of another one: `--csv --set rate=10` would
/// otherwise write a file named "--set". An empty text, as from a script's unset variable, counts as missing, too. So
/// does "-", by which other programs mean a pipe: a file would be called so. Call it before parsing the program's
/// words.
void refuse_missing_values(CLI::App& program);

/// A completion of the word being typed.
struct Candidate {
  std::string word;
  std::string help;  ///< a few words, or none
};

/// What a command line has so far.
struct Typed {
  std::string word;                            ///< what there is of the word being typed
  std::map<std::string, std::string> options;  ///< the values of options before it, by their names ("--runs-dir")
};

/// The candidates for the value of an option or positional, by its name ("--set", "experiment"); empty: a file.
using ValuesOf = std::function<std::optional<std::vector<Candidate>>(const std::string& name, const Typed& typed)>;

/// Completions for `words`, all after the program's name, of which the last is being typed: lines of "WORD<tab>HELP"
/// that begin with it, after a line "@files" if a file is possible as well (resources/completion). Commands, options
/// and the allowed words of an option come from the program itself.
std::string completions(const CLI::App& program, const std::vector<std::string>& words, const ValuesOf& values = {});

}  // namespace skein::app
