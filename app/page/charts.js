// The charts, by Dygraphs. Titles, labels and legends are the page's own elements: Dygraphs would
// take text for HTML.

// Its legend sets styles that the page's Content-Security-Policy refuses.
Dygraph.PLUGINS = Dygraph.PLUGINS.filter((plugin) => plugin !== Dygraph.Plugins.Legend);

/** One row per x of any curve: [x, y, y, ...], null where a curve has no point, NaN where a gap. */
function mergedRows(series) {
  const next = series.map(() => 0);
  const rows = [];
  while (true) {
    let x = Infinity;
    series.forEach((one, k) => { if (next[k] < one.x.length) x = Math.min(x, one.x[next[k]]); });
    if (x === Infinity) return rows;
    rows.push([x, ...series.map((one, k) =>
      (next[k] < one.x.length && one.x[next[k]] === x ? one.y[next[k]++] : null))]);
  }
}

class Chart {
  /** @param page  {model, onPick(stamp), onZoom(chart, range)} */
  constructor(json, page) {
    this.json = json;
    this.page = page;
    this.values = json.series.map(() => make('span', {class: 'value'}));
    this.plot = make('div', {class: 'plot'});
    this.frame = make('div', {class: 'plot-frame'}, this.plot);
    this.element = make('figure', {class: 'chart', 'aria-label': json.title},
      make('figcaption', {}, make('h2', {}, json.title), this.legend()),
      make('p', {class: 'y-label'}, json.y_label), this.frame,
      make('p', {class: 'x-label'}, json.x_label));
    this.cursors = (json.over_time ? [null] : json.series).map((series) => {
      const cursor = make('div', {class: 'cursor'});
      if (series) cursor.style.color = this.colour(series.name);
      this.frame.append(cursor);
      return cursor;
    });
    this.time = page.model.firstStamp;
  }

  colour(name) { return colourOf(this.page.model, name); }

  legend() {
    return make('ul', {class: 'legend'}, ...this.json.series.map((series, k) =>
      make('li', {}, makeSwatch('line', this.colour(series.name)), series.name, ' ', this.values[k])));
  }

  options() {
    return {
      labels: ['x', ...this.json.series.map((_, k) => `curve ${k}`)],
      colors: this.json.series.map((series) => this.colour(series.name)),
      axisLineColor: themeColour('--line'),
      gridLineColor: themeColour('--grid'),
    };
  }

  /** Draws; the element must be on the page, which gives it its size. */
  draw() {
    const rows = mergedRows(this.json.series);
    if (!rows.length) {
      this.plot.append(make('p', {class: 'empty'}, 'no data'));
      return;
    }
    const {touchstart, touchmove, touchend, ...model} = Dygraph.defaultInteractionModel;
    this.graph = new Dygraph(this.plot, rows, {
      ...this.options(),
      connectSeparatedPoints: true, strokeWidth: 1.5, axisLabelFontSize: 11,
      highlightCircleSize: 3, gridLineWidth: 1, rightGap: 12, yRangePad: 6, xRangePad: 2,
      digitsAfterDecimal: 4, maxNumberWidth: 7,
      axes: {x: {pixelsPerLabel: 56}, y: {axisLabelWidth: 46, pixelsPerLabel: 32}},
      resizable: 'passive',
      // Fingers scroll the page; a tap is a click.
      interactionModel: model,
      clickCallback: (event) => this.pick(event),
      zoomCallback: (from, to) => this.page.onZoom(this, [from, to]),
      drawCallback: (graph) => this.placeCursors(graph),
      highlightCallback: (event, x) => this.showValues(x),
      unhighlightCallback: () => this.showValues(null),
    });
  }

