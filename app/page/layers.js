// What can be switched on and off on the map. Each layer: key (its name for window.ceilmap), text,
// swatch [shape, colour], shown at first or not, and draw(), which makes Leaflet's layer of it.

const statusColours = {tracking: '#009E73', relocalized: '#56B4E9', predicted: '#0072B2',
                       ambiguous: '#E69F00', lost: '#D55E00', 'no pose': '#999999'};
const spotColour = '#CC79A7';
const maxEllipses = 200;  // of one path: more would hide it

const latLng = (x, y) => [y, x];  // Leaflet's order, of CRS.Simple
const toLatLngs = (points) => points.map(([x, y]) => [y, x]);

const linePoints = (path, [begin, end]) =>
  Array.from({length: end - begin}, (_, i) => latLng(path.x[begin + i], path.y[begin + i]));

/** Pixels that a drawn path may be off: at Leaflet's own tolerance circles have corners. */
const curveTolerance = 0.25;

/** Path as a line that breaks where there is no pose; a halo sets it off from the picture. */
function drawPath(path, colour, rank, panes) {
  const lines = path.stretches().map((stretch) => linePoints(path, stretch));
  const line = (pane, options) =>
    L.polyline(lines, {interactive: false, renderer: panes[pane], lineJoin: 'round',
                       smoothFactor: curveTolerance, ...options});
  if (path.role === 'truth') {
    return L.layerGroup([line('halo', {color: themeColour('--halo'), weight: 8, opacity: 0.6}),
                         line('truth', {color: colour, weight: 5.5})]);
  }
  if (path.role === 'before') {
    return L.layerGroup([line('lines', {color: colour, weight: 1.5, dashArray: '2 5'})]);
  }
  // Runs that lie upon each other stay visible: the later, the thinner.
  const weight = Math.max(1.5, 3.5 - 0.8 * rank);
  return L.layerGroup([line('halo', {color: themeColour('--halo'), weight: 6, opacity: 0.6}),
                       line('lines', {color: colour, weight})]);
}

function drawEllipses(path, colour, panes) {
  const step = Math.max(1, Math.ceil(path.length / maxEllipses));
  const rings = [];
  for (let i = 0; i < path.length; i += step) {
    if (path.has(i) && path.knowsSigma(i)) rings.push([toLatLngs(path.ellipseAt(i))]);
  }
  return L.polygon(rings, {interactive: false, renderer: panes.lines, color: colour, weight: 1,
                           fillOpacity: 0.15, smoothFactor: 0});
}

/** Stretches [begin, end) of one status, each reaching the next so that no piece is left out. */
function statusStretches(path) {
  const found = new Map();
  for (const [begin, end] of path.stretches()) {
    let start = begin;
    for (let i = begin + 1; i <= end; ++i) {
      if (i < end && path.status[i] === path.status[start]) continue;
      const name = path.statusAt(start);
      if (!found.has(name)) found.set(name, []);
      found.get(name).push([start, Math.min(i + 1, end)]);
      start = i;
    }
  }
  return found;
}

/** A mark at the last known pose for each gap of frames without one. */
function drawGaps(path, panes) {
  const gaps = path.stretches().map(([, end]) => end).filter((end) => end < path.length);
  return gaps.map((end) => L.circleMarker(latLng(path.x[end - 1], path.y[end - 1]), {
    interactive: false, renderer: panes.marks, radius: 6, weight: 2.5,
    color: statusColours[path.has(end) ? 'no pose' : path.statusAt(end)],
    fillColor: themeColour('--halo'), fillOpacity: 0.9,
  }));
}

function drawStatus(path, panes) {
  const bands = [...statusStretches(path)].map(([name, stretches]) =>
    L.polyline(stretches.map((stretch) => linePoints(path, stretch)), {
      interactive: false, renderer: panes.bands, color: statusColours[name], weight: 12,
      opacity: 0.55, lineCap: 'butt', smoothFactor: curveTolerance,
    }));
  return L.layerGroup([...bands, ...drawGaps(path, panes)]);
}

/** Dots, and ticks of the same length on the screen however far the map is zoomed. */
function drawKeyframes({ids, x, y, yaw}, panes, map) {
  const colour = themeColour('--graph');
  const dots = ids.map((_, i) => L.circleMarker(latLng(x[i], y[i]), {
    interactive: false, renderer: panes.marks, radius: 2.5, color: colour, weight: 1,
    fillColor: themeColour('--halo'), fillOpacity: 1,
  }));
  const ticks = L.polyline([], {interactive: false, renderer: panes.marks, color: colour,
                                weight: 1.25, smoothFactor: 0});
  const turn = () => {
    const length = 9 / map.options.crs.scale(map.getZoom());
    ticks.setLatLngs(ids.map((_, i) => [
      latLng(x[i], y[i]),
      latLng(x[i] + length * Math.cos(yaw[i]), y[i] + length * Math.sin(yaw[i])),
    ]));
  };
  const group = L.layerGroup([ticks, ...dots]);
  group.on('add', () => { turn(); map.on('zoomend', turn); });
  group.on('remove', () => map.off('zoomend', turn));
  return group;
}

