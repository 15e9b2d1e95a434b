# Figures of samples/colour-experiments.sh, as SVG and PNG, from what it leaves in its folder. The caller sets
#   folder

set encoding utf8

# Okabe and Ito's colours, which colour-blind people tell apart; dashes and points differ as well.
set style line 1 lc rgb '#D55E00' lw 2 dt 1 pt 7 ps 0.6
set style line 2 lc rgb '#0072B2' lw 2 dt (8,3) pt 5 ps 0.6
set style line 3 lc rgb '#E69F00' lw 2 dt (2,3) pt 9 ps 0.7
set style line 4 lc rgb '#009E73' lw 2 dt (10,3,2,3) pt 13 ps 0.7
set style line 5 lc rgb '#000000' lw 1 dt 1
set style line 9 lc rgb '#DDDDDD' lw 1 dt 1
set tics nomirror out scale 0.6
set grid ls 9

result(name) = folder . '/results/' . name
rad = pi / 180

# Both formats show a figure alike: a unit of size is a pixel of the SVG and two of the PNG.
terminal(format, width, height) = format eq 'svg' ? \
  sprintf("set terminal svg size %d,%d background '#FFFFFF' font 'DejaVu Sans,13'", width, height) : \
  sprintf("set terminal pngcairo size %d,%d font 'DejaVu Sans,10' fontscale 2 linewidth 2 pointscale 2", \
    2 * width, 2 * height)
output(name, format) = sprintf("set output '%s/%s.%s'", folder, name, format)

do for [format in 'svg png'] {
  # As figure 3 of ViCTORiA. Left: an image in the colours of the classes, and a scan line between two white ones. Right: its
  # transitions, rows and columns in the order of the classes, whose colours stand beside them. Frequent transitions are dark, with
  # a gamma of 0.25.
  eval terminal(format, 1080, 480)
  eval output('transitions', format)
  set multiplot layout 1,2 margins char 2,char 3,char 4,char 1 spacing char 9,char 0
  set size ratio -1
  unset grid
  unset key
  unset colorbox
  unset tics
  unset border
  unset xlabel
  unset ylabel
  plot result('classes.png') binary filetype=png with rgbimage
  set border
  set tics nomirror out scale 0.6
  set datafile separator ','
  set palette defined (0 '#FFFFFF', 1 '#000000')
  set cbrange [0:1]
  set xlabel 'followed by class'
  set ylabel 'class'
  set xtics 0,1
  set ytics 0,1
  set xrange [-1.6:7.6]    # eight classes
  set yrange [7.6:-1.6]
  plot result('transitions.csv') skip 9 using 3:2:($4 ** 0.25) with image, \
    '' using (-1.0):(strcol(1) eq 'class' ? $2 : NaN):4 with points pt 5 ps 3 lc rgb variable, \
    '' using (strcol(1) eq 'class' ? $2 : NaN):(-1.0):4 with points pt 5 ps 3 lc rgb variable
  unset multiplot
  set datafile separator whitespace
  set size noratio
  set autoscale
  set xtics autofreq
  set ytics autofreq
  set grid ls 9

  # (a) As figure 4 of ViCTORiA: each cell a disc of its angle bins.
  eval terminal(format, 860, 640)
  eval output('cells', format)
  set size ratio -1
  unset grid
  set key default
  set key above horizontal
  set xlabel 'x (m)'
  set ylabel 'y (m)'
  set xrange [1.4:7.6]
  set yrange [1.4:5.6]
  set style fill solid noborder
  plot result('cells-walk.txt') using ($5 == 0 ? $1 : NaN):2:(0.55):3:4 with circles fc rgb '#E4E4E4' title 'not seen yet', \
    '' using ($5 == 1 ? $1 : NaN):2:(0.55):3:4 with circles fc rgb '#56B4E9' title 'learned directions', \
    folder . '/walk/truth.tum' using 2:3 with lines ls 5 title 'walk'
  set size noratio
  set autoscale
  set grid ls 9

  # (b) Updating on and off along another walk.
  eval terminal(format, 1000, 560)
  eval output('updating', format)
  set datafile separator ','
  set multiplot layout 2,1 margins char 9,char 2,char 3.5,char 2 spacing char 0,char 5
  set key at graph 1,1.01 bottom right horizontal samplen 3
  set ylabel 'error of heading (deg)'
  do for [model in 'turn walk'] {
    if (model eq 'walk') { set xlabel 'time (s)' } else { unset xlabel }
    set label 1 'Model of the ' . model at graph 0,1 offset 0,0.8 left
    plot result('after-' . model . '-bayes.csv') using ($1 - 400):6 every ::1 with lines ls 1 title 'updating off', \
      result('after-' . model . '-update.csv') using ($1 - 400):6 every ::1 with lines ls 2 title 'updating on'
  }
  unset multiplot
  unset label 1
  set datafile separator whitespace

  # (c) As figure 5: boards that come and go, by the Bayes filter and by the query of the paper.
  do for [method in 'bayes 2013-alone'] {
    eval terminal(format, 860, 460)
    eval output(method eq 'bayes' ? 'boards' : 'boards-2013', format)
    set key default
    set xlabel 'boards around the robot'
    set ylabel 'mean error (rad)'
    set xrange [0.5:10.5]
    set xtics 1
    set yrange [0:*]
    plot for [i = 1:4] result('boards-' . method . '.txt') using 1:(column(i + 1)) with linespoints ls i \
      title 'learned with ' . word('2 6 9 10', i)
  }
  set xtics autofreq

  # (d) Away from the place of learning.
  eval terminal(format, 860, 460)
  eval output('distance', format)
  set key default
  set key above
  set xlabel 'distance from the place of learning (m)'
  set xrange [-0.05:2.55]
  plot result('distance.txt') using 1:4 with linespoints ls 1 title 'one cell, no parallax', \
    '' using 1:2 with linespoints ls 2 title 'one cell', \
    '' using 1:9 with linespoints ls 3 title 'grid, no parallax', \
    '' using 1:7 with linespoints ls 4 title 'grid', \
    '' using 1:11 with linespoints ls 5 title 'grid, victoria-2013, frames alone'
  set autoscale

  # (e) As figure 6: values of Y, U and V of six cameras, before and after the white balance.
  eval terminal(format, 1080, 560)
  eval output('histograms', format)
  set datafile separator ','
  set multiplot layout 2,3 margins char 8,char 2,char 3.5,char 2 spacing char 6,char 4
  unset key
  do for [column in '4 5'] {
    do for [channel in 'Y U V'] {
      set label 1 channel . (column eq '4' ? ' as the cameras have it' : ' after the white balance') at graph 0,1 offset 0,0.7 left
      if (channel eq 'Y') { set ylabel 'frequency' } else { unset ylabel }
      if (column eq '5') { set xlabel 'value' } else { unset xlabel }
      first = channel eq 'Y' ? 0 : 64
      set xrange [first:256 - first]
      plot for [head = 1:6] result('histograms.csv') \
        using (strcol(1) eq 'head-' . head && strcol(2) eq channel ? $3 + 2 : NaN):(column(int(column))) with lines lw 1.5 lc head
    }
  }
  unset multiplot
  unset label 1
  set datafile separator whitespace
  set autoscale
  set output
}
