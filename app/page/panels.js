// Lists and tables beside and below the map.

/** The layers as checkboxes. */
class LayerPanel {
  /** @param onToggle, onOpacity  called with the key and what the user wants. */
  constructor(container, onToggle, onOpacity) {
    Object.assign(this, {container, onToggle, onOpacity, signature: ''});
  }

  show(layers) {
    const signature = JSON.stringify(layers.map(({key, text, swatch, opacity}) =>
      [key, text, swatch, opacity !== undefined]));
    if (signature === this.signature) return;  // keeps the keyboard's focus
    this.signature = signature;
    this.container.replaceChildren(...layers.flatMap((layer) => this.entry(layer)));
  }

  entry({key, text, swatch, shown, legend, opacity}) {
    const box = make('input', {type: 'checkbox', 'data-layer': key});
    box.checked = shown;
    const label = make('label', {class: 'layer'}, box, makeSwatch(...swatch), make('span', {}, text));
    const items = [label];
    if (legend) {
      items.push(make('ul', {class: 'legend', hidden: !shown}, ...Object.entries(legend).map(
        ([name, colour]) => make('li', {}, makeSwatch('band', colour), name))));
    }
    if (opacity !== undefined) items.push(this.opacityRow(key, text, opacity));
    box.addEventListener('change', () => {
      if (legend) items[1].hidden = !box.checked;
      this.onToggle(key, box.checked);
    });
    return items;
  }

  opacityRow(key, text, opacity) {
    const range = make('input', {type: 'range', min: 0, max: 1, step: 0.05, value: opacity,
                                 'data-opacity': key, 'aria-label': `Opacity: ${text}`});
    range.addEventListener('input', () => this.onOpacity(key, Number(range.value)));
    return make('label', {class: 'opacity'}, 'opacity', range);
  }
}

/** Where each robot is at the slider's time; below each number its standard deviation. */
class Readout {
  constructor(table) { this.table = table; }

  show(model) {
    this.model = model;
    this.paths = model.paths.filter((path) => path.role !== 'before');
    const columns = ['', `x (${model.unit})`, `y (${model.unit})`, 'yaw (\u00b0)'];
    const spans = (name) =>
      this.paths.map(() => columns.slice(1).map(() => make('span', {class: name})));
    this.values = spans('value');
    this.sigmas = spans('sigma');
    this.statuses = this.paths.map(() => make('span', {class: 'status'}));
    this.table.replaceChildren(
      make('thead', {}, make('tr', {}, ...columns.map((text, k) =>
        make('th', {scope: 'col', class: k ? 'number' : ''}, text)))),
      make('tbody', {}, ...this.paths.map((path, row) => this.row(path, row))));
  }

  row(path, row) {
    const name = make('div', {class: 'robot-name'},
      makeSwatch('line', colourOf(this.model, path.name)),
      make('span', {}, path.name, this.statuses[row]));
    return make('tr', {}, make('th', {scope: 'row'}, name), ...this.values[row].map((value, k) =>
      make('td', {class: 'number'}, value, this.sigmas[row][k])));
  }

  setTime(time) {
    const digits = this.model.unit === 'm' ? 3 : 1;
    const degrees = 180 / Math.PI;
    this.paths.forEach((path, row) => {
      const {index, shown, status, x, y, yaw} = path.poseAt(time);
      const values = [decimals(x, digits), decimals(y, digits), decimals(yaw * degrees, 2)];
      const sigmas = shown && path.knowsSigma(index)
        ? [decimals(path.sigmas.x[index], digits + 1), decimals(path.sigmas.y[index], digits + 1),
           decimals(path.sigmas.yaw[index] * degrees, 3)] : [];
      values.forEach((text, k) => {
        this.values[row][k].textContent = shown ? text : '';
        this.sigmas[row][k].textContent = sigmas[k] ? `\u00b1${sigmas[k]}` : '';
      });
      this.statuses[row].textContent = path.role === 'truth' && shown ? '' : status;
      this.statuses[row].dataset.status = status;
    });
  }
}

const looksLikeNumber = (text) => /^[-+\u2212]?[\d.,\u2009 ]*\d([eE][-+]?\d+)?\s?(%|\u00b0)?$/.test(text);

/** A column whose cells are nearly all numbers is set to the right. */
function numberColumns(table) {
  return table.columns.map((_, k) => {
    const texts = table.rows.map((row) => row[k]).filter((text) => text !== '' && text !== '-');
    return texts.length > 0 && texts.filter(looksLikeNumber).length > texts.length / 2;
  });
}

function makeTable(model, table) {
  const numeric = numberColumns(table);
  const cell = (tag, text, k) => {
    const element = make(tag, {class: numeric[k] ? 'number' : ''}, text);
    if (tag === 'td' && model.paths.some((path) => path.name === text)) {
      element.prepend(makeSwatch('line', colourOf(model, text)));
    }
    return element;
  };
  return make('section', {class: 'table', 'aria-label': table.title},
    make('h2', {}, table.title),
    make('div', {class: 'scroll', tabindex: 0}, make('table', {},
      make('thead', {}, make('tr', {}, ...table.columns.map((text, k) => cell('th', text, k)))),
      make('tbody', {}, ...table.rows.map((row) =>
        make('tr', {}, ...row.map((text, k) => cell('td', text, k))))))));
}

function showTables(container, model) {
  container.replaceChildren(...model.tables.map((table) => makeTable(model, table)));
  container.hidden = !model.tables.length;
}

const progressText = ({running, frames, frames_expected: expected, rate_hz: rate}) =>
  [running ? 'running' : 'ended',
   expected ? `${frames} of ${expected} frames` : frames ? `${frames} frames` : '',
   running && rate ? `${rate.toFixed(1)} frames/s` : ''].filter(Boolean).join(' \u00b7 ');
