# Figure 3 of the paper: where the robots should go (solid) and where they went (dotted), x at both ends of every path,
# an arrow where somebody put a robot elsewhere. Of more than eight robots, the robot's number at the beginning of its path.
load "figure3.dat"  # $reference_i, $path_i, $moves_i, $ends_i of robot i; of a long run as much as can be seen

set datafile missing "nan"  # where a robot was never seen: gnuplot 5.4 crashes at a label there
set encoding utf8
set minussign

# Okabe and Ito's colours, which colour-blind readers can tell apart; from robot 9 on they come again.
array colour[8] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000, 0xF0E442]
of(i) = colour[(i - 1) % 8 + 1]
larger(a, b) = (a > b ? a : b)
block(name, i) = sprintf("$%s_%d", name, i)

# Everything that is drawn, and a twentieth around it; of a straight path a third as much across as along, so that the
# numbers of that axis have room.
span = larger(x_high - x_low, y_high - y_low)
around(low, high) = 0.05 * span + 0.01 + larger(0, span / 3.0 - (high - low)) / 2
beside_x = around(x_low, x_high); beside_y = around(y_low, y_high)
set xrange [x_low - beside_x : x_high + beside_x]
set yrange [y_low - beside_y : y_high + beside_y]

# One column of a journal, 88 mm, and as high as equal axes ask. In cm:
width = 8.8
rows = (n > 8 ? 0 : ceil((n + 1) / 3.0))  # of the legend
beside = 1.6; beyond = 0.3; below = 1.1; above = 0.2 + 0.35 * rows
plot_width = width - beside - beyond
plot_height = plot_width * (y_high - y_low + 2 * beside_y) / (x_high - x_low + 2 * beside_x)
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

numbers = (n > 8 ? ', for [i=1:n] block("ends", i) every ::0::0 using 1:2:(sprintf("%d", i))' \
                   . ' with labels offset 0.7, 0.5 font ",6" notitle' : "")

do for [kind in "pdf svg png"] {
  if (kind eq "pdf") { set terminal pdfcairo color enhanced size width cm, height cm font "sans,8" fontscale 0.75 linewidth 1 }
  if (kind eq "svg") { set terminal svg enhanced size width * 37.8, height * 37.8 font "sans,9.6" linewidth 1 background "white" }
  if (kind eq "png") { set terminal pngcairo color enhanced size width * 118.1, height * 118.1 font "sans,8" fontscale 3.1 linewidth 3 pointscale 3 }
  set output "figure3." . kind
  plot for [i=1:n] block("reference", i) using 1:2 with lines \
         linecolor rgb 0xA0A0A0 linewidth 1.5 dashtype solid title (i == 1 ? "reference" : ""), \
       for [i=1:n] block("path", i) using 1:2 with lines \
         linecolor rgb of(i) linewidth 1.5 dashtype (1.5,1.5) title sprintf("robot %d", i), \
       for [i=1:n] block("moves", i) using 1:2:3:4 with vectors \
         head filled size screen 0.02,20 linecolor rgb of(i) linewidth 0.75 dashtype solid notitle, \
       for [i=1:n] for [end=0:1] block("ends", i) every ::end::end using 1:2 with points \
         pointtype 2 pointsize 0.75 linewidth 1 linecolor rgb of(i) notitle @numbers
  unset output
}
