# Where a robot was seen, against what the pose before and its wheels let expect.
set encoding utf8
set minussign
set datafile separator ","
set tics nomirror scale 0.6
set border 3 linewidth 0.75
set grid ytics linecolor rgb 0xDDDDDD linewidth 0.5 dashtype solid
unset key

# One column of a journal, 88 mm; in cm:
width = 8.8
height = 10.5
array column_of[3] = [2, 3, 4]
array scale_of[3] = [1e3, 1e3, 180 / pi]
array label_of[3] = ["ahead [mm]", "to the left [mm]", "heading [°]"]
array colour[2] = [0x0072B2, 0xD55E00]

do for [kind in "pdf svg png"] {
  if (kind eq "pdf") { set terminal pdfcairo color enhanced size width cm, height cm font "sans,6.5" fontscale 0.75 linewidth 1 }
  if (kind eq "svg") { set terminal svg enhanced size width * 37.8, height * 37.8 font "sans,8" linewidth 1 background "white" }
  if (kind eq "png") { set terminal pngcairo color enhanced size width * 118.1, height * 118.1 font "sans,8" fontscale 2.4 linewidth 3 pointscale 3 }
  set output name . "." . kind
  set multiplot layout 3, 1 title robot noenhanced
  do for [k = 1:3] {
    if (k == 3) { set xlabel "time [s]" offset 0, 0.4 }
    set ylabel label_of[k]
    plot name . ".csv" using 1:(column(6) == 1 ? scale_of[k] * column(column_of[k]) : NaN) every stride::1 with points \
           pointtype 7 pointsize 0.12 linecolor rgb colour[1], \
         "" using 1:(column(6) == 0 ? scale_of[k] * column(column_of[k]) : NaN) every ::1 with points \
           pointtype 2 pointsize 0.4 linecolor rgb colour[2]
  }
  unset multiplot
  unset xlabel
  unset output
}
