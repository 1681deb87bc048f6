# Figure 3 of the paper: where the robots should go (solid) and where they went (dotted), x at both ends of every path,
# an arrow where somebody put a robot elsewhere.
data = "run.csv"

set datafile separator ","
set datafile columnheaders
set encoding utf8
set minussign

# Okabe and Ito's colours, which colour-blind readers can tell apart; from robot 9 on they come again.
array colour[8] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000, 0xF0E442]
of(i) = colour[(i - 1) % 8 + 1]
of_robot(i, quantity) = column(sprintf("r%d_%s", i, quantity))
smaller(a, b) = (a < b ? a : b)
larger(a, b) = (a > b ? a : b)

# What is drawn, a block in memory for each robot: x, y, x_ref, y_ref. The file is read twice,
# to count its rows and for all robots at once: with 64 of them it has half a gigabyte in ten minutes. While robots drive to their starts t stands still: no part of the run.
per_robot = 4
stats data using (0) nooutput
if (!exists("STATS_records")) exit error data.": cannot be read"
rows = int(STATS_records)
array value[larger(1, rows * n * per_robot)]
at(i, row, k) = (row * n + i - 1) * per_robot + k
left_out = 1e300
driven(i) = (strstrt(strcol(sprintf("r%d_mode", i)), "staging") == 0)
keep(i) = (driven(i) ? (value[at(i, $0, 1)] = of_robot(i, "x"), value[at(i, $0, 2)] = of_robot(i, "y"), \
                        value[at(i, $0, 3)] = of_robot(i, "x_nom"), value[at(i, $0, 4)] = of_robot(i, "y_nom")) \
                     : (value[at(i, $0, 1)] = left_out))
set table $read
plot data using (sum [i=1:n] (keep(i), 0)) with table
unset table
set datafile separator whitespace
set datafile nocolumnheaders
block(i) = sprintf("$robot%d", i)
do for [i=1:n] {
  eval "set table " . block(i)
  plot $read using (value[at(i, $0, 1)]):(value[at(i, $0, 2)]):(value[at(i, $0, 3)]):(value[at(i, $0, 4)]) \
    with table if (!(value[at(i, $0, 1)] >= left_out))
  unset table
}
undefine value $read

# A robot that was put elsewhere jumps; driving, it never does 3 cm in a tick. Its path is broken there.
jump = 0.03
x = NaN; y = NaN
look(row) = (ox = ($0 == 0 ? NaN : x), oy = ($0 == 0 ? NaN : y), x = column(1), y = column(2), \
           moved = (sqrt((x - ox)**2 + (y - oy)**2) > jump))

# Everything that is drawn, and a twentieth around it.
left = bottom = 1e9; right = top = -1e9
do for [i=1:n] {
  do for [k in "1 3"] {
    stats block(i) using (column(int(k))):(column(k + 1)) nooutput
    left = smaller(left, STATS_min_x); right = larger(right, STATS_max_x)
    bottom = smaller(bottom, STATS_min_y); top = larger(top, STATS_max_y)
  }
}
last = int(STATS_records) - 1
around = 0.05 * larger(right - left, top - bottom) + 0.01
set xrange [left - around : right + around]
set yrange [bottom - around : top + around]

# One column of a journal, 88 mm, and as high as equal axes ask. In cm:
width = 8.8
rows = (n > 8 ? 0 : ceil((n + 1) / 3.0))  # of the legend
beside = 1.2; beyond = 0.3; below = 1.1; above = 0.2 + 0.35 * rows
plot_width = width - beside - beyond
plot_height = plot_width * (top - bottom + 2 * around) / (right - left + 2 * around)
if (plot_height > 20) { plot_width = plot_width * 20 / plot_height; plot_height = 20 }
height = below + plot_height + above
set lmargin at screen beside / width
set rmargin at screen (beside + plot_width) / width
set bmargin at screen below / height
set tmargin at screen (below + plot_height) / height

set xlabel "{/:Italic x} [m]" offset 0, 0.4
set label 1 "{/:Italic y} [m]" at screen 0.3 / width, graph 0.5 center rotate
set tics nomirror scale 0.6
set border linewidth 0.75
if (rows == 0) { unset key } else {
  set key at screen 0.5, screen 1 - 0.1 / height center top vertical maxrows rows Left reverse samplen 2 width -1
}

do for [kind in "pdf svg png"] {
  if (kind eq "pdf") { set terminal pdfcairo color enhanced size width cm, height cm font "sans,8" fontscale 0.75 linewidth 1 }
  if (kind eq "svg") { set terminal svg enhanced size width * 37.8, height * 37.8 font "sans,9.6" linewidth 1 background "white" }
  if (kind eq "png") { set terminal pngcairo color enhanced size width * 118.1, height * 118.1 font "sans,8" fontscale 3.1 linewidth 3 pointscale 3 }
  set output "figure3." . kind
  plot for [i=1:n] block(i) using 3:4 with lines \
         linecolor rgb 0xA0A0A0 linewidth 1.5 dashtype solid title (i == 1 ? "reference" : ""), \
       for [i=1:n] block(i) using (look(0), moved ? NaN : x):(y) with lines \
         linecolor rgb of(i) linewidth 1.5 dashtype (1.5,1.5) title sprintf("robot %d", i), \
       for [i=1:n] block(i) using (look(0), moved ? ox : NaN):(oy):(x - ox):(y - oy) with vectors \
         head filled size screen 0.02,20 linecolor rgb of(i) linewidth 0.75 dashtype solid notitle, \
       for [i=1:n] for [end in sprintf("0 %d", last)] block(i) every ::int(end)::int(end) \
         using 1:2 with points \
         pointtype 2 pointsize 0.75 linewidth 1 linecolor rgb of(i) notitle
  unset output
}
