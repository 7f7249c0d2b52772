// --- curves over two axes -----------------------------------------------------------------------------------

// About `count` round numbers from `low` to `high`, of powers on a logarithmic axis.
function ticks(low, high, log, count = 4) {
  const list = [];
  if (log) {
    const every = Math.max(1, Math.ceil((high - low) / 6));
    for (let p = Math.ceil(low - 1e-9); p <= high + 1e-9; p += every) list.push(p);
  } else {
    const rough = (high - low) / count;
    const unit = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map(m => m * unit).find(s => s >= rough * (1 - 1e-9));
    for (let t = Math.ceil(low / step - 1e-9) * step; t <= high + step * 1e-9; t += step) list.push(Math.abs(t) < step * 1e-9 ? 0 : t);
  }
  return list;
}

// The values between which a chart is drawn, as the axis counts them (powers of ten on a logarithmic one).
function extent(usable, log, f) {
  let low = Infinity, high = -Infinity;
  // Bands may leave the picture: where seeds are few they are as wide as they are.
  for (const s of usable) for (const v of s.y) { low = Math.min(low, f(v)); high = Math.max(high, f(v)); }
  if (log && high - low < .8) { const middle = (low + high) / 2; low = Math.min(low, middle - .4); high = Math.max(high, middle + .4); }
  const margin = .06 * (high - low);
  [low, high] = [low - margin, high + margin];
  return high - low < 1e-9 ? [low - 1, high + 1] : [low, high];
}

// A logarithmic axis of less than two decades has ticks at 1, 2 and 5 as well.
function logTicks(low, high) {
  if (high - low >= 2) return ticks(low, high, true);
  const list = [];
  for (let p = Math.floor(low); p <= Math.ceil(high); p++) for (const m of [1, 2, 5]) {
    const t = p + Math.log10(m);
    if (t >= low - 1e-9 && t <= high + 1e-9) list.push(t);
  }
  return list;
}

// A figure with its title, and how many pixels wide it is inside.
function frame(parent, title) {
  const caption = element('figcaption', {}, title), figure = element('figure', {}, caption);
  parent.append(figure);
  return { figure, width: Math.max(260, caption.clientWidth) };
}

const picture = (width, height, text) => element('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': text });

// The scale below a picture: {at, text} from left to right, those left out that have no room.
function scaleBelow(svg, y, marks) {
  let free = -Infinity;
  for (const { at, text } of marks) {
    const half = textWidth(text) / 2;
    if (at - half < free) continue;
    free = at + half + 8;
    svg.append(element('line', { x1: at, x2: at, y1: y, y2: y + 5, class: 'axis' }),
      element('text', { x: at, y: y + 19, 'text-anchor': 'middle' }, text));
  }
}

// The last point of a series that is not after `x`.
function pointAt(s, x) {
  let low = 0, high = s.x.length;
  while (low < high) { const middle = (low + high) >> 1; if (s.x[middle] <= x) low = middle + 1; else high = middle; }
  return low - 1;
}

// series: {x, y, low?, high?, color, name, label?, dash?, arm?, thin?}; a label that is '' is not drawn.
function chart(parent, { title, xTitle, yTitle, series, log, xlog }) {
  const { figure, width } = frame(parent, title);
  const usable = series.filter(s => s.x.length > 0);
  if (!usable.length) { figure.append(element('p', {}, 'Nothing recorded.')); return; }
  const groups = twins(usable), { texts, room } = endTexts(groups, width);
  const space = plan(usable, { log, xlog, width, room, height: Math.max(300, 18 * texts.length + 70) });
  const ends = usable.map(s => `${s.name} ends at ${number(s.y.at(-1))}`).join('; ');
  const svg = picture(width, space.height, `${title}. Across: ${xTitle}. Up: ${yTitle}. ${ends}.`);
  drawAxes(svg, space, xTitle, yTitle);
  drawLines(svg, space, usable, groups);
  drawTexts(svg, space, texts);
  figure.append(svg);
  probeCurves(svg, space, usable, xTitle.split(',')[0]);
}

