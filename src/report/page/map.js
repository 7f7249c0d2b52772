// --- maps and graphs ----------------------------------------------------------------------------------------

// Up, right, down, left, where arrows would be too small.
const DIRECTIONS = ['#0072b2', '#e69f00', '#009e73', '#cc79a7'];
const ARROWS = ['up', 'right', 'down', 'left'];

// Side of a picture in its own pixels.
const SIDE = 1000;

const nameOf = (sights, place) => sights.names[place] ?? `state ${place}`;
const actionOf = (sights, action) => sights.actions[action] ?? `action ${action}`;

// Remembers what was made of an object.
const once = make => {
  const made = new WeakMap();
  return object => {
    if (!made.has(object)) made.set(object, make(object));
    return made.get(object);
  };
};

// Places of the states of a graph without a map: second and third eigenvector of the last moment that has them.
const layout = once(sights => {
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
});

// What is where on a map.
const ground = once(({ map, cells }) => ({ placeOf: new Map(cells.map((cell, place) => [cell, place])), walls: new Set(map.walls) }));

function colorOf(values, signed) {
  let low = Infinity, high = -Infinity;
  for (const v of values) if (v !== null) { low = Math.min(low, v); high = Math.max(high, v); }
  if (signed) { high = Math.max(Math.abs(low), Math.abs(high)); low = -high; }
  const colors = signed ? SIGNED : VIRIDIS;
  return { low, high, colors, of: v => paint(colors, high > low ? (v - low) / (high - low) : signed ? .5 : 0) };
}

function drawMap(canvas, sights, values, colors, arrows) {
  const { map, cells } = sights;
  canvas.width = SIDE;
  canvas.height = Math.round(SIDE * Math.min(map.rows / map.cols, 2));
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
  const size = canvas.width = canvas.height = SIDE;
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
  nameNodes(g, sights, places, radius, values.length);
}

// Names below the nodes, those left out that would hide others.
function nameNodes(g, sights, places, radius, count) {
  const letters = 40, taken = [];
  if (count > 40 || !sights.names.length) return;
  g.font = `${letters}px system-ui, sans-serif`;
  g.textAlign = 'center'; g.textBaseline = 'middle'; g.lineJoin = 'round';
  g.strokeStyle = css('--blank'); g.lineWidth = 10; g.fillStyle = css('--text');
  for (let i = 0; i < count; i++) {
    const name = sights.names[i], text = name.length > 14 ? name.slice(0, 13) + '…' : name;
    const half = g.measureText(text).width / 2;
    const x = Math.min(Math.max(places[i][0], half + 8), SIDE - half - 8), y = places[i][1];
    const box = down => [x - half, y + down - letters / 2, x + half, y + down + letters / 2];
    const free = ([l, t, r, b]) => t > 0 && b < SIDE && taken.every(([l2, t2, r2, b2]) => r < l2 || l > r2 || b < t2 || t > b2)
      && places.slice(0, count).every(([px, py], k) => k === i || px + radius < l || px - radius > r || py + radius < t || py - radius > b);
    const down = [radius + letters * .7, -radius - letters * .7].find(down => free(box(down)));
    if (down === undefined) continue;
    taken.push(box(down));
    g.strokeText(text, x, y + down); g.fillText(text, x, y + down);
  }
}

// What is at a place of the picture, under the pointer or for the arrow keys.
function probeMap(canvas, cursor, sights, values, said) {
  const { map, cells } = sights, cols = map.cols;
  const { placeOf, walls } = ground(sights);
  const size = () => ({ w: canvas.clientWidth / cols, h: canvas.clientHeight / map.rows });
  const within = (v, end) => Math.min(Math.max(v, 0), end - 1);
  const where = v => map.side > 1 ? `${v * map.side}–${(v + 1) * map.side - 1}` : v;
  const what = cell => {
    const place = placeOf.get(cell), value = place === undefined ? null : values[place] ?? null;
    if (walls.has(cell)) return [element('div', {}, 'wall')];
    return value === null ? [element('div', {}, 'not yet known')] : said(place, value);
  };
  probe(canvas, {
    find: (x, y) => within(Math.floor(y / size().h), map.rows) * cols + within(Math.floor(x / size().w), cols),
    go: (cell, key) => {
      if (cell === null) return map.start ?? cells[0] ?? 0;
      const [down, right] = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[key];
      return within(Math.floor(cell / cols) + down, map.rows) * cols + within(cell % cols + right, cols);
    },
    mark: cell => {
      cursor.hidden = cell === null;
      if (cell === null) return;
      const place = { left: cell % cols / cols, top: Math.floor(cell / cols) / map.rows, width: 1 / cols, height: 1 / map.rows };
      for (const [side, share] of Object.entries(place)) cursor.style[side] = `${100 * share}%`;
    },
    tell: cell => {
      const names = [[cell === map.start, 'start'], [map.goals.includes(cell), 'goal'], [(map.hazards ?? []).includes(cell), 'hazard']];
      const marks = names.filter(([is]) => is).map(([, name]) => `, ${name}`).join('');
      return { x: (cell % cols + .5) * size().w, y: Math.floor(cell / cols) * size().h,
        lines: [head(`row ${where(Math.floor(cell / cols))}, column ${where(cell % cols)}${marks}`), ...what(cell)] };
    },
  });
}

