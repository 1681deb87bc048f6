#include "app/runs/run_index.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <future>
#include <limits>
#include <set>
#include <span>
#include <stdexcept>
#include <thread>
#include <unordered_map>
#include <utility>

#include "app/experiment/text_file.h"
#include "app/run/event.h"
#include "app/runs/run_folder.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

constexpr int schema_version = 6;
constexpr const char* schema =
    "CREATE TABLE run(number INTEGER PRIMARY KEY, id TEXT UNIQUE NOT NULL, changed INTEGER NOT NULL, size INTEGER NOT "
    "NULL, began INTEGER NOT NULL);"
    "CREATE INDEX run_by_time ON run(began, id);"
    "CREATE TABLE key(number INTEGER PRIMARY KEY, name TEXT UNIQUE NOT NULL);"
    "CREATE TABLE fact(key INTEGER NOT NULL, run INTEGER NOT NULL, value, PRIMARY KEY(key, run)) WITHOUT ROWID;";

/// The index cannot be written here, and may be sound all the same.
struct Unwritable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws what SQLite says.
void check(sqlite3* database, int status) {
  constexpr int primary = 0xff;  // of an extended result code
  switch (status & primary) {
    case SQLITE_OK:
    case SQLITE_DONE:
    case SQLITE_ROW:
      return;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
    case SQLITE_FULL:
      throw Unwritable(sqlite3_errmsg(database));
    default:
      throw std::runtime_error(sqlite3_errmsg(database));
  }
}

class Statement {
 public:
  Statement(sqlite3* database, const std::string& sql) : database_(database) {
    check(database, sqlite3_prepare_v2(database, sql.c_str(), -1, &statement_, nullptr));
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(int place, std::int64_t value) {
    check(database_, sqlite3_bind_int64(statement_, place, value));
    return *this;
  }
  Statement& bind(int place, const std::string& value) {
    check(database_,
          sqlite3_bind_text(statement_, place, value.c_str(), static_cast<int>(value.size()), SQLITE_TRANSIENT));
    return *this;
  }
  Statement& bind(int place, const RunIndex::Value& value) {
    if (const double* const number = std::get_if<double>(&value))
      check(database_, sqlite3_bind_double(statement_, place, *number));
    else if (const std::int64_t* const whole = std::get_if<std::int64_t>(&value))
      bind(place, *whole);
    else
      bind(place, std::get<std::string>(value));
    return *this;
  }
  /// The next row; false: there is none.
  bool row() {
    const int status = sqlite3_step(statement_);
    check(database_, status);
    return status == SQLITE_ROW;
  }
  void run() {
    while (row()) {
    }
    sqlite3_reset(statement_);
  }
  std::int64_t whole(int column) { return sqlite3_column_int64(statement_, column); }
  std::string text(int column) {
    const auto* const bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return bytes ? bytes : "";
  }
  RunIndex::Value value(int column) {
    const int type = sqlite3_column_type(statement_, column);
    if (type == SQLITE_FLOAT) return sqlite3_column_double(statement_, column);
    if (type == SQLITE_INTEGER) return whole(column);
    return text(column);
  }

 private:
  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

struct Stamp {
  std::int64_t changed, size;
  bool operator==(const Stamp&) const = default;
};

/// When a file changed [ns since 1970]; none before 1677 or after 2262, of which there are no such numbers.
std::int64_t nanoseconds(const timespec& time) {
  constexpr std::int64_t per_second = 1'000'000'000, most = std::numeric_limits<std::int64_t>::max() / per_second - 1;
  return std::clamp<std::int64_t>(time.tv_sec, -most, most) * per_second + time.tv_nsec;
}

/// What is read of a run's folder.
struct Reading {
  std::string id;
  Stamp stamp{};
  std::int64_t began = 0;
  std::map<std::string, RunIndex::Value> facts{};
  std::string problem{};  // empty: it could be read
};

void read(const fs::path& directory, Reading& run) {
  const std::string folder = (directory / run.id).string();
  const auto story = read_story(folder);
  if (!story) {
    run.problem = story.error();
    return;
  }
  run.began = began_at(*story).value_or(run.stamp.changed);
  run.facts = run_facts(*story);
  run.facts["id"] = run.id;  // a folder may have been given another name
  const auto bytes = bytes_when_written(*story, static_cast<std::uintmax_t>(run.stamp.size));
  run.facts["megabytes"] = std::round(static_cast<double>(bytes ? *bytes : bytes_of_run(folder)) / 1e5) / 10.0;
}

/// Reads these runs, on all processors.
void read(const fs::path& directory, std::span<Reading> runs) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < runs.size(); i = next++) read(directory, runs[i]);
  };
  constexpr std::size_t worth_a_thread = 50;  // runs
  const std::size_t threads = std::min<std::size_t>(std::thread::hardware_concurrency(), runs.size() / worth_a_thread);
  std::vector<std::future<void>> others;
  for (std::size_t i = 1; i < threads; ++i) others.push_back(std::async(std::launch::async, work));
  work();
  for (std::future<void>& other : others) other.get();
}

}  // namespace

