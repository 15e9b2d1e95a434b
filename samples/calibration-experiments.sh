#!/usr/bin/env bash
# Calibration on simulated robots whose rigs are known: ten upward cameras, mounted up to 15 degrees askew, with and without
# rolling shutters, half of them with fisheye lenses, each calibrated from a turn on the spot and a straight drive, with wheels
# and a gyro; and ten cameras under a mirror that is off the picture's centre, each from a turn. Prints errors, standard deviations
# and their ratio.
#   samples/calibration-experiments.sh [OUTPUT_DIR] [RIGS]     default: samples/out/calibration, 10
# shellcheck disable=SC2154  # values of a rig: draw names them
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
rigs=${2:-10}
prepare "${1:-$root/samples/out/calibration}"
mkdir -p "$out/scenes"

# Random values of a rig ($1, its seed), as NAME=VALUE lines.
draw() {
  awk -v seed="$1" '
    function between(least, most) { return least + (most - least) * rand() }
    BEGIN {
      pi = 4 * atan2(1, 1)
      srand(1000 + seed); for (i = 0; i < 10; ++i) rand()
      printf "axle=%.4f\n", between(-0.1, 0.25)
      printf "side=%.4f\n", between(-0.04, 0.04)
      printf "height=%.3f\n", between(0.3, 0.9)
      printf "ceiling=%.3f\n", between(2.3, 3.2)
      printf "focal=%.1f\n", between(380, 520)
      k1 = seed % 2 ? 0 : between(-0.15, -0.05)
      printf "yaw=%.3f\n", between(-8, 8)
      between(0, 1); between(0, 1)
      printf "start=%.1f\n", between(0, 360)
      printf "course=%.1f\n", between(-25, 25)
      printf "length=%.2f\n", between(2, 4)
      printf "mirror_focal=%.1f\n", between(440, 560)
      printf "mirror_u=%.2f\n", between(-8, 8)
      printf "mirror_v=%.2f\n", between(-8, 8)
      printf "body=%.1f\n", between(-70, -50)
      printf "forward_yaw=%.3f\n", between(-6, 6)
      printf "forward_pitch=%.3f\n", between(-5, 15)
      printf "forward_roll=%.3f\n", between(-3, 3)
      tilt = between(0, 15) * pi / 180
      way = between(0, 2 * pi)
      printf "pitch=%.3f\n", 180 / pi * atan2(sin(tilt) * cos(way), sqrt(1 - (sin(tilt) * cos(way)) ^ 2))
      printf "roll=%.3f\n", 180 / pi * atan2(sin(tilt) * sin(way), cos(tilt))
      printf "readout=%.4f\n", seed % 5 ? between(-0.033, 0.033) : 0
      wide = between(100, 170) * pi / 360  # half of the diagonal
      if (seed % 2) {
        printf "model=plumb_bob\ndistortion=%.3f, 0, 0, 0, 0\n", k1
      } else {
        printf "focal=%.1f\n", 400 / (wide - 0.02 * wide ^ 3 + 0.005 * wide ^ 5)
        printf "model=equidistant\ndistortion=-0.02, 0.005, 0, 0\n"
      }
      printf "wheel_error=%.4f\ntrack_error=%.4f\n", between(-0.03, 0.03), between(-0.04, 0.04)
      printf "wheels_late=%.4f\ngyro_late=%.4f\n", between(-0.03, 0.05), between(-0.03, 0.05)
      printf "gyro_bias=%.4f\n", between(-0.6, 0.6)
    }'
}

