# Figures of one experiment, as SVG and PNG, from what samples/experiments.sh leaves in its folder. The caller sets
#   folder
#   mosaic                             PNG of the map on which the positions are drawn
#   mosaic_x, mosaic_y, mosaic_pixel   centre of the mosaic's lower left pixel and size of a pixel, in metres

set datafile separator ','
set encoding utf8

# Okabe and Ito's colours, which colour-blind people tell apart; dashes and points differ as well.
set style line 1 lc rgb '#D55E00' lw 2 dt 1 pt 7 ps 0.5           # before
set style line 2 lc rgb '#0072B2' lw 1.5 dt (8,3)                 # forward
set style line 3 lc rgb '#E69F00' lw 2 dt (2,3)                   # ceiling
set style line 4 lc rgb '#009E73' lw 2 dt 1 pt 7 ps 0.5           # fused
set style line 5 lc rgb '#000000' lw 1 dt 1                       # truth
set style line 6 lc rgb '#AAAAAA' lw 6 dt 1                       # truth, under other lines
set style line 7 lc rgb '#CC79A7' lw 1.5 dt (6,2,2,2)           # matsumoto
set style line 9 lc rgb '#DDDDDD' lw 1 dt 1
set style textbox opaque noborder fillcolor rgb '#CCCCCC' margins 0.3,0.3    # over legs
set tics nomirror out scale 0.6
set grid ls 9

csv(method) = sprintf('%s/report/%s-errors.csv', folder, method)

