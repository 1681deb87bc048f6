// The page of the cameras: what the chosen one shows, every tag and why it is not taken, and its settings.
#include <QAbstractItemView>
#include <QAccessible>
#include <QAction>
#include <QCheckBox>
#include <QComboBox>
#include <QImage>
#include <QLabel>
#include <QLineEdit>

#include "app/calibration/calibration_file.h"
#include "app/tools/aside.h"
#include "operator.h"
#include "tests/places.h"
#include "tests/vision/aravis/fake_gige.h"
#include "ui/camera/camera_page.h"
#include "ui/camera/camera_picture.h"
#include "ui/editor/experiment_editor.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::ui::test {
namespace {

class CameraPageTest : public Operator {
 protected:
  CameraPage* open_page() {
    find<QAction>("camera")->trigger();
    auto* page = find<CameraPage>("camera_page");
    EXPECT_TRUE(bring_to_front(*page));
    return page;
  }
  void look_at(const QString& source, const QString& calibration = {}) {
    find<QComboBox>("camera_source")->setEditText(source);
    find<QLineEdit>("camera_calibration")->setText(calibration);
    QTest::mouseClick(find<QPushButton>("camera_look"), Qt::LeftButton);
  }
  QString status() { return find<QLabel>("camera_status")->text(); }
  /// In the picture's place, while there is no picture.
  QString in_its_place() {
    return QAccessible::queryAccessibleInterface(find("camera_picture"))->text(QAccessible::Description);
  }
  /// Of the first row of this tag; empty: there is none.
  QString verdict(int tag, int column = CameraTagModel::verdict) {
    const auto* tags = find<QAbstractItemView>("camera_tags")->model();
    for (int row = 0; row < tags->rowCount(); ++row)
      if (tags->index(row, CameraTagModel::tag).data().toInt() == tag)
        return tags->index(row, column).data().toString();
    return {};
  }
  /// Once the page is closed. A fake camera may go only then: what still asks for it would take the next one that comes
  /// by its name and address, that of another test.
  static bool let_go_of_the_camera() { return app::aside_is_over(60.0); }
  static QString overhead() {
    return QString::fromStdString(skein::test::in_source("resources/cameras/overhead.toml"));
  }
};

TEST_F(CameraPageTest, ShowsTheRunsOwnPictureWithEveryTagInIt) {
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  ASSERT_TRUE(experiment.has_value());
  start(*experiment);
  open_page();
  for (int tag = 1; tag <= 4; ++tag)
    ASSERT_TRUE(eventually([&] { return verdict(tag) == QStringLiteral("robot %1").arg(tag); }))
        << tag << ": " << verdict(tag).toStdString() << "; " << status().toStdString();
  const QStringList size = verdict(2, CameraTagModel::size).split(QStringLiteral(", "));
  ASSERT_EQ(size.size(), 2) << verdict(2, CameraTagModel::size).toStdString();
  EXPECT_GT(size[0].section(QLatin1Char(' '), 0, 0).toDouble(), 10.0);
  const double millimetres = size[1].section(QLatin1Char(' '), 0, 0).toDouble();
  EXPECT_TRUE(status().contains(QStringLiteral("Tags should have %1 mm").arg(millimetres, 0, 'f', 0)))
      << status().toStdString() << size[1].toStdString();
  EXPECT_TRUE(eventually([&] { return status().contains(QStringLiteral("frames/s")); })) << status().toStdString();
  EXPECT_FALSE(find<NumberField>("camera_exposure")->isEnabled()) << "a camera that is rendered has none";
  for (const char* setting : {"camera_exposure", "camera_gain", "camera_focus"})
    EXPECT_EQ(find<NumberField>(setting)->text().toStdString(), "–") << setting << " is not known to be that";
  EXPECT_TRUE(find<QLabel>("camera_settings_note")->text().contains(QStringLiteral("cannot be changed")));
  EXPECT_FALSE(find<QLineEdit>("camera_calibration")->placeholderText().contains(QStringLiteral("px only")))
      << "sizes are in mm, by the run's calibration";
  EXPECT_TRUE(running()) << "the run goes on";
  key(Qt::Key_Space, find<CameraPage>("camera_page"));
  EXPECT_TRUE(eventually([&] { return stopped(); })) << "STOP while it is open";
}

/// It looked like any other picture, and the frames that reached the window went on as well.
TEST_F(CameraPageTest, SaysThatThePictureOfAFrozenCameraIsOld) {
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"),
                                               {"camera.freeze_at=0.5"});
  ASSERT_TRUE(experiment.has_value());
  start(*experiment);
  open_page();
  EXPECT_TRUE(eventually([&] { return in_its_place().contains(QStringLiteral("No new picture has come for 2 s")); }))
      << in_its_place().toStdString();
}

