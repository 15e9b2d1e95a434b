# Figures of one experiment, as SVG and PNG, from what samples/experiments.sh leaves in its folder. The caller sets
#   folder, and mosaic_x, mosaic_y, mosaic_pixel: centre of the mosaic's lower left pixel and size of a pixel, in metres.

set datafile separator ','
set encoding utf8

# Okabe and Ito's colours, which colour-blind people tell apart; dashes and points differ as well.
set style line 1 lc rgb '#D55E00' lw 2 dt 1 pt 7 ps 0.5           # before
set style line 2 lc rgb '#0072B2' lw 2 dt (9,4)                   # forward
set style line 3 lc rgb '#E69F00' lw 2 dt (2,2)                   # ceiling
set style line 4 lc rgb '#009E73' lw 2 dt 1 pt 7 ps 0.5           # fused
set style line 5 lc rgb '#000000' lw 1.5 dt 1 pt 6 ps 0.5         # truth
set style line 6 lc rgb '#AAAAAA' lw 6 dt 1                       # truth, under other lines
set style line 9 lc rgb '#DDDDDD' lw 1 dt 1
set tics nomirror out scale 0.6
set grid ls 9

csv(method) = sprintf('%s/report-%s/%s-errors.csv', folder, method, method)
cm(metres) = 100 * metres

# Both formats show a figure alike: a unit of size is a pixel of the SVG and two of the PNG.
terminal(format, width, height) = format eq 'svg' ? \
  sprintf("set terminal svg size %d,%d font 'DejaVu Sans,13' rounded", width, height) : \
  sprintf("set terminal pngcairo size %d,%d font 'DejaVu Sans,10' fontscale 2 linewidth 2 pointscale 2 rounded", \
    2 * width, 2 * height)
output(name, format) = sprintf("set output '%s/%s.%s'", folder, name, format)

# Ends of the true path, and its left, for the legs below.
end(column, row) = sprintf("stats csv('fused') using %d every ::%d::%d nooutput", column, row, row)
stats csv('fused') using 10 nooutput
last = int(STATS_records) - 1
eval end(10, 1); first_x = STATS_min
eval end(11, 1); first_y = STATS_min
eval end(10, last); last_x = STATS_min
eval end(11, last); last_y = STATS_min
length = sqrt((last_x - first_x)**2 + (last_y - first_y)**2)
leg = 0.16
left_x = -leg * (last_y - first_y) / length
left_y = leg * (last_x - first_x) / length
min(a, b) = a < b ? a : b
max(a, b) = a > b ? a : b
margin_x = 0.3
margin_y = 0.32
span_x = abs(last_x - first_x) + 2 * margin_x
span_y = abs(last_y - first_y) + 2 * margin_y

do for [format in 'svg png'] {
  # (a) Errors along a straight path hide in it. So every tenth frame has a leg with its number: to the left from where the
  # robot was, to the right from where the map has it.
  eval terminal(format, 860, int(2 * (90 + 760 * span_y / span_x)))
  eval output('positions', format)
  set multiplot layout 2,1 margins 0.09,0.98,0.07,0.95 spacing 0.1
  set size ratio -1
  set key top right box opaque samplen 1 width 0.5 height 0.3
  set xrange [min(first_x, last_x) - margin_x : max(first_x, last_x) + margin_x]
  set yrange [min(first_y, last_y) - margin_y : max(first_y, last_y) + margin_y]
  set xlabel 'x (m)'
  set ylabel 'y (m)'
  do for [panel = 1:2] {
    x = panel == 1 ? 12 : 14
    y = x + 1
    style = panel == 1 ? 1 : 4
    set title panel == 1 ? 'Before compensation' : 'After compensation (fused)'
    plot folder . '/fused.png' binary filetype=png origin=(mosaic_x, mosaic_y) dx=mosaic_pixel dy=mosaic_pixel \
        using (140 + 0.45 * $1):(140 + 0.45 * $2):(140 + 0.45 * $3) with rgbimage notitle, \
      csv('fused') using 10:11:(left_x):(left_y) every 10::1 with vectors nohead ls 5 notitle, \
      csv('fused') using ($10 + 1.25 * left_x):($11 + 1.25 * left_y):(int($0) * 10) every 10::1 with labels \
        font ',9' notitle, \
      csv('fused') using x:y:(-left_x):(-left_y) every 10::1 with vectors nohead ls style notitle, \
      csv('fused') using (column(x) - 1.25 * left_x):(column(y) - 1.25 * left_y):(int($0) * 10) every 10::1 with labels \
        font ',9' textcolor ls style notitle, \
      csv('fused') using x:y every ::1 with points ls style title 'ceiling map', \
      csv('fused') using 10:11 every ::1 with points ls 5 title 'truth'
  }
  unset multiplot
  set size noratio
  set autoscale
  set key default
}

do for [format in 'svg png'] {
  # (b) The left column shows all errors at one scale, the right one what compensation leaves.
  eval terminal(format, 1000, 640)
  eval output('errors', format)
  set multiplot layout 2,2 margins 0.08,0.98,0.1,0.9 spacing 0.09,0.12
  set xrange [0:last]
  set xlabel 'frame'
  set key above horizontal samplen 3
  do for [axis = 0:1] {
    set ylabel axis == 0 ? 'error along the path (cm)' : 'error across the path (cm)'
    plot csv('fused') using 0:(cm(column(2 + axis))) every ::1 with lines ls 1 title 'before', \
      csv('forward') using 0:(cm(column(4 + axis))) every ::1 with lines ls 2 title 'forward', \
      csv('ceiling') using 0:(cm(column(4 + axis))) every ::1 with lines ls 3 title 'ceiling', \
      csv('fused') using 0:(cm(column(4 + axis))) every ::1 with lines ls 4 title 'fused'
    plot csv('forward') using 0:(cm(column(4 + axis))) every ::1 with lines ls 2 title 'forward', \
      csv('ceiling') using 0:(cm(column(4 + axis))) every ::1 with lines ls 3 title 'ceiling', \
      csv('fused') using 0:(cm(column(4 + axis))) every ::1 with lines ls 4 title 'fused'
  }
  unset multiplot

  # (c)
  eval terminal(format, 860, 640)
  eval output('tilt', format)
  set multiplot layout 2,1 margins 0.09,0.98,0.1,0.93 spacing 0.12
  do for [axis = 0:1] {
    set ylabel axis == 0 ? 'pitch (deg), nose down > 0' : 'roll (deg), left side up > 0'
    plot csv('fused') using 0:6 + axis every ::1 with lines ls 6 title 'truth', \
      csv('forward') using 0:8 + axis every ::1 with lines ls 2 title 'forward', \
      csv('ceiling') using 0:8 + axis every ::1 with lines ls 3 title 'ceiling', \
      csv('fused') using 0:8 + axis every ::1 with lines ls 4 title 'fused'
  }
  unset multiplot
  set output
}
