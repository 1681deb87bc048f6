# The runs of a study that went worst, from above: where the robots should have gone (grey), where they really went, x where they began and
# o where they ended, an arrow where a hand put one elsewhere, obstacles, the arena's edge.
set encoding utf8
set minussign
array colour[8] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000, 0xF0E442]
of(i) = colour[(i - 1) % 8 + 1]
jump = 0.03
x = NaN; y = NaN
# A block a robot: x_nom, y_nom, x, y.
look(row) = (ox = (row == 0 ? NaN : x), oy = (row == 0 ? NaN : y), x = column(3), y = column(4), \
             moved = (sqrt((x - ox)**2 + (y - oy)**2) > jump))

# Two columns of a journal, 178 mm, three plans a row; in cm:
width = 17.8
across = (plans < 3 ? plans : 3)
down = (plans + across - 1) / across
gap = 0.35; heading = 0.75
plan_width = (width - gap * (across + 1)) / across
plan_height = plan_width * arena_height / arena_width
height = down * (plan_height + heading) + gap
unset key; unset tics; unset xlabel; unset ylabel
set border 15 linewidth 0.75 linecolor rgb 0x404040
set xrange [-0.5 * arena_width : 0.5 * arena_width]
set yrange [-0.5 * arena_height : 0.5 * arena_height]

do for [kind in "pdf svg png"] {
  if (kind eq "pdf") { set terminal pdfcairo color enhanced size width cm, height cm font "sans,8" fontscale 0.75 linewidth 1 }
  if (kind eq "svg") { set terminal svg enhanced size width * 37.8, height * 37.8 font "sans,9.6" linewidth 1 background "white" }
  if (kind eq "png") { set terminal pngcairo color enhanced size width * 118.1, height * 118.1 font "sans,8" fontscale 3.1 linewidth 3 pointscale 3 }
  set output "worst." . kind
  set multiplot
  do for [p=1:plans] {
    c = (p - 1) % across; r = (p - 1) / across
    left = gap + c * (plan_width + gap); top = height - r * (plan_height + heading) - heading
    set lmargin at screen left / width; set rmargin at screen (left + plan_width) / width
    set tmargin at screen top / height; set bmargin at screen (top - plan_height) / height
    set label 1 title_of[p] at screen left / width, screen (top + 0.28) / height left noenhanced
    unset object
    do for [o=1:words(obstacles_of[p]) / 3] {
      set object o circle at word(obstacles_of[p], 3 * o - 2) + 0, word(obstacles_of[p], 3 * o - 1) + 0 \
        size word(obstacles_of[p], 3 * o) + 0 back fillstyle solid 1 noborder fillcolor rgb 0xC8C8C8
    }
    data = file_of[p]; n = robots_of[p]; last = last_of[p]
    plot for [i=1:n] data index i - 1 using 1:2 with lines linecolor rgb 0xB0B0B0 linewidth 1, \
         for [i=1:n] data index i - 1 using (look($0), moved ? NaN : x):(y) with lines linecolor rgb of(i) linewidth 1.25, \
         for [i=1:n] data index i - 1 using (look($0), moved ? ox : NaN):(oy):(x - ox):(y - oy) with vectors \
           head filled size screen 0.008,20 linecolor rgb of(i) linewidth 0.75, \
         for [i=1:n] data index i - 1 every ::0::0 using 3:4 with points pointtype 2 pointsize 0.5 linewidth 1 linecolor rgb of(i), \
         for [i=1:n] data index i - 1 every ::last::last using 3:4 with points pointtype 6 pointsize 0.6 linewidth 1 linecolor rgb of(i)
  }
  unset multiplot
  unset output
}
