# Figure 4 of the paper: tracking errors of every robot in the world's frame, e_x = x_ref - x and so on, with the reference
# of the formation; and the errors in keeping the formation (37). Grey: a robot was put elsewhere. Dashed: the formation
# had settled again, to 1 cm. Of more than eight robots, the numbers of those whose curves come farthest from zero,
# where they do.
load "figure4.dat"  # $x_i, $y_i, $theta_i, $delta_i of robot i; of a long run the lowest and highest values

set encoding utf8
set minussign

# Okabe and Ito's colours, which colour-blind readers can tell apart; from robot 9 on they come again.
array colour[8] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000, 0xF0E442]
of(i) = colour[(i - 1) % 8 + 1]
of_pair(i) = colour[(i + 3) % 8 + 1]
smaller(a, b) = (a < b ? a : b)
larger(a, b) = (a > b ? a : b)

block(name, i) = sprintf("$%s_%d", name, i)

# The numbers of more than eight robots; curves that stay near zero have none.
number(text, value, range) = (abs(value) > 0.05 * range ? text : "")
numbers(k, scale, range, text) = (n > 8 ? sprintf(', $peaks_%d using 1:(%d * $2):(number(%s, %d * $2, %g))' \
                                                  . ' with labels font ",6" notitle', k, scale, text, scale, range) : "")

# Ranges with three to six round steps; e_x and e_y have the same one. At least +-1 mm and +-0.05 rad: less is noise.
nice(step) = (p = 10**floor(log10(step)), f = step / p, p * (f <= 1 ? 1 : f <= 2 ? 2 : f <= 5 ? 5 : 10))
xy_low = smaller(-1.0, 1000 * e_xy_low); xy_high = larger(1.0, 1000 * e_xy_high)
theta_low = smaller(-0.05, e_theta_low); theta_high = larger(0.05, e_theta_high)
d_low = smaller(-1.0, 1000 * delta_low); d_high = larger(1.0, 1000 * delta_high)
set xrange [t_low : larger(t_high, t_low + 0.001)]

set tics nomirror scale 0.6
set border linewidth 0.75
set grid ytics linecolor rgb 0xDDDDDD linewidth 0.5 dashtype solid
do for [t in perturbed] {
  set arrow from first t + 0, graph 0 to first t + 0, graph 1 nohead back linecolor rgb 0xBBBBBB linewidth 1.5
}
do for [t in settled] {
  set arrow from first t + 0, graph 0 to first t + 0, graph 1 nohead front linecolor rgb 0x404040 linewidth 0.75 dashtype 2
}

# One column of a journal, 88 mm; four panels below one another, each legend above its own. In cm:
width = 8.8
beside = 1.65; beyond = 0.25; below = 1.1; panel = 2.85; gap = 0.25
rows = (n > 8 ? 0 : n > 4 ? 2 : 1)  # of the legends
legend = 0.15 + 0.35 * rows
above(k) = below + (4 - k) * (panel + gap) + panel + (k < 4 ? legend : 0)  # upper edge of panel k, 1 on top
height = above(1) + 0.1 + legend
set lmargin at screen beside / width
set rmargin at screen 1 - beyond / width
begin_panel(k) = sprintf("set tmargin at screen %f; set bmargin at screen %f", above(k) / height, (above(k) - panel) / height)
begin_key(k, closer) = (rows == 0 ? "unset key" : \
  sprintf("set key at screen %f, screen %f center bottom vertical maxrows rows Left reverse samplen 1.5 width %g", \
          0.5 * (beside + width - beyond) / width, (above(k) + 0.1) / height, closer))
spread(low, high) = sprintf("set yrange [%g : %g]; set ytics %g", low - 0.08 * (high - low), high + 0.08 * (high - low), \
                            nice((high - low) / 5.0))
beside_panel(text) = sprintf("set label 1 '%s' at screen %f, graph 0.5 center rotate", text, 0.27 / width)

numbers_1 = numbers(1, 1000, xy_high - xy_low, 'sprintf("%d", $3)')
numbers_2 = numbers(2, 1000, xy_high - xy_low, 'sprintf("%d", $3)')
numbers_3 = numbers(3, 1, theta_high - theta_low, 'sprintf("%d", $3)')
numbers_4 = numbers(4, 1000, d_high - d_low, 'sprintf("%d,%d", $3, $3 + 1)')

do for [kind in "pdf svg png"] {
  if (kind eq "pdf") { set terminal pdfcairo color enhanced size width cm, height cm font "sans,8" fontscale 0.75 linewidth 1 }
  if (kind eq "svg") { set terminal svg enhanced size width * 37.8, height * 37.8 font "sans,9.6" linewidth 1 background "white" }
  if (kind eq "png") { set terminal pngcairo color enhanced size width * 118.1, height * 118.1 font "sans,8" fontscale 3.1 linewidth 3 pointscale 3 }
  set output "figure4." . kind
  set multiplot
  set format x ""
  unset xlabel
  eval begin_panel(1)
  eval begin_key(1, -1.5)
  eval spread(xy_low, xy_high)
  eval beside_panel("{/:Italic e_x} [mm]")
  plot for [i=1:n] block("x", i) using 1:(1000 * $2) with lines linecolor rgb of(i) title sprintf("robot %d", i) @numbers_1

  unset key
  eval begin_panel(2)
  eval beside_panel("{/:Italic e_y} [mm]")
  plot for [i=1:n] block("y", i) using 1:(1000 * $2) with lines linecolor rgb of(i) @numbers_2

  eval begin_panel(3)
  eval spread(theta_low, theta_high)
  eval beside_panel("{/:Italic e}_θ [rad]")
  plot for [i=1:n] block("theta", i) using 1:2 with lines linecolor rgb of(i) @numbers_3

  set format x "%g"
  set xlabel "{/:Italic t} [s]" offset 0, 0.4
  eval begin_panel(4)
  eval begin_key(4, 0)
  eval spread(d_low, d_high)
  eval beside_panel("δ [mm]")
  if (n > 1) {
    plot for [i=1:n-1] block("delta", i) using 1:(1000 * $2) with lines linecolor rgb of_pair(i) \
           title sprintf("δ_{%d,%d}", i, i + 1) @numbers_4
  } else {
    plot 0 with lines linecolor rgb 0x808080 notitle
  }
  unset multiplot
  unset output
}
