// What `skein export` writes, read by libraries that somebody else wrote.
#include "app/exchange/export.h"

#include <gtest/gtest.h>
#include <matio.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>

#include "app/exchange/run_exporter.h"
#include "app/record/csv_reader.h"
#include "tests/app/exchange/recorded.h"
#include "tests/files.h"

namespace skein::app {
namespace {

using test::Folder;
using test::Recorded;

using test::read_file;

tl::expected<Exported, std::string> export_text(const std::string& csv, const std::string& to, ExportFormat format) {
  std::istringstream in(csv);
  return export_run(in, "run.csv", to, {.format = format});
}

TEST(Export, APlainCsvIsTheSameRowsWithoutTheLinesBeforeTheHeader) {
  const Recorded run;
  const Folder folder;
  const auto exported = export_text(run.csv, folder / "plain.csv", ExportFormat::csv);
  ASSERT_TRUE(exported) << exported.error();
  EXPECT_EQ(exported->rows, static_cast<std::int64_t>(run.rows.size()));
  EXPECT_EQ(read_file(folder / "plain.csv"), run.csv.substr(run.csv.find("\nt,tick,") + 1));
}

TEST(Export, ATornRowIsLeftOutAndSaid) {
  const Recorded run;
  const Folder folder;
  const std::string torn = run.csv.substr(0, run.csv.size() - 30);
  for (const ExportFormat format : {ExportFormat::csv, ExportFormat::mcap, ExportFormat::mat}) {
    const auto exported = export_text(torn, folder / std::string(word(format)), format);
    ASSERT_TRUE(exported) << exported.error();
    EXPECT_TRUE(exported->torn.has_value());
    EXPECT_EQ(exported->rows, static_cast<std::int64_t>(run.rows.size()) - 1);
  }
}

TEST(Export, WhatIsNoRunIsRefusedAndLeavesNoFile) {
  const Folder folder;
  for (const ExportFormat format : {ExportFormat::csv, ExportFormat::mcap, ExportFormat::mat}) {
    const auto exported = export_text("a,b\n1,2\n", folder / "out", format);
    ASSERT_FALSE(exported);
    EXPECT_NE(exported.error().find("run.csv:1"), std::string::npos) << exported.error();
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  }
}

TEST(Export, AFileThatIsThereStays) {
  const Recorded run;
  const Folder folder;
  std::ofstream(folder / "run.mat") << "mine";
  EXPECT_FALSE(export_text(run.csv, folder / "run.mat", ExportFormat::mat));
  EXPECT_EQ(read_file(folder / "run.mat"), "mine");
}

TEST(Export, NamesStandBesideTheRun) {
  EXPECT_EQ(export_name("a/run.csv", ExportFormat::csv), "a/run.plain.csv");
  EXPECT_EQ(export_name("a/run.csv", ExportFormat::mcap), "a/run.mcap");
  EXPECT_EQ(export_name("run", ExportFormat::mat), "run.mat");
}

struct MatFile {
  explicit MatFile(const std::string& path) : file(Mat_Open(path.c_str(), MAT_ACC_RDONLY)) {
    if (file) run = Mat_VarRead(file, "run");
  }
  ~MatFile() {
    if (run) Mat_VarFree(run);
    if (file) Mat_Close(file);
  }
  MatFile(const MatFile&) = delete;
  MatFile& operator=(const MatFile&) = delete;
  const matvar_t* field(const char* name) const { return run ? Mat_VarGetStructFieldByName(run, name, 0) : nullptr; }
  mat_t* file;
  matvar_t* run = nullptr;
};

/// A run of many hours has gigabytes: nothing holds the whole file.
TEST(Export, AMatFileIsTakenFieldByField) {
  const Recorded run;
  std::istringstream csv(run.csv);
  auto reader = CsvReader::open(csv, "run.csv").value();
  const auto exporter = mat_exporter(reader);
  for (TickRecord row; reader.next(row).value();) exporter->row(row);
  exporter->finish();
  std::size_t largest = 0, whole = 0;
  for (std::string piece = exporter->take(); !piece.empty(); piece = exporter->take()) {
    largest = std::max(largest, piece.size());
    whole += piece.size();
  }
  EXPECT_LT(largest, whole / 4);
  const Folder folder;
  ASSERT_TRUE(export_text(run.csv, folder / "run.mat", ExportFormat::mat));
  EXPECT_EQ(whole, std::filesystem::file_size(folder / "run.mat"));
}

/// By libmatio, which reads what MATLAB writes.
TEST(Export, MatlabsFormatHoldsEveryCellToTheBit) {
  const Recorded run;
  const Folder folder;
  ASSERT_TRUE(export_text(run.csv, folder / "run.mat", ExportFormat::mat));
  const MatFile mat(folder / "run.mat");
  ASSERT_NE(mat.file, nullptr);
  ASSERT_NE(mat.run, nullptr);

  std::istringstream in(run.csv);
  auto reader = CsvReader::open(in, "run.csv").value();
  TickRecord row;
  std::size_t words = 0, numbers = 0, empty = 0;
  for (std::size_t k = 0; reader.next(row).value(); ++k)
    for (std::size_t i = 0; i < reader.columns().size(); ++i) {
      const std::string& name = reader.columns()[i];
      const std::string cell(reader.cells()[i]);
      const matvar_t* const field = mat.field(name.c_str());
      ASSERT_NE(field, nullptr) << name;
      ASSERT_EQ(field->dims[0], run.rows.size());
      if (field->class_type == MAT_C_CELL) {
        const matvar_t* const text = static_cast<matvar_t**>(field->data)[k];
        ASSERT_EQ(text->dims[1], cell.size()) << name << " " << cell;
        ++words;
        continue;
      }
      ASSERT_EQ(field->class_type, MAT_C_DOUBLE) << name;
      const double value = static_cast<const double*>(field->data)[k];
      ++(cell.empty() ? empty : numbers);
      if (cell.empty())
        ASSERT_TRUE(std::isnan(value)) << name;
      else
        ASSERT_EQ(value, std::stod(cell)) << name;
    }
  EXPECT_EQ(words, run.rows.size() * (1 + 4 * run.experiment.robots.size()));
  EXPECT_GT(numbers, 100 * run.rows.size());
  EXPECT_GT(empty, 0u);
  const matvar_t* const experiment = mat.field("experiment");
  ASSERT_NE(experiment, nullptr);
  EXPECT_EQ(experiment->dims[1], run.experiment.source.size());
}

}  // namespace
}  // namespace skein::app
