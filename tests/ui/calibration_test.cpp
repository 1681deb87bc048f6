// The calibration of a camera in the window: a board is shown, views come with their errors, a file is written.
#include <QAbstractItemView>
#include <QAction>
#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QRegularExpression>
#include <QTabWidget>
#include <array>
#include <cmath>

#include "app/calibration/calibration_file.h"
#include "operator.h"
#include "shown_board.h"
#include "tests/places.h"
#include "ui/calibration/calibration_dialog.h"
#include "ui/calibration/floor_page.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::ui::test {
namespace {

constexpr double tag_height = 0.06, camera_height = 2.4115;  // of resources/cameras/overhead.toml

class Calibration : public Operator {
 protected:
  CalibrationDialog* open_dialog() {
    find<QAction>("calibrate_camera")->trigger();
    auto* dialog = find<CalibrationDialog>("calibration_dialog");
    EXPECT_TRUE(QTest::qWaitForWindowExposed(dialog));
    return dialog;
  }
};

TEST_F(Calibration, ShowsViewsWithTheirErrorsAndWritesTheFile) {
  const QTemporaryDir dir;
  ASSERT_TRUE(board::save_views(QDir(dir.path())));
  start();
  CalibrationDialog* dialog = open_dialog();
  EXPECT_EQ(find<QLineEdit>("calibration_source")->toolTip(),
            QStringLiteral("images:DIR, video:FILE, v4l2:DEVICE, aravis:CAMERA"));
  find<QLineEdit>("calibration_source")->setText(QStringLiteral("images:") + dir.path());
  find<QComboBox>("calibration_board")->setCurrentIndex(1);
  find<NumberField>("calibration_columns")->setValue(board::columns);
  find<NumberField>("calibration_rows")->setValue(board::rows);
  const QString file = dir.filePath(QStringLiteral("camera.toml"));
  find<QLineEdit>("calibration_file")->setText(file);
  auto* save = find<QPushButton>("calibration_save");
  EXPECT_FALSE(save->isEnabled());
  QTest::mouseClick(find<QPushButton>("calibration_look"), Qt::LeftButton);
  auto* views = find<QAbstractItemView>("calibration_views")->model();
  ASSERT_TRUE(eventually([&] { return views->rowCount() == 7; })) << views->rowCount();
  EXPECT_EQ(views->index(0, ViewModel::corners).data().toString(),
            QString::number((board::columns - 1) * (board::rows - 1)));
  ASSERT_TRUE(eventually([&] {
    for (int row = 0; row < 7; ++row)
      if (!views->index(row, ViewModel::error).data().toString().endsWith(QStringLiteral("px"))) return false;
    return save->isEnabled();
  })) << find<QLabel>("calibration_result")->text().toStdString();
  EXPECT_TRUE(running()) << "pictures from a directory take no camera away";
  QTest::mouseClick(save, Qt::LeftButton);
  QFile written(file);
  ASSERT_TRUE(written.open(QIODevice::ReadOnly)) << find<QLabel>("calibration_result")->text().toStdString();
  const QString text = QString::fromUtf8(written.readAll());
  const QRegularExpressionMatch fx = QRegularExpression(QStringLiteral("fx = ([0-9.]+)")).match(text);
  ASSERT_TRUE(fx.hasMatch()) << text.toStdString();
  EXPECT_NEAR(fx.captured(1).toDouble(), board::focal, 0.02 * board::focal);
  // A view that is taken out is solved without.
  find<QAbstractItemView>("calibration_views")->setCurrentIndex(views->index(6, 0));
  QTest::mouseClick(find<QPushButton>("calibration_remove"), Qt::LeftButton);
  EXPECT_TRUE(eventually([&] { return views->rowCount() == 6; }));
  key(Qt::Key_Space, dialog);
  EXPECT_TRUE(eventually([&] { return stopped(); })) << "STOP while it is open";
  delete dialog;
}

TEST_F(Calibration, SaysWhyACameraCannotBeLookedAt) {
  start();
  CalibrationDialog* dialog = open_dialog();
  dialog->findChild<QLineEdit*>(QStringLiteral("calibration_source"))->setText(QStringLiteral("v4l2:/dev/nowhere"));
  QTest::mouseClick(dialog->findChild<QPushButton*>(QStringLiteral("calibration_look")), Qt::LeftButton);
  auto* advice = dialog->findChild<QLabel*>(QStringLiteral("calibration_advice"));
  EXPECT_TRUE(eventually([&] { return advice->text().contains(QStringLiteral("nowhere")); }))
      << advice->text().toStdString();
  EXPECT_TRUE(running());
  delete dialog;
}

TEST_F(Calibration, FindsWhereTheCameraHangsFromTagsOnTheFloor) {
  // The tags of four robots that stand about, in the picture of a synthetic camera, serve as the floor's.
  auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  ASSERT_TRUE(experiment.has_value());
  experiment->camera.calibration = "overhead.toml";
  experiment->directory = skein::test::in_source("resources/cameras");
  window.resize(1280, 800);
  window.show();
  window.activateWindow();
  window.open(*experiment, false);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  find<QAction>("view_picture")->trigger();
  ASSERT_TRUE(eventually([&] { return arena().map().shows_picture() && arena().scene().pose(3).has_value(); }));
  drag(robot(0), floor(-0.5, 0.35));
  drag(robot(1), floor(-0.5, -0.35));
  drag(robot(2), floor(0.4, 0.4));
  ASSERT_TRUE(eventually([&] { return arena().scene().pose(2)->x < 0.5 && arena().scene().pose(0)->x < -0.4; }));
  QTest::qWait(300);  // filter and picture have come to rest
  const QTemporaryDir dir;
  for (const char* name : {"a.png", "b.png"})
    ASSERT_TRUE(arena().scene().picture.save(dir.filePath(QString::fromLatin1(name))));
  const QString file = dir.filePath(QStringLiteral("camera.toml"));
  ASSERT_TRUE(QFile::copy(QString::fromStdString(skein::test::in_source("resources/cameras/overhead.toml")), file));
  QFile::setPermissions(file, QFile::ReadOwner | QFile::WriteOwner);

  CalibrationDialog* dialog = open_dialog();
  find<QLineEdit>("calibration_source")->setText(QStringLiteral("images:") + dir.path());
  find<QLineEdit>("calibration_file")->setText(file);
  find<QTabWidget>("calibration_tabs")->setCurrentIndex(1);
  auto* tags = find<QAbstractItemView>("floor_tags")->model();
  EXPECT_FALSE(tags->setData(tags->index(0, FloorModel::id), QStringLiteral("1.5"), Qt::EditRole));
  EXPECT_TRUE(tags->setData(tags->index(0, FloorModel::x), QStringLiteral("0,25"), Qt::EditRole));
  EXPECT_EQ(tags->index(0, FloorModel::x).data().toString(), QStringLiteral("0.25")) << "with either decimal sign";
  for (int i = 0; i < 4; ++i) {
    const core::Pose pose = *arena().scene().pose(static_cast<std::size_t>(i));
    const std::array<double, 4> row{i + 1.0, pose.x, pose.y, tag_height};
    for (int column = 0; column < 4; ++column)
      ASSERT_TRUE(tags->setData(tags->index(i, column), QString::number(row[static_cast<std::size_t>(column)], 'f', 6),
                                Qt::EditRole));
  }
  QTest::mouseClick(find<QPushButton>("floor_look"), Qt::LeftButton);
  auto* result = find<QLabel>("floor_result");
  ASSERT_TRUE(eventually([&] { return result->text().startsWith(QStringLiteral("Written")); }))
      << result->text().toStdString();
  const QRegularExpressionMatch z = QRegularExpression(QStringLiteral("z ([0-9.]+) m")).match(result->text());
  EXPECT_NEAR(z.captured(1).toDouble(), camera_height, 0.02) << result->text().toStdString();
  EXPECT_TRUE(tags->index(3, FloorModel::off).data().toString().endsWith(QStringLiteral("mm")));
  QFile written(file);
  ASSERT_TRUE(written.open(QIODevice::ReadOnly));
  EXPECT_TRUE(written.readAll().contains("[world]"));
  delete dialog;
}

/// The table had a dash for it, and no reason.
TEST(CalibrationFloor, SaysWhyATagIsNotSeen) {
  const vision::Calibration camera = vision::overhead_calibration(2.0, 1.5);
  vision::Calibration lens = camera;
  lens.world_from_camera.reset();
  const QTemporaryDir dir;
  const QString file = dir.filePath(QStringLiteral("camera.toml"));
  ASSERT_TRUE(app::save_calibration(lens, file.toStdString()));
  app::KnownFloor floor{{}, 0.04, 0.06};
  std::vector<vision::SyntheticTag> tags;
  for (const auto& [x, y] : {std::pair{-0.9, 0.6}, {0.9, 0.6}, {0.9, -0.6}, {-0.9, -0.6}, {0.1, 0.1}}) {
    const int id = 20 + static_cast<int>(tags.size());
    floor.tags.push_back({.id = id, .x = x, .y = y});
    tags.push_back({.tag = id, .pose = {x, y, 0.3}, .size = 0.06, .lifted = -camera.tag_height, .bare = true});
  }
  FloorPage page;
  page.show_known(floor);
  const auto* result = page.findChild<QLabel*>(QStringLiteral("floor_result"));
  const auto look = [&](const std::vector<vision::SyntheticTag>& there) {
    vision::Frame frame;
    vision::SyntheticCamera(camera).render(there, 0.0, frame);
    const QImage picture(frame.grey.data(), frame.width, frame.height, frame.width, QImage::Format_Grayscale8);
    ASSERT_TRUE(picture.save(dir.filePath(QStringLiteral("a.png"))));
    page.use_camera({.source = "images:" + dir.path().toStdString()}, file);
    ASSERT_TRUE(eventually([&] { return !page.looks(); }));
  };
  tags.pop_back();
  look(tags);
  EXPECT_TRUE(result->text().startsWith(QStringLiteral("Written."))) << result->text().toStdString();
  EXPECT_TRUE(
      result->text().contains(QStringLiteral(" mark 24 is not seen: nothing can be read at (0.10, 0.10) m, pixel (")))
      << result->text().toStdString();
  tags.pop_back();
  look(tags);
  EXPECT_TRUE(result->text().contains(QStringLiteral("marks 23, 24 are not seen: no such tag is in the picture")))
      << result->text().toStdString();
}

TEST_F(Calibration, SaysWhatItTakesOfANumberBeyondItsRange) {
  open_and_wait();
  CalibrationDialog* dialog = open_dialog();
  ASSERT_TRUE(bring_to_front(*dialog));
  const auto type = [&](const char* name, const char* text) {
    auto* field = find<NumberField>(name);
    find<QLabel>("calibration_advice")->clear();
    field->setFocus();
    EXPECT_TRUE(eventually([&] { return field->hasFocus(); })) << name;
    field->selectAll();
    QTest::keyClicks(field, QString::fromLatin1(text));
    QTest::keyClick(field, Qt::Key_Return);
    return field->value();
  };
  const auto told = [&] { return find<QLabel>("calibration_advice")->text().toStdString(); };
  EXPECT_EQ(type("calibration_columns", "200"), 100.0) << "not 20";
  EXPECT_EQ(told(), "Columns of squares: found 200, allowed: 3 to 100; 100 is taken");
  EXPECT_EQ(type("calibration_rows", "7.5"), app::CalibrationBoard{}.rows);
  EXPECT_EQ(told(), "Rows of squares: found 7.5, allowed: a whole number from 3 to 100");
  EXPECT_EQ(type("calibration_square", "0.5"), 1.0);
  EXPECT_EQ(told(), "Edge of a square in millimetres: found 0.5, allowed: 1.00 to 500.00; 1.00 mm is taken");
  delete dialog;
}

TEST(CalibrationFloor, ShowsAnyHeightOfTagsThatAFileMayHave) {
  FloorPage page;
  app::KnownFloor floor;
  for (const double height : {0.0, -0.02, 1.5}) {
    floor.tag_size = 0.04;
    floor.tag_height = height;
    page.show_known(floor);
    EXPECT_EQ(page.findChild<NumberField*>(QStringLiteral("floor_tag_height"))->value(), 1000 * height);
  }
}

}  // namespace
}  // namespace skein::ui::test
