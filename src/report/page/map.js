// --- maps and graphs ----------------------------------------------------------------------------------------

// Up, right, down, left, where arrows would be too small.
const DIRECTIONS = ['#0072b2', '#e69f00', '#009e73', '#cc79a7'];
const ARROWS = ['up', 'right', 'down', 'left'];

// Places of the states of a graph without a map: second and third eigenvector of the last moment that has them.
function layout(sights) {
  const last = [...sights.frames].reverse().find(frame => frame.vectors.length);
  const count = sights.frames[sights.frames.length - 1].potential.levels.length / 2;
  const axis = k => {
    const list = last && last.vectors[k] ? unpack(last.vectors[k]) : [];
    // Ranks pull apart what crowds together; half of each keeps the shape.
    const order = list.map((_, i) => i).sort((a, b) => list[a] - list[b]);
    const low = Math.min(...list), span = Math.max(...list) - low || 1;
    const place = new Array(count).fill(.5);
    order.forEach((i, rank) => { place[i] = .06 + .88 * (.5 * (list[i] - low) / span + .5 * rank / Math.max(1, list.length - 1)); });
    return place;
  };
  const [x, y] = [axis(0), axis(1)];
  return x.map((v, i) => [v, y[i]]);
}

function colorOf(values, signed) {
  let low = Infinity, high = -Infinity;
  for (const v of values) if (v !== null) { low = Math.min(low, v); high = Math.max(high, v); }
  if (signed) { high = Math.max(Math.abs(low), Math.abs(high)); low = -high; }
  const colors = signed ? SIGNED : VIRIDIS;
  return { low, high, colors, of: v => paint(colors, high > low ? (v - low) / (high - low) : signed ? .5 : 0) };
}

function drawMap(canvas, sights, values, colors, arrows) {
  const { map, cells } = sights;
  canvas.width = 1000;
  canvas.height = Math.round(1000 * Math.min(map.rows / map.cols, 2));
  const g = canvas.getContext('2d');
  g.fillStyle = css('--blank');
  g.fillRect(0, 0, canvas.width, canvas.height);
  const w = canvas.width / map.cols, h = canvas.height / map.rows;
  const at = cell => [cell % map.cols * w, Math.floor(cell / map.cols) * h];
  const fill = (cell, style) => {
    const [x, y] = at(cell), left = Math.round(x), top = Math.round(y);
    g.fillStyle = style;
    g.fillRect(left, top, Math.round(x + w) - left, Math.round(y + h) - top);
  };
  const wall = css('--wall');
  for (const cell of map.walls) fill(cell, wall);
  const small = arrows && Math.min(w, h) < 16;
  values.forEach((v, i) => {
    if (small && arrows[i] !== null) fill(cells[i], DIRECTIONS[arrows[i] % 4]);
    else if (v !== null) fill(cells[i], colors.of(v));
  });
  if (arrows && !small) arrows.forEach((action, i) => {
    if (action !== null && !map.goals.includes(cells[i])) arrow(g, at(cells[i]), w, h, action);
  });
  const mark = (cell, letter) => {
    const [x, y] = at(cell), size = Math.max(40, Math.min(w, h) * .66);
    const [cx, cy] = [Math.min(Math.max(x + w / 2, size * .6), canvas.width - size * .6), Math.min(Math.max(y + h / 2, size * .6), canvas.height - size * .6)];
    g.font = `700 ${size}px system-ui, sans-serif`;
    g.textAlign = 'center'; g.textBaseline = 'middle'; g.lineJoin = 'round';
    g.strokeStyle = '#000'; g.lineWidth = size / 5; g.strokeText(letter, cx, cy);
    g.fillStyle = '#fff'; g.fillText(letter, cx, cy);
  };
  if (map.start !== null) mark(map.start, 'S');
  for (const hazard of map.hazards ?? []) mark(hazard, 'X');
  for (const goal of map.goals) mark(goal, 'G');
}

