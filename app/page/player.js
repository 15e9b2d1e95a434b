// The time: slider, play and pause, speed, keyboard.

const speeds = [0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];

class Player {
  /** @param onTime  called with each new time. */
  constructor(onTime) {
    this.onTime = onTime;
    this.slider = byId('slider');
    this.button = byId('play');
    this.clock = byId('clock');
    this.speed = byId('speed');
    this.first = this.last = this.time = 0;
    this.stamps = [];
    this.playing = false;
    for (const speed of speeds) {
      const option = make('option', {value: speed}, `\u00d7${speed}`);
      option.selected = speed === 1;
      this.speed.append(option);
    }
    this.slider.addEventListener('input', () => this.go(this.first + Number(this.slider.value)));
    this.button.addEventListener('click', () => this.play(!this.playing));
    document.addEventListener('keydown', (event) => this.onKey(event));
    this.play(false);
  }

  /** Takes over the stretch of time. At its end, the time goes with it: a run is followed. */
  show(model) {
    const follows = this.atEnd() && this.model.state.running && !this.playing;
    const fresh = !this.model;
    this.model = model;
    this.first = model.firstStamp;
    this.last = model.lastStamp;
    this.stamps = mergedStamps(model);
    this.slider.max = String(Math.max(this.last - this.first, 1e-6));
    const wanted = follows || (fresh && model.state.running) ? this.last : fresh ? this.first : this.time;
    this.go(wanted);
  }

  atEnd() { return Boolean(this.model) && this.time >= this.last - halfStampStep; }

  go(time) {
    this.time = Math.min(Math.max(time, this.first), this.last);
    const seconds = this.time - this.first;
    this.slider.value = String(seconds);
    this.clock.textContent = `${seconds.toFixed(2)} s`;
    this.clock.title = `stamp ${this.time.toFixed(6)}`;
    this.slider.setAttribute('aria-valuetext', `${seconds.toFixed(2)} seconds`);
    this.onTime(this.time);
  }

  play(playing) {
    this.playing = playing;
    this.button.classList.toggle('playing', playing);
    this.button.setAttribute('aria-label', playing ? 'Pause' : 'Play');
    if (!playing) return;
    if (this.atEnd()) this.go(this.first);
    let before = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      this.go(this.time + Math.max(0, now - before) / 1000 * Number(this.speed.value));
      before = now;
      if (this.atEnd()) this.play(false);
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /** To the pose after (+1) or before (-1) the time. */
  step(direction) {
    const here = lastAtOrBefore(this.stamps, this.time + halfStampStep);
    const onPose = here >= 0 && this.time - this.stamps[here] <= halfStampStep;
    const next = direction > 0 ? here + 1 : onPose ? here - 1 : here;
    if (next >= 0 && next < this.stamps.length) this.go(this.stamps[next]);
  }

  onKey(event) {
    const target = event.target;
    const typing = target !== this.slider && target.closest('input, select, textarea');
    if (event.ctrlKey || event.metaKey || event.altKey || typing || target.closest('#map')) return;
    if (event.key === ' ' && !target.closest('button, summary, a')) {
      this.play(!this.playing);
    } else if (event.key === 'ArrowRight' || event.key === 'ArrowLeft') {
      this.play(false);
      this.step(event.key === 'ArrowRight' ? 1 : -1);
    } else {
      return;
    }
    event.preventDefault();
  }
}

/**
 * Where the arrow keys stop: stamps of all paths but the truth, else of the truth, else of charts;
 * ascending, each once.
 */
function mergedStamps({paths, charts}) {
  const estimated = paths.filter((path) => path.role !== 'truth');
  const overTime = charts.filter((chart) => chart.over_time).flatMap((chart) => chart.series);
  const kept = [estimated, paths, overTime].find((list) => list.length) ?? [];
  return Float64Array.from(kept.flatMap(({stamps}) => [...stamps])).sort().filter(
    (stamp, i, all) => i === 0 || stamp - all[i - 1] > halfStampStep);
}
