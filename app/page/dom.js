// Small helpers: elements, colours, numbers.

/** A new element. Text children are put in as text, whatever characters they have. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== false) element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children);
  return element;
}

function makeSvg(tag, attributes = {}, ...children) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

const byId = (id) => document.getElementById(id);

/** The value of a colour of page.css under the theme of now. */
const themeColour = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** A sample of a line or a mark, for lists; `shape` is a class of page.css. */
function makeSwatch(shape, colour) {
  const swatch = make('span', {class: `swatch ${shape}`, 'aria-hidden': 'true'});
  swatch.style.color = colour;
  return swatch;
}

/** A number with so many decimals, with the minus sign of typography; empty when not known. */
function decimals(value, digits) {
  if (!Number.isFinite(value)) return '';
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace('-', '') : text.replace('-', '\u2212');
}

/** A number with about four digits, for values of any size. */
function fourDigits(value) {
  if (!Number.isFinite(value)) return '\u2013';
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) {
    return value.toExponential(2).replace('-', '\u2212');
  }
  return decimals(value, size >= 1000 ? 0 : size >= 100 ? 1 : size >= 10 ? 2 : size >= 1 ? 3 : 4);
}

/** Index of the last of ascending `values` that is <= limit; -1: none. */
function lastAtOrBefore(values, limit) {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= limit) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Index of the value of ascending `values` nearest to `wanted`; -1: there is none. */
function nearestIndex(values, wanted) {
  const below = lastAtOrBefore(values, wanted);
  if (below < 0) return values.length ? 0 : -1;
  if (below + 1 === values.length) return below;
  return wanted - values[below] <= values[below + 1] - wanted ? below : below + 1;
}