// What stands at the ends of curves, line by line, and how wide it may be. Curves that are the same stand below each other, as equal.
function endTexts(groups, width) {
  const narrow = width < 420;
  const labels = groups.flatMap(group => group.map((s, k) => ({ s, name: (k ? '= ' : '') + (s.label ?? s.name), value: narrow || k ? '' : number(s.y.at(-1)),
    dash: group.length === 1 && s.dash ? '4 2' : 'none' }))).filter(({ s }) => s.label !== '');
  const longest = Math.max(0, ...labels.map(({ name, value }) => textWidth(`${name}  ${value}`)));
  const room = Math.min(longest, .4 * width);
  const texts = labels.flatMap(label => wrapped(label.name, room - textWidth(`  ${label.value}`) + .5)
    .map((text, k, lines) => ({ ...label, text, first: k === 0, last: k === lines.length - 1 })));
  return { texts, room };
}

// Where everything goes: the edges, the numbers at the axes, and x and y in pixels.
function plan(usable, { log, xlog, width, room, height }) {
  const floor = log ? Math.max(1e-300, usable.reduce((m, s) => s.y.reduce((n, v) => v > 0 ? Math.min(n, v) : n, m), 1e300)) : 0;
  const f = log ? v => Math.log10(Math.max(v, floor)) : v => v;
  const fx = xlog ? x => Math.log10(Math.max(x, 1)) : x => x;
  const value = (power, is) => is ? +(10 ** power).toPrecision(3) : power;
  const [y0, y1] = extent(usable, log, f);
  const rungs = (log ? logTicks(y0, y1) : ticks(y0, y1)).map(t => ({ share: (t - y0) / (y1 - y0), text: number(value(t, log)) }));
  const xs = usable.flatMap(s => [s.x[0], s.x.at(-1)]);
  const most = Math.max(...xs), x0 = fx(Math.min(...xs)), x1 = Math.max(fx(most), x0 + 1e-9);
  const left = 10 + Math.max(...rungs.map(({ text }) => textWidth(text))), right = width - (room ? room + 24 : 10), top = 26, bottom = height - 44;
  const px = x => left + (fx(x) - x0) / (x1 - x0) * (right - left);
  const py = y => bottom - Math.min(Math.max((f(y) - y0) / (y1 - y0), 0), 1) * (bottom - top);
  const end = { at: px(most), text: number(most) }, before = right - textWidth(end.text) / 2 - 8;
  const marks = (xlog ? logTicks(x0, x1) : ticks(x0, x1)).map(t => value(t, xlog)).map(t => ({ at: px(t), text: number(t) }))
    .filter(({ at, text }) => at + textWidth(text) / 2 < before);
  return { height, left, right, top, bottom, px, py, rungs, marks: [...marks, end] };
}

function drawAxes(svg, { height, left, right, top, bottom, rungs, marks }, xTitle, yTitle) {
  for (const { share, text } of rungs) {
    const y = bottom - share * (bottom - top);
    svg.append(element('line', { x1: left, x2: right, y1: y, y2: y, class: 'grid' }),
      element('text', { x: left - 7, y: y + 4, 'text-anchor': 'end' }, text));
  }
  scaleBelow(svg, bottom, marks);
  svg.append(element('line', { x1: left, x2: right, y1: bottom, y2: bottom, class: 'axis' }),
    element('text', { x: (left + right) / 2, y: height - 6, 'text-anchor': 'middle' }, xTitle),
    element('text', { x: 0, y: 12 }, yTitle));
}

