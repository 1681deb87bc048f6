// Six robots that drive on circles, for rendered_robots_test.cpp. POV-Ray 3.7 draws them, a program that knows nothing of
// Skein. From this folder, for 1.png; 0, 2 and 3 are of the times 0, 0.08 and 0.12:
//
//   povray +Irendered_robots.pov +O/tmp/1.png +W640 +H480 +A0.0 +AM1 +R5 -J -D +FN16 File_Gamma=1.0 Grayscale_Output=on \
//     Declare=T=0.04
//   convert /tmp/1.png -set colorspace Gray -gaussian-blur 0x0.6 -depth 8 -strip rendered/1.png
//
// Other films: Declare=Glare=1 (two lamps that paper reflects), Declare=Shadow=1 (soft shadows that move). Lenses out of
// focus (Declare=Aperture=0.0045): in this mode POV-Ray draws everything a thirtieth of a pixel to the right and down,
// with an aperture of nothing, too.
//
// T: the time [s]. World frame: x right, y up, z towards the camera, metres. The modules of the tags are those of the
// sheets that `skein tags` writes (# is ink; with the white border).
#version 3.7;
#ifndef (T) #declare T = 0; #end
#ifndef (Shadow) #declare Shadow = 0; #end
#ifndef (Glare) #declare Glare = 0; #end
#ifndef (Aperture) #declare Aperture = 0; #end
global_settings { assumed_gamma 1.0 max_trace_level 3 ambient_light 0 }

#declare Tag20 = array[10] {"..........", ".########.", ".#.######.", ".##...#.#.", ".#.#.##.#.", ".###.##.#.", ".##.##.##.", ".#.#....#.", ".########.", ".........."}
#declare Tag21 = array[10] {"..........", ".########.", ".#.####.#.", ".##..####.", ".###..###.", ".#...##.#.", ".#.#.##.#.", ".#..#.###.", ".########.", ".........."}
#declare Tag1 = array[10] {"..........", ".########.", ".#..#..##.", ".##.#...#.", ".#....###.", ".##..####.", ".#.#..#.#.", ".###.##.#.", ".########.", ".........."}
#declare Tag2 = array[10] {"..........", ".########.", ".#..#...#.", ".##.##.##.", ".#.######.", ".###.##.#.", ".####.###.", ".###...##.", ".########.", ".........."}
#declare Tag3 = array[10] {"..........", ".########.", ".#...##.#.", ".####...#.", ".#.##...#.", ".#.#.##.#.", ".#..##.##.", ".##..####.", ".########.", ".........."}
#declare Tag4 = array[10] {"..........", ".########.", ".#...#.##.", ".#....###.", ".#.#....#.", ".###.#.##.", ".#.######.", ".#.###.##.", ".########.", ".........."}

// The camera hangs over (0.02, -0.03, 1.2), tilted by 3 degrees about x and 1 degree about y.
camera {
  perspective location <0, 0, 0> right <1, 0, 0> up <0, 480 / 640, 0> direction <0, 0, -690 / 640>
  #if (Aperture > 0) aperture Aperture focal_point <0, 0, -0.70> blur_samples 19 variance 0 confidence 0.99999 #end
  rotate <3, 1, 0> translate <0.02, -0.03, 1.2>
}

#if (Shadow)
  light_source { <-1.6, 1.2, 2.6> rgb 1.0 area_light <0.35, 0, 0>, <0, 0.35, 0>, 5, 5 adaptive 1 circular orient }
  // Two beams hang between lamp and robots, and move.
  box { <-0.03, -1.5, 0>, <0.03, 1.5, 0.01> rotate z * 25 translate <-0.50 + 0.35 * T, 0.2, 0.5> pigment { rgb 0.3 } no_image }
  box { <-1.5, -0.015, 0>, <1.5, 0.015, 0.01> rotate z * 10 translate <0, 0.55 - 0.3 * T, 0.35> pigment { rgb 0.3 } no_image }
#else
  light_source { <-4, 3, 5> rgb 1.0 parallel point_at 0 }
#end
light_source { <3, -2, 9> rgb 0.18 shadowless }
light_source { <0, 0, 30> rgb 0.09 shadowless }
#if (Glare)
  // Its reflection wanders over the tags.
  light_source { <0.3, 0.1, 2.4> rgb 0.35 shadowless }
  light_source { <-0.5, -0.3, 2.4> rgb 0.35 shadowless }
#end

// Of the floor, only what is around the robots: the rest takes long, and large pictures.
background { rgb 0.2 }
#declare Floor = texture { pigment { granite turbulence 0.3 color_map { [0 rgb 0.30] [1 rgb 0.42] } scale 0.4 }
            finish { diffuse 0.8 ambient 0 } }
  texture { pigment { brick rgb 0.08, rgbt 1 brick_size <0.5, 0.2, 1> mortar 0.002 translate <0.13, 0.05, -0.5> }
            finish { diffuse 0.6 ambient 0 } }

#if (Glare)
  #declare Paper = finish { diffuse 0.85 ambient 0 specular 0.6 roughness 0.004 }
#else
  #declare Paper = finish { diffuse 0.85 ambient 0 }
#end

#macro Sheet(Rows, Module)
  union {
    box { <-5, -5, -0.05>, <5, 5, 0> pigment { rgb 0.8 } finish { Paper } }
    #for (R, 0, 9)
      #for (C, 0, 9)
        #if (strcmp(substr(Rows[R], C + 1, 1), "#") = 0)
          box { <C - 5, 4 - R, -0.01>, <C - 4, 5 - R, 0.0001> pigment { rgb 0.04 } finish { Paper } }
        #end
      #end
    #end
    scale Module
  }
#end

// Centre and radius of the circle [m], angle at the start and speed [degrees].
#macro Robot(Rows, X, Y, Radius, From, Speed)
  #local A = radians(From + Speed * T);
  #local Turn = From + Speed * T + (Speed > 0 ? 90 : -90);
  #local At = <X + Radius * cos(A), Y + Radius * sin(A), 0>;
  union {
    cylinder { <0, 0, 0.003>, <0, 0, 0.0598>, 0.035 pigment { rgb <0.34, 0.42, 0.30> } finish { diffuse 0.6 ambient 0 } }
    object { Sheet(Rows, 0.005) translate 0.06 * z }
    rotate z * Turn translate At
  }
  disc { At, z, 0.062 texture { Floor } }
#end
Robot(Tag1, -0.34, 0.20, 0.09, 20, 80)
Robot(Tag2, 0.02, 0.21, 0.10, 100, -70)
Robot(Tag3, 0.37, 0.18, 0.11, 200, 65)
Robot(Tag4, -0.33, -0.23, 0.10, -60, -75)
Robot(Tag20, 0.00, -0.22, 0.08, 10, 90)
Robot(Tag21, 0.36, -0.24, 0.09, 140, -85)
