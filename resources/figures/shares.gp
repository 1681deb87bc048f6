# Shares of a study's runs, with their 95 % intervals (Wilson), each variant in a row of its own.
set encoding utf8
set minussign
# Colours that the colour-blind can tell apart (Okabe, Ito).
array colours[8] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000, 0x999999]
array types[4] = [7, 5, 9, 11]
type(v) = types[(v - 1) % 4 + 1]
colour(v) = colours[(v - 1) % 8 + 1]
set tics nomirror scale 0.6
set border 1 linewidth 0.75
set grid xtics linecolor rgb 0xDDDDDD linewidth 0.5 dashtype solid

# One column of a journal, 88 mm; in cm:
width = 8.8
row = (variants > 2 ? 0.3 * variants + 0.2 : 0.8); below = 1.05
legend = 0.35 + 0.35 * variants
height = legend + row * rows + below
set tmargin at screen 1 - legend / height
set bmargin at screen below / height
set lmargin at screen 3.3 / width
set rmargin at screen 1 - 0.45 / width
set xrange [0 : 100]
set xtics 25
set xlabel "share of the runs [%]" offset 0, 0.4
set yrange [rows + 0.5 : 0.5]
set ytics scale 0
eval "set ytics (" . names . ")"
set key noenhanced at screen 0.5, screen 1 - 0.12 / height center top vertical maxcols 1 Left reverse samplen 1.5 width 1
beside(v) = (v - 0.5 * (variants + 1)) * (variants > 2 ? 0.3 / row : 0.32)

do for [kind in "pdf svg png"] {
  if (kind eq "pdf") { set terminal pdfcairo color enhanced size width cm, height cm font "sans,8" fontscale 0.75 linewidth 1 }
  if (kind eq "svg") { set terminal svg enhanced size width * 37.8, height * 37.8 font "sans,9.6" linewidth 1 background "white" }
  if (kind eq "png") { set terminal pngcairo color enhanced size width * 118.1, height * 118.1 font "sans,8" fontscale 3.1 linewidth 3 pointscale 3 }
  set output "shares." . kind
  plot for [v=1:variants] "shares.dat" index v - 1 using (100 * $2):($1 + beside(v)):(100 * $3):(100 * $4) with xerrorbars \
         pointtype type(v) pointsize 0.6 linecolor rgb colour(v) linewidth 1.25 title name_of[v]
  unset output
}