function drawLines(svg, { px, py }, usable, groups) {
  const trace = (x, y) => x.map((v, i) => `${i ? 'L' : 'M'}${px(v).toFixed(1)} ${py(y[i]).toFixed(1)}`).join('');
  for (const s of usable) if (s.low) {
    const back = [...s.x].reverse(), low = [...s.low].reverse();
    svg.append(element('path', { d: trace(s.x, s.high) + trace(back, low).replace('M', 'L') + 'Z', fill: s.color, 'fill-opacity': .16 }));
  }
  // Of lines that are the same every one has its turn.
  const dashes = (group, k) => group.length > 1 ? { 'stroke-dasharray': `7 ${7 * (group.length - 1)}`, 'stroke-dashoffset': -7 * k }
    : group[k].dash ? { 'stroke-dasharray': group[k].dash } : {};
  for (const group of groups) group.forEach((s, k) => svg.append(element('path', { d: trace(s.x, s.y), fill: 'none', stroke: s.color,
    'stroke-width': s.thin ? 1.5 : 2.5, 'stroke-linejoin': 'round', 'data-arm': s.arm ?? '', ...dashes(group, k) })));
}

// The texts at the ends of curves, each with a line from where its curve ends.
function drawTexts(svg, { right, top, bottom, px, py }, texts) {
  const heights = spread(texts.map(({ s }) => py(s.y.at(-1))), texts.map(({ first }) => first ? 18 : 14), top, bottom);
  texts.forEach(({ s, dash, text, value, first, last }, i) => {
    const end = py(s.y.at(-1)).toFixed(1), y = heights[i].toFixed(1);
    const leader = `M${px(s.x.at(-1)).toFixed(1)} ${end}L${right + 5} ${end}L${right + 12} ${y}L${right + 20} ${y}`;
    if (first) svg.append(element('path', { d: leader, fill: 'none', stroke: s.color, 'stroke-width': 1.5, 'stroke-dasharray': dash }));
    svg.append(element('text', { x: right + 24, y: heights[i] + 4.5, class: 'label strong' }, text,
      element('tspan', { class: 'soft', dx: 6 }, last ? value : ''), element('title', {}, s.name)));
  });
}

// The values of all curves at one place on the x axis.
function probeCurves(svg, { px, py, top, bottom }, usable, what) {
  const stops = [...new Set(usable.flatMap(s => s.x))].sort((a, b) => a - b);
  const size = () => svg.getBoundingClientRect().width / svg.viewBox.baseVal.width || 1;
  const known = x => usable.map(s => [s, pointAt(s, x)]).filter(([s, i]) => i >= 0 && x <= s.x.at(-1));
  const marks = element('g', { class: 'marks' });
  svg.append(marks);
  const nearest = x => stops.reduce((best, stop, i) => Math.abs(px(stop) - x) < Math.abs(px(stops[best]) - x) ? i : best, 0);
  probe(svg, {
    find: x => nearest(x / size()),
    go: (i, key) => {
      if (i === null) return stops.length - 1;
      const by = { ArrowRight: 1, ArrowUp: 10, ArrowLeft: -1, ArrowDown: -10 }[key];
      return Math.min(Math.max(i + by, 0), stops.length - 1);
    },
    mark: i => {
      marks.replaceChildren();
      if (i === null) return;
      const x = px(stops[i]);
      marks.append(element('line', { x1: x, x2: x, y1: top, y2: bottom, class: 'axis' }),
        ...known(stops[i]).map(([s, at]) => element('circle', { cx: px(s.x[at]), cy: py(s.y[at]), r: 4, fill: s.color, class: 'dot' })));
    },
    tell: i => {
      const values = known(stops[i]).sort(([a, i], [b, k]) => b.y[k] - a.y[i]);
      const key = s => { const node = element('i', { class: s.dash ? 'swatch hollow' : 'swatch' }); node.style.setProperty('--color', s.color); return node; };
      return { x: px(stops[i]) * size(), y: (top + 20) * size(), lines: [head(`${what} ${count(stops[i])}`),
        ...values.map(([s, at]) => line(s.label || s.name, withInterval(s.y[at], s.low?.[at], s.high?.[at]), key(s)))] };
    },
  });
}