struct RunIndex::State {
  std::string directory;
  std::chrono::milliseconds patience{};
  sqlite3* database = nullptr;
  std::vector<std::string> problems;
  std::map<std::string, std::int64_t> key_numbers;
  struct Unread {
    std::string id;
    std::int64_t began = 0;  // when its file changed [ns]
  } newest_unread{};         // of the folders that cannot be read

  ~State() { sqlite3_close(database); }
  void execute(const char* sql) { check(database, sqlite3_exec(database, sql, nullptr, nullptr, nullptr)); }

  /// Opens the file, or memory.
  void open(const std::string& file) {
    check(database, sqlite3_open(file.c_str(), &database));
    begin();
  }

  /// Opens a copy in memory of a file that cannot be written.
  void open_copy(const std::string& file) {
    sqlite3* source = nullptr;
    const int opened = sqlite3_open_v2(file.c_str(), &source, SQLITE_OPEN_READONLY, nullptr);
    const std::unique_ptr<sqlite3, int (*)(sqlite3*)> closed(source, sqlite3_close);
    check(source, opened);
    check(database, sqlite3_open(":memory:", &database));
    sqlite3_backup* const copy = sqlite3_backup_init(database, "main", source, "main");
    if (!copy) throw std::runtime_error(sqlite3_errmsg(database));
    sqlite3_backup_step(copy, -1);
    check(database, sqlite3_backup_finish(copy));
    begin();
  }

  /// Begins a transaction; what is no index of this version is refused.
  void begin() {
    sqlite3_busy_timeout(database, static_cast<int>(patience.count()));
    // With the journal in a file, as is usual: half an index, which a killed program would leave, may look sound.
    execute("BEGIN IMMEDIATE");
    Statement version(database, "PRAGMA user_version");
    version.row();
    if (const auto found = version.whole(0); found != schema_version) {
      if (found != 0) throw std::runtime_error("an index of another version");
      execute(schema);
      execute(fmt::format("PRAGMA user_version = {}", schema_version).c_str());
    }
  }

  void close() {
    sqlite3_close(database);
    database = nullptr;
    key_numbers.clear();
    problems.clear();
    newest_unread = {};
  }

  /// Asks; an index that turns out to be damaged is built again, in memory where its file cannot be.
  template <typename Ask>
  auto ask(Ask&& of) {
    try {
      return of();
    } catch (const std::exception& found) {
      const bool sound = dynamic_cast<const Unwritable*>(&found) != nullptr;  // another program has it, say
      close();
      if (std::error_code ignored; !sound) fs::remove(fs::path(directory) / ".index.sqlite", ignored);
    }
    open(":memory:");
    refresh();
    return of();
  }

  std::int64_t key_number(const std::string& name) {
    const auto [known, is_new] = key_numbers.emplace(name, 0);
    if (!is_new) return known->second;
    Statement(database, "INSERT OR IGNORE INTO key(name) VALUES(?)").bind(1, name).run();
    Statement number(database, "SELECT number FROM key WHERE name = ?");
    number.bind(1, name).row();
    return known->second = number.whole(0);
  }

  /// The folders as they are now; those that may not be looked into are problems.
  std::unordered_map<std::string, Stamp> folders() {
    std::unordered_map<std::string, Stamp> found;
    std::error_code error;
    fs::directory_iterator one(directory, error);
    if (error) throw std::runtime_error(fmt::format("{}: cannot be read: {}", directory, error.message()));
    for (const fs::directory_iterator end; one != end; one.increment(error)) {
      if (error) throw std::runtime_error(fmt::format("{}: cannot be read: {}", directory, error.message()));
      struct stat status {};
      const fs::path story = one->path() / run_files::story;
      if (::stat(story.c_str(), &status) != 0) {
        if (errno == EACCES)
          problems.push_back(fmt::format("{}: cannot be read: {}", story.string(), std::strerror(errno)));
        continue;
      }
      found[one->path().filename().string()] = {nanoseconds(status.st_mtim), status.st_size};
    }
    return found;
  }

