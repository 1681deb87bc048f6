# Figure 4 of the paper: tracking errors of every robot in the world's frame, e_x = x_ref - x and so on, with the reference
# of the formation; and the errors in keeping the formation (37). Grey: a robot was put elsewhere. Dashed: the formation
# had settled again, to 1 cm.
data = "run.csv"

set datafile separator ","
set datafile columnheaders
set encoding utf8
set minussign

# Okabe and Ito's colours, which colour-blind readers can tell apart; from robot 9 on they come again.
array colour[8] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000, 0xF0E442]
of(i) = colour[(i - 1) % 8 + 1]
of_pair(i) = colour[(i + 3) % 8 + 1]
smaller(a, b) = (a < b ? a : b)
larger(a, b) = (a > b ? a : b)

# What the panels show, in mm and rad, a block in memory for each robot: t, e_x, e_y, e_theta, delta to the next robot. The
# file is read twice, to count its rows and for all robots at once: with 64 of them it has half a gigabyte in ten minutes.
wrapped(angle) = angle - 2 * pi * floor((angle + pi) / (2 * pi))
e(i, quantity) = column(sprintf("r%d_%s_nom", i, quantity)) - column(sprintf("r%d_%s", i, quantity))
delta(i) = (i < n ? column(sprintf("delta_%d_%d", i, i + 1)) : 0)
# While robots drive to their starts t stands still: no part of the run.
driven(i) = (strstrt(strcol(sprintf("r%d_mode", i)), "staging") == 0)
per_robot = 5
stats data using (0) nooutput
if (!exists("STATS_records")) exit error data.": cannot be read"
rows = int(STATS_records)
array value[larger(1, rows * n * per_robot)]
at(i, row, k) = (row * n + i - 1) * per_robot + k
left_out = 1e300
keep(i) = (driven(i) ? (value[at(i, $0, 1)] = column("t"), value[at(i, $0, 2)] = 1000 * e(i, "x"), \
                        value[at(i, $0, 3)] = 1000 * e(i, "y"), value[at(i, $0, 4)] = wrapped(e(i, "theta")), \
                        value[at(i, $0, 5)] = 1000 * delta(i)) \
                     : (value[at(i, $0, 1)] = left_out))
set table $read
plot data using (sum [i=1:n] (keep(i), 0)) with table
unset table
set datafile separator whitespace
set datafile nocolumnheaders
block(i) = sprintf("$robot%d", i)
do for [i=1:n] {
  eval "set table " . block(i)
  plot $read using (value[at(i, $0, 1)]):(value[at(i, $0, 2)]):(value[at(i, $0, 3)]):(value[at(i, $0, 4)]):(value[at(i, $0, 5)]) \
    with table if (!(value[at(i, $0, 1)] >= left_out))
  unset table
}
undefine value $read

# Ranges with three to six round steps; e_x and e_y have the same one. At least +-1 mm and +-0.05 rad: less is noise.
nice(step) = (p = 10**floor(log10(step)), f = step / p, p * (f <= 1 ? 1 : f <= 2 ? 2 : f <= 5 ? 5 : 10))
xy_low = delta_low = -1.0; xy_high = delta_high = 1.0; theta_low = -0.05; theta_high = 0.05
do for [i=1:n] {
  do for [k in "2 3"] {
    stats block(i) using (column(int(k))) nooutput
    xy_low = smaller(xy_low, STATS_min); xy_high = larger(xy_high, STATS_max)
  }
  stats block(i) using 4 nooutput
  theta_low = smaller(theta_low, STATS_min); theta_high = larger(theta_high, STATS_max)
  stats block(i) using 5 nooutput
  delta_low = smaller(delta_low, STATS_min); delta_high = larger(delta_high, STATS_max)
}
stats block(1) using 1 nooutput
set xrange [STATS_min : larger(STATS_max, STATS_min + 0.001)]

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
                            nice((high - low) / 5))
beside_panel(text) = sprintf("set label 1 '%s' at screen %f, graph 0.5 center rotate", text, 0.27 / width)

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
  plot for [i=1:n] block(i) using 1:2 with lines linecolor rgb of(i) title sprintf("robot %d", i)

  unset key
  eval begin_panel(2)
  eval beside_panel("{/:Italic e_y} [mm]")
  plot for [i=1:n] block(i) using 1:3 with lines linecolor rgb of(i)

  eval begin_panel(3)
  eval spread(theta_low, theta_high)
  eval beside_panel("{/:Italic e}_θ [rad]")
  plot for [i=1:n] block(i) using 1:4 with lines linecolor rgb of(i)

  set format x "%g"
  set xlabel "{/:Italic t} [s]" offset 0, 0.4
  eval begin_panel(4)
  eval begin_key(4, 0)
  eval spread(delta_low, delta_high)
  eval beside_panel("δ [mm]")
  if (n > 1) {
    plot for [i=1:n-1] block(i) using 1:5 with lines linecolor rgb of_pair(i) \
           title sprintf("δ_{%d,%d}", i, i + 1)
  } else {
    plot 0 with lines linecolor rgb 0x808080 notitle
  }
  unset multiplot
  unset output
}