  /** A click leads to the stamp there: of the curve that is nearest. */
  pick(event) {
    const box = this.plot.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    if (this.json.over_time) {
      this.page.onPick(this.page.model.firstStamp + this.graph.toDataXCoord(x));
      return;
    }
    let nearest = Infinity;
    for (const series of this.json.series) {
      const i = nearestIndex(series.x, this.graph.toDataXCoord(x));
      if (i < 0 || !series.stamps.length) continue;
      const height = this.graph.toDomYCoord(series.y[i]) - y;
      const distance = Math.hypot(this.graph.toDomXCoord(series.x[i]) - x, height || 0);
      if (distance < nearest) {
        nearest = distance;
        this.page.onPick(series.stamps[i]);
      }
    }
  }

  /** Place of the slider's time on the x axis, for a curve; NaN: it is not there. */
  cursorX(series) {
    if (this.json.over_time) return this.time - this.page.model.firstStamp;
    return series.x[lastAtOrBefore(series.stamps, this.time + halfStampStep)] ?? NaN;
  }

  setTime(time) {
    this.time = time;
    if (!this.graph) return;
    this.placeCursors(this.graph);
    this.showValues(null);
  }

  placeCursors(graph) {
    const {x: left, y: top, w: width, h: height} = graph.getArea();
    this.cursors.forEach((cursor, k) => {
      const x = graph.toDomXCoord(this.cursorX(this.json.series[k]));
      cursor.hidden = !(x >= left - 0.5 && x <= left + width + 0.5);
      cursor.style.transform = `translateX(${x}px)`;
      cursor.style.top = `${top}px`;
      cursor.style.height = `${height}px`;
    });
  }

  /** @param x  where the pointer is; null: the slider's time. */
  showValues(x) {
    this.json.series.forEach((series, k) => {
      const at = x ?? this.cursorX(series);
      const i = Number.isNaN(at) ? -1 : lastAtOrBefore(series.x, at + halfStampStep);
      this.values[k].textContent = i < 0 ? '' : fourDigits(series.y[i]);
    });
  }

  /** Stretch of x that is shown. */
  range() { return this.graph ? this.graph.xAxisRange() : null; }

  zoomTo(range) {
    if (this.graph) this.graph.updateOptions({dateWindow: range});
  }

  recolour() {
    if (!this.graph) return;
    this.graph.updateOptions(this.options());
    this.element.querySelector('.legend').replaceWith(this.legend());
    this.cursors.forEach((cursor, k) => {
      if (!this.json.over_time) cursor.style.color = this.colour(this.json.series[k].name);
    });
  }

  /** Takes over new points of the same curves. */
  update(json) {
    this.json = json;
    if (!this.graph) return;
    this.graph.updateOptions({file: mergedRows(json.series)});
  }
}

/** All charts of the page; those over time show the same stretch of it. */
class Charts {
  constructor(container, onPick) {
    this.container = container;
    this.page = {onPick, onZoom: (from, range) => this.zoom(from, range)};
    this.charts = [];
    this.kind = '';
  }

  show(model) {
    this.page.model = model;
    const kind = JSON.stringify(model.charts.map(({title, x_label, y_label, over_time, series}) =>
      [title, x_label, y_label, over_time, series.map(({name, x}) => [name, x.length > 0])]));
    if (kind === this.kind) {
      this.charts.forEach((chart, k) => chart.update(model.charts[k]));
      return;
    }
    this.kind = kind;
    for (const chart of this.charts) if (chart.graph) chart.graph.destroy();
    this.charts = model.charts.map((json) => new Chart(json, this.page));
    this.container.replaceChildren(...this.charts.map((chart) => chart.element));
    this.container.hidden = !this.charts.length;
    for (const chart of this.charts) chart.draw();
  }

  zoom(from, range) {
    if (!from.json.over_time) return;
    const all = from.graph.isZoomed('x') ? range : null;
    for (const chart of this.charts) {
      if (chart !== from && chart.json.over_time) chart.zoomTo(all);
    }
  }

  setTime(time) { for (const chart of this.charts) chart.setTime(time); }
  recolour() { for (const chart of this.charts) chart.recolour(); }
}