# Both formats show a figure alike: a unit of size is a pixel of the SVG and two of the PNG.
terminal(format, width, height) = format eq 'svg' ? \
  sprintf("set terminal svg size %d,%d background '#FFFFFF' font 'DejaVu Sans,13'", width, height) : \
  sprintf("set terminal pngcairo size %d,%d font 'DejaVu Sans,10' fontscale 2 linewidth 2 pointscale 2", \
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
leg = 0.15
left_x = -leg * (last_y - first_y) / length
left_y = leg * (last_x - first_x) / length
stagger(n) = int(n) % 2 ? 1.6 : 1    # where the map has neighbours in one place, their numbers do not
label(n) = stagger(n) + 0.25
min(a, b) = a < b ? a : b
max(a, b) = a > b ? a : b
margin_x = 0.3
margin_y = 0.34
span_x = abs(last_x - first_x) + 2 * margin_x
span_y = abs(last_y - first_y) + 2 * margin_y

do for [format in 'svg png'] {
  # (a) Errors along a straight path hide in it. So every tenth frame has a leg with its number: to the left from where
  # the robot was, to the right from where the map has it.
  eval terminal(format, 860, int(2 * (100 + 760 * span_y / span_x)))
  eval output('positions', format)
  set multiplot layout 2,1 margins char 8,char 2,char 3.5,char 2 spacing char 0,char 5
  set size ratio -1
  set key at graph 1,1.01 bottom right horizontal samplen 2 maxrows 1
  set xrange [min(first_x, last_x) - margin_x : max(first_x, last_x) + margin_x]
  set yrange [min(first_y, last_y) - margin_y : max(first_y, last_y) + margin_y]
  set xtics 0.5
  set ytics 0.5
  set xlabel 'x (m)'
  set ylabel 'y (m)'
  do for [panel = 1:2] {
    map_x = panel == 1 ? 12 : 14
    map_y = map_x + 1
    style = panel == 1 ? 1 : 4
    set label 1 panel == 1 ? 'Before compensation' : 'After compensation (fused)' at graph 0,1 offset 0,0.8 left
    plot mosaic binary filetype=png origin=(mosaic_x, mosaic_y) dx=mosaic_pixel dy=mosaic_pixel \
        using (140 + 0.45 * $1):(140 + 0.45 * $2):(140 + 0.45 * $3) with rgbimage notitle, \
      csv('fused') using 10:11:(stagger($0) * left_x):(stagger($0) * left_y) every 10::1 \
        with vectors nohead ls 5 notitle, \
      csv('fused') using ($10 + label($0) * left_x):($11 + label($0) * left_y):(int($0) * 10) every 10::1 \
        with labels boxed font ',9' notitle, \
      csv('fused') using map_x:map_y:(-stagger($0) * left_x):(-stagger($0) * left_y) every 10::1 \
        with vectors nohead ls style notitle, \
      csv('fused') using (column(map_x) - label($0) * left_x):(column(map_y) - label($0) * left_y):(int($0) * 10) \
        every 10::1 with labels boxed font ',9' textcolor ls style notitle, \
      csv('fused') using 10:11 every ::1 with lines ls 5 title 'truth', \
      csv('fused') using map_x:map_y every ::1 with points ls style title 'ceiling map'
  }
  unset multiplot
  set size noratio
  set autoscale
  set xtics autofreq
  set ytics autofreq
  unset label 1
}

# One legend above all panels.
legend = 'set key at screen 0.5,0.995 center top horizontal maxrows 3 samplen 6 width 2'
panels = 'set multiplot layout 2,2 margins char 8,char 2,char 3.5,char 6.5 spacing char 10,char 4'
# Lines of all methods in a column, times a factor; fused runs under ceiling, which often agrees with it.
lines(column, factor) = sprintf("csv('matsumoto') using 0:(%g * column(%d)) every ::1 with lines ls 7 title 'matsumoto', \
  csv('forward') using 0:(%g * column(%d)) every ::1 with lines ls 2 title 'forward', \
  csv('fused') using 0:(%g * column(%d)) every ::1 with lines ls 4 title 'fused', \
  csv('ceiling') using 0:(%g * column(%d)) every ::1 with lines ls 3 title 'ceiling'", \
  factor, column, factor, column, factor, column, factor, column)
# The same, less the truth's column.
differences(column, truth) = sprintf("for [i = 1:4] csv(word(methods, i)) \
  using 0:(column(%d) - column(%d)) every ::1 with lines ls word(styles, i) notitle", column, truth)
methods = 'matsumoto forward fused ceiling'
styles = '7 2 4 3'

do for [format in 'svg png'] {
  # (b) The left column has all errors at one scale, the right one what compensation leaves.
  eval terminal(format, 1000, 640)
  eval output('errors', format)
  eval panels
  set xrange [0:last]
  eval legend
  do for [axis = 0:1] {
    direction = axis == 0 ? 'along' : 'across'
    if (axis == 1) { set xlabel 'frame'; unset key; } else { unset xlabel }
    set title 'Error ' . direction . ' the path, before and after compensation'
    set ylabel 'error (cm)'
    eval "plot csv('fused') using 0:(100 * column(2 + axis)) every ::1 with lines ls 1 title 'before', " . \
      lines(4 + axis, 100)
    unset key
    set title 'Error ' . direction . ' the path, after compensation'
    eval 'plot ' . lines(4 + axis, 100)
  }
  unset multiplot

  # (c) Beside the tilt, the error of its estimate.
  eval terminal(format, 1000, 640)
  eval output('tilt', format)
  eval panels
  eval legend
  do for [axis = 0:1] {
    angle = axis == 0 ? 'pitch' : 'roll'
    if (axis == 1) { set xlabel 'frame' } else { unset xlabel }
    set title axis == 0 ? 'Pitch, positive with the nose down' : 'Roll, positive with the left side up'
    set ylabel angle . ' (deg)'
    eval "plot csv('fused') using 0:6 + axis every ::1 with lines ls 6 title 'truth', " . lines(8 + axis, 1)
    unset key
    set title 'Error of the estimated ' . angle
    set ylabel 'estimate - truth (deg)'
    eval 'plot ' . differences(8 + axis, 6 + axis)
  }
  unset multiplot
  unset title
  set output
}
