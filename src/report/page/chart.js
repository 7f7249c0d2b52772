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
function chart(parent, { title, xTitle, yTitle, series, log, xlog, say }) {
  const { figure, width } = frame(parent, title);
  const usable = series.filter(s => s.x.length > 0);
  if (!usable.length) { figure.append(element('p', {}, 'Nothing recorded.')); return; }
  const floor = log ? Math.max(1e-300, usable.reduce((m, s) => s.y.reduce((n, v) => v > 0 ? Math.min(n, v) : n, m), 1e300)) : 0;
  const f = log ? v => Math.log10(Math.max(v, floor)) : v => v;
  const fx = xlog ? x => Math.log10(Math.max(x, 1)) : x => x;
  const groups = twins(usable), narrow = width < 420;
  // Lines that are the same stand below each other, as equal.
  const labels = groups.flatMap(group => group.map((s, k) => ({ s, name: (k ? '= ' : '') + (s.label ?? s.name), value: narrow || k ? '' : number(s.y.at(-1)),
    dash: group.length === 1 && s.dash ? '4 2' : 'none' }))).filter(({ s }) => s.label !== '');
  const longest = Math.max(0, ...labels.map(label => textWidth(`${label.name}  ${label.value}`)));
  const room = Math.min(longest, .4 * width), right = room ? room + 24 : 10;
  const texts = labels.flatMap(label => wrapped(label.name, room - textWidth(`  ${label.value}`) + .5).map((text, k, lines) => ({ ...label, text, first: !k, last: k === lines.length - 1 })));
  const gaps = texts.map(text => text.first ? 18 : 14), top = 26, bottom = 44, height = Math.max(300, texts.length * 18 + top + bottom);
  const [y0, y1] = extent(usable, log, f);
  const rungs = (log ? logTicks(y0, y1) : ticks(y0, y1)).map(t => [t, number(log ? +(10 ** t).toPrecision(3) : t)]);
  const left = 10 + Math.max(...rungs.map(([, text]) => textWidth(text)));
  const xs = usable.flatMap(s => [s.x[0], s.x.at(-1)]);
  const most = Math.max(...xs), x0 = fx(Math.min(...xs)), x1 = Math.max(fx(most), x0 + 1e-9);
  const inside = share => Math.min(Math.max(share, 0), 1);
  const right0 = width - right, bottom0 = height - bottom;
  const px = x => left + (fx(x) - x0) / (x1 - x0) * (right0 - left);
  const py = y => bottom0 - inside((f(y) - y0) / (y1 - y0)) * (bottom0 - top);
  const last = say || usable.map(s => `${s.name} ends at ${number(s.y.at(-1))}`).join('; ') + '.';
  const svg = picture(width, height, `${title}. Across: ${xTitle}. Up: ${yTitle}. ${last}`);
  for (const [t, text] of rungs) {
    const y = bottom0 - (t - y0) / (y1 - y0) * (bottom0 - top);
    svg.append(element('line', { x1: left, x2: right0, y1: y, y2: y, class: 'grid' }),
      element('text', { x: left - 7, y: y + 4, 'text-anchor': 'end' }, text));
  }
  const across = (xlog ? logTicks(x0, x1) : ticks(x0, x1)).map(p => xlog ? +(10 ** p).toPrecision(3) : p);
  const atEnd = { at: px(most), text: number(most) }, before = right0 - textWidth(atEnd.text) / 2 - 8;
  const marks = across.map(t => ({ at: px(t), text: number(t) })).filter(({ at, text }) => at + textWidth(text) / 2 < before);
  scaleBelow(svg, bottom0, [...marks, atEnd]);
  svg.append(element('line', { x1: left, x2: right0, y1: bottom0, y2: bottom0, class: 'axis' }),
    element('text', { x: (left + right0) / 2, y: height - 6, 'text-anchor': 'middle' }, xTitle),
    element('text', { x: 0, y: 12 }, yTitle));
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
  const heights = spread(texts.map(({ s }) => py(s.y.at(-1))), gaps, top, bottom0);
  texts.forEach(({ s, dash, text, value, first, last }, i) => {
    const end = py(s.y.at(-1)).toFixed(1), y = heights[i];
    const leader = `M${px(s.x.at(-1)).toFixed(1)} ${end}L${right0 + 5} ${end}L${right0 + 12} ${y.toFixed(1)}L${right0 + 20} ${y.toFixed(1)}`;
    if (first) svg.append(element('path', { d: leader, fill: 'none', stroke: s.color, 'stroke-width': 1.5, 'stroke-dasharray': dash }));
    svg.append(element('text', { x: right0 + 24, y: y + 4.5, class: 'label strong' }, text, element('tspan', { class: 'soft', dx: 6 }, last ? value : ''), element('title', {}, s.name)));
  });
  figure.append(svg);
  if (say) figure.append(element('p', {}, say));
  probeCurves(svg, { usable, stops: [...new Set(usable.flatMap(s => s.x))].sort((a, b) => a - b), px, py, top, bottom0, what: xTitle.split(',')[0] });
}

// The values of all curves at one place on the x axis.
function probeCurves(svg, { usable, stops, px, py, top, bottom0, what }) {
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
      marks.append(element('line', { x1: x, x2: x, y1: top, y2: bottom0, class: 'axis' }),
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