/// All of them have the source "synthetic": it was taken for that of the second, whose pictures the run does not show.
TEST_F(CameraPageTest, ShowsTheFirstOfTwoSyntheticCameras) {
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/two-cameras.toml"));
  ASSERT_TRUE(experiment.has_value());
  start(*experiment);
  open_page();
  EXPECT_TRUE(eventually([&] { return status().contains(QStringLiteral("frames/s")); }))
      << in_its_place().toStdString();
}

TEST_F(CameraPageTest, ThatIsIdleSaysSoOnce) {
  open_and_wait();
  const CameraPage* page = open_page();
  const auto shown = [&] {
    QStringList texts{in_its_place()};
    for (const QLabel* label : page->findChildren<QLabel*>())
      if (label->isVisible() && !label->text().isEmpty()) texts << label->text();
    return texts;
  };
  const QString idle = QStringLiteral("Choose a camera and press Look");
  EXPECT_EQ(shown().count(idle), 1) << shown().join(QLatin1Char('|')).toStdString();
}

/// The tag of robot `k`, its middle at (u, v). [pixels]
app::WatchedTag tag_at(int k, double u, double v, double edge_px) {
  app::WatchedTag tag{};
  tag.tag = k + 1;
  tag.robot = k;
  tag.seen = true;
  tag.state = app::WatchedTag::State::taken;
  tag.edge_px = edge_px;
  const double half = edge_px / 2.0;
  tag.corners = {{{u - half, v - half}, {u + half, v - half}, {u + half, v + half}, {u - half, v + half}}};
  return tag;
}

TEST(CameraPicture, HidesNoTagBehindTheTextOfAnother) {
  app::CameraView view;
  view.picture = {400, 300, std::vector<std::uint8_t>(400 * 300, 128)};
  for (int k = 0; k < 4; ++k) {  // one below the other, as robots of a platoon
    view.tags.push_back(tag_at(k, 200.0, 100.0 + 20.0 * k, 12.0));
  }
  CameraPicture picture;
  picture.resize(400, 300);
  picture.show_view(view);
  const QImage shown = picture.grab().toImage();
  for (int k = 0; k < 4; ++k)
    EXPECT_EQ(shown.pixelColor(200, 100 + 20 * k), QColor(128, 128, 128)) << "a text lies over tag " << k + 1;
}

TEST(CameraPicture, WritesNoTextOverAnother) {
  constexpr int robots = 20, pitch = 40;
  app::CameraView view;
  view.picture = {640, 480, std::vector<std::uint8_t>(640 * 480, 128)};
  for (int k = 0; k < robots; ++k) {  // a crowd, in five columns
    view.tags.push_back(tag_at(k, 240.0 + pitch * (k % 5), 160.0 + pitch * (k / 5), 16.0));
    view.tags.back().edge = 0.0441;
  }
  CameraPicture picture;
  picture.resize(640, 480);
  picture.show_view(view);
  picture.grab();
  const auto& texts = picture.texts();
  for (const auto& one : texts)
    for (const auto& other : texts)
      EXPECT_TRUE(one.tag == other.tag || !one.place.intersects(other.place)) << one.tag << " and " << other.tag;
  EXPECT_EQ(texts.size(), robots) << "each has at least its number";
}