  /// Reads what has changed since it was read last. Within a transaction, which it ends.
  void refresh() {
    auto found = folders();
    std::vector<std::pair<std::int64_t, std::string>> gone;
    {
      Statement known(database, "SELECT number, id, changed, size FROM run");
      while (known.row()) {
        const auto there = found.find(known.text(1));
        if (there != found.end() && there->second == Stamp{known.whole(2), known.whole(3)})
          found.erase(there);
        else
          gone.emplace_back(known.whole(0), known.text(1));
      }
    }
    Statement forget_facts(database, "DELETE FROM fact WHERE key IN (SELECT number FROM key) AND run = ?"),
        forget(database, "DELETE FROM run WHERE number = ?");
    for (const auto& [number, id] : gone) {
      forget_facts.bind(1, number).run();
      forget.bind(1, number).run();
    }
    std::vector<Reading> runs;
    runs.reserve(found.size());
    for (const auto& [id, stamp] : found) runs.push_back({id, stamp});
    constexpr std::size_t most = 2000;  // in memory at a time
    for (std::size_t i = 0; i < runs.size(); i += most) {
      const std::span part = std::span(runs).subspan(i, std::min(most, runs.size() - i));
      read(directory, part);
      add(part);
    }
    execute("COMMIT");
  }

  /// Adds runs that have been read, and empties them. Their facts go in by the order of the table, which is much faster
  /// than run after run.
  void add(std::span<Reading> runs) {
    Statement add_run(database, "INSERT INTO run(id, changed, size, began) VALUES(?, ?, ?, ?)"),
        add_fact(database, "INSERT INTO fact(key, run, value) VALUES(?, ?, ?)");
    std::map<std::int64_t, std::vector<std::pair<std::int64_t, Value>>> by_key;
    for (Reading& run : runs) {
      if (!run.problem.empty()) {
        problems.push_back(std::move(run.problem));
        if (newest_unread.id.empty() || run.stamp.changed > newest_unread.began)
          newest_unread = {run.id, run.stamp.changed};
        continue;
      }
      add_run.bind(1, run.id).bind(2, run.stamp.changed).bind(3, run.stamp.size).bind(4, run.began).run();
      const std::int64_t number = sqlite3_last_insert_rowid(database);
      for (auto& [key, value] : std::exchange(run.facts, {}))
        by_key[key_number(key)].emplace_back(number, std::move(value));
    }
    for (const auto& [key, values] : by_key)
      for (const auto& [run, value] : values) add_fact.bind(1, key).bind(2, run).bind(3, value).run();
  }

  /// The keys that a word stands for: the one with this name; else those that end in it behind a dot, numbered ones
  /// (of single robots, say) only where there are no others. Expectations are named in full: they have the names of
  /// results, which a run without any would seem to have.
  tl::expected<std::int64_t, std::string> resolve(const std::string& word) {
    std::vector<std::pair<std::string, std::int64_t>> plain, similar;
    Statement keys(database, "SELECT name, number FROM key ORDER BY name");
    while (keys.row()) {
      const std::string name = keys.text(0);
      if (name == word) return keys.whole(1);
      if (name.ends_with('.' + word) && !name.starts_with("expect.")) plain.emplace_back(name, keys.whole(1));
      if (name.find(word) != std::string::npos) similar.emplace_back(name, 0);
    }
    const auto numbered = [](const auto& key) {
      for (std::size_t dot = key.first.find('.'); dot != std::string::npos; dot = key.first.find('.', dot + 1))
        if (std::isdigit(static_cast<unsigned char>(key.first[dot + 1])) != 0) return true;
      return false;
    };
    if (!std::all_of(plain.begin(), plain.end(), numbered)) std::erase_if(plain, numbered);
    if (plain.size() == 1) return plain.front().second;
    std::string names;
    for (const auto& [name, number] : plain.empty() ? similar : plain) names += (names.empty() ? "" : ", ") + name;
    if (!plain.empty()) return tl::unexpected(fmt::format("{}: could be {}, allowed: one of them", word, names));
    return tl::unexpected(
        fmt::format("{}: no run has such a key; {}", word,
                    names.empty() ? "`skein runs find --keys` lists the available ones" : "similar ones are " + names));
  }

