// A floor with marks and robots as a user would photograph it, for rendered_floor_test.cpp. POV-Ray 3.7 draws it, a
// program that knows nothing of Skein. From this folder:
//
//   povray +Irendered_floor.pov +O/tmp/floor.png +W640 +H480 +A0.03 +AM1 +R5 -J -D
//   convert /tmp/floor.png -colorspace Gray -gaussian-blur 0x0.5 -quality 85 rendered/floor.jpg
#include "lab.inc"

#macro Mark(Rows, X, Y, Turn)
  object { Sheet(Rows, 0.005, Matt) rotate z * Turn translate <X, Y, 0.0002> }
#end

// Marks that can be read.
Mark(Tag20, -0.45, 0.33, 12)
Mark(Tag21, 0.47, 0.31, 90)
Mark(Tag22, -0.46, -0.33, -80)
Mark(Tag23, 0.45, -0.34, -150)
Mark(Tag30, 0.02, -0.33, 5)

// 24: a lamp is reflected by half of it, which is printed on glossy paper.
object { Sheet(Tag24, 0.005, Glossy) rotate z * -25 translate <0.0, 0.30, 0.0002> }
box { <-0.075, -0.075, 0>, <0.075, 0.075, 0.02> translate <0.035, 0.96, 2>
      pigment { rgb 1 } finish { emission 25 diffuse 0 } no_shadow }

// 25: robot 2 stands on a part of it.
Mark(Tag25, 0.27, 0.05, 60)
Robot(Tag2, 0.305, 0.055, 100, 0.005)

// 26: mirrored.
object { Sheet(Tag26, 0.005, Matt) scale <-1, 1, 1> rotate z * 45 translate <-0.40, 0.0, 0.0002> }

// 27: the edge of a shadow lies across it. The camera does not see what makes the shadow.
Mark(Tag27, -0.18, -0.24, -25)
box { <-0.04, -0.1, 0>, <0.04, 0.1, 0.005> rotate z * 20 translate <-0.145 - 4 * 0.3 / 5, -0.24 + 3 * 0.3 / 5, 0.3>
      pigment { rgb 0.5 } no_image }

// 28: of the family 25h9. 29 lies outside of the picture, 31 is not there.
Mark(Tag28of25h9, 0.22, -0.17, 30)

// Robot 1 is in order. Robot 3 has a tag without a white border, that of robot 4 was printed at 75 %.
Robot(Tag1, -0.20, 0.14, 20, 0.005)
Body(0.02, -0.02)
intersection {
  object { Sheet(Tag3, 0.005, Matt) }
  box { <-0.02, -0.02, -1>, <0.02, 0.02, 1> }
  rotate z * 70 translate <0.02, -0.02, 0.06>
}
Robot(Tag4, 0.47, -0.10, -60, 0.00375)