function probeGraph(canvas, cursor, sights, values, said) {
  const places = layout(sights).map(([x, y]) => [x, 1 - y]), count = values.length;
  const size = () => canvas.clientWidth;
  const distance = (i, x, y) => Math.hypot(places[i][0] - x, places[i][1] - y);
  probe(canvas, {
    find: (x, y) => {
      let best = null;
      for (let i = 0; i < count; i++) if (best === null || distance(i, x / size(), y / size()) < distance(best, x / size(), y / size())) best = i;
      return best !== null && distance(best, x / size(), y / size()) < .08 ? best : null;
    },
    go: (i, key) => count ? i === null ? 0 : (i + (['ArrowRight', 'ArrowDown'].includes(key) ? 1 : count - 1)) % count : null,
    mark: i => {
      cursor.hidden = i === null;
      if (i === null) return;
      cursor.style.left = `${100 * places[i][0] - 3}%`;
      cursor.style.top = `${100 * places[i][1] - 3}%`;
      cursor.style.width = cursor.style.height = '6%';
    },
    tell: i => ({ x: places[i][0] * size(), y: places[i][1] * size(),
      lines: [head(nameOf(sights, i)), ...values[i] === null ? [element('div', {}, 'not yet known')] : said(i, values[i])] }),
  });
}

// The bar of colours below a map.
function colorBar({ low, high, colors }) {
  const stops = colors.map((_, i) => paint(colors, i / (colors.length - 1)));
  const bar = element('div', { class: 'bar' });
  bar.style.background = `linear-gradient(90deg, ${stops})`;
  return element('div', { class: 'scale', 'aria-hidden': 'true' }, element('span', {}, number(low)), bar, element('span', {}, number(high)));
}

// `text` is what a value says, if not itself.
function mapFigure(parent, title, sights, values, note, { signed = false, arrows = null, text = number } = {}) {
  const canvas = element('canvas', { role: 'img' }), cursor = element('div', { class: 'cursor', hidden: '' });
  const figure = element('figure', {}, element('figcaption', {}, title), element('div', { class: 'view' }, canvas, cursor));
  parent.append(figure);
  const colors = colorOf(values, signed);
  if (sights.map) drawMap(canvas, sights, values, colors, arrows);
  else drawGraph(canvas, sights, values, colors, arrows);
  const known = Number.isFinite(colors.low);
  const range = known ? `From ${number(colors.low)} to ${number(colors.high)}.` : 'Nothing yet.';
  canvas.setAttribute('aria-label', `${title}. ${range} ${values.length} places. ${note}`);
  const name = title.split(',')[0];
  const said = (place, value) => [line(arrows ? 'φ' : name, text(value)), ...arrows ? policyLines(sights, place) : []];
  (sights.map ? probeMap : probeGraph)(canvas, cursor, sights, values, said);
  const small = arrows && sights.map && SIDE / Math.max(sights.map.cols, sights.map.rows) < 16;
  if (small) figure.append(element('p', { class: 'keys' }, ...ARROWS.map((name, i) => {
    const key = element('i', { class: 'swatch' });
    key.style.setProperty('--color', DIRECTIONS[i]);
    return element('span', {}, key, name);
  })));
  else if (known) figure.append(colorBar(colors));
  if (note) figure.append(element('p', {}, note));
}

// The action held best at a place, and where it leads.
function policyLines(sights, place) {
  const action = sights.greedy[place] ?? null, next = sights.next[place] ?? null;
  if (action === null) return [line('action', 'none learnt')];
  const lines = [line('action', actionOf(sights, action))];
  if (next !== null) lines.push(line('leads to', nameOf(sights, next)));
  return lines;
}