  /// The query as a condition on run.number, with what is to be bound.
  tl::expected<std::string, std::string> condition(const RunQuery& query, std::vector<Value>& bound) {
    switch (query.kind) {
      case RunQuery::Kind::comparison:
        return condition(query.comparison, bound);
      case RunQuery::Kind::negation: {
        auto of = condition(query.of.front(), bound);
        if (of) *of = "NOT " + *of;
        return of;
      }
      case RunQuery::Kind::all:
        return joined(query.of, " AND ", bound);
      case RunQuery::Kind::any:
        return joined(query.of, " OR ", bound);
    }
    return tl::unexpected(std::string("no such condition"));
  }
  tl::expected<std::string, std::string> joined(const std::vector<RunQuery>& parts, const char* joint,
                                                std::vector<Value>& bound) {
    std::string sql;
    for (const RunQuery& part : parts) {
      auto one = condition(part, bound);
      if (!one) return one;
      sql += (sql.empty() ? "(" : joint) + *one;
    }
    return sql + ")";
  }
  tl::expected<std::string, std::string> condition(const RunQuery::Comparison& c, std::vector<Value>& bound) {
    const auto key = resolve(c.key);
    if (!key) return tl::unexpected(key.error());
    if (const std::string year = year_of(c.value); !year.empty() && has_times(*key))
      return condition({c.key, c.relation, year}, bound);
    const bool is_text = std::holds_alternative<std::string>(c.value);
    // A text is no smaller or larger number: SQLite sorts all texts behind all numbers.
    const auto facts = [&](bool text) {
      return fmt::format("FROM fact WHERE key = {} AND typeof(value) {}", *key,
                         text ? "= 'text'" : "IN ('real', 'integer')");
    };
    const auto any = [&](bool text) { return Statement(database, "SELECT 1 " + facts(text) + " LIMIT 1").row(); };
    const std::string of_this_type = facts(is_text);
    if (!any(is_text) && any(!is_text))
      return tl::unexpected(
          fmt::format("{}: found {}, allowed: {}", c.key,
                      std::visit(Overloaded{[](const std::string& text) { return fmt::format("the text {}", text); },
                                            [](const auto& number) { return fmt::format("the number {}", number); }},
                                 c.value),
                      is_text ? "a number, such as 0.01, since no run has a text here"
                              : "a text between quotes, since no run has a number here"));
    std::string left = "value", right = "?";
    Value value = c.value;
    if (is_text && c.relation != RunQuery::Relation::contains && has_times(*key)) {
      auto time = time_of(std::get<std::string>(c.value));
      if (!time) return tl::unexpected(c.key + ": " + time.error());
      // As exactly as it is written: with a zone the instant, else by the clock where the run was made.
      const auto to_its_end = [&](std::string_view of) { return fmt::format("substr({}, 1, {})", of, time->size); };
      left = to_its_end(time->has_zone ? "strftime('%Y-%m-%dT%H:%M:%f', value)" : "value");
      if (time->has_zone) right = to_its_end("strftime('%Y-%m-%dT%H:%M:%f', ?)");
      value = std::move(time->text);
    }
    std::string_view sign;
    switch (c.relation) {
      case RunQuery::Relation::equal:
        sign = "=";
        break;
      case RunQuery::Relation::unequal:
        sign = "<>";
        break;
      case RunQuery::Relation::less:
        sign = "<";
        break;
      case RunQuery::Relation::at_most:
        sign = "<=";
        break;
      case RunQuery::Relation::greater:
        sign = ">";
        break;
      case RunQuery::Relation::at_least:
        sign = ">=";
        break;
      case RunQuery::Relation::contains:
        bound.push_back(c.value);
        return fmt::format("(number IN (SELECT run {} AND instr(value, ?) > 0))", of_this_type);
    }
    bound.push_back(std::move(value));
    return fmt::format("(number IN (SELECT run {} AND {} {} {}))", of_this_type, left, sign, right);
  }

  /// A number that is a year, of four digits; empty: it is none.
  static std::string year_of(const Value& value) {
    constexpr double first = 1000.0, last = 9999.0;
    const double* const number = std::get_if<double>(&value);
    const bool is_year = number != nullptr && *number >= first && *number <= last && *number == std::floor(*number);
    return is_year ? fmt::format("{}", *number) : std::string();
  }