function drawEdges(model, kind, options, panes) {
  const {ids, x, y} = model.keyframes;
  const place = new Map(ids.map((id, i) => [id, i]));
  const lines = [];
  for (let i = 0; i < model.edges.from.length; ++i) {
    if (model.edges.kind[i] !== kind) continue;
    const [a, b] = [place.get(model.edges.from[i]), place.get(model.edges.to[i])];
    lines.push([latLng(x[a], y[a]), latLng(x[b], y[b])]);
  }
  return L.polyline(lines, {interactive: false, renderer: panes.lines, smoothFactor: 0, ...options});
}

function drawSpots(spots, panes) {
  return L.layerGroup(spots.map((spot) =>
    L.circleMarker(latLng(spot.x, spot.y), {
      renderer: panes.marks, radius: 8, color: spotColour, weight: 3, fillOpacity: 0.25,
    }).bindTooltip(make('span', {}, spot.text))));
}

function drawAreas(areas, panes) {
  return L.layerGroup(areas.map((area) =>
    L.polygon(area.rings.map(toLatLngs), {
      renderer: panes.lines, color: spotColour, weight: 2, fillOpacity: 0.08, smoothFactor: 0,
    }).bindTooltip(make('span', {}, area.text))));
}

/** Colours of heights, from the lowest to the highest: dark to light, also in print. */
const heightColours = [[48, 18, 59], [65, 69, 171], [57, 118, 186], [31, 158, 137], [94, 201, 98],
                       [190, 215, 52], [253, 231, 80]];

/** @param part  0: lowest, 1: highest. */
function heightColour(part) {
  const at = Math.min(Math.max(part, 0), 1) * (heightColours.length - 1);
  const below = Math.min(Math.floor(at), heightColours.length - 2);
  return heightColours[below].map((value, k) =>
    Math.round(value + (at - below) * (heightColours[below + 1][k] - value)));
}

/**
 * A picture that may be turned: its upper left, upper right and lower left corner [x, y] lie at
 * these places of the page.
 */
const PlacedImage = L.ImageOverlay.extend({
  initialize(image, corners, options) {
    this.corners = toLatLngs(corners);
    L.ImageOverlay.prototype.initialize.call(this, image, allCorners(corners).map(([x, y]) => [y, x]), options);
  },
  _reset() {
    const origin = this._map.getPixelOrigin();
    const place = (corner) => this._map.project(corner).subtract(origin);
    const [at, right, down] = this.corners.map(place);
    this.size = [at.distanceTo(right), at.distanceTo(down)];
    const {style} = this.getElement();
    [style.width, style.height] = this.size.map((length) => `${length}px`);
    this.turn(at, right, down);
  },
  _animateZoom({zoom, center}) {
    const origin = this._map._getNewPixelOrigin(center, zoom);
    this.turn(...this.corners.map((corner) => this._map.project(corner, zoom).subtract(origin)));
  },
  turn(at, right, down) {
    const [u, v] = [right.subtract(at).divideBy(this.size[0]), down.subtract(at).divideBy(this.size[1])];
    this.getElement().style.transform =
      `matrix(${[u.x, u.y, v.x, v.y, at.x, at.y].map((value) => value.toFixed(9)).join()})`;
  },
});

/** The four corners of three. */
const allCorners = ([at, right, down]) =>
  [at, right, down, [right[0] + down[0] - at[0], right[1] + down[1] - at[1]]];

/** The floor plan: below the mosaic. */
function drawPlan(plan, panes) {
  const layers = [];
  if (plan.url) {
    layers.push(new PlacedImage(plan.url, plan.corners, {className: 'plan', pane: 'plan', alt: 'Floor plan'}));
  }
  if (plan.lines.length) {
    layers.push(L.polyline(plan.lines.map(toLatLngs), {interactive: false, renderer: panes.plan,
                                                       color: themeColour('--plan'), weight: 1.25,
                                                       smoothFactor: curveTolerance}));
  }
  return L.layerGroup(layers);
}

