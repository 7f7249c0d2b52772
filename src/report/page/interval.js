// --- numbers with intervals, a row for each arm --------------------------------------------------------------

// rows: {name, value, low, high, color}; `line` is where nothing is won or lost.
function forest(parent, { title, xTitle, rows, line, log, range }) {
  const figure = element('figure', {}, element('figcaption', {}, title));
  parent.append(figure);
  const usable = rows.filter(row => row.value !== null && (!log || row.value > 0));
  if (!usable.length) { figure.append(element('p', {}, 'Not defined: no arm to compare with has any regret.')); return; }
  const each = 30, width = 560, left = 130, right = 96, top = 8, bottom0 = top + each * rows.length, height = bottom0 + 46;
  const f = log ? v => Math.log10(v) : v => v;
  const positive = v => v !== null && (!log || v > 0);
  const all = usable.flatMap(row => [row.value, row.low, row.high]).filter(positive).concat(line).map(f);
  let [x0, x1] = range || [Math.min(...all), Math.max(...all)];
  if (!range) { const margin = Math.max(.05 * (x1 - x0), .1); x0 -= margin; x1 += margin; }
  const px = v => left + Math.min(Math.max((f(v) - x0) / (x1 - x0), 0), 1) * (width - left - right);
  const said = row => row.value === null ? `${row.name}: not defined` : `${row.name}: ${number(row.value)} [${number(row.low)}, ${number(row.high)}]`;
  const svg = element('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `${title}. ${xTitle}. ${rows.map(said).join('; ')}.` });
  for (const t of log ? logTicks(x0, x1) : ticks(x0, x1)) {
    const v = log ? +(10 ** t).toPrecision(3) : t;
    svg.append(element('line', { x1: px(v), x2: px(v), y1: top, y2: bottom0, class: 'grid' }),
      element('text', { x: px(v), y: bottom0 + 18, 'text-anchor': 'middle' }, number(v)));
  }
  svg.append(element('line', { x1: px(line), x2: px(line), y1: top, y2: bottom0, class: 'mark' }),
    element('text', { x: (left + width - right) / 2, y: height - 7, 'text-anchor': 'middle' }, xTitle));
  rows.forEach((row, i) => {
    const y = top + each * (i + .5);
    svg.append(element('text', { x: left - 12, y: y + 4, 'text-anchor': 'end', class: 'strong' }, row.name));
    if (row.value === null || (log && row.value <= 0)) return;
    const low = positive(row.low) ? px(row.low) : left;
    svg.append(element('line', { x1: low, x2: px(row.high), y1: y, y2: y, stroke: row.color, 'stroke-width': 3, 'stroke-linecap': 'round' }),
      element('circle', { cx: px(row.value), cy: y, r: 5.5, fill: row.color, class: 'dot' }),
      element('text', { x: width - right + 12, y: y + 4, class: 'strong' }, number(row.value)));
  });
  figure.append(svg, element('p', {}, 'Dots: values; lines: 95 % intervals over seeds.'));
}

// rows: {name, parts: [seconds]}; `parts` names them.
function bars(parent, { title, rows, parts }) {
  const figure = element('figure', {}, element('figcaption', {}, title));
  parent.append(figure);
  if (!rows.length) { figure.append(element('p', {}, 'Nothing recorded.')); return; }
  const each = 30, width = 560, left = 130, right = 70, top = 8, bottom0 = top + each * rows.length, height = bottom0 + 46;
  const sum = row => row.parts.reduce((a, b) => a + b, 0);
  const most = Math.max(...rows.map(sum), 1e-9);
  const [unit, factor] = most < 1 ? ['milliseconds', 1e3] : ['seconds', 1];
  const px = v => left + v / most * (width - left - right);
  const share = row => `${row.name}: ${number(sum(row) * factor)} ${unit}, of it ${row.parts.map((v, i) => `${number(v * factor)} ${parts[i]}`).join(', ')}`;
  const svg = element('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `${title}. ${rows.map(share).join('; ')}.` });
  for (const t of ticks(0, most * factor)) {
    svg.append(element('line', { x1: px(t / factor), x2: px(t / factor), y1: top, y2: bottom0, class: 'grid' }),
      element('text', { x: px(t / factor), y: bottom0 + 18, 'text-anchor': 'middle' }, number(t)));
  }
  svg.append(element('text', { x: (left + width - right) / 2, y: height - 7, 'text-anchor': 'middle' }, unit));
  const shades = [color(0), color(4), css('--wall')];
  rows.forEach((row, i) => {
    const y = top + each * i + 6;
    svg.append(element('text', { x: left - 12, y: y + 13, 'text-anchor': 'end', class: 'strong' }, row.name));
    let from = 0;
    row.parts.forEach((v, k) => {
      const x = px(from), wide = px(from + v) - x;
      svg.append(element('rect', { x, y, width: Math.max(wide, 0), height: 18, fill: shades[k] }, element('title', {}, `${parts[k]}: ${number(v * factor)} ${unit}`)));
      from += v;
    });
    svg.append(element('text', { x: px(from) + 8, y: y + 13 }, number(from * factor)));
  });
  const legend = element('p', {});
  parts.forEach((name, k) => {
    const swatch = element('i', { class: 'swatch' });
    swatch.style.background = shades[k];
    legend.append(swatch, element('span', {}, name));
  });
  figure.append(svg, legend);
}
