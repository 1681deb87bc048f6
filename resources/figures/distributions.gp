# What a study counted: on the left how often each value came up, on the right the share of all runs that had at most it, with its 95 %
# interval (Wilson, point by point). Runs in which it never came to that count for the share's whole.
set encoding utf8
set minussign
# Colours that the colour-blind can tell apart (Okabe, Ito), and dashes for print in grey.
array colours[8] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000, 0x999999]
colour(v) = colours[(v - 1) % 8 + 1]
set tics nomirror scale 0.6
set border 3 linewidth 0.75
set grid linecolor rgb 0xDDDDDD linewidth 0.5 dashtype solid
larger(a, b) = (a > b ? a : b)
nice(step) = (p = 10**floor(log10(step)), f = step / p, p * (f <= 1 ? 1 : f <= 2 ? 2 : f <= 5 ? 5 : 10))

# Two columns of a journal, 178 mm; in cm:
width = 17.8
beside = 1.45; between = 1.75; beyond = 0.4; below = 1.05; panel = 3.1; gap = 1.35
legend = 0.4 + 0.35 * variants
column_width = 0.5 * (width - beside - between - beyond)
height = legend + panels * panel + (panels - 1) * gap + below
top_of(k) = height - legend - (k - 1) * (panel + gap)
place(k, side) = sprintf("set tmargin at screen %f; set bmargin at screen %f; set lmargin at screen %f; set rmargin at screen %f", \
  top_of(k) / height, (top_of(k) - panel) / height, (beside + side * (column_width + between)) / width, \
  (beside + side * (column_width + between) + column_width) / width)
block(k, v) = (k - 1) * variants + v - 1

do for [kind in "pdf svg png"] {
  if (kind eq "pdf") { set terminal pdfcairo color enhanced size width cm, height cm font "sans,8" fontscale 0.75 linewidth 1 }
  if (kind eq "svg") { set terminal svg enhanced size width * 37.8, height * 37.8 font "sans,9.6" linewidth 1 background "white" }
  if (kind eq "png") { set terminal pngcairo color enhanced size width * 118.1, height * 118.1 font "sans,8" fontscale 3.1 linewidth 3 pointscale 3 }
  set output figure . "." . kind
  set multiplot
  do for [k=1:panels] {
    set xrange [from[k] : to[k]]
    set xtics nice((to[k] - from[k]) / 6.0)  # of whole numbers, too
    set xlabel label_of[k] offset 0, 0.5
    eval place(k, 0)
    unset key
    set ylabel "runs [%]" offset 1.2, 0
    set yrange [0 : *]
    set ytics autofreq
    set style fill transparent solid (variants > 2 ? 0.08 : 0.25) noborder
    plot for [v=1:variants] "histograms-" . figure . ".dat" index block(k, v) using 1:(100 * $2) with fillsteps \
           linecolor rgb colour(v) notitle, \
         for [v=1:variants] "" index block(k, v) using 1:(100 * $2) with steps linecolor rgb colour(v) linewidth 1.25 dashtype v notitle
    eval place(k, 1)
    if (k == 1) { set key noenhanced at screen 0.5, screen 1 - 0.12 / height center top vertical maxcols 1 Left reverse samplen 2 width 1 }
    set ylabel "at most so much [%]" offset 1.2, 0
    set yrange [0 : 103]
    set ytics 25
    set style fill transparent solid (variants > 2 ? 0.1 : 0.2) noborder
    plot for [v=1:variants] "distributions-" . figure . ".dat" index block(k, v) using 1:(100 * $3):(100 * $4) with filledcurves \
           linecolor rgb colour(v) notitle, \
         for [v=1:variants] "" index block(k, v) using 1:(100 * $2) with steps linecolor rgb colour(v) linewidth 1.25 dashtype v \
           title (k == 1 ? name_of[v] : "")
  }
  unset multiplot
  unset output
}
