#include "ui/results/run_results.h"

#include <QStringList>
#include <cmath>

#include "ui/base/number_text.h"
#include "ui/base/sentence.h"
#include "ui/base/tr.h"

namespace skein::ui {
namespace {

/// The sentence of those that failed for this key of [expect]; empty: none did.
QString failure_of(const std::vector<std::string>& failed, const char* key) {
  const std::string beginning = std::string("expect.") + key + ":";
  for (const std::string& sentence : failed)
    if (sentence.starts_with(beginning)) return QString::fromStdString(sentence.substr(beginning.size())).trimmed();
  return {};
}

/// What happened in sentences, from the log's words; what they do not know stays as it is.
QString in_sentences(const std::string& words) {
  QStringList sentences;
  for (const QString& one : QString::fromStdString(words).split(QStringLiteral("; "))) {
    const auto event = app::parse_event(one.toStdString());
    sentences << (event ? sentence(*event) : one);
  }
  sentences.removeDuplicates();
  return sentences.join(QStringLiteral("; "));
}

/// "1.50 s earlier", "0.60 s later", "alike".
QString difference(const std::optional<double>& later) {
  if (!later) return QStringLiteral("–");
  if (std::abs(*later) < 0.005) return tr("alike");
  return (*later < 0.0 ? tr("%1 s earlier") : tr("%1 s later")).arg(std::abs(*later), 0, 'f', 2);
}

}  // namespace

QString centimetres(double metres) {
  return std::isfinite(metres) ? tr("%1 cm").arg(100 * metres, 0, 'f', 1) : QStringLiteral("–");
}

RunResults::RunResults(const app::Experiment& experiment) : experiment_(experiment), statistics_(experiment) {}

void RunResults::add_record(const app::TickRecord& record) {
  const bool moves = record.phase == app::Phase::running || record.phase == app::Phase::staging;
  started_ = started_ || moves;
  const double ticks_later = (record.t - experiment_.duration) * experiment_.rate;
  // A recording ends with its last tick: what comes after it is no row.
  over_ = record.phase == app::Phase::finished || record.phase == app::Phase::stopped || ticks_later > -1.5;
  if (!moves && !(started_ && !record.events.empty())) return;
  statistics_.record(record);
  const double kick = statistics_.newest_perturbation();
  if (statistics_.perturbations() >= extremes_.size()) {
    extremes_.push_back({kick});
  } else if (extremes_.size() > 1 && kick > extremes_.back().since) {  // a hand that carries on: it counts from now
    Extremes& before = extremes_[extremes_.size() - 2];
    before.add(extremes_.back().closest, extremes_.back().largest);
    extremes_.back() = {kick};
  }
  if (record.phase == app::Phase::staging) return;
  seen_ = true;
  extremes_.back().add(record.min_distance, record.tracking_error());
}

void RunResults::Extremes::add(double distance, double error) {
  closest = std::fmin(closest, distance);
  largest = std::fmax(largest, error);
}

std::vector<RunResults::Kick> RunResults::kicks() const {
  const app::Statistics::Summary summary = statistics_.summary();
  std::vector<Kick> kicks;
  for (const app::PerturbationResult& p : summary.perturbations) {
    Kick kick{p.t, in_sentences(p.what), QString::fromStdString(p.what), p.settling.formation_1cm,
              p.settling.tracking_1cm};
    if (const std::size_t k = kicks.size() + 1; k < extremes_.size()) {
      kick.closest = extremes_[k].closest;
      kick.largest = extremes_[k].largest;
    }
    kicks.push_back(kick);
  }
  return kicks;
}

std::vector<RunResults::Expectation> RunResults::expectations() const {
  const app::Expectations& expect = experiment_.expect;
  const std::vector<std::string> failed = app::failed_expectations(expect, statistics_.summary());
  std::vector<Expectation> all;
  const auto add = [&](const char* key, const QString& what) { all.push_back({what, failure_of(failed, key)}); };
  if (expect.formation_first)
    add("formation_first", *expect.formation_first ? tr("the formation settles before tracking does")
                                                   : tr("the formation does not settle before tracking does"));
  if (expect.min_distance) add("min_distance", tr("robots keep %1 apart").arg(centimetres(*expect.min_distance)));
  if (expect.collisions) add("collisions", tr("at most %1 collisions").arg(*expect.collisions));
  if (expect.final_error) add("final_error", tr("at the end all within %1").arg(centimetres(*expect.final_error)));
  if (expect.arrived) add("arrived", tr("all have arrived after %1 s").arg(*expect.arrived));
  return all;
}

double RunResults::closest() const {
  double closest = app::none;
  for (const Extremes& part : extremes_) closest = std::fmin(closest, part.closest);
  return closest;
}

double RunResults::largest() const {
  double largest = app::none;
  for (const Extremes& part : extremes_) largest = std::fmax(largest, part.largest);
  return largest;
}

std::vector<std::optional<std::size_t>> counterparts(const std::vector<RunResults::Kick>& kicks,
                                                     const std::vector<RunResults::Kick>& others) {
  constexpr double at_once = 0.1;  // [s]
  std::vector<std::optional<std::size_t>> found(kicks.size());
  std::size_t next = 0, next_other = 0;  // the first of each that has not been told of yet
  const auto in_order = [&](std::size_t end, std::size_t end_of_others) {
    for (; next < end && next_other < end_of_others; ++next, ++next_other) found[next] = next_other;
    next = end;
    next_other = end_of_others;
  };
  for (std::size_t k = 0; k < kicks.size(); ++k)
    for (std::size_t o = next_other; o < others.size(); ++o)
      if (std::abs(kicks[k].t - others[o].t) < at_once) {
        in_order(k, o);
        found[next++] = next_other++;
        break;
      }
  in_order(kicks.size(), others.size());
  return found;
}

std::vector<std::vector<KickBeside>> compare(const std::vector<RunResults::Kick>& kicks,
                                             const std::vector<RunBeside>& others) {
  const auto later = [](const std::optional<double>& here, const std::optional<double>& there) {
    return here && there ? std::optional(*here - *there) : std::nullopt;
  };
  std::vector<std::vector<KickBeside>> compared;
  for (const RunBeside& other : others) {
    const std::vector<RunResults::Kick> theirs = other.results->kicks();
    const std::vector<std::optional<std::size_t>> found = counterparts(kicks, theirs);
    std::vector<KickBeside>& row = compared.emplace_back(kicks.size());
    for (std::size_t k = 0; k < kicks.size(); ++k) {
      if (!found[k]) continue;
      const RunResults::Kick& there = theirs[*found[k]];
      row[k] = {true, later(kicks[k].formation, there.formation), later(kicks[k].tracking, there.tracking)};
    }
  }
  return compared;
}

QString beside_text(const KickBeside& kick) {
  if (!kick.has_counterpart) return QStringLiteral("–");
  return tr("formation %1, tracking %2").arg(difference(kick.formation), difference(kick.tracking));
}

QString settling_text(const std::optional<double>& seconds) {
  return seconds ? tr("%1 s").arg(*seconds, 0, 'f', 2) : tr("not yet");
}

QString order_of(const RunResults::Kick& kick) {
  if (!kick.formation && !kick.tracking) return tr("neither yet");
  if (!kick.tracking) return tr("formation first");
  if (!kick.formation) return tr("tracking first");
  const double earlier = *kick.tracking - *kick.formation;
  if (earlier == 0.0) return tr("at once, both");
  return earlier > 0.0 ? tr("formation %1 s earlier").arg(earlier, 0, 'f', 2)
                       : tr("tracking %1 s earlier").arg(-earlier, 0, 'f', 2);
}

QString as_text(const QString& name, const RunResults& results, const std::vector<RunBeside>& others) {
  QStringList lines{name};
  const std::vector<RunResults::Kick> kicks = results.kicks();
  const std::vector<std::vector<KickBeside>> beside = compare(kicks, others);
  for (std::size_t k = 0; k < kicks.size(); ++k) {
    const RunResults::Kick& kick = kicks[k];
    lines << tr("%1 s, %2: formation settled %3, tracking settled %4 (%5); closest pair %6, largest error %7")
                 .arg(kick.t, 0, 'f', 2)
                 .arg(kick.what, settling_text(kick.formation), settling_text(kick.tracking), order_of(kick),
                      centimetres(kick.closest), centimetres(kick.largest));
    for (std::size_t o = 0; o < others.size(); ++o)
      lines.back() += tr("; beside %1: %2").arg(others[o].letter, beside_text(beside[o][k]));
  }
  for (const RunBeside& other : others) lines << tr("beside %1: %2").arg(other.letter, other.name);
  lines << tr("whole run: closest pair %1, largest error %2")
               .arg(centimetres(results.closest()), centimetres(results.largest()));
  for (const RunResults::Expectation& expected : results.expectations())
    lines << (!results.is_over() ? QStringLiteral("… ") + expected.what + tr(" (the run is not over)")
              : expected.holds() ? QStringLiteral("✓ ") + expected.what
                                 : QStringLiteral("✗ ") + expected.what + QStringLiteral(": ") + expected.found);
  return lines.join(QLatin1Char('\n')) + QLatin1Char('\n');
}

QString as_latex(const RunResults& results, const std::vector<RunBeside>& others) {
  const auto seconds = [](const std::optional<double>& s) {
    return s ? QString::number(*s, 'f', 2) : QStringLiteral("--");
  };
  const auto length = [](double metres) {
    return std::isfinite(metres) ? QString::number(100 * metres, 'f', 1) : QStringLiteral("--");
  };
  const auto later = [](const std::optional<double>& s) {  // with its sign, which + has as well
    return s ? QStringLiteral("$%1%2$").arg(*s < 0.0 ? "" : "+").arg(fixed(*s, 2)) : QStringLiteral("--");
  };
  QStringList lines;
  QString heads;
  for (const RunBeside& other : others) {
    lines << QStringLiteral("% %1: %2").arg(other.letter, other.name.simplified());
    heads += QStringLiteral(" & formation, later than %1 [s] & tracking, later than %1 [s]").arg(other.letter);
  }
  lines
      << QStringLiteral("\\begin{tabular}{%1}").arg(QString(5 + 2 * static_cast<int>(others.size()), QLatin1Char('r')))
      << QStringLiteral("\\toprule")
      << QStringLiteral("$t$ [s] & formation [s] & tracking [s] & closest [cm] & error [cm]%1 \\\\").arg(heads)
      << QStringLiteral("\\midrule");
  const std::vector<RunResults::Kick> kicks = results.kicks();
  const std::vector<std::vector<KickBeside>> beside = compare(kicks, others);
  for (std::size_t k = 0; k < kicks.size(); ++k) {
    QStringList cells{QString::number(kicks[k].t, 'f', 2), seconds(kicks[k].formation), seconds(kicks[k].tracking),
                      length(kicks[k].closest), length(kicks[k].largest)};
    for (const std::vector<KickBeside>& run : beside) cells << later(run[k].formation) << later(run[k].tracking);
    lines << cells.join(QStringLiteral(" & ")) + QStringLiteral(" \\\\");
  }
  lines << QStringLiteral("\\bottomrule") << QStringLiteral("\\end{tabular}");
  return lines.join(QLatin1Char('\n')) + QLatin1Char('\n');
}

}  // namespace skein::ui
