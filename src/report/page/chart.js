// --- curves over two axes -----------------------------------------------------------------------------------

function ticks(low, high, log) {
  const list = [];
  if (log) {
    const every = Math.max(1, Math.ceil((high - low) / 6));
    for (let p = Math.ceil(low - 1e-9); p <= high + 1e-9; p += every) list.push(p);
  } else {
    const rough = (high - low) / 4;
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
    if (t >= low && t <= high) list.push(t);
  }
  return list;
}

// series: {x, y, low?, high?, color, name, dash?, arm?}
function chart(parent, { title, xTitle, yTitle, series, log, xlog, say }) {
  const width = 560, height = 300, left = 76, right = 22, top = 12, bottom = 46;
  const usable = series.filter(s => s.x.length > 0);
  const figure = element('figure', {}, element('figcaption', {}, title));
  parent.append(figure);
  if (!usable.length) { figure.append(element('p', {}, 'Nothing recorded.')); return; }
  const floor = log ? Math.max(1e-300, usable.reduce((m, s) => s.y.reduce((n, v) => v > 0 ? Math.min(n, v) : n, m), 1e300)) : 0;
  const f = log ? v => Math.log10(Math.max(v, floor)) : v => v;
  const fx = xlog ? x => Math.log10(Math.max(x, 1)) : x => x;
  const xs = usable.flatMap(s => [s.x[0], s.x[s.x.length - 1]]);
  const x0 = fx(Math.min(...xs)), x1 = Math.max(fx(Math.max(...xs)), x0 + 1);
  const [y0, y1] = extent(usable, log, f);
  const inside = share => Math.min(Math.max(share, 0), 1);
  const right0 = width - right, bottom0 = height - bottom;
  const px = x => left + (fx(x) - x0) / (x1 - x0) * (right0 - left);
  const py = y => bottom0 - inside((f(y) - y0) / (y1 - y0)) * (bottom0 - top);
  const last = say || usable.map(s => `${s.name} ends at ${number(s.y[s.y.length - 1])}`).join('; ') + '.';
  const svg = element('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `${title}. Across: ${xTitle}. Up: ${yTitle}. ${last}` });
  for (const t of log ? logTicks(y0, y1) : ticks(y0, y1)) {
    const y = bottom0 - (t - y0) / (y1 - y0) * (bottom0 - top);
    svg.append(element('line', { x1: left, x2: right0, y1: y, y2: y, class: 'grid' }),
      element('text', { x: left - 7, y: y + 4, 'text-anchor': 'end' }, number(log ? +(10 ** t).toPrecision(3) : t)));
  }
  for (const power of xlog ? logTicks(x0, x1) : ticks(x0, x1)) {
    const t = xlog ? +(10 ** power).toPrecision(3) : power;
    svg.append(element('line', { x1: px(t), x2: px(t), y1: bottom0, y2: bottom0 + 5, class: 'axis' }),
      element('text', { x: px(t), y: bottom0 + 19, 'text-anchor': 'middle' }, number(t)));
  }
  svg.append(element('line', { x1: left, x2: right0, y1: bottom0, y2: bottom0, class: 'axis' }),
    element('text', { x: (left + right0) / 2, y: height - 7, 'text-anchor': 'middle' }, xTitle),
    element('text', { transform: `translate(13 ${(bottom0 + top) / 2}) rotate(-90)`, 'text-anchor': 'middle' }, yTitle));
  const trace = (x, y) => x.map((v, i) => `${i ? 'L' : 'M'}${px(v).toFixed(1)} ${py(y[i]).toFixed(1)}`).join('');
  for (const s of usable) if (s.low) {
    const back = [...s.x].reverse(), low = [...s.low].reverse();
    svg.append(element('path', { d: trace(s.x, s.high) + trace(back, low).replace('M', 'L') + 'Z', fill: s.color, 'fill-opacity': .2 }));
  }
  for (const s of usable) {
    const path = { d: trace(s.x, s.y), fill: 'none', stroke: s.color, 'stroke-width': s.thin ? 1.5 : 2.5, 'stroke-linejoin': 'round', 'data-arm': s.arm ?? '' };
    if (s.dash) path['stroke-dasharray'] = s.dash;
    svg.append(element('path', path, element('title', {}, s.name)));
  }
  figure.append(svg, element('p', {}, last));
}
