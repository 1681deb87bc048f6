// A floor with marks and robots as a user would photograph it, for rendered_floor_test.cpp. POV-Ray 3.7 draws it, a
// program that knows nothing of Skein. From this folder:
//
//   povray +Irendered_floor.pov +O/tmp/floor.png +W640 +H480 +A0.03 +AM1 +R5 -J -D
//   convert /tmp/floor.png -colorspace Gray -gaussian-blur 0x0.5 -quality 85 rendered/floor.jpg
//
// World frame: x right, y up, z towards the camera, metres. The modules of the tags are those of the sheets that
// `skein tags` writes (# is ink; with the white border), of 25h9 those that AprilTag writes.
#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 3 ambient_light 0 }

#declare Tag20 = array[10] {"..........", ".########.", ".#.######.", ".##...#.#.", ".#.#.##.#.", ".###.##.#.", ".##.##.##.", ".#.#....#.", ".########.", ".........."}
#declare Tag21 = array[10] {"..........", ".########.", ".#.####.#.", ".##..####.", ".###..###.", ".#...##.#.", ".#.#.##.#.", ".#..#.###.", ".########.", ".........."}
#declare Tag22 = array[10] {"..........", ".########.", ".#.###..#.", ".###..#.#.", ".##.#.###.", ".##..#.##.", ".##.#...#.", ".#.....##.", ".########.", ".........."}
#declare Tag23 = array[10] {"..........", ".########.", ".#.##...#.", ".#..##.##.", ".####...#.", ".###..###.", ".###.#..#.", ".##.#...#.", ".########.", ".........."}
#declare Tag24 = array[10] {"..........", ".########.", ".#.#.####.", ".#.#..###.", ".#.#.#.##.", ".#....###.", ".#.###.##.", ".##...###.", ".########.", ".........."}
#declare Tag25 = array[10] {"..........", ".########.", ".#.#.#..#.", ".##...###.", ".##.#..##.", ".###..#.#.", ".#.##...#.", ".#.#.#..#.", ".########.", ".........."}
#declare Tag26 = array[10] {"..........", ".########.", ".#.#..###.", ".##.#..##.", ".#...##.#.", ".#....#.#.", ".#.....##.", ".#..#####.", ".########.", ".........."}
#declare Tag27 = array[10] {"..........", ".########.", ".#.#...##.", ".###..###.", ".######.#.", ".##....##.", ".#.#..###.", ".#...#.##.", ".########.", ".........."}
#declare Tag30 = array[10] {"..........", ".########.", ".#...##.#.", ".###.#.##.", ".#.#...##.", ".#.###..#.", ".######.#.", ".#..#..##.", ".########.", ".........."}
#declare Tag1 = array[10] {"..........", ".########.", ".#..#..##.", ".##.#...#.", ".#....###.", ".##..####.", ".#.#..#.#.", ".###.##.#.", ".########.", ".........."}
#declare Tag2 = array[10] {"..........", ".########.", ".#..#...#.", ".##.##.##.", ".#.######.", ".###.##.#.", ".####.###.", ".###...##.", ".########.", ".........."}
#declare Tag3 = array[10] {"..........", ".########.", ".#...##.#.", ".####...#.", ".#.##...#.", ".#.#.##.#.", ".#..##.##.", ".##..####.", ".########.", ".........."}
#declare Tag4 = array[10] {"..........", ".########.", ".#...#.##.", ".#....###.", ".#.#....#.", ".###.#.##.", ".#.######.", ".#.###.##.", ".########.", ".........."}
#declare Tag28of25h9 = array[9] {".........", ".#######.", ".##..###.", ".#.###.#.", ".#...###.", ".#.#.#.#.", ".###.#.#.", ".#######.", "........."}

// The camera hangs over (0.02, -0.03, 1), tilted by 3 degrees about x and 1 degree about y. A focal length of 575 px.
camera {
  perspective location <0, 0, 0> right <1, 0, 0> up <0, 480 / 640, 0> direction <0, 0, -575 / 640>
  rotate <3, 1, 0> translate <0.02, -0.03, 1>
}

// The sun through a window, and the light of the room.
light_source { <-4, 3, 5> rgb 0.65 parallel point_at 0 }
light_source { <3, -2, 9> rgb 0.12 shadowless }
light_source { <0, 0, 30> rgb 0.06 shadowless }

plane { z, 0
  texture { pigment { granite turbulence 0.3 color_map { [0 rgb 0.30] [1 rgb 0.42] } scale 0.4 }
            finish { diffuse 0.8 ambient 0 } }
  texture { pigment { brick rgb 0.08, rgbt 1 brick_size <0.5, 0.2, 1> mortar 0.002 translate <0.13, 0.05, -0.5> }
            finish { diffuse 0.6 ambient 0 } }
}

#declare Matt = finish { diffuse 0.85 ambient 0 }
#declare Glossy = finish { diffuse 0.85 ambient 0 reflection 0.06 }

// A tag of so many modules from side to side, each of this size, upright around the origin.
#macro Sheet(Rows, Module, Paper)
  union {
    #local N = dimension_size(Rows, 1);
    box { <-N / 2, -N / 2, -0.05>, <N / 2, N / 2, 0> pigment { rgb 0.8 } finish { Paper } }
    #for (R, 0, N - 1)
      #for (C, 0, N - 1)
        #if (strcmp(substr(Rows[R], C + 1, 1), "#") = 0)
          box { <C - N / 2, N / 2 - R - 1, 0>, <C + 1 - N / 2, N / 2 - R, 0.01> pigment { rgb 0.04 } finish { Paper } }
        #end
      #end
    #end
    scale Module
  }
#end
#macro Mark(Rows, X, Y, Turn)
  object { Sheet(Rows, 0.005, Matt) rotate z * Turn translate <X, Y, 0.0002> }
#end
#macro Body(X, Y)
  cylinder { <X, Y, 0.003>, <X, Y, 0.0598>, 0.035 pigment { rgb <0.34, 0.42, 0.30> } finish { diffuse 0.6 ambient 0 } }
#end
#macro Robot(Rows, X, Y, Turn, Module)
  Body(X, Y)
  object { Sheet(Rows, Module, Matt) rotate z * Turn translate <X, Y, 0.06> }
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