# The scene of a rig whose values are set, along the poses of a file ($1); noise and ceiling by a seed ($2).
scene() {
  cat <<SCENE
seed: $2
axle_behind_mast_m: $axle
room:
  length_m: 9
  width_m: 7
  height_m: $ceiling
  wall_brightness: 0.32
  wall_posters_per_100m2: 45
  floor_contrast: 0.12
ceiling: {kind: tiles, lamp_every_x: 5, lamp_every_y: 4, vents_per_100m2: 3}
fixtures: {sprinklers_per_100m2: 10, ducts_per_100m2: 2}
camera:
  focal_px: $focal
  distortion_model: $model
  distortion: [$distortion]
  readout_time_s: $readout
  mount_y_m: $side
  mount_height_m: $height
  mount_yaw_deg: $yaw
  mount_pitch_deg: $pitch
  mount_roll_deg: $roll
forward:
  mount_height_m: 0.45
  mount_yaw_deg: $forward_yaw
  mount_pitch_deg: $forward_pitch
  mount_roll_deg: $forward_roll
wheels:
  scale_error_ratio: $wheel_error
  track_width_error_ratio: $track_error
  translation_noise_per_sqrt_m: 0.002
  yaw_noise_deg_per_sqrt_m: 0.4
  encoder_step_m: 0.0005
  clock_offset_s: $wheels_late
gyro: {noise_deg_s: 0.1, bias_deg_s: $gyro_bias, bias_walk_deg_s_per_sqrt_s: 0.002, clock_offset_s: $gyro_late}
picture: {exposure_drift: 0.02}
path: {kind: tum, tum_file: $1}
SCENE
}

# A room with a camera under a mirror whose values are set; the upward camera has next to nothing to do.
mirror_scene() {
  cat <<SCENE
seed: $2
axle_behind_mast_m: $axle
room: {length_m: 6, width_m: 5, height_m: 2.6, wall_brightness: 0.32, wall_posters_per_100m2: 45, floor_contrast: 0.12}
ceiling: {kind: tiles, lamp_every_x: 4, lamp_every_y: 3}
camera: {width_px: 32, height_px: 32, focal_px: 30}
omni: {focal_px: $mirror_focal, centre_offset_px: [$mirror_u, $mirror_v], body_below_deg: $body}
path: {kind: tum, tum_file: $1}
SCENE
}

# The radius in the picture of an elevation ($1, degrees) by samples/simulator's mirror.
mirror_radius() {
  awk -v e="$1" -v f="$mirror_focal" 'BEGIN {
    A = 0.028095; B = 0.0234125; C = sqrt(A * A + B * B); e *= 4 * atan2(1, 1) / 180
    # t^2 (sin^2 e / A^2 - cos^2 e / B^2) + 2 t C sin e / A^2 + C^2 / A^2 - 1 = 0, on the upper sheet
    q = sin(e) ^ 2 / A ^ 2 - cos(e) ^ 2 / B ^ 2; h = C * sin(e) / A ^ 2; w = sqrt(h * h - q * (C * C / A / A - 1))
    t = (-h - w) / q; if (t <= 0 || C + t * sin(e) <= 0) t = (-h + w) / q
    print f * t * cos(e) / (2 * C + t * sin(e))
  }'
}

# Part of the way after a number of steps out of all of them; the first three accelerate, the last three brake.
ramp='function ramp(step, steps) {
  if (step < 3) return step * step / 6 / (steps - 3)
  return step > steps - 3 ? 1 - ramp(steps - step, steps) : (step - 1.5) / (steps - 3)
}'

# A full turn about the axle at X ($1), Y ($2), from START_DEG ($3) on, in so many steps ($4, default 72).
turn() {
  awk -v x="$1" -v y="$2" -v start="$3" -v a="$axle" -v steps="${4:-72}" "$ramp"'
  BEGIN {
    pi = 4 * atan2(1, 1)
    for (i = 0; i <= steps; ++i) {
      yaw = (start + 360 * ramp(i, steps)) * pi / 180
      printf "%.6f %.9f %.9f 0 0 0 %.9f %.9f\n", 100 + i / 6, x + a * cos(yaw), y + a * sin(yaw), sin(yaw / 2), cos(yaw / 2)
    }
  }'
}

# From X ($1), Y ($2) ahead on a course in degrees ($3), so far ($4), 6 cm a frame.
ahead() {
  awk -v x="$1" -v y="$2" -v course="$3" -v way="$4" "$ramp"'
  BEGIN {
    yaw = course * 4 * atan2(1, 1) / 180
    steps = int(way / 0.06 + 0.5)
    for (i = 0; i <= steps; ++i) {
      s = way * ramp(i, steps)
      printf "%.6f %.9f %.9f 0 0 0 %.9f %.9f\n", 100 + i / 4, x + s * cos(yaw), y + s * sin(yaw), sin(yaw / 2), cos(yaw / 2)
    }
  }'
}

