'use strict';
const errors = [];
addEventListener('error', event => errors.push(event.message));
const byId = id => document.getElementById(id);
// Okabe–Ito, in an order that also differs in lightness.
const COLORS = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#7f7f7f'];
// The same, lighter, for dark ground.
const LIGHTER = ['#56b4e9', '#f0803c', '#2fc79a', '#e39bc6', '#f2b632', '#a6dcff', '#a8a8a8'];
const dark = matchMedia('(prefers-color-scheme: dark)');
const color = arm => (dark.matches ? LIGHTER : COLORS)[arm % COLORS.length];
// The eighth arm has the colour of the first: its lines are dashed, its dots hollow.
const again = arm => arm >= COLORS.length;
const scale = hexes => hexes.map(hex => [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16)));
const VIRIDIS = scale(['440154', '472c7a', '3b518b', '2c718e', '21908d', '27ad81', '5cc863', 'aadc32', 'fde725']);
// Blue over white to orange, which no colour blindness confuses: for values with a sign.
const SIGNED = scale(['053061', '2166ac', '4393c3', '92c5de', 'f7f7f7', 'fdb863', 'e08214', 'b35806', '7f3b08']);

function element(tag, attributes = {}, ...children) {
  const svg = ['svg', 'g', 'path', 'line', 'rect', 'text', 'tspan', 'circle', 'title'].includes(tag);
  const node = svg ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

// A count with every digit.
const count = n => Math.round(n).toString().replace(/\B(?=(\d{3})+$)/g, '\u202f');

function number(x) {
  if (x === 0) return '0';
  const size = Math.abs(x);
  if (size >= 1e6 || size < 1e-3) return x.toExponential(1).replace('e+', 'e').replace('.0e', 'e').replace('-', '−');
  const text = size >= 1000 ? count(x) : String(+x.toPrecision(3));
  return text.replace('-', '−');
}

// A number, and in brackets the interval around it if there is one.
function withInterval(value, low, high) {
  const around = low !== undefined && low !== null && high !== null && high > low;
  return number(value) + (around ? ` [${number(low)}, ${number(high)}]` : '');
}

function swatch(arm) {
  const node = element('i', { class: again(arm) ? 'swatch hollow' : 'swatch' });
  node.style.setProperty('--color', color(arm));
  return node;
}

function ramp(colors, share) {
  const place = Math.min(Math.max(share, 0), 1) * (colors.length - 1);
  const below = Math.min(Math.floor(place), colors.length - 2);
  return colors[below].map((low, i) => Math.round(low + (place - below) * (colors[below + 1][i] - low)));
}
const paint = (colors, share) => `rgb(${ramp(colors, share)})`;

// The numbers of a text of two digits in base 64 each; level 4095 is none.
const DIGITS = new Map([...'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/'].map((c, i) => [c, i]));
function unpack({ low, high, levels }) {
  const values = new Array(levels.length / 2);
  for (let i = 0; i < values.length; i++) {
    const level = 64 * DIGITS.get(levels[2 * i]) + DIGITS.get(levels[2 * i + 1]);
    values[i] = level === 4095 ? null : low + level / 4094 * (high - low);
  }
  return values;
}

function css(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }
