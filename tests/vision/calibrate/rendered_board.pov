// A ChArUco board that somebody holds before a camera, for rendered_board_test.cpp. POV-Ray 3.7 draws it, a program that
// knows nothing of Skein; the sheet is that of the user, printed by librsvg. From this folder:
//
//   skein tags board --out /tmp/board.svg
//   rsvg-convert --width 5940 --height 4200 --background-color white /tmp/board.svg -o /tmp/board.png
//   povray +Irendered_board.pov +L/tmp +O/tmp/view.png +W640 +H480 +A0.03 +AM1 +R5 -J -D
//   convert /tmp/view.png -colorspace Gray -gaussian-blur 0x0.5 -quality 90 rendered_board.jpg
#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 3 }

// A focal length of 575 px. The camera looks along -z, x is to its right and y up; metres.
camera { perspective location <0, 0, 0> right <1, 0, 0> up <0, 480 / 640, 0> direction <0, 0, -575 / 640> }
light_source { <-4, 3, 1> rgb 0.6 }
light_source { <0, 0, 30> rgb 0.3 shadowless }
background { rgb 0.15 }

// A4, 297 x 210 mm, around the origin; then turned and held where it is seen.
box { <0, 0, -0.002>, <1, 1, 0>
  pigment { image_map { png "board.png" gamma srgb once interpolate 2 } } finish { diffuse 0.9 ambient 0 }
  translate <-0.5, -0.5, 0> scale <0.297, 0.21, 1>
  rotate z * 12 rotate x * 20 rotate y * -25 translate <0.01, -0.005, -0.36> }