TEST_F(CameraPageTest, SaysOfEachTagWhyItIsNotTaken) {
  auto calibration = app::load_calibration(overhead().toStdString());
  ASSERT_TRUE(calibration.has_value());
  // The middle of the picture: the search for the tags that are not there takes a quarter of the time.
  calibration->cx -= calibration->width / 4.0;
  calibration->cy -= calibration->height / 4.0;
  calibration->width /= 2;
  calibration->height /= 2;
  const QTemporaryDir files;
  const QString middle = files.filePath(QStringLiteral("middle.toml"));
  ASSERT_TRUE(app::save_calibration(*calibration, middle.toStdString()));
  const double size = calibration->tag_size;
  vision::SyntheticCamera camera(*calibration);
  vision::Frame frame;
  const std::array tags{vision::SyntheticTag{1, {0.15, 0.1, 0.5}, size},
                        vision::SyntheticTag{2, {-0.2, 0.15, 1.0}, 0.8 * size},
                        vision::SyntheticTag{9, {0.0, -0.15, 0.0}, size}};
  camera.render(tags, 0.0, frame);
  const QImage picture(frame.grey.data(), frame.width, frame.height, frame.width, QImage::Format_Grayscale8);
  const QTemporaryDir dir;
  ASSERT_TRUE(picture.save(dir.filePath(QStringLiteral("a.png"))));
  start();
  open_page();
  look_at(QStringLiteral("images:") + dir.path(), middle);
  ASSERT_TRUE(eventually([&] { return verdict(1) == QStringLiteral("robot 1"); }))
      << status().toStdString() << verdict(1).toStdString();
  EXPECT_TRUE(eventually([&] { return verdict(2).contains(QStringLiteral("smaller")); })) << verdict(2).toStdString();
  EXPECT_NEAR(
      verdict(2, CameraTagModel::size).section(QStringLiteral(", "), 1).section(QLatin1Char(' '), 0, 0).toDouble(),
      800 * size, 10 * size * 1e3 / 100)
      << verdict(2, CameraTagModel::size).toStdString();
  EXPECT_EQ(verdict(3), QStringLiteral("no tag 3 is in the picture"));
  EXPECT_EQ(verdict(3, CameraTagModel::size), QStringLiteral("–"));
  EXPECT_TRUE(verdict(9).contains(QStringLiteral("no robot"))) << verdict(9).toStdString();
  EXPECT_TRUE(eventually([&] { return status().contains(QStringLiteral("no more pictures")); }))
      << status().toStdString();
  // Without a calibration nothing is judged, and sizes are in pixels only.
  look_at(QStringLiteral("images:") + dir.path());
  ASSERT_TRUE(eventually([&] { return verdict(1).contains(QStringLiteral("no calibration")); }))
      << verdict(1).toStdString();
  EXPECT_FALSE(verdict(1, CameraTagModel::size).contains(QStringLiteral("mm")));
  EXPECT_TRUE(running());
}

TEST_F(CameraPageTest, SaysWhyACameraCannotBeLookedThrough) {
  start();
  open_page();
  for (const auto& [source, why] :
       {std::pair("v4l2:/dev/nowhere", "/dev/nowhere"), std::pair("webcam", "allowed"),
        std::pair("images:/nowhere", "/nowhere"), std::pair("synthetic", "robots of a run")}) {
    look_at(QLatin1String(source));
    EXPECT_TRUE(eventually([&] { return in_its_place().contains(QLatin1String(why)); }))
        << source << ": " << in_its_place().toStdString();
    EXPECT_EQ(status().toStdString(), "") << "twice, one below the other";
    EXPECT_TRUE(eventually([&] { return find<QPushButton>("camera_look")->text() == QStringLiteral("Look"); }))
        << source;
  }
  EXPECT_TRUE(running());
}

/// Every other row of such a film was taken later, and only the commands said so.
TEST_F(CameraPageTest, SaysHowAFilmIsReadThatPlayersShowOtherwise) {
  start(*app::load_experiment(skein::test::in_source("resources/experiments/platoon.toml")));
  const QTemporaryDir dir;
  const QString film = dir.filePath(QStringLiteral("film.y4m"));
  QFile file(film);
  ASSERT_TRUE(file.open(QFile::WriteOnly));
  file.write("YUV4MPEG2 W64 H48 F25:1 It C420jpeg\nFRAME\n" + QByteArray(64 * 48 * 3 / 2, '\x80'));
  file.close();
  open_page();
  look_at(QStringLiteral("video:") + film);
  EXPECT_TRUE(eventually([&] {
    return find<QLabel>("camera_settings_note")->text().contains(QStringLiteral("its frames are interlaced"));
  })) << find<QLabel>("camera_settings_note")->text().toStdString()
      << status().toStdString();
}

