// The result card: what the experiment is for, kick by kick.
#include <malloc.h>

#include <QApplication>
#include <QClipboard>
#include <QDockWidget>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QScrollArea>
#include <QScrollBar>
#include <QTableWidget>

#include "app/record/csv_file.h"
#include "app/record/statistics.h"
#include "app/runs/kept_run.h"
#include "app/runs/verify.h"
#include "operator.h"
#include "ui/base/settings.h"
#include "ui/main/result_controller.h"
#include "ui/results/result_panel.h"

namespace skein::ui::test {
namespace {

class Results : public Operator {
 protected:
  struct Rows final : app::RecordSink {
    void record(const app::TickRecord& record) override { rows.push_back(record); }
    std::vector<app::TickRecord> rows;
  };
  /// A run of the paper's experiment on the virtual clock; `sets`: keys of its file.
  std::vector<app::TickRecord> run(const std::vector<std::string>& sets, app::Experiment& experiment) {
    experiment = *app::parse_experiment(app::paper_experiment().source, "platoon.toml", sets);
    Rows rows;
    (*app::Session::open(experiment, app::SessionOptions::Clock::virtual_, {false, {&rows}}))->run();
    return rows.rows;
  }
};

TEST_F(Results, AreThoseOfTheCommandLine) {
  app::Experiment experiment;
  const std::vector<app::TickRecord> rows = run({"duration=30"}, experiment);
  app::Statistics statistics(experiment);
  RunResults results(experiment);
  for (const app::TickRecord& row : rows) {
    statistics.record(row);
    results.add_record(row);
  }
  const app::Statistics::Summary summary = statistics.summary();
  const std::vector<RunResults::Kick> kicks = results.kicks();
  ASSERT_EQ(kicks.size(), summary.perturbations.size());
  ASSERT_GE(kicks.size(), 1u);
  EXPECT_EQ(kicks[0].formation, summary.perturbations[0].settling.formation_1cm);
  EXPECT_EQ(kicks[0].tracking, summary.perturbations[0].settling.tracking_1cm);
  EXPECT_EQ(results.closest(), summary.min_distance);
  EXPECT_GT(kicks[0].largest, 0.05) << "the kick itself is 15 cm";
  const bool all_hold = app::failed_expectations(experiment.expect, summary).empty();
  bool all_ticks = true;
  for (const RunResults::Expectation& expected : results.expectations()) all_ticks = all_ticks && expected.holds();
  EXPECT_EQ(all_ticks, all_hold);
}

TEST_F(Results, OfARecordingHaveTheirTicksAndCrosses) {
  app::Experiment experiment;
  const std::vector<app::TickRecord> rows = run({"duration=30"}, experiment);
  RunResults results(experiment);
  for (const app::TickRecord& row : rows) {
    if (row.phase != app::Phase::running) continue;  // a recording has no row after its last tick
    EXPECT_FALSE(results.is_over()) << row.t;
    results.add_record(row);
  }
  EXPECT_TRUE(results.is_over());
}

/// A report is saved, and gnuplot or not: what is missing is said.
class Report : public Results {
 protected:
  /// Presses the button; the folder that it was saved in.
  QString save() {
    QString folder;
    const auto connection = QObject::connect(window.findChild<ResultController*>(), &ResultController::saved, &window,
                                             [&](const QString& in, const QStringList& missing) {
                                               folder = in;
                                               problems = missing.join(QLatin1Char('|'));
                                             });
    find<QPushButton>("save_results")->click();
    EXPECT_TRUE(eventually([&] { return !folder.isEmpty(); }));
    QObject::disconnect(connection);
    return folder;
  }
  static QString text_of(const QString& file) {
    QFile in(file);
    EXPECT_TRUE(in.open(QIODevice::ReadOnly)) << file.toStdString();
    return QString::fromUtf8(in.readAll());
  }
  QString problems;
};

TEST_F(Report, IsSavedFromTheCardByOneButton) {
  const QTemporaryDir dir;
  settings().setValue(QStringLiteral("recordings"), dir.path());
  start();
  const QString folder = save();
  settings().remove(QStringLiteral("recordings"));
  EXPECT_EQ(problems.toStdString(), "");
  EXPECT_TRUE(folder.startsWith(dir.path())) << folder.toStdString();
  EXPECT_TRUE(text_of(folder + QStringLiteral("/results.txt")).contains(QStringLiteral("platoon")));
  EXPECT_TRUE(text_of(folder + QStringLiteral("/results.tex")).contains(QStringLiteral("tabular")));
  EXPECT_TRUE(text_of(folder + QStringLiteral("/report.html")).contains(QStringLiteral("<html")));
  for (const char* file : {"figure3.pdf", "figure4.svg", "summary.json"})
    EXPECT_TRUE(QFile::exists(folder + QLatin1Char('/') + QLatin1String(file))) << file;
  const auto recorded = app::load_run((folder + QStringLiteral("/run.csv")).toStdString());
  ASSERT_TRUE(recorded) << recorded.error();
  EXPECT_EQ(recorded->check.different, 0);
}

TEST_F(Report, OfAKeptRunGoesIntoItsFolder) {
  const QTemporaryDir dir;
  const app::Experiment experiment = *app::parse_experiment(app::paper_experiment().source, "short", {"duration=2"});
  auto kept = app::KeptRun::begin({dir.path().toStdString(), {}, {"duration=2"}, {"run"}, false}, experiment);
  ASSERT_TRUE(kept) << kept.error();
  app::Statistics statistics(experiment);
  app::CsvFile csv(kept->csv(), experiment);
  auto session = app::Session::open(experiment, app::Session::Clock::virtual_, {.sinks = {&statistics, &csv}});
  (*session)->run();
  csv.finish();
  ASSERT_TRUE(kept->end(statistics.summary(), {}));

  window.resize(1280, 800);
  window.show();
  window.open_recording(QString::fromStdString(kept->csv()));
  ASSERT_TRUE(eventually([&] { return window.replay().is_loaded(); }));
  EXPECT_EQ(save().toStdString(), kept->folder());
  EXPECT_EQ(problems.toStdString(), "");
  EXPECT_TRUE(QFile::exists(QString::fromStdString(kept->folder() + "/report.html")));
  const auto found = app::verify_run(kept->folder());
  ASSERT_TRUE(found);
  for (const auto& step : found->steps) EXPECT_TRUE(step.holds) << step.what << ": " << step.finding;
}

TEST_F(Results, TakeNoMoreMemoryTheLongerARunLasts) {
  app::Experiment experiment;
  std::vector<app::TickRecord> rows = run({"duration=1"}, experiment);
  app::TickRecord row = rows.back();
  row.phase = app::Phase::running;
  row.events.clear();
  RunResults results(experiment);
  const auto drive = [&](int from, int to) {  // [h]
    for (int k = from * 90'000; k < to * 90'000; ++k) {
      row.t = k / 25.0;
      results.add_record(row);
    }
    return static_cast<std::int64_t>(::mallinfo2().uordblks);
  };
  const std::int64_t after_one_hour = drive(0, 1);
  EXPECT_LE(drive(1, 4) - after_one_hour, 64 * 1024);
}

TEST_F(Results, AHandThatCarriesARobotOnIsOneKickFromItsLastMoment) {
  app::Experiment experiment;
  app::TickRecord row = run({"duration=1"}, experiment).back();
  row.phase = app::Phase::running;
  RunResults results(experiment);
  const auto take = [&](double t, double distance, bool moved) {
    row.t = t;
    row.min_distance = distance;
    row.events.clear();
    if (moved) row.events.add(app::events::Move{0, {0.1, 0.0, 0.0}});
    results.add_record(row);
  };
  take(1.00, 0.20, false);
  take(1.04, 0.30, true);
  take(1.08, 0.15, false);  // the hand is still there
  take(1.12, 0.25, true);
  take(1.16, 0.22, false);
  const std::vector<RunResults::Kick> kicks = results.kicks();
  ASSERT_EQ(kicks.size(), 1u);
  EXPECT_DOUBLE_EQ(kicks[0].t, 1.12);
  EXPECT_DOUBLE_EQ(kicks[0].closest, 0.22);
  EXPECT_DOUBLE_EQ(results.closest(), 0.15);
}

TEST_F(Results, NameTheirKicksInSentences) {
  start();
  find<QAction>("go_to_results")->trigger();
  auto* table = find<QTableWidget>("result_table");
  EXPECT_FALSE(table->isVisible()) << "nothing but its head, over the text";
  drag(robot(1), robot(1) + QPoint(30, 25));
  moved(1);
  ASSERT_TRUE(eventually([&] { return table->rowCount() == 2; })) << "its numbers, and its sentences";
  EXPECT_TRUE(table->isVisible());
  EXPECT_TRUE(table->item(1, 0)->text().startsWith(QStringLiteral("Robot 2 was moved by hand: ")))
      << table->item(1, 0)->text().toStdString();
  EXPECT_TRUE(table->item(1, 0)->toolTip().startsWith(QStringLiteral("move r2 ")))
      << table->item(1, 0)->toolTip().toStdString();
  find<QPushButton>("copy_results")->click();
  EXPECT_TRUE(QGuiApplication::clipboard()->text().contains(QStringLiteral("Robot 2 was moved by hand")));
}

TEST_F(Results, FitIntoANarrowPanel) {
  app::Experiment experiment;
  const std::vector<app::TickRecord> rows = run({"duration=25"}, experiment);
  ResultPanel panel;
  panel.resize(320, 300);
  panel.show();
  panel.show_experiment(experiment);
  for (const app::TickRecord& row : rows) panel.show_record(row);
  panel.refresh();
  const auto* scroll = panel.findChild<QScrollArea*>();
  const auto* save = panel.findChild<QPushButton*>(QStringLiteral("save_results"));
  ASSERT_EQ(panel.width(), 320);
  EXPECT_TRUE(eventually([&] { return scroll->widget()->width() <= scroll->viewport()->width(); }))
      << scroll->widget()->width() << " px in " << scroll->viewport()->width();
  EXPECT_LE(save->mapTo(scroll->widget(), QPoint(save->width(), 0)).x(), scroll->viewport()->width());
}

TEST_F(Results, SayWhatAComparedRunDidOtherwise) {
  app::Experiment experiment, uncoupled;
  const std::vector<app::TickRecord> rows = run({"duration=40"}, experiment);
  const std::vector<app::TickRecord> others =
      run({"duration=40", "controller.gains.k_xx=0", "controller.gains.k_yy=0", "controller.gains.k_tt=0"}, uncoupled);
  ResultPanel panel;
  panel.resize(900, 300);
  panel.show();
  panel.show_experiment(experiment);
  for (const app::TickRecord& row : rows) panel.show_record(row);
  auto beside_it = std::make_shared<RunResults>(uncoupled);
  for (const app::TickRecord& row : others) beside_it->add_record(row);
  panel.compare({{QStringLiteral("A"), QStringLiteral("uncoupled"), beside_it}});
  auto* table = panel.findChild<QTableWidget*>(QStringLiteral("result_table"));
  const std::vector<RunResults::Kick> here = panel.results()->kicks(), there = beside_it->kicks();
  ASSERT_EQ(table->rowCount(), 2 * static_cast<int>(here.size()));
  const auto sentences = [&] { return table->item(1, 0)->text(); };
  const double formation = *here[0].formation - *there[0].formation, tracking = *here[0].tracking - *there[0].tracking;
  ASSERT_LT(formation, -0.1);
  ASSERT_GT(tracking, 0.1);
  const QString beside =
      QStringLiteral("formation %1 s earlier, tracking %2 s later").arg(-formation, 0, 'f', 2).arg(tracking, 0, 'f', 2);
  EXPECT_TRUE(sentences().endsWith(QStringLiteral("\nBeside A: ") + beside)) << sentences().toStdString();

  // What is copied has the same differences.
  const auto copied = [&](const char* button) {
    panel.findChild<QPushButton*>(QString::fromLatin1(button))->click();
    return QApplication::clipboard()->text();
  };
  const QString text = copied("copy_results");
  EXPECT_TRUE(text.contains(QStringLiteral("; beside A: ") + beside + QLatin1Char('\n'))) << text.toStdString();
  EXPECT_TRUE(text.contains(QStringLiteral("\nbeside A: uncoupled\n"))) << text.toStdString();
  const QString latex = copied("copy_results_latex");
  EXPECT_TRUE(latex.startsWith(QStringLiteral("% A: uncoupled\n\\begin{tabular}{rrrrrrr}\n"))) << latex.toStdString();
  EXPECT_TRUE(
      latex.contains(QStringLiteral(" & $%1$ & $+%2$ \\\\\n").arg(formation, 0, 'f', 2).arg(tracking, 0, 'f', 2)))
      << latex.toStdString();
  for (const QString& line : latex.split(QLatin1Char('\n')))
    if (line.endsWith(QStringLiteral("\\\\"))) {
      EXPECT_EQ(line.count(QLatin1Char('&')), 6) << line.toStdString();
    }

  panel.compare({{QStringLiteral("A"), QStringLiteral("uncoupled"), beside_it},
                 {QStringLiteral("B"), QStringLiteral("again"), beside_it}});
  EXPECT_TRUE(sentences().contains(QStringLiteral("\nBeside B: formation"))) << sentences().toStdString();
  panel.compare({});
  EXPECT_FALSE(sentences().contains(QStringLiteral("Beside"))) << "control";
  EXPECT_FALSE(copied("copy_results").contains(QStringLiteral("beside")));
  EXPECT_EQ(copied("copy_results_latex").count(QStringLiteral("later")), 0);
}

TEST_F(Results, CompareAKickWithThatAtTheSameTimeAlthoughAHandWasThereBefore) {
  const auto at = [](std::initializer_list<double> times) {
    std::vector<RunResults::Kick> kicks;
    for (const double t : times) kicks.push_back({.t = t, .what = {}, .words = {}, .formation = {}, .tracking = {}});
    return kicks;
  };
  using Others = std::vector<std::optional<std::size_t>>;
  EXPECT_EQ(counterparts(at({5, 18, 46}), at({18, 46})), (Others{{}, 0, 1}));
  EXPECT_EQ(counterparts(at({18, 46}), at({5, 18, 46})), (Others{1, 2}));
  EXPECT_EQ(counterparts(at({12.3, 30}), at({14.8})), (Others{0, {}})) << "by hand, at other times";
  EXPECT_EQ(counterparts(at({18, 40}), at({18.02, 33, 50})), (Others{0, 1}));

  app::Experiment experiment, with_hand;
  const std::vector<app::TickRecord> rows = run({"duration=30"}, experiment);
  with_hand = *app::parse_experiment(
      experiment.source + "[[operator]]\nt = 5\ndoes = \"move r1 x=0.7 y=0.1 theta=1.57\"\n", "with a hand");
  Rows others;
  (*app::Session::open(with_hand, app::SessionOptions::Clock::virtual_, {false, {&others}}))->run();
  ResultPanel panel;
  panel.resize(900, 300);
  panel.show();
  panel.show_experiment(with_hand);
  for (const app::TickRecord& row : others.rows) panel.show_record(row);
  auto beside_it = std::make_shared<RunResults>(experiment);
  for (const app::TickRecord& row : rows) beside_it->add_record(row);
  panel.compare({{QStringLiteral("A"), QStringLiteral("left alone"), beside_it}});
  auto* table = panel.findChild<QTableWidget*>(QStringLiteral("result_table"));
  ASSERT_EQ(table->rowCount(), 4) << "a row of numbers and one of sentences for each kick";
  const auto beside = [&](int row) { return table->item(row, 0)->text().section(QStringLiteral("Beside A: "), 1, 1); };
  EXPECT_EQ(beside(1).toStdString(), "–") << "nobody moved a robot at 5 s there";
  EXPECT_TRUE(beside(3).startsWith(QStringLiteral("formation "))) << beside(3).toStdString();
}

TEST_F(Results, AreNotJudgedInACopyBeforeTheRunIsOver) {
  app::Experiment experiment;
  const std::vector<app::TickRecord> rows = run({"duration=20", "expect.arrived=19"}, experiment);
  RunResults results(experiment);
  for (const app::TickRecord& row : rows) {
    if (row.t > 19.5) break;
    results.add_record(row);
  }
  ASSERT_FALSE(results.expectations().empty());
  QString text = as_text(QStringLiteral("platoon"), results);
  EXPECT_FALSE(text.contains(QStringLiteral("✗")) || text.contains(QStringLiteral("✓"))) << text.toStdString();
  EXPECT_TRUE(text.contains(QStringLiteral("… "))) << text.toStdString();
  app::TickRecord last = rows.back();
  last.phase = app::Phase::finished;
  results.add_record(last);
  text = as_text(QStringLiteral("platoon"), results);
  EXPECT_TRUE(text.contains(QStringLiteral("✗")) || text.contains(QStringLiteral("✓"))) << text.toStdString();
}

TEST_F(Results, HaveTheirNumbersAndTheirTextOnTheScreensOfLaptops) {
  start();
  window.resize(1366, 728);
  window.set_speed(20.0);
  find<QDockWidget>("results_dock")->raise();
  auto* table = find<QTableWidget>("result_table");
  auto* rest = find<QLabel>("result_text");
  const auto seen = [&](const QWidget& widget) { return !widget.visibleRegion().isEmpty(); };
  EXPECT_TRUE(eventually([&] { return seen(*rest); })) << "before a kick nothing is said";
  ASSERT_TRUE(eventually([&] { return table->rowCount() >= 1; }));
  for (const QSize size : {QSize(1366, 728), QSize(1280, 760)}) {
    window.resize(size);
    for (const char* title : {"t", "Formation", "Tracking", "Closest", "Error"}) {
      int column = 0;
      while (table->horizontalHeaderItem(column)->text() != QLatin1String(title)) ++column;
      EXPECT_TRUE(eventually([&] {
        const QRect cell = table->visualItemRect(table->item(0, column));
        return table->viewport()->visibleRegion().contains(cell.adjusted(2, 2, -2, -2).center()) &&
               cell.right() <= table->viewport()->width();
      })) << title
          << " at " << size.width() << ": " << table->horizontalHeader()->length() << " px of columns in "
          << table->viewport()->width();
    }
  }
  EXPECT_TRUE(table->item(1, 0)->text().startsWith(QStringLiteral("Robot 2 was moved")));
  for (const QSize size : {QSize(1366, 728), QSize(1280, 800), QSize(800, 600)}) {
    window.resize(size);
    EXPECT_TRUE(eventually([&] {
      QRect room = table->visualItemRect(table->item(1, 0));
      room.setWidth(std::min(room.width(), table->viewport()->width()) - 12);
      const QRect text = table->fontMetrics().boundingRect(room, Qt::TextWordWrap, table->item(1, 0)->text());
      return window.size() == size && text.height() <= room.height() && text.width() <= room.width();
    })) << "what the kick was is cut at "
        << size.width();
  }
  auto* scroll = find("results")->findChild<QScrollArea*>();
  scroll->verticalScrollBar()->setValue(scroll->verticalScrollBar()->maximum());
  EXPECT_TRUE(eventually([&] { return seen(*rest); })) << "below the kicks";
}

TEST_F(Results, AreShownLiveAndCopied) {
  start();
  window.set_speed(20.0);
  find<QDockWidget>("results_dock")->raise();
  auto* table = find<QTableWidget>("result_table");
  ASSERT_TRUE(eventually([&] { return record().t > 24.0; }));
  EXPECT_TRUE(eventually([&] { return table->rowCount() >= 1; })) << "the kick at 18 s has no row";
  find<QPushButton>("copy_results")->click();
  EXPECT_TRUE(QApplication::clipboard()->text().contains(QStringLiteral("formation settled")));
  find<QPushButton>("copy_results_latex")->click();
  EXPECT_TRUE(QApplication::clipboard()->text().startsWith(QStringLiteral("\\begin{tabular}")));
}

}  // namespace
}  // namespace skein::ui::test