/** The heights as a picture, transparent where they are not known. */
function drawHeights(heights) {
  const canvas = make('canvas', {width: heights.columns, height: heights.rows});
  const context = canvas.getContext('2d');
  const picture = context.createImageData(heights.columns, heights.rows);
  const [from, to] = heights.colours_m;
  heights.cells.forEach((cell, i) => {
    if (!cell) return;
    picture.data.set([...heightColour((heights.metres(i) - from) / (to - from || 1)), 255], 4 * i);
  });
  context.putImageData(picture, 0, 0);
  return new PlacedImage(canvas.toDataURL(), heights.placement.corners(heights.extent),
                         {className: 'heights', pane: 'heights', alt: 'Heights', opacity: 0.8});
}

/** The scale: a height of each colour, from the highest to the lowest. */
function heightLegend({lowest_m: lowest, highest_m: highest, colours_m: [from, to]}) {
  const steps = to > from ? heightColours.length - 1 : 0;
  return Object.fromEntries(Array.from({length: steps + 1}, (_, i) => {
    const part = steps ? 1 - i / steps : 0;
    // The colours of the ends are also those of heights beyond.
    const sign = i === 0 && highest > to ? '\u2265 ' : i === steps && lowest < from ? '\u2264 ' : '';
    return [`${sign}${decimals(from + part * (to - from), 2)} m`,
            `rgb(${heightColour(part).join()})`];
  }));
}

/** The layers of graph and spots, of those that the page has. */
function graphLayers(model, panes, map) {
  const layers = [];
  const graph = themeColour('--graph');
  const loop = themeColour('--loop');
  if (model.keyframes.ids.length) {
    layers.push({key: 'keyframes', text: 'Keyframes', swatch: ['dot', graph], shown: false,
                 draw: () => drawKeyframes(model.keyframes, panes, map)});
  }
  if (model.edges.kind.includes('w')) {
    layers.push({key: 'ways', text: 'Edges between keyframes', swatch: ['line', graph],
                 shown: false, draw: () => drawEdges(model, 'w', {color: graph, weight: 1}, panes)});
  }
  if (model.edges.kind.includes('l')) {
    layers.push({key: 'loops', text: 'Loop closures', swatch: ['line', loop], shown: false,
                 draw: () => drawEdges(model, 'l', {color: loop, weight: 1.5, opacity: 0.8}, panes)});
  }
  if (model.areas.length) {
    layers.push({key: 'areas', text: 'Changes', swatch: ['frame', spotColour], shown: true,
                 draw: () => drawAreas(model.areas, panes)});
  }
  if (model.spots.length) {
    layers.push({key: 'spots', text: 'Weak spots', swatch: ['ring', spotColour], shown: true,
                 draw: () => drawSpots(model.spots, panes)});
  }
  return layers;
}

/** Uncertainty and status of the runs, of those that the page knows. */
function qualityLayers(model, panes) {
  const layers = [];
  const runs = model.paths.filter((path) => path.role === 'run');
  const known = runs.filter((path) => path.sigmas);
  if (known.length) {
    layers.push({key: 'ellipses', text: 'Uncertainty, 2\u03c3', swatch: ['ring', themeColour('--text')],
                 shown: false, draw: () => L.layerGroup(known.map((path) =>
                   drawEllipses(path, colourOf(model, path.name), panes)))});
  }
  if (runs.some((path) => /[^t]/.test(path.status) || path.stretches().length > 1)) {
    layers.push({key: 'status', text: 'Status', swatch: ['band', statusColours.tracking],
                 legend: statusColours, shown: false,
                 draw: () => L.layerGroup(runs.map((path) => drawStatus(path, panes)))});
  }
  return layers;
}

/** All layers of the page, from the lowest up, with keys that no two share. */
function pageLayers(model, panes, map) {
  const plan = !model.plan ? [] : [{key: 'plan', text: 'Floor plan',
    swatch: ['line', themeColour('--plan')], shown: true, draw: () => drawPlan(model.plan, panes)}];
  const ceiling = !model.heights ? [] : [{
    key: 'heights', text: 'Height above the floor',
    swatch: ['band', `rgb(${heightColours[2].join()})`], legend: heightLegend(model.heights),
    shown: false, draw: () => drawHeights(model.heights)}];
  const fixed = [...ceiling, ...qualityLayers(model, panes), ...graphLayers(model, panes, map)];
  const taken = new Set(['mosaic', 'plan', 'views', ...fixed.map((layer) => layer.key)]);
  const order = {truth: 0, before: 1, run: 2};
  const sorted = [...model.paths].sort((a, b) => order[a.role] - order[b.role]);
  const runs = sorted.filter((path) => path.role === 'run');
  const paths = sorted.map((path) => {
    const colour = colourOf(model, path.name);
    return {key: taken.has(path.name) ? `${path.name} (path)` : path.name, text: path.name, path,
            swatch: [path.role === 'before' ? 'dashes' : 'line', colour], shown: true,
            draw: () => drawPath(path, colour, runs.indexOf(path), panes)};
  });
  return [...plan, ...paths, ...fixed];
}