  struct Time {
    std::string text;      // as run.json has it, or its beginning: 2026-11, 2026-11-20T20:15
    std::size_t size = 0;  // of that, without the zone
    bool has_zone = false;
  };
  /// A time in a query. Only times of this form can be compared as texts: 2026-9-1 would be later than 2026-11-01.
  tl::expected<Time, std::string> time_of(std::string text) {
    constexpr std::string_view form = "0000-00-00T00:00:00.000", earliest = "0000-01-01T00:00:00.000";
    constexpr std::size_t day = 10, minute = 16;
    if (text.size() > day && text[day] == ' ') text[day] = 'T';
    std::size_t size = text.size();
    if (size > minute && text.back() == 'Z')
      size -= 1;
    else if (size >= minute + 6 && (text[size - 6] == '+' || text[size - 6] == '-'))
      size -= 6;
    bool good = size == 4 || size == 7 || size == day || size == minute || (size >= 19 && size != 20);
    for (std::size_t i = 0; i < size; ++i)
      good = good && i < form.size() &&
             (form[i] == '0' ? std::isdigit(static_cast<unsigned char>(text[i])) != 0 : text[i] == form[i]);
    if (good) {
      Statement known(database, "SELECT julianday(?) IS NULL");
      known.bind(1, text.substr(0, size) + std::string(earliest.substr(size)) + text.substr(size)).row();
      good = known.whole(0) == 0;
    }
    if (good && size >= day) {  // SQLite takes the 30th of February for the 2nd of March
      const auto number = [&](std::size_t from, std::size_t digits) { return std::stoi(text.substr(from, digits)); };
      good = std::chrono::year_month_day{std::chrono::year(number(0, 4)),
                                         std::chrono::month(static_cast<unsigned>(number(5, 2))),
                                         std::chrono::day(static_cast<unsigned>(number(8, 2)))}
                 .ok();
    }
    if (!good)
      return tl::unexpected(
          fmt::format("found {}, allowed: a date such as 2026-11-20, or a time such as 2026-11-20T20:15", text));
    return Time{text, size, size < text.size()};
  }

  /// Whether the key's values are times.
  bool has_times(std::int64_t key) {
    Statement name(database, "SELECT name FROM key WHERE number = ?");
    name.bind(1, key).row();
    return name.text(0) == "began" || name.text(0) == "ended";
  }

  std::vector<Run> select(const std::string& where, const std::vector<Value>& bound,
                          const std::vector<std::string>& keys) {
    std::vector<Run> runs;
    Statement found(database, "SELECT number, id FROM run WHERE " + where + " ORDER BY began, id");
    for (std::size_t i = 0; i < bound.size(); ++i) found.bind(static_cast<int>(i) + 1, bound[i]);
    std::vector<std::pair<std::string, std::int64_t>> asked;  // by the words that they were asked for with
    for (const std::string& key : keys)
      if (const auto number = resolve(key)) asked.emplace_back(key, *number);
    Statement fact(database, "SELECT value FROM fact WHERE key = ? AND run = ?");
    while (found.row()) {
      Run run{found.text(1), {}};
      for (const auto& [key, number] : asked) {
        Statement& value = fact.bind(1, number).bind(2, found.whole(0));
        if (value.row()) run.facts[key] = value.value(0);
        value.run();
      }
      runs.push_back(std::move(run));
    }
    return runs;
  }
};

