# Figures of Labrosse 2004 and 2006 as SVG, from what samples/compass-experiments.sh leaves in its folder. The caller sets
#   folder

set datafile separator ','
set encoding utf8
set style line 1 lc rgb '#0072B2' lw 1.5
set style line 2 lc rgb '#D55E00' lw 1.5
set style line 3 lc rgb '#000000' lw 1
set style line 9 lc rgb '#DDDDDD' lw 1
set tics nomirror out scale 0.6
set grid ls 9
set ylabel 'distance (grey levels)'
svg(name, width, height) = sprintf("set terminal svg size %d,%d background '#FFFFFF' font 'DejaVu Sans,13'; \
  set output '%s/%s.svg'", width, height, folder, name)

# 2006, Fig. 6 and 8: the distance over the shift, in the perfect and in the general case.
set xlabel 'column-wise shift of the first image (deg)'
set xrange [-180:180]
set xtics 45
eval svg('fig-6-8', 860, 380)
set key outside top center horizontal
plot folder.'/perfect.csv' using 2:($1 == last_perfect && strcol(4) eq 'curve' ? $3 : 1/0) with lines ls 1 \
  title 'a turn on the spot (Fig. 6)', \
  folder.'/general.csv' using 2:($1 == last_general && strcol(4) eq 'curve' ? $3 : 1/0) with lines ls 2 \
  title 'a turn and a displacement (Fig. 8)'

# Fig. 11 and 12: an image of a circle against itself and the ten that follow.
eval svg('fig-11', 860, 420)
set key off
set palette defined (0 '#000000', 1 '#0072B2', 2 '#E69F00')
unset colorbox
plot folder.'/followers.csv' using 2:(strcol(4) eq 'curve' ? $3 : 1/0):1 with lines lw 1.2 lc palette
eval svg('fig-12', 860, 420)
set key outside top center horizontal
set xrange [-4:18]
set xtics 2
plot folder.'/followers.csv' using 2:(strcol(4) eq 'curve' ? $3 : 1/0):1 with linespoints pt 7 ps 0.2 lw 1 lc palette notitle, \
  folder.'/followers.csv' using 2:(strcol(4) eq 'parabola' ? $3 : 1/0) with points pt 12 ps 0.8 lc rgb '#009E73' \
  title 'parabola', \
  folder.'/followers.csv' using 2:(strcol(4) eq 'mixture' ? $3 : 1/0) with points pt 1 ps 0.9 lw 1.5 lc rgb '#D55E00' \
  title 'mixture of lines and parabola'

# Fig. 9: both models through the same three distances.
eval svg('fig-9', 860, 340)
set xlabel 'shift (columns from the least distance)'
set ylabel 'distance'
set xrange [-1.4:1.4]
set xtics 1
unset ytics
set yrange [0:7]
set samples 400
set multiplot layout 1,2
# Distances left, least, right; the vertex of the parabola and of the two lines.
parabola(x, l, m, r) = m + (r - l) / 2 * x + (l - 2 * m + r) / 2 * x**2
lines_(x, l, m, r) = m - abs(l - r) / 2 + (((l > r ? l : r) - m) * abs(x - (l - r) / (2.0 * ((l > r ? l : r) - m))))
set title 'similar images: two lines fit'
$sharp << EOD
-1,6
0,2
1,3
EOD
plot $sharp using 1:2 with linespoints ls 3 lw 2 pt 7 notitle, lines_(x, 6.0, 2.0, 3.0) ls 1 title 'lines', \
  parabola(x, 6.0, 2.0, 3.0) ls 2 title 'parabola'
set title 'different images: a parabola fits'
$round << EOD
-1,5
0,2.6
1,4.2
EOD
plot $round using 1:2 with linespoints ls 3 lw 2 pt 7 notitle, lines_(x, 5.0, 2.6, 4.2) ls 1 title 'lines', \
  parabola(x, 5.0, 2.6, 4.2) ls 2 title 'parabola'
unset multiplot
unset title
set ytics

# 2004, Fig. 2: distance to the image at the mark, over the place.
eval svg('fig-2', 620, 560)
unset key
set size ratio -1
set xrange [*:*]
set yrange [*:*]
set xtics 0.5
set ytics 0.5
set xlabel 'x (m)'
set ylabel 'y (m)'
set colorbox
set cblabel 'distance (grey levels)'
set palette defined (0 '#000033', 1 '#0072B2', 2 '#E69F00', 3 '#FFFFCC')
plot folder.'/positions.csv' using 1:2:3 with points pt 5 ps 0.9 lc palette, \
  '' using 1:($3 == 0 ? $2 : 1/0) with points pt 6 ps 2 lw 2 lc rgb '#D55E00'

# All compasses: largest error of each recording.
eval svg('largest', 860, 420)
reset
set datafile separator ','
set encoding utf8
set logscale y
set ylabel 'largest error (deg)'
set yrange [0.03:*]
set grid ytics lc rgb '#DDDDDD'
set style data histogram
set style histogram clustered gap 1
set style fill solid 0.9 border -1
set xtics rotate by -35 nomirror
set key outside top center horizontal
plot folder.'/largest.csv' using 2:xtic(1) lc rgb '#CCCCCC' title '2004, smooth', '' using 3 lc rgb '#D55E00' title '2006, Atm 0.6055', \
  '' using 4 lc rgb '#E69F00' title '2006, best Fx', '' using 5 lc rgb '#0072B2' title 'fft'