TEST_F(CameraPageTest, IsClosedWhileItsCameraHangs) {
  skein::test::FakeGige fake;
  ASSERT_TRUE(fake.running());
  start();
  CameraPage* page = open_page();
  look_at(QStringLiteral("aravis:Aravis-Fake-") + QLatin1String(skein::test::fake_gige_serial));
  ASSERT_TRUE(eventually([&] { return status().contains(QStringLiteral("frames/s come")); })) << status().toStdString();
  fake.hang();
  delete page;
  const double t = record().t;
  EXPECT_TRUE(eventually([&] { return record().t > t + 0.2; })) << "the window hangs";
  key(Qt::Key_Space);
  EXPECT_TRUE(eventually([&] { return stopped(); }));
  fake.go_on();
  EXPECT_TRUE(let_go_of_the_camera());
}

TEST_F(CameraPageTest, SetsACameraAndPutsItIntoTheExperiment) {
  const skein::test::FakeGige fake({"--tags"});
  ASSERT_TRUE(fake.running());
  start();
  CameraPage* page = open_page();
  auto* cameras = find<QComboBox>("camera_source");
  ASSERT_TRUE(eventually([&] { return find<QPushButton>("camera_search")->isEnabled(); }));
  int listed = -1;
  for (int k = 0; k < cameras->count(); ++k)
    if (cameras->itemText(k).contains(QLatin1String(skein::test::fake_gige_serial))) listed = k;
  ASSERT_GE(listed, 0) << "it is not in the list";
  cameras->setCurrentIndex(listed);
  const QTemporaryDir dir;
  const QString file = dir.filePath(QStringLiteral("cal.toml"));
  ASSERT_TRUE(app::save_calibration(vision::overhead_calibration(2.0, 1.5), file.toStdString()));
  find<QLineEdit>("camera_calibration")->setText(file);
  QTest::mouseClick(find<QPushButton>("camera_look"), Qt::LeftButton);
  auto* exposure = find<NumberField>("camera_exposure");
  ASSERT_TRUE(eventually([&] { return exposure->isEnabled(); })) << status().toStdString();
  ASSERT_TRUE(eventually([&] { return verdict(4) == QStringLiteral("robot 4"); }))
      << status().toStdString() << verdict(4).toStdString();
  EXPECT_TRUE(eventually([&] { return status().contains(QStringLiteral("frames/s come")); })) << status().toStdString();
  exposure->setFocus();
  exposure->selectAll();
  QTest::keyClicks(exposure, QStringLiteral("0.004"));
  QTest::keyClick(exposure, Qt::Key_Return);
  const auto note = [&] { return find<QLabel>("camera_settings_note")->text(); };
  // Beyond its range: the sentence says what is allowed, and the field has again what the camera answers.
  exposure->selectAll();
  QTest::keyClicks(exposure, QStringLiteral("5000"));
  QTest::keyClick(exposure, Qt::Key_Return);
  EXPECT_TRUE(eventually([&] { return note().contains(QStringLiteral("allowed")); })) << note().toStdString();
  EXPECT_TRUE(eventually([&] { return std::abs(exposure->value() - 0.004) < 1e-6; })) << exposure->value();

  QTest::mouseClick(find<QPushButton>("camera_put"), Qt::LeftButton);
  auto* editor = find<ExperimentEditor>("experiment_editor");
  EXPECT_TRUE(editor->has_changes());
  EXPECT_TRUE(editor->text().contains(QStringLiteral("source = \"aravis:"))) << editor->text().toStdString();
  EXPECT_TRUE(editor->text().contains(QStringLiteral("exposure = 0.004"))) << editor->text().toStdString();
  delete editor;
  delete page;
  EXPECT_TRUE(let_go_of_the_camera());
}

}  // namespace
}  // namespace skein::ui::test
