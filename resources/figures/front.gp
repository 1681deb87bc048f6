# What a search for gains found: every candidate, the front with its numbers, and what front and own gains took on kicks held out.
set encoding utf8
set minussign
set tics nomirror scale 0.6
set border 3 linewidth 0.75
set grid linecolor rgb 0xDDDDDD linewidth 0.5 dashtype solid

# One column of a journal, 88 mm; in cm:
width = 8.8; height = 8.2
set lmargin at screen 1.3 / width
set rmargin at screen 1 - 0.3 / width
set tmargin at screen 1 - 1.5 / height
set bmargin at screen 1.05 / height
set key at screen 0.5, screen 1 - 0.08 / height center top vertical maxrows 3 Left reverse samplen 1 width 1
set xlabel "relative positions within 1 cm after [s], mean" offset 0, 0.4
set ylabel "tracking within 1 cm after [s], mean" offset 1.4, 0

# Candidates far from the front would flatten it: the frame holds front and own gains, and half as much again.
set terminal unknown
plot for [b=1:3] "front.dat" index b using 1:2, for [b=1:2] "" index b using 3:4
pad(low, high) = (high > low ? 0.25 * (high - low) : 0.5)
set xrange [GPVAL_DATA_X_MIN - pad(GPVAL_DATA_X_MIN, GPVAL_DATA_X_MAX) : GPVAL_DATA_X_MAX + pad(GPVAL_DATA_X_MIN, GPVAL_DATA_X_MAX)]
set yrange [GPVAL_DATA_Y_MIN - pad(GPVAL_DATA_Y_MIN, GPVAL_DATA_Y_MAX) : GPVAL_DATA_Y_MAX + pad(GPVAL_DATA_Y_MIN, GPVAL_DATA_Y_MAX)]

do for [kind in "pdf svg png"] {
  if (kind eq "pdf") { set terminal pdfcairo color enhanced size width cm, height cm font "sans,8" fontscale 0.75 linewidth 1 }
  if (kind eq "svg") { set terminal svg enhanced size width * 37.8, height * 37.8 font "sans,9.6" linewidth 1 background "white" }
  if (kind eq "png") { set terminal pngcairo color enhanced size width * 118.1, height * 118.1 font "sans,8" fontscale 3.1 linewidth 3 pointscale 3 }
  set output "front." . kind
  plot "front.dat" index 0 using 1:2 with points pointtype 7 pointsize 0.15 linecolor rgb 0xBBBBBB title "tried", \
       "" index 1 using 1:2 with linespoints pointtype 7 pointsize 0.5 linecolor rgb 0x0072B2 title "front", \
       "" index 2 using 1:2 with points pointtype 7 pointsize 0.7 linecolor rgb 0xD55E00 title "own gains", \
       "" index 1 using 3:4 with points pointtype 6 pointsize 0.5 linecolor rgb 0x0072B2 title "front, held out", \
       "" index 2 using 3:4 with points pointtype 6 pointsize 0.7 linecolor rgb 0xD55E00 title "own gains, held out", \
       "" index 3 using 1:2 with points pointtype 4 pointsize 1.1 linecolor rgb 0x0072B2 title "chosen", \
       "" index 1 using 1:2:5 with labels offset 0.7, 0.5 font ",6" textcolor rgb 0x0072B2 notitle
  unset output
}
