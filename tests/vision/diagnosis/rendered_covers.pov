// Robots whose tags are half covered, for rendered_floor_test.cpp, by the camera of rendered_floor.pov. With Covers=0
// nothing covers them; with 1, a half of each is free, from one edge to the middle; with 2, none is. From this folder, for
// each of the pictures free, covers and askew:
//
//   povray +Irendered_covers.pov +O/tmp/covers.png +W640 +H480 +A0.03 +AM1 +R5 -J -D Declare=Covers=1
//   convert /tmp/covers.png -colorspace Gray -gaussian-blur 0x0.5 -quality 85 rendered_covers.jpg
#include "lab.inc"

#ifndef (Covers) #declare Covers = 1; #end

Robot(Tag1, -0.32, 0.22, 20, 0.005)
Robot(Tag2, 0.02, 0.20, 100, 0.005)
Robot(Tag3, -0.30, -0.10, -70, 0.005)
Robot(Tag22, 0.04, -0.06, 40, 0.005)
Robot(Tag20, 0.36, -0.20, 10, 0.005)

// 21 is printed on glossy paper.
Body(0.34, 0.18)
object { Sheet(Tag21, 0.005, Glossy) rotate z * -25 translate <0.34, 0.18, 0.06> }

#declare Hand = union {
  box { <0, -0.045, 0>, <0.09, 0.045, 0.025> }
  cylinder { <0.01, -0.034, 0.012>, <-0.045, -0.038, 0.008>, 0.009 }
  cylinder { <0.01, -0.011, 0.012>, <-0.060, -0.012, 0.008>, 0.009 }
  cylinder { <0.01, 0.012, 0.012>, <-0.055, 0.013, 0.008>, 0.009 }
  cylinder { <0.01, 0.034, 0.012>, <-0.040, 0.040, 0.008>, 0.009 }
  pigment { rgb <0.75, 0.55, 0.45> } finish { diffuse 0.7 ambient 0 }
}

#if (Covers = 1)
  // 1: a black cable lies along one side of it.
  cylinder { <-0.4275, 0.1937, 0.066>, <-0.2207, 0.2689, 0.066>, 0.004 pigment { rgb 0.03 } finish { diffuse 0.8 ambient 0 } }
  // 2: a hand is over a half of it.
  object { Hand rotate z * 10 translate <0.082, 0.211, 0.08> }
  // 3: a sheet of paper lies on a half of it.
  box { <-0.07, 0, 0>, <0.07, 0.10, 0.0005> rotate z * 15 translate <-0.30, -0.10, 0.0605> pigment { rgb 0.8 }
        finish { Matt } }
  // 22: the same on all of it.
  box { <-0.07, -0.05, 0>, <0.07, 0.05, 0.0005> rotate z * -30 translate <0.04, -0.06, 0.0605> pigment { rgb 0.8 }
        finish { Matt } }
  // 21: a lamp is reflected by half of it.
  box { <-0.052, -0.104, 0>, <0.052, 0.104, 0.02> rotate z * -25
        translate <0.3228 + 0.3028 * 2.064, 0.188 + 0.218 * 2.064, 2>
        pigment { rgb 1 } finish { emission 25 diffuse 0 } no_shadow }
#end

#if (Covers = 2)
  // The same of 1, 2 and 21, but askew through the middle.
  cylinder { <-0.42, 0.25, 0.066>, <-0.20, 0.20, 0.066>, 0.005 pigment { rgb 0.03 } finish { diffuse 0.8 ambient 0 } }
  object { Hand rotate z * 25 translate <0.066, 0.216, 0.08> }
  box { <-0.052, -0.104, 0>, <0.052, 0.104, 0.02> translate <0.323 + 0.303 * 2.064, 0.18 + 0.21 * 2.064, 2>
        pigment { rgb 1 } finish { emission 25 diffuse 0 } no_shadow }
#end