function arrow(g, [x, y], w, h, action) {
  const r = Math.min(w, h) * .3;
  g.save();
  g.translate(x + w / 2, y + h / 2);
  g.rotate(action * Math.PI / 2);
  g.beginPath();
  g.moveTo(0, r); g.lineTo(0, -r); g.moveTo(-r * .6, -r * .3); g.lineTo(0, -r); g.lineTo(r * .6, -r * .3);
  for (const [style, wide] of [['#000', .4], ['#fff', .2]]) { g.strokeStyle = style; g.lineWidth = Math.max(1.5, r * wide); g.stroke(); }
  g.restore();
}

function drawGraph(canvas, sights, values, colors, next) {
  const size = canvas.width = canvas.height = 1000;
  const g = canvas.getContext('2d');
  g.fillStyle = css('--blank');
  g.fillRect(0, 0, size, size);
  const places = layout(sights).map(([x, y]) => [x * size, (1 - y) * size]);
  const radius = Math.max(4, Math.min(22, size / Math.sqrt(values.length + 1) / 6));
  g.strokeStyle = css('--wall');
  g.lineWidth = Math.max(1.5, radius / 6);
  for (const [a, b] of sights.edges) {
    if (a >= values.length || b >= values.length) continue;
    g.beginPath(); g.moveTo(...places[a]); g.lineTo(...places[b]); g.stroke();
  }
  values.forEach((v, i) => {
    if (v === null) return;
    g.beginPath(); g.arc(...places[i], radius, 0, 7); g.fillStyle = colors.of(v); g.fill(); g.stroke();
  });
  if (next) next.forEach((to, from) => {
    if (to === null || from >= values.length || to >= values.length) return;
    const [[ax, ay], [bx, by]] = [places[from], places[to]];
    const far = Math.hypot(bx - ax, by - ay) || 1, [dx, dy] = [(bx - ax) / far, (by - ay) / far];
    const [x, y] = [bx - dx * radius, by - dy * radius], s = radius * .9;
    g.strokeStyle = css('--text'); g.lineWidth = Math.max(3, radius / 3);
    g.beginPath(); g.moveTo(ax + dx * radius, ay + dy * radius); g.lineTo(x, y);
    g.moveTo(x - dx * s - dy * s * .6, y - dy * s + dx * s * .6); g.lineTo(x, y); g.lineTo(x - dx * s + dy * s * .6, y - dy * s - dx * s * .6);
    g.stroke();
  });
}

// The bar of colours below a map.
function colorBar({ low, high, colors }) {
  const stops = colors.map((_, i) => paint(colors, i / (colors.length - 1)));
  const bar = element('div', { class: 'bar' });
  bar.style.background = `linear-gradient(90deg, ${stops})`;
  return element('div', { class: 'scale', 'aria-hidden': 'true' }, element('span', {}, number(low)), bar, element('span', {}, number(high)));
}

function mapFigure(parent, title, sights, values, note, { signed = false, arrows = null } = {}) {
  const canvas = element('canvas', { role: 'img' });
  const figure = element('figure', {}, element('figcaption', {}, title), canvas);
  parent.append(figure);
  const colors = colorOf(values, signed);
  if (sights.map) drawMap(canvas, sights, values, colors, arrows);
  else drawGraph(canvas, sights, values, colors, arrows);
  const known = Number.isFinite(colors.low);
  const range = known ? `From ${number(colors.low)} to ${number(colors.high)}.` : 'Nothing yet.';
  canvas.setAttribute('aria-label', `${title}. ${range} ${values.length} places. ${note}`);
  const small = arrows && sights.map && 1000 / Math.max(sights.map.cols, sights.map.rows) < 16;
  if (small) figure.append(element('p', {}, ...ARROWS.flatMap((name, i) => {
    const swatch = element('i', { class: 'swatch' });
    swatch.style.background = DIRECTIONS[i];
    return [swatch, element('span', {}, name)];
  })));
  else if (known) figure.append(colorBar(colors));
  if (note) figure.append(element('p', {}, note));
}