std::optional<std::string> damage_of_index(const std::string& directory) {
  const std::string file = (fs::path(directory) / ".index.sqlite").string();
  std::error_code error;
  if (!fs::exists(file, error)) return {};
  if (const auto is_file = check_is_file(file); !is_file) return is_file.error();
  const auto damaged = [&](const std::string& why) { return fmt::format("{}: is damaged: {}", file, why); };
  sqlite3* database = nullptr;
  const std::unique_ptr<sqlite3*, void (*)(sqlite3**)> closed(&database, [](sqlite3** open) { sqlite3_close(*open); });
  try {
    check(database, sqlite3_open_v2(file.c_str(), &database, SQLITE_OPEN_READONLY, nullptr));
    sqlite3_busy_timeout(database, 10'000);  // another program may be updating it
    Statement sound(database, "PRAGMA quick_check");
    if (!sound.row()) return damaged("it says nothing");
    if (const std::string said = sound.text(0); said != "ok") return damaged(said);
  } catch (const std::exception& why) {
    return damaged(why.what());
  }
  return {};
}

RunIndex::RunIndex(std::unique_ptr<State> state) : state_(std::move(state)) {}
RunIndex::RunIndex(RunIndex&&) noexcept = default;
RunIndex& RunIndex::operator=(RunIndex&&) noexcept = default;
RunIndex::~RunIndex() = default;

tl::expected<RunIndex, std::string> RunIndex::open(const std::string& directory, std::chrono::milliseconds patience) {
  auto state = std::make_unique<State>();
  state->directory = directory;
  state->patience = patience;
  std::error_code error;
  if (!fs::is_directory(directory, error)) {
    if (error && error != std::errc::no_such_file_or_directory && error != std::errc::not_a_directory)
      return tl::unexpected(fmt::format("{}: cannot be read: {}", directory, error.message()));
    return tl::unexpected(fmt::format("{}: there is no such directory: no run has been kept there", directory));
  }
  if (auto refused = folder_of_a_run(directory)) return tl::unexpected(*std::move(refused));
  const std::string file = (fs::path(directory) / ".index.sqlite").string();
  std::string why;
  bool unwritable = false;
  const auto opens = [&](void (State::*open_at)(const std::string&), const std::string& place) {
    try {
      (*state.*open_at)(place);
      state->refresh();
      return true;
    } catch (const std::exception& found) {
      why = found.what();
      unwritable = dynamic_cast<const Unwritable*>(&found) != nullptr;
      state->close();
      return false;
    }
  };
  bool open = opens(&State::open, file);
  if (!open && !unwritable) {  // damaged, of another version, or no file
    fs::remove(file, error);
    open = opens(&State::open, file);
  }
  if (!open && unwritable && fs::is_regular_file(file, error)) open = opens(&State::open_copy, file);
  if (!open && !opens(&State::open, ":memory:")) return tl::unexpected(why);
  return RunIndex(std::move(state));
}

std::vector<RunIndex::Run> RunIndex::all(const std::vector<std::string>& keys) {
  return state_->ask([&] { return state_->select("1", {}, keys); });
}

tl::expected<std::vector<RunIndex::Run>, std::string> RunIndex::find(const RunQuery& query,
                                                                     const std::vector<std::string>& keys) {
  return state_->ask([&]() -> tl::expected<std::vector<Run>, std::string> {
    std::vector<Value> bound;
    const auto where = state_->condition(query, bound);
    if (!where) return tl::unexpected(where.error());
    return state_->select(*where, bound, keys);
  });
}

std::map<std::string, RunIndex::Value> RunIndex::facts(const std::string& id) {
  std::map<std::string, Value> facts;
  Statement found(state_->database,
                  "SELECT key.name, value FROM run CROSS JOIN key CROSS JOIN fact ON fact.key = key.number AND "
                  "fact.run = run.number WHERE run.id = ?");
  found.bind(1, id);
  while (found.row()) facts[found.text(0)] = found.value(1);
  return facts;
}

std::vector<std::string> RunIndex::keys() {
  return state_->ask([&] {
    std::vector<std::string> names;
    Statement found(state_->database, "SELECT name FROM key ORDER BY name");
    while (found.row()) names.push_back(found.text(0));
    return names;
  });
}

tl::expected<void, std::string> RunIndex::knows(const std::vector<std::string>& words) {
  return state_->ask([&]() -> tl::expected<void, std::string> {
    for (const std::string& word : words)
      if (const auto key = state_->resolve(word); !key && size() > 0) return tl::unexpected(key.error());
    return {};
  });
}

std::string RunIndex::newest() {
  return state_->ask([&] {
    Statement last(state_->database, "SELECT id, began FROM run ORDER BY began DESC, id DESC LIMIT 1");
    if (!last.row()) return state_->newest_unread.id;
    const State::Unread& unread = state_->newest_unread;
    return !unread.id.empty() && unread.began > last.whole(1) ? unread.id : last.text(0);
  });
}

std::size_t RunIndex::size() {
  Statement count(state_->database, "SELECT count(*) FROM run");
  count.row();
  return static_cast<std::size_t>(count.whole(0));
}

const std::vector<std::string>& RunIndex::problems() const noexcept {
  return state_->problems;
}

}  // namespace skein::app
