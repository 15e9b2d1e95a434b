#!/usr/bin/env bash
# The experiments of all papers behind ceilmap by one command, and a page with the papers' tables beside ours: Matsumoto et al.
# 2010 (samples/experiments.sh), Labrosse 2004 and 2006 (samples/compass-experiments.sh), ViCTORiA and Sturm & Visser
# (samples/colour-experiments.sh).
#   samples/papers.sh [OUTPUT_DIR]     default: samples/out/experiments; some 45 minutes on two cores, most of it rendering
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
prepare "${1:-$root/samples/out/experiments}" --plots
cmake --build --preset release --target ceilmap_papers_bench
bench=$root/build/release/tests/bench/ceilmap_papers_bench
papers=$root/samples/papers

"$root/samples/experiments.sh" "$out"
"$root/samples/compass-experiments.sh" "$out"
"$root/samples/colour-experiments.sh" "$out"

# What Labrosse plots and leaves open: distances of images, other metrics and colour spaces.
echo "distances and metrics of images"
"$bench" distances "$out/recordings/rotate-right" 20 8 >"$out/perfect.csv"
"$bench" distances "$out/recordings/circle-1" 20 12 >"$out/general.csv"
"$bench" distances "$out/recordings/circle-1" 200 10 >"$out/followers.csv"
"$bench" positions "$(recording pen)" 150 >"$out/positions.csv"
"$bench" metrics "$out"/recordings/{rotate-right,straight-1,circle-1,circle-2,grass-1,car-park} >"$out/metrics.csv"
awk -F, -v OFS=, 'NR == 1 { next }
  !($1 in seen) { seen[$1] = 1; names[++n] = $1 }
  { kind = substr($2, 1, 2) == "Fx" ? "Fx" : $2; value[$1, kind] = $5 }
  END { for (i = 1; i <= n; ++i) print names[i], value[names[i], "2004 smooth"], value[names[i], "Atm 0.6055"],
    value[names[i], "Fx"], value[names[i], "fft"] }' "$out/compass.csv" >"$out/largest.csv"
gnuplot -e "folder = '$out'; last_perfect = 28; last_general = 32" "$papers/labrosse.gp"

# A CSV file as a table, below a caption. Fields in quotes may contain commas.
table() {
  echo "<table><caption>$2</caption>"
  awk '
    function cells(line, tag, row, field, quoted, i, c) {
      row = field = ""
      quoted = 0
      for (i = 1; i <= length(line) + 1; ++i) {
        c = i > length(line) ? "," : substr(line, i, 1)
        if (c == "\"") quoted = !quoted
        else if (c != "," || (quoted && i <= length(line))) field = field c
        else {
          if (tag == "th") gsub("_", " ", field)
          if (field ~ /^-?[0-9]+\.[0-9]+(e[-+][0-9]+)?$/) field = sprintf("%.4g", field)
          row = row "<" tag ">" field "</" tag ">"
          field = ""
        }
      }
      return row
    }
    { print "<tr" ($0 ~ /^[^,]*,paper,/ ? " class=paper" : "") ">" cells($0, NR == 1 ? "th" : "td") "</tr>" }' "$1"
  echo "</table>"
}

# A figure that was drawn, within the page.
figure() {
  [[ -f $1 ]] || return 0
  echo "<figure>"
  sed -n '/<svg/,$p' "$1"
  echo "<figcaption>$2</figcaption></figure>"
}

page() {
  cat <<'HTML'
<!doctype html><html lang=en><meta charset=utf-8><title>ceilmap and the papers</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 980px; margin: 2em auto; padding: 0 1em; color: #222; background: #fff }
h1, h2 { line-height: 1.2 } h2 { margin-top: 2.5em; border-bottom: 1px solid #ccc }
table { border-collapse: collapse; margin: 1.5em 0; font-size: 13px; font-variant-numeric: tabular-nums }
caption { text-align: left; font-weight: 600; padding-bottom: .4em } th { text-align: left; border-bottom: 2px solid #888 }
th, td { padding: .15em .7em .15em 0 } td { border-bottom: 1px solid #eee } tr.paper { background: #f4f1e8 }
figure { margin: 1.5em 0 } figure svg { max-width: 100%; height: auto } figcaption { font-size: 13px; color: #555 }
</style>
<h1>ceilmap and the papers</h1>
<p>The experiments of the papers, repeated with their methods as published and with those of ceilmap. The recordings are simulated
and like those of the papers, not the same; their truth is exact. Rows of the papers are shaded.</p>
<h2>Matsumoto et al. 2010: localization on a ceiling map over debris</h2>
<p>In the paper the error falls from 21 to 2 cm (9.52 %) when the front wheels climb, and from 17 to 2 cm (11.76 %) along and from 9
to 1 cm (11.11 %) across the path when either side climbs too.</p>
HTML
  table "$out/matsumoto.csv" "Largest errors along and across the path, and their ratio to those without compensation (along)"
  figure "$out/experiment-2/localization/errors.svg" "Fig. 7: errors of each frame, experiment 2, on the map of lab-map"
  figure "$out/experiment-2/localization/positions.svg" "Fig. 6: positions on the ceiling map"
  echo "<h2>Labrosse 2004: the visual compass</h2>"
  table "$papers/labrosse2004.csv" "The paper: largest error and error at the end, deg, against a magnetic compass"
  table <(awk -F, 'NR == 1 || $2 ~ /^2004/' "$out/compass.csv") "Its method on our recordings"
  figure "$out/fig-2.svg" "Fig. 2: distance of images to the one at the circle, over the place"
  echo "<h2>Labrosse 2006: performance and limitations</h2>"
  table "$out/compass-tables-3-4.csv" "Tables 3 and 4: each row of the paper, then the published method on our recording of that name"
  table "$papers/labrosse2006-table1.csv" "Table 1 of the paper: normalised amplitude with the best skip and the next"
  table "$out/compass-amplitudes.csv" "The same on our recordings"
  figure "$out/fig-6-8.svg" "Fig. 6 and 8: distance over the shift"
  figure "$out/fig-9.svg" "Fig. 9: the two shapes of the minimum"
  figure "$out/fig-11.svg" "Fig. 11: circle-1, image 200 against itself and the ten that follow"
  figure "$out/fig-12.svg" "Fig. 12: the same near the minima, with both interpolations"
  table "$out/metrics.csv" "Section 5: other metrics and colour spaces, one image of four, compared with the one before, fields of 60 deg"
  echo "<h2>All compasses</h2>"
  figure "$out/largest.svg" "Largest error on each recording"
  table "$out/compass.csv" "All compasses on all recordings"
  figure "$out/compass-circle-1/heading.svg" "Heading by fft, and its error, on circle-1"
  echo "<h2>ViCTORiA 2013, Sturm &amp; Visser 2009: the compass of colours</h2>"
  [[ ! -f $out/victoria.csv ]] || table "$out/victoria.csv" "Experiments 1 to 4 by method"
  for name in transitions cells updating boards distance histograms; do figure "$out/$name.svg" "$name"; done
  echo "</html>"
}
page >"$out/papers.html.part"
mv "$out/papers.html.part" "$out/papers.html"
echo "written $out/papers.html"
