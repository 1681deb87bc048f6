// The window over a camera and robots with links, drawn and emulated.
#include <cmath>

#include "operator.h"
#include "tests/places.h"

namespace skein::ui::test {
namespace {

class Camera : public Operator {
 protected:
  void start_loopback() {
    const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
    ASSERT_TRUE(experiment.has_value());
    start(*experiment);
  }
  void show_picture() {
    find<QAction>("view_picture")->trigger();
    ASSERT_TRUE(eventually([&] { return arena().map().shows_picture(); })) << "no picture came";
  }
};

TEST_F(Camera, DrawsOverThePictureAndLetsRobotsBeDraggedInIt) {
  start_loopback();
  show_picture();
  const QImage& picture = arena().scene().picture;
  EXPECT_GT(picture.width(), 600);
  const double sheet_scale = arena().map().sheet().width() / picture.width();
  EXPECT_NEAR(arena().map().sheet().height(), picture.height() * sheet_scale, 1e-6) << "the picture is bent";
  drag(robot(1), floor(0.4, 0.1));
  const core::Pose put = moved(1);
  EXPECT_NEAR(put.x, 0.4, 0.02);  // a pixel of the screen is 4 mm
  EXPECT_NEAR(put.y, 0.1, 0.02);
}

TEST_F(Camera, SaysWhetherRobotsHaveAcknowledgedTheirStop) {
  start_loopback();
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  EXPECT_TRUE(eventually([&] {
    return find<QLabel>("alert")->text().contains(QStringLiteral("All robots have acknowledged"));
  })) << find<QLabel>("alert")->text().toStdString();
}

TEST_F(Camera, GoesAwayWithTheSession) {
  start_loopback();
  show_picture();
  window.new_run();
  arena().grab();  // while there is no session that could place a point in the picture
  ASSERT_TRUE(eventually([&] { return live().is_open() && arena().map().shows_picture(); }));
  window.close();
  arena().grab();
}

}  // namespace
}  // namespace skein::ui::test
