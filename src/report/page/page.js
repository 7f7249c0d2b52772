'use strict';
const errors = [];
addEventListener('error', event => errors.push(event.message));
// Everything on the page is drawn from these two: `update` replaces the first, the reader the second.
let data = JSON.parse(document.getElementById('data').textContent);
const hidden = new Set();
const byId = id => document.getElementById(id);
// Okabe–Ito, in an order that also differs in lightness.
const COLORS = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#7f7f7f'];
const VIRIDIS = ['440154', '472c7a', '3b518b', '2c718e', '21908d', '27ad81', '5cc863', 'aadc32', 'fde725']
  .map(hex => [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16)));
const color = arm => COLORS[arm % COLORS.length];

function element(tag, attributes = {}, ...children) {
  const svg = ['svg', 'path', 'line', 'text', 'circle', 'title'].includes(tag);
  const node = svg ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

function number(x) {
  if (x === 0) return '0';
  const size = Math.abs(x);
  if (size >= 1e6 || size < 1e-3) return x.toExponential(1).replace('e+', 'e');
  return size >= 1000 ? Math.round(x).toString().replace(/\B(?=(\d{3})+$)/g, ' ') : String(+x.toPrecision(3));
}

function viridis(share) {
  const place = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
  const below = Math.min(Math.floor(place), VIRIDIS.length - 2);
  const mix = VIRIDIS[below].map((low, i) => Math.round(low + (place - below) * (VIRIDIS[below + 1][i] - low)));
  return `rgb(${mix})`;
}

// --- charts -------------------------------------------------------------------------------------------------

function ticks(low, high, log) {
  const list = [];
  if (log) {
    const every = Math.max(1, Math.ceil((high - low) / 6));
    for (let p = Math.ceil(low); p <= high + 1e-9; p += every) list.push(p);
  } else {
    const rough = (high - low) / 4;
    const unit = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map(m => m * unit).find(s => s >= rough);
    for (let t = Math.ceil(low / step) * step; t <= high + step * 1e-9; t += step) list.push(t);
  }
  return list;
}

// series: {x, y, low?, high?, color, name, dash?}
function chart(parent, { title, xTitle, yTitle, series, log, xlog }) {
  const width = 520, height = 280, left = 62, right = 12, top = 12, bottom = 44;
  const usable = series.filter(s => s.x.length > 0);
  const figure = element('figure', {}, element('figcaption', {}, title));
  parent.append(figure);
  if (!usable.length) { figure.append(element('p', {}, 'Nothing recorded.')); return; }
  const positive = usable.flatMap(s => s.y.filter(v => v > 0));
  const floor = log ? Math.max(1e-12, Math.min(...positive, 1e12)) : -Infinity;
  const f = log ? v => Math.log10(Math.max(v, floor)) : v => v;
  const xs = usable.flatMap(s => [s.x[0], s.x[s.x.length - 1]]);
  const fx = xlog ? x => Math.log10(Math.max(x, 1)) : x => x;
  const x0 = fx(Math.min(...xs)), x1 = Math.max(fx(Math.max(...xs)), x0 + 1);
  let y0 = Infinity, y1 = -Infinity;
  for (const s of usable) for (let i = 0; i < s.y.length; i++) {
    // Bands may leave the picture: where seeds are few they are as wide as they are.
    y0 = Math.min(y0, f(s.y[i]));
    y1 = Math.max(y1, f(s.y[i]));
  }
  if (log) { y0 = Math.floor(y0); y1 = Math.ceil(y1); }
  else { const margin = .06 * (y1 - y0); y0 -= margin; y1 += margin; }
  if (y1 - y0 < 1e-9) { y0 -= 1; y1 += 1; }
  const inside = share => Math.min(Math.max(share, 0), 1);
  const px = x => left + (fx(x) - x0) / (x1 - x0) * (width - left - right);
  const py = y => height - bottom - inside((f(y) - y0) / (y1 - y0)) * (height - top - bottom);
  const last = usable.map(s => `${s.name} ends at ${number(s.y[s.y.length - 1])}`).join('; ');
  const svg = element('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `${title}. ${last}.` });
  for (const t of ticks(y0, y1, log)) {
    const y = height - bottom - (t - y0) / (y1 - y0) * (height - top - bottom);
    svg.append(element('line', { x1: left, x2: width - right, y1: y, y2: y, class: 'grid' }));
    svg.append(element('text', { x: left - 6, y: y + 4, 'text-anchor': 'end' }, number(log ? 10 ** t : t)));
  }
  for (const power of ticks(x0, x1, xlog)) {
    const t = xlog ? 10 ** power : power;
    svg.append(element('line', { x1: px(t), x2: px(t), y1: height - bottom, y2: height - bottom + 5, class: 'axis' }));
    svg.append(element('text', { x: px(t), y: height - bottom + 18, 'text-anchor': 'middle' }, number(t)));
  }
  svg.append(element('line', { x1: left, x2: width - right, y1: height - bottom, y2: height - bottom, class: 'axis' }));
  svg.append(element('text', { x: (left + width - right) / 2, y: height - 6, 'text-anchor': 'middle' }, xTitle));
  svg.append(element('text', { transform: `translate(14 ${(height - bottom + top) / 2}) rotate(-90)`, 'text-anchor': 'middle' }, yTitle));
  const trace = (x, y) => x.map((v, i) => `${i ? 'L' : 'M'}${px(v).toFixed(1)} ${py(y[i]).toFixed(1)}`).join('');
  for (const s of usable) {
    if (s.low) {
      const back = [...s.x].reverse(), low = [...s.low].reverse();
      svg.append(element('path', { d: trace(s.x, s.high) + trace(back, low).replace('M', 'L') + 'Z', fill: s.color, 'fill-opacity': .2 }));
    }
    svg.append(element('path', { d: trace(s.x, s.y), fill: 'none', stroke: s.color, 'stroke-width': 2,
      'stroke-linejoin': 'round', 'stroke-dasharray': s.dash || 'none', 'data-arm': s.arm ?? '' }, element('title', {}, s.name)));
  }
  figure.append(svg, element('p', {}, `${last}.`));
}

const visible = () => data.arms.map((arm, i) => [arm, i]).filter(([arm]) => !hidden.has(arm.name));

function drawCurves() {
  const parent = byId('curves');
  parent.replaceChildren();
  const many = data.arms.some(arm => arm.seeds.length > 1);
  const band = many ? ' (mean, 95 % interval over seeds)' : '';
  const bands = key => visible().map(([arm, i]) => ({ x: arm.episodes, y: arm[key].mean,
    low: arm.seeds.length > 1 ? arm[key].low : null, high: arm.seeds.length > 1 ? arm[key].high : null,
    color: color(i), name: arm.name, arm: i }));
  chart(parent, { title: 'Regret ρ' + band, xTitle: 'episode', yTitle: 'reward, log scale', series: bands('regret'), log: true });
  chart(parent, { title: 'Steps per episode' + band, xTitle: 'episode', yTitle: 'steps, log scale', series: bands('length'), log: true });
  chart(parent, { title: 'Return, as the environment pays it' + band, xTitle: 'episode', yTitle: 'reward', series: bands('plain') });
  chart(parent, { title: 'Shaped return, as the agent learns from it' + band, xTitle: 'episode', yTitle: 'reward', series: bands('shaped') });
}

function drawGrowth() {
  const parent = byId('growth');
  parent.replaceChildren();
  const arms = visible();
  const over = (frames, value) => ({ x: frames.map(f => f.step), y: frames.map(value) });
  chart(parent, { title: 'Graph discovered (solid: states, dashed: edges)', xTitle: 'environment step, log scale', xlog: true, yTitle: 'count',
    series: arms.flatMap(([arm, i]) => [
      { ...over(arm.frames, f => f.nodes), name: `states of ${arm.name}`, color: color(i) },
      { ...over(arm.frames, f => f.edges), name: `edges of ${arm.name}`, color: color(i), dash: '5 4' }]) });
  const arm = data.arms[Number(byId('arm').value)];
  const known = arm.frames.filter(f => f.eigenvalues.length);
  const count = Math.max(0, ...known.map(f => f.eigenvalues.length));
  const eigen = [];
  for (let k = 1; k < count; k++) {
    const frames = known.filter(f => f.eigenvalues.length > k && f.eigenvalues[k] > 1e-12);
    eigen.push({ ...over(frames, f => f.eigenvalues[k]), name: `λ${k + 1}`, color: viridis(k / count) });
  }
  chart(parent, { title: `Eigenvalues of ${arm.name}, without λ1 = 0`, xTitle: 'environment step, log scale', xlog: true, yTitle: 'λ, log scale', series: eigen, log: true });
  const effort = (key, dash) => arms.map(([arm, i]) => {
    const rows = arm.solver.filter(r => r[key] !== null);
    return { x: rows.map(r => r.step), y: rows.map(r => r[key]), name: `${key} of ${arm.name}`, color: color(i), dash };
  });
  chart(parent, { title: 'Effort of the eigensolver in each refresh', xTitle: 'environment step, log scale', xlog: true, yTitle: 'products and solves',
    series: [...effort('applications'), ...effort('solves', '5 4')] });
  chart(parent, { title: 'Loss of the network after each fit', xTitle: 'environment step, log scale', xlog: true, yTitle: 'loss, log scale', series: effort('loss'), log: true });
}

// --- maps ---------------------------------------------------------------------------------------------------

function css(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }

// Places of the states of a graph without a map: second and third eigenvector of the last frame.
function layout(arm) {
  const vectors = arm.frames[arm.frames.length - 1].vectors;
  const [u, v] = [vectors[0] || [], vectors[1] || []];
  const scale = list => {
    const low = Math.min(...list, 0), high = Math.max(...list, low + 1e-9);
    return list.map(x => .06 + .88 * (x - low) / (high - low));
  };
  const [x, y] = [scale(u), scale(v)];
  return arm.cells.map((_, i) => [x[i] ?? .5, y[i] ?? .5]);
}

function paint(canvas, arm, values, { symmetric = false, arrows = null } = {}) {
  const finite = values.filter(v => v !== null && Number.isFinite(v));
  let low = finite.reduce((a, b) => Math.min(a, b), Infinity), high = finite.reduce((a, b) => Math.max(a, b), -Infinity);
  if (symmetric) { high = Math.max(Math.abs(low), Math.abs(high)); low = -high; }
  const share = v => high > low ? (v - low) / (high - low) : .5;
  const map = arm.map;
  canvas.width = 560;
  canvas.height = map ? Math.round(560 * Math.min(map.rows / map.cols, 2)) : 560;
  const g = canvas.getContext('2d');
  g.fillStyle = css('--blank');
  g.fillRect(0, 0, canvas.width, canvas.height);
  if (!map) { paintGraph(g, arm, values, share, canvas.width); return [low, high]; }
  const w = canvas.width / map.cols, h = canvas.height / map.rows;
  const at = cell => [cell % map.cols * w, Math.floor(cell / map.cols) * h];
  const fill = (cell, style) => {
    const [x, y] = at(cell);
    g.fillStyle = style;
    g.fillRect(Math.floor(x), Math.floor(y), Math.ceil(x + w) - Math.floor(x), Math.ceil(y + h) - Math.floor(y));
  };
  for (const cell of map.walls) fill(cell, css('--wall'));
  values.forEach((v, state) => { if (v !== null && arm.cells[state] !== null) fill(arm.cells[state], viridis(share(v))); });
  if (arrows) arrows.forEach((action, state) => {
    if (action === null || arm.cells[state] === null || map.goals.includes(arm.cells[state])) return;
    const [x, y] = at(arm.cells[state]), r = Math.min(w, h) * .3;
    g.save();
    g.translate(x + w / 2, y + h / 2);
    g.rotate(action * Math.PI / 2);
    g.beginPath();
    g.moveTo(0, r); g.lineTo(0, -r); g.moveTo(-r * .6, -r * .3); g.lineTo(0, -r); g.lineTo(r * .6, -r * .3);
    for (const [style, wide] of [['#000', .34], ['#fff', .16]]) { g.strokeStyle = style; g.lineWidth = Math.max(1, r * wide); g.stroke(); }
    g.restore();
  });
  const mark = (cell, letter) => {
    const [x, y] = at(cell), size = Math.max(13, Math.min(w, h) * .62);
    g.font = `700 ${size}px system-ui, sans-serif`;
    g.textAlign = 'center'; g.textBaseline = 'middle'; g.lineJoin = 'round';
    g.strokeStyle = '#000'; g.lineWidth = size / 5; g.strokeText(letter, x + w / 2, y + h / 2);
    g.fillStyle = '#fff'; g.fillText(letter, x + w / 2, y + h / 2);
  };
  if (map.start !== null) mark(map.start, 'S');
  for (const goal of map.goals) mark(goal, 'G');
  return [low, high];
}

function paintGraph(g, arm, values, share, size) {
  const places = layout(arm).map(([x, y]) => [x * size, y * size]);
  g.strokeStyle = css('--wall'); g.lineWidth = 1;
  for (const [a, b] of arm.edges) {
    if (a >= values.length || b >= values.length) continue;
    g.beginPath(); g.moveTo(...places[a]); g.lineTo(...places[b]); g.stroke();
  }
  const radius = Math.max(3, Math.min(12, size / Math.sqrt(values.length + 1) / 5));
  values.forEach((v, i) => {
    if (v === null) return;
    g.beginPath(); g.arc(...places[i], radius, 0, 7); g.fillStyle = viridis(share(v)); g.fill(); g.stroke();
  });
}

function mapFigure(title, arm, values, note, options) {
  const canvas = element('canvas', { role: 'img' });
  const figure = element('figure', {}, element('figcaption', {}, title), canvas);
  byId('maps').append(figure);
  const [low, high] = paint(canvas, arm, values, options);
  const range = Number.isFinite(low) ? `${number(low)} (violet) to ${number(high)} (yellow)` : 'nothing yet';
  canvas.setAttribute('aria-label', `${title}: ${range}, ${values.length} states. ${note}`);
  figure.append(element('p', {}, `${range}. ${note}`));
}

function drawMaps() {
  const arm = data.arms[Number(byId('arm').value)];
  const frame = arm.frames[Number(byId('time').value)];
  byId('maps').replaceChildren();
  const text = `step ${number(frame.step)}: ${frame.nodes} states, ${frame.edges} edges`;
  byId('moment').value = text;
  byId('time').setAttribute('aria-valuetext', text);
  const place = arm.map ? 'Blank: not yet discovered.' : 'Placed by the second and third eigenvector.';
  mapFigure('Potential φ (reward)', arm, frame.potential, place);
  frame.vectors.slice(0, 3).forEach((vector, k) =>
    mapFigure(`Eigenvector v${k + 2}, scaled by √n`, arm, vector, 'Blank: not yet discovered. Signs follow the moment before.', { symmetric: true }));
  mapFigure('Visits, at the end (log₁₀ of 1 + times)', arm, arm.visits.map(n => Math.log10(1 + n)), 'Of the whole run.');
  mapFigure('Greedy policy on φ, at the end', arm, arm.frames[arm.frames.length - 1].potential,
    'Arrows: the action held best, without advice; none where nothing was learnt.', { arrows: arm.greedy });
}

// --- the rest -----------------------------------------------------------------------------------------------

function drawFacts() {
  const table = byId('facts');
  table.replaceChildren(element('tr', {}, element('th', {}, 'mean [95 % interval]'), ...data.arms.map(arm => element('th', { scope: 'col' }, arm.name))));
  data.arms[0].facts.forEach(([name], row) => table.append(element('tr', {}, element('td', {}, name),
    ...data.arms.map(arm => element('td', {}, arm.facts[row][1])))));
}

function drawChecks() {
  byId('checks').replaceChildren();
  byId('again').replaceChildren();
  for (const arm of data.arms) {
    if (data.arms.length > 1) byId('checks').append(element('h3', {}, arm.name));
    for (const { name, holds, detail } of arm.checks) {
      const [sign, word, kind] = holds === null ? ['·', 'no verdict', ''] : holds ? ['✓', 'yes', 'yes'] : ['✗', 'no', 'no'];
      byId('checks').append(element('div', { class: 'check' }, element('b', { class: kind, 'aria-label': word }, sign),
        element('div', {}, name, element('br'), element('span', {}, detail))));
    }
    const command = element('pre', {}, arm.command);
    const details = element('details', {}, element('summary', {}, `Resolved scenario of ${arm.name}`), element('pre', {}, arm.resolved));
    byId('again').append(command, details);
  }
}

function drawLegend() {
  const chosen = byId('arm').value;
  byId('legend').replaceChildren();
  byId('arm').replaceChildren();
  data.arms.forEach((arm, i) => {
    const swatch = element('i');
    swatch.style.background = color(i);
    const button = element('button', { class: 'arm', type: 'button', 'aria-pressed': !hidden.has(arm.name) }, swatch, arm.name);
    button.addEventListener('click', () => {
      if (!hidden.delete(arm.name)) hidden.add(arm.name);
      button.setAttribute('aria-pressed', !hidden.has(arm.name));
      drawCurves();
      drawGrowth();
    });
    byId('legend').append(button);
    byId('arm').append(element('option', { value: i }, `${arm.name}, seed ${arm.seeds[0]}`));
  });
  byId('arm').value = chosen && chosen < data.arms.length ? chosen : 0;
}

// Keeps to the last moment if it stood there, else where it was.
function fitSlider() {
  const slider = byId('time');
  const last = Math.max(0, data.arms[Number(byId('arm').value)].frames.length - 1);
  const follow = slider.value === slider.max;
  slider.max = last;
  slider.value = follow ? last : Math.min(slider.value, last);
}

function chooseArm() {
  byId('time').value = byId('time').max;
  fitSlider();
  drawMaps();
  drawGrowth();
}

function drawAbout() {
  const thinned = data.thinned ? ' Moments were left out to keep this file below 5 MB.' : '';
  byId('about').textContent = `${data.program}. Curves have at most 400 points and maps at most 40 moments; the run folder has everything.${thinned}`;
}

// Draws the whole page from `next`, which has the form of the data embedded in the file. A live view calls it again
// and again: the reader's choices stay.
function update(next) {
  data = next;
  drawAbout();
  drawLegend();
  drawFacts();
  drawCurves();
  drawChecks();
  fitSlider();
  drawMaps();
  drawGrowth();
}

byId('arm').addEventListener('change', chooseArm);
byId('time').addEventListener('input', drawMaps);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', drawMaps);

// With #selftest the page operates itself and writes down what it saw.
function selfTest() {
  const result = {};
  const slider = byId('time');
  const look = () => byId('maps').querySelector('canvas').toDataURL();
  const late = look(), moment = byId('moment').value;
  slider.value = 0;
  slider.dispatchEvent(new Event('input'));
  result.sliderMoves = look() !== late && byId('moment').value !== moment;
  const curves = () => byId('curves').querySelectorAll('path[data-arm="0"]').length;
  const before = curves();
  byId('legend').querySelector('button').click();
  result.armSwitchesOff = before === 4 && curves() === 0;
  byId('legend').querySelector('button').click();
  result.armComesBack = curves() === before;
  result.figuresHaveText = [...document.querySelectorAll('svg[role=img],canvas')].every(f => f.getAttribute('aria-label'));
  result.fitsWidth = document.documentElement.scrollWidth <= innerWidth;
  result.noRequests = performance.getEntriesByType('resource').length === 0;
  result.errors = errors;
  document.body.append(element('pre', { id: 'selftest' }, JSON.stringify(result)));
}

update(data);
if (location.hash === '#selftest') selfTest();
