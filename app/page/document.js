// What the program writes (document.cpp), as the page works with it: metres, seconds, radians.

const statusNames = {t: 'tracking', r: 'relocalized', p: 'predicted', a: 'ambiguous', l: 'lost'};
const halfStampStep = 5e-7;  // stamps are written in microseconds

/** Columns hold whole multiples of `step`, null where a value is not known. */
const column = (steps, step) =>
  Float64Array.from(steps, (value) => (value === null ? NaN : value * step));

/** Stamps are differences in microseconds, the first to the page's first stamp. */
function stampColumn(differences, first) {
  let sum = 0;
  return Float64Array.from(differences, (difference) => first + (sum += difference) / 1e6);
}

/** More time than this (s) between two of the stamps is a gap: nearly all are much closer. */
function longestStep(stamps) {
  const steps = stamps.slice(1).map((stamp, i) => stamp - stamps[i]).sort();
  const usual = steps.length ? steps[Math.floor(0.95 * (steps.length - 1))] : 0;
  return Math.max(0.3, 3 * usual) + halfStampStep;
}

/** Where the map lies on the page: p_page = scale R(yaw) p_map + (x, y). */
class Placement {
  constructor({scale, x, y, yaw}) {
    Object.assign(this, {x, y, cos: scale * Math.cos(yaw), sin: scale * Math.sin(yaw)});
  }

  toPage(x, y) { return [this.x + this.cos * x - this.sin * y, this.y + this.sin * x + this.cos * y]; }

  toMap(x, y) {
    const [dx, dy] = [x - this.x, y - this.y];
    const square = this.cos ** 2 + this.sin ** 2;
    return [(this.cos * dx + this.sin * dy) / square, (this.cos * dy - this.sin * dx) / square];
  }

  /** Of an extent [minX, minY, maxX, maxY] in the map: upper left, upper right, lower left corner. */
  corners([minX, minY, maxX, maxY]) {
    return [[minX, maxY], [maxX, maxY], [minX, minY]].map(([x, y]) => this.toPage(x, y));
  }
}

/** The lines of a plan: steps of a millimetre from point to point, the first from the origin. */
function planLines({origin: [originX, originY], lines}) {
  return lines.map((steps) => {
    let [u, v] = [0, 0];
    return Array.from({length: steps.length / 2}, (_, i) => {
      u += steps[2 * i];
      v += steps[2 * i + 1];
      return [originX + u / 1000, originY + v / 1000];
    });
  });
}

/** Heights of the ceiling above the floor (m), on a grid of square cells in the map. */
class Heights {
  constructor(json, placement) {
    Object.assign(this, json, {placement});
    const text = atob(json.cells);
    this.cells = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  }

  get extent() {
    const {min_x: minX, max_y: maxY, cell, columns, rows} = this;
    return [minX, maxY - rows * cell, minX + columns * cell, maxY];
  }

  /** Of a cell; NaN where not known. */
  metres(index) {
    return this.cells[index] ? this.lowest_m + (this.cells[index] - 1) * this.step_m : NaN;
  }

  /** At a place of the page; NaN where not known. */
  at(pageX, pageY) {
    const [x, y] = this.placement.toMap(pageX, pageY);
    const column = Math.floor((x - this.min_x) / this.cell);
    const row = Math.floor((this.max_y - y) / this.cell);
    const inside = column >= 0 && column < this.columns && row >= 0 && row < this.rows;
    return inside ? this.metres(row * this.columns + column) : NaN;
  }
}

/** One trajectory. */
class Path {
  constructor(json, firstStamp) {
    this.name = json.name;
    this.role = json.role;
    this.footprint = json.footprint;
    this.status = json.status;
    this.stamps = stampColumn(json.stamps, firstStamp);
    this.x = column(json.x, 1e-4);
    this.y = column(json.y, 1e-4);
    this.yaw = column(json.yaw, 1e-4);
    this.sigmas = json.sigma_x && {
      x: column(json.sigma_x, 1e-6),
      y: column(json.sigma_y, 1e-6),
      yaw: column(json.sigma_yaw, 1e-6),
      correlation: column(json.correlation, 1e-3),
    };
    this.longestStep = longestStep(this.stamps);
  }

  get length() { return this.stamps.length; }
  has(i) { return i >= 0 && !Number.isNaN(this.x[i]); }

  statusAt(i) {
    const name = statusNames[this.status[i]];
    if (this.has(i) || ['predicted', 'ambiguous', 'lost'].includes(name)) return name;
    return 'no pose';
  }

  /**
   * Where the robot is at a time: the nearest pose at or before it. Not shown when the path has
   * none there; then the place is the last one known, if any.
   */
  poseAt(time) {
    const index = lastAtOrBefore(this.stamps, time + halfStampStep);
    const recent = index >= 0 && time - this.stamps[index] <= this.longestStep;
    let place = index;
    while (place >= 0 && !this.has(place)) --place;
    return {
      index: place,
      shown: recent && place === index,
      status: recent ? this.statusAt(index) : 'no pose',
      x: place < 0 ? NaN : this.x[place],
      y: place < 0 ? NaN : this.y[place],
      yaw: place < 0 ? NaN : this.yaw[place],
    };
  }

  /** Pose i follows the one before without a gap: neither frames without a pose nor long time. */
  continues(i) {
    return this.has(i) && this.has(i - 1) && this.stamps[i] - this.stamps[i - 1] <= this.longestStep;
  }

  /** Stretches of poses without a gap, as lists of indices [begin, end). */
  stretches() {
    const found = [];
    for (let i = 0; i < this.length; ++i) {
      if (this.continues(i)) found[found.length - 1][1] = i + 1;
      else if (this.has(i)) found.push([i, i + 1]);
    }
    return found;
  }

  /** Corners [x, y] of the footprint with the robot at pose i. */
  footprintAt(i) {
    const cos = Math.cos(this.yaw[i]);
    const sin = Math.sin(this.yaw[i]);
    return this.footprint.map(([x, y]) =>
      [this.x[i] + cos * x - sin * y, this.y[i] + sin * x + cos * y]);
  }

  knowsSigma(i) { return this.sigmas && i >= 0 && Number.isFinite(this.sigmas.x[i]); }

  /** The ellipse of two standard deviations about pose i, as points [x, y]. */
  ellipseAt(i) {
    const {x: sigmaX, y: sigmaY, correlation} = this.sigmas;
    // Lower triangular root of the covariance: it takes the unit circle to the ellipse.
    const a = sigmaX[i];
    const b = correlation[i] * sigmaY[i];
    const c = sigmaY[i] * Math.sqrt(Math.max(0, 1 - correlation[i] ** 2));
    return Array.from({length: 36}, (_, k) => {
      const cos = 2 * Math.cos(k * Math.PI / 18);
      const sin = 2 * Math.sin(k * Math.PI / 18);
      return [this.x[i] + a * cos, this.y[i] + b * cos + c * sin];
    });
  }
}

/** A chart's curve: x as it is shown, stamps where they are known. It breaks where time does. */
function readSeries(json, overTime, first) {
  const known = stampColumn(json.stamps, first);
  const longest = longestStep(known);
  const [x, y, stamps] = [[], [], []];
  const add = (xHere, yHere, stamp) => {
    x.push(xHere);
    y.push(yHere ?? NaN);
    if (stamp !== undefined) stamps.push(stamp);
  };
  json.y.forEach((value, i) => {
    const xHere = overTime ? known[i] - first : json.x[i];
    const part = longest / (known[i] - known[i - 1]);  // of the way, where the gap begins
    if (part < 1) add(x[x.length - 1] * (1 - part) + xHere * part, NaN, known[i - 1] + longest);
    add(xHere, value, known[i]);
  });
  return {name: json.name, stamps, x, y};
}

/** Everything on the page, from the program's JSON. */
function readDocument(json) {
  const first = json.first_stamp_s;
  const placement = new Placement(json.placement);
  const paths = json.paths.map((path) => new Path(path, first));
  const charts = json.charts.map((chart) => ({
    ...chart, series: chart.series.map((series) => readSeries(series, chart.over_time, first)),
  }));
  const overTime = charts.filter((chart) => chart.over_time).flatMap((chart) => chart.series);
  const ends = [...paths, ...overTime].map(({stamps}) => stamps[stamps.length - 1] ?? first);
  return {
    title: json.title,
    note: json.note,
    unit: json.unit,
    state: json.state,
    plan: json.plan && {url: json.plan.url, corners: json.plan.corners, lines: planLines(json.plan)},
    picture: json.picture && {url: json.picture.url, corners: placement.corners(json.picture.extent)},
    heights: json.heights && new Heights(json.heights, placement),
    paths,
    charts,
    tables: json.tables,
    // In the coordinates of the page, whatever the map's are.
    before: json.before && {url: json.before.url,
                            corners: new Placement({scale: 1, x: 0, y: 0, yaw: 0}).corners(json.before.extent)},
    spots: json.spots,
    areas: json.areas,
    edges: json.edges,
    keyframes: {
      ids: json.keyframes.id,
      x: column(json.keyframes.x, 1e-4),
      y: column(json.keyframes.y, 1e-4),
      yaw: column(json.keyframes.yaw, 1e-4),
    },
    firstStamp: first,
    lastStamp: ends.reduce((a, b) => Math.max(a, b), first),
    colours: assignColours(paths, charts),
  };
}

const runColours = ['#0072B2', '#D55E00', '#E69F00', '#009E73', '#CC79A7', '#56B4E9'];

/**
 * Colour of each name, the same on the map and in all charts: a run's own, or one of the theme's
 * by its name in page.css. A path before compensation has the colour of the run whose name it
 * begins with.
 */
function assignColours(paths, charts) {
  const colours = new Map();
  let next = 0;
  const take = (name) => {
    if (!colours.has(name)) colours.set(name, runColours[next++ % runColours.length]);
  };
  for (const path of paths) if (path.role === 'truth') colours.set(path.name, '--truth');
  for (const path of paths) if (path.role === 'run') take(path.name);
  for (const path of paths) {
    if (path.role !== 'before') continue;
    const run = paths.find((other) => other.role === 'run' && path.name.startsWith(other.name));
    colours.set(path.name, run ? colours.get(run.name) : '--before');
  }
  for (const chart of charts) for (const series of chart.series) take(series.name);
  return colours;
}

function colourOf(model, name) {
  const colour = model.colours.get(name);
  return colour.startsWith('--') ? themeColour(colour) : colour;
}