# What is known before: the cameras' intrinsics and heights, that one looks up and one ahead.
rough() {
  awk -v z="$height" '
    BEGIN { turn = "[0, 0, 0.707106781, 0.707106781]" }
    /^a:/ { print "a: 0"; next }
    /^h:/ { next }
    / translation:/ { print "      translation: [0, 0, " z "]"; next }
    /^  forward:/ { z = 0.45; turn = "[-0.5, 0.5, -0.5, 0.5]" }
    / rotation_xyzw:/ { print "      rotation_xyzw: " turn; next }
    / matrix: \[/ { next }
    / readout_time_s:/ { next }
    { print }' "$1"
}

# Field ($3) of a parameter ($2) in a summary ($1), where each key stands on a line of its own.
field() {
  awk -v parameter="\"$2\":" -v key="\"$3\":" '
    $1 == parameter { inside = 1 }
    inside && $1 == key { sub(/,$/, "", $2); print $2; exit }' "$1"
}

# A line of a parameter ($3) of a rig ($2) by its summary ($1): its truth ($4), and the unit of its errors ($5 of it).
compare() {
  local value sigma
  value=$(field "$1" "$3" value)
  sigma=$(field "$1" "$3" sigma)
  awk -v rig="$2" -v name="$3" -v truth="$4" -v value="$value" -v sigma="$sigma" -v unit="$5" 'BEGIN {
    error = value - truth
    printf "%s,%s,%.9g,%.9g,%.4f,%.4f,%.3f\n", rig, name, truth, value, unit * error, unit * sigma, (sigma > 0 ? error / sigma : 0)
  }'
}

# The table of a file of such lines ($1).
tell() {
  awk -F, 'NR > 1 {
    if (!($2 in count)) order[++kinds] = $2
    ++count[$2]; square[$2] += $5 * $5; sigma[$2] += $6 * $6; ratio[$2] += $7 * $7
    size = $5 < 0 ? -$5 : $5; if (size > most[$2]) most[$2] = size
    far = $7 < 0 ? -$7 : $7; if (far > farthest[$2]) farthest[$2] = far
  }
  END {
    unit["a_m"] = unit["camera_y_m"] = unit["distance_m"] = "mm"
    unit["readout_ms"] = unit["wheels_late_ms"] = unit["gyro_late_ms"] = "ms"
    unit["wheel_scale"] = unit["turn_scale"] = "%"; unit["gyro_bias_deg_s"] = "deg/s"
    unit["yaw_deg"] = unit["pitch_deg"] = unit["roll_deg"] = "deg"
    unit["forward_yaw_deg"] = unit["forward_pitch_deg"] = unit["forward_roll_deg"] = "deg"
    unit["centre_u_px"] = unit["centre_v_px"] = unit["outer_radius_px"] = unit["inner_radius_px"] = "px"
    printf "%-16s %9s %9s %9s %12s %12s\n", "", "RMS", "largest", "sigma", "error/sigma", "largest"
    for (i = 1; i <= kinds; ++i) {
      k = order[i]
      printf "%-16s %9.4f %9.4f %9.4f %12.2f %12.2f  %s\n", k, sqrt(square[k] / count[k]), most[k],
        sqrt(sigma[k] / count[k]), sqrt(ratio[k] / count[k]), farthest[k], unit[k]
    }
  }' "$1"
}

