// --- numbers with intervals, a row for each arm --------------------------------------------------------------

const ROW = 30;

// Names at the left of rows that begin at `top`; returns where they end.
function rowNames(svg, rows, width, top) {
  const left = Math.min(Math.max(...rows.map(row => textWidth(row.name))) + 6, .4 * width);
  rows.forEach((row, i) => svg.append(element('text', { x: left, y: top + ROW * (i + .5) + 4, 'text-anchor': 'end', class: 'strong' },
    fitted(row.name, left), element('title', {}, row.name))));
  return left + 14;
}

// What is said of the row under the pointer.
function probeRows(svg, rows, top, tell) {
  const size = () => svg.getBoundingClientRect().width / svg.viewBox.baseVal.width || 1;
  const within = i => Math.min(Math.max(i, 0), rows.length - 1);
  const band = element('rect', { x: 0, width: svg.viewBox.baseVal.width, height: ROW, class: 'under', visibility: 'hidden' });
  svg.prepend(band);
  probe(svg, {
    find: (x, y) => within(Math.floor((y / size() - top) / ROW)),
    go: (i, key) => i === null ? 0 : within(i + ({ ArrowDown: 1, ArrowRight: 1 }[key] ?? -1)),
    mark: i => {
      band.setAttribute('visibility', i === null ? 'hidden' : 'visible');
      if (i !== null) band.setAttribute('y', top + ROW * i);
    },
    tell: i => ({ x: svg.viewBox.baseVal.width * size() / 2, y: (top + ROW * i) * size(), lines: tell(rows[i]) }),
  });
}

// rows: {name, value, low, high, arm}; `line` is where nothing is won or lost.
function forest(parent, { title, xTitle, note, rows, line: neutral, log, range }) {
  const { figure, width } = frame(parent, title);
  const usable = rows.filter(row => row.value !== null && (!log || row.value > 0));
  if (!usable.length) { figure.append(element('p', {}, 'Not defined: no arm to compare with has any regret.')); return; }
  const top = 8, bottom0 = top + ROW * rows.length, height = bottom0 + 46;
  const said = row => row.value === null ? 'not defined' : withInterval(row.value, row.low, row.high);
  const svg = picture(width, height, `${title}. ${xTitle}. ${rows.map(row => `${row.name}: ${said(row)}`).join('; ')}.`);
  const left = rowNames(svg, rows, width, top);
  const short = row => row.value === null ? '–' : number(row.value);
  const written = width > 480 ? said : short;
  const right = Math.max(...rows.map(row => textWidth(written(row)))) + 12;
  const f = log ? v => Math.log10(v) : v => v;
  const positive = v => v !== null && (!log || v > 0);
  const all = usable.flatMap(row => [row.value, row.low, row.high]).filter(positive).concat(neutral).map(f);
  let [x0, x1] = range || [Math.min(...all), Math.max(...all)];
  if (!range) { const margin = Math.max(.05 * (x1 - x0), .1); x0 -= margin; x1 += margin; }
  const px = v => left + Math.min(Math.max((f(v) - x0) / (x1 - x0), 0), 1) * (width - left - right);
  const marks = (log ? logTicks(x0, x1) : ticks(x0, x1)).map(t => log ? +(10 ** t).toPrecision(3) : t);
  for (const v of marks) svg.append(element('line', { x1: px(v), x2: px(v), y1: top, y2: bottom0, class: 'grid' }));
  scaleBelow(svg, bottom0, marks.map(v => ({ at: px(v), text: number(v) })));
  svg.append(element('line', { x1: px(neutral), x2: px(neutral), y1: top, y2: bottom0, class: 'mark' }),
    element('text', { x: width / 2, y: height - 7, 'text-anchor': 'middle' }, fitted(xTitle, width)));
  rows.forEach((row, i) => {
    const y = top + ROW * (i + .5);
    svg.append(element('text', { x: width - right + 12, y: y + 4, class: 'strong' }, written(row)));
    if (row.value === null || (log && row.value <= 0)) return;
    const low = positive(row.low) ? px(row.low) : left, stroke = color(row.arm);
    svg.append(element('line', { x1: low, x2: px(row.high), y1: y, y2: y, stroke, 'stroke-width': 3, 'stroke-linecap': 'round' }),
      again(row.arm) ? element('circle', { cx: px(row.value), cy: y, r: 4.5, stroke, 'stroke-width': 2.5, class: 'hole' })
        : element('circle', { cx: px(row.value), cy: y, r: 5.5, fill: stroke, class: 'dot' }));
  });
  figure.append(svg, element('p', {}, `${note}; lines: 95 % intervals.`));
  probeRows(svg, rows, top, row => [head(row.name), line('value [interval]', said(row))]);
}

// rows: {name, parts: [seconds]}; `parts` names them.
function bars(parent, { title, rows, parts }) {
  const { figure, width } = frame(parent, title);
  if (!rows.length) { figure.append(element('p', {}, 'Nothing recorded.')); return; }
  const top = 8, bottom0 = top + ROW * rows.length, height = bottom0 + 46;
  const sum = row => row.parts.reduce((a, b) => a + b, 0);
  const most = Math.max(...rows.map(sum), 1e-9);
  const [unit, factor] = most < 1 ? ['milliseconds', 1e3] : ['seconds', 1];
  const share = row => `${row.name}: ${number(sum(row) * factor)} ${unit}, of it ${row.parts.map((v, i) => `${number(v * factor)} ${parts[i]}`).join(', ')}`;
  const svg = picture(width, height, `${title}. ${rows.map(share).join('; ')}.`);
  const left = rowNames(svg, rows, width, top), right = 60;
  const px = v => left + v / most * (width - left - right);
  const marks = ticks(0, most * factor, false, 3);
  for (const t of marks) svg.append(element('line', { x1: px(t / factor), x2: px(t / factor), y1: top, y2: bottom0, class: 'grid' }));
  scaleBelow(svg, bottom0, marks.map(t => ({ at: px(t / factor), text: number(t) })));
  svg.append(element('text', { x: (left + width - right) / 2, y: height - 7, 'text-anchor': 'middle' }, unit));
  const shades = [color(0), color(4), css('--wall')];
  const key = k => { const node = element('i', { class: 'swatch' }); node.style.setProperty('--color', shades[k]); return node; };
  rows.forEach((row, i) => {
    const y = top + ROW * i + 6;
    let from = 0;
    row.parts.forEach((v, k) => {
      const x = px(from), wide = px(from + v) - x;
      svg.append(element('rect', { x, y, width: Math.max(wide, 0), height: 18, fill: shades[k] }));
      from += v;
    });
    svg.append(element('text', { x: px(from) + 8, y: y + 13 }, number(from * factor)));
  });
  const legend = element('p', { class: 'keys' });
  parts.forEach((name, k) => legend.append(element('span', {}, key(k), name)));
  figure.append(svg, legend);
  probeRows(svg, rows, top, row => [head(row.name), ...row.parts.map((v, k) => line(parts[k], `${number(v * factor)} ${unit}`, key(k)))]);
}