results=$out/rigs.csv
mirrors=$out/mirrors.csv
for file in "$results" "$mirrors"; do echo "rig,parameter,truth,value,error,sigma,ratio" >"$file"; done
for ((rig = 1; rig <= rigs; ++rig)); do
  echo "rig $rig"
  values=$(draw "$rig")
  while IFS='=' read -r name value; do declare "$name=$value"; done <<<"$values"
  turn 4.5 3.5 "$start" >"$out/scenes/spin-$rig.tum"
  ahead 2.2 3.4 "$course" "$length" >"$out/scenes/straight-$rig.tum"
  for drive in spin straight; do
    scene "$drive-$rig.tum" "$((100 * rig + ${#drive}))" >"$out/scenes/$drive-$rig.yaml"
    if [[ ! -f $out/$drive-$rig/rig.yaml ]]; then
      "$ceilmap" simulate "$out/scenes/$drive-$rig.yaml" --quiet --force -o "$out/$drive-$rig"
    fi
  done
  rough "$out/spin-$rig/rig.yaml" >"$out/rough-$rig.yaml"
  "$ceilmap" calibrate rig --force --quiet --rig "$out/rough-$rig.yaml" --spin "$out/spin-$rig/up.mp4" \
    --straight "$out/straight-$rig/up.mp4" --distance "$length" --spin-stamps "$out/spin-$rig/frames.csv" \
    --straight-stamps "$out/straight-$rig/frames.csv" --spin-forward "$out/spin-$rig/forward.mp4" \
    --straight-forward "$out/straight-$rig/forward.mp4" --spin-odometry "$out/spin-$rig/odometry.csv" \
    --straight-odometry "$out/straight-$rig/odometry.csv" --spin-gyro "$out/spin-$rig/gyro.csv" \
    --straight-gyro "$out/straight-$rig/gyro.csv" -o "$out/rig-$rig.yaml" --summary "$out/rig-$rig.json"
  summary=$out/rig-$rig.json
  {
    compare "$summary" "$rig" a_m "$axle" 1000
    compare "$summary" "$rig" camera_y_m "$side" 1000
    compare "$summary" "$rig" yaw_deg "$(awk -v y="$yaw" 'BEGIN { print 90 + y }')" 1
    compare "$summary" "$rig" pitch_deg "$pitch" 1
    compare "$summary" "$rig" roll_deg "$roll" 1
    compare "$summary" "$rig" readout_ms "$(awk -v s="$readout" 'BEGIN { print 1000 * s }')" 1
    compare "$summary" "$rig" forward_yaw_deg "$forward_yaw" 1
    compare "$summary" "$rig" forward_pitch_deg "$forward_pitch" 1
    compare "$summary" "$rig" forward_roll_deg "$forward_roll" 1
    compare "$summary" "$rig" wheel_scale "$(awk -v e="$wheel_error" 'BEGIN { print 1 / (1 + e) }')" 100
    compare "$summary" "$rig" turn_scale "$(awk -v e="$track_error" 'BEGIN { print 1 / (1 + e) }')" 100
    compare "$summary" "$rig" wheels_late_ms "$(awk -v s="$wheels_late" 'BEGIN { print 1000 * s }')" 1
    compare "$summary" "$rig" gyro_bias_deg_s "$gyro_bias" 1
    compare "$summary" "$rig" gyro_late_ms "$(awk -v s="$gyro_late" 'BEGIN { print 1000 * s }')" 1
    compare "$summary" "$rig" distance_m "$(awk -v h="$ceiling" -v z="$height" 'BEGIN { print h - z }')" 1000
  } >>"$results"

  turn 2.6 2.3 "$start" 36 >"$out/scenes/mirror-$rig.tum"
  mirror_scene "mirror-$rig.tum" "$((100 * rig + 7))" >"$out/scenes/mirror-$rig.yaml"
  if [[ ! -f $out/mirror-$rig/rig.yaml ]]; then
    "$ceilmap" simulate "$out/scenes/mirror-$rig.yaml" --quiet --force -o "$out/mirror-$rig"
  fi
  summary=$out/mirror-$rig.json
  "$ceilmap" calibrate mirror --force --quiet --omni "$out/mirror-$rig/omni.mp4" --rig "$out/mirror-$rig/rig.yaml" \
    -o "$out/mirror-$rig.yaml" --summary "$summary"
  {
    compare "$summary" "$rig" centre_u_px "$(awk -v u="$mirror_u" 'BEGIN { print 239.5 + u }')" 1
    compare "$summary" "$rig" centre_v_px "$(awk -v v="$mirror_v" 'BEGIN { print 239.5 + v }')" 1
    compare "$summary" "$rig" outer_radius_px "$(awk '/rim_radius_px:/ { print $2 }' "$out/mirror-$rig/rig.yaml")" 1
    compare "$summary" "$rig" inner_radius_px "$(mirror_radius "$body")" 1
  } >>"$mirrors"
done

printf '\nUpward camera, %s rigs\n' "$rigs"
tell "$results"
printf '\nMirror, %s rigs\n' "$rigs"
tell "$mirrors"
