// --- the page -----------------------------------------------------------------------------------------------

// Everything is drawn from these two: `update` replaces the first, the reader the second.
let data = JSON.parse(byId('data').textContent);
const hidden = new Set();
const visible = () => data.arms.map((arm, i) => [arm, i]).filter(([arm]) => !hidden.has(arm.name));
const chosen = () => data.arms[Number(byId('arm').value)];

function drawHead() {
  byId('bands').textContent = data.arms.some(arm => arm.seeds.length > 1) ? `Lines and bands: ${data.statistic}. ` : '';
  byId('headline').textContent = data.headline;
  byId('about').textContent = `${data.program}. ${data.notes.join(' ')}`;
}

function drawLegend() {
  const before = byId('arm').value;
  byId('legend').replaceChildren();
  byId('arm').replaceChildren();
  data.arms.forEach((arm, i) => {
    const swatch = element('i');
    swatch.style.background = color(i);
    const button = element('button', { class: 'arm', type: 'button', 'aria-pressed': !hidden.has(arm.name) }, swatch, arm.name);
    button.addEventListener('click', () => {
      if (!hidden.delete(arm.name)) hidden.add(arm.name);
      button.setAttribute('aria-pressed', !hidden.has(arm.name));
      drawArms();
    });
    byId('legend').append(button);
    if (arm.sights) byId('arm').append(element('option', { value: i }, `${arm.name}, seed ${arm.seeds[0]}`));
  });
  const options = [...byId('arm').options].map(option => option.value);
  // The potential is what one came to see.
  const first = data.arms.findIndex(arm => arm.sights && arm.sights.frames.some(frame => frame.vectors.length));
  byId('arm').value = options.includes(before) ? before : options.includes(String(first)) ? first : options[0];
  byId('seen').hidden = !options.length;
}

function drawVersus() {
  const parent = byId('versus');
  parent.replaceChildren();
  const rows = key => visible().map(([arm, i]) => ({ name: arm.name, color: color(i), value: arm.versus[key].median ?? arm.versus[key].value ?? null,
    low: arm.versus[key].low, high: arm.versus[key].high }));
  parent.hidden = !data.arms.some(arm => arm.versus);
  if (parent.hidden) return;
  forest(parent, { title: 'Regret against the sparse arm', xTitle: 'regret ÷ regret of sparse, same seed (median, log scale)', rows: rows('ratio'), line: 1, log: true });
  forest(parent, { title: 'Chance of less regret than the sparse arm', xTitle: 'probability of improvement', rows: rows('improvement'), line: .5, range: [0, 1] });
}

function drawFacts() {
  const table = byId('facts');
  const arms = visible();
  table.replaceChildren(element('tr', {}, element('th', { scope: 'col' }, data.statistic), ...arms.map(([arm]) => element('th', { scope: 'col' }, arm.name))));
  data.arms[0].facts.forEach(([name], row) => table.append(element('tr', {}, element('th', { scope: 'row' }, name),
    ...arms.map(([arm]) => element('td', {}, (arm.facts[row] || ['', '–'])[1])))));
}

function drawCurves() {
  const parent = byId('curves');
  parent.replaceChildren();
  const bands = key => visible().filter(([arm]) => arm[key]).map(([arm, i]) => ({ x: arm.episodes, y: arm[key].middle,
    low: arm.seeds.length > 1 ? arm[key].low : null, high: arm.seeds.length > 1 ? arm[key].high : null, color: color(i), name: arm.name, arm: i }));
  const xlog = !byId('linear').checked;
  const x = { xTitle: xlog ? 'episode, log scale' : 'episode', xlog };
  chart(parent, { title: 'Regret ρ', ...x, yTitle: 'reward, log scale', series: bands('regret'), log: true });
  chart(parent, { title: 'Steps per episode', ...x, yTitle: 'steps, log scale', series: bands('length'), log: true });
  if (!data.arms.some(arm => arm.plain)) return;
  chart(parent, { title: 'Return, as the environment pays it', ...x, yTitle: 'reward', series: bands('plain') });
  chart(parent, { title: 'Shaped return, as the agent learns from it', ...x, yTitle: 'reward', series: bands('shaped') });
}

function drawGrowth() {
  const parent = byId('growth');
  parent.replaceChildren();
  const seen = visible().filter(([arm]) => arm.sights);
  const over = (frames, value) => ({ x: frames.map(f => f.step), y: frames.map(value) });
  const steps = { xTitle: 'environment step, log scale', xlog: true };
  if (seen.length) chart(parent, { title: 'Graph discovered (solid: states, dashed: edges)', ...steps, yTitle: 'count',
    series: seen.flatMap(([arm, i]) => [
      { ...over(arm.sights.frames, f => f.nodes), name: `${arm.name}, states`, color: color(i) },
      { ...over(arm.sights.frames, f => f.edges), name: `${arm.name}, edges`, color: color(i), dash: '5 4' }]) });
  const arm = chosen();
  if (arm) drawEigenvalues(parent, arm, steps);
  const effort = (key, what, dash) => visible().flatMap(([arm, i]) => {
    const rows = arm.solver.filter(r => r[key] !== null);
    return rows.length ? [{ x: rows.map(r => r.step), y: rows.map(r => r[key]), name: `${arm.name}, ${what}`, color: color(i), dash }] : [];
  });
  if (data.arms.some(arm => arm.solver.length)) {
    chart(parent, { title: 'Effort of the eigensolver (solid: products, dashed: solves)', ...steps, yTitle: 'in each refresh', series: [...effort('applications', 'products'), ...effort('solves', 'solves', '5 4')] });
    chart(parent, { title: 'Residual of the eigenvectors kept', ...steps, yTitle: '‖Lv − λv‖ ÷ λₖ, log scale', series: effort('residual', 'residual'), log: true });
    chart(parent, { title: 'Loss of the network after each fit', ...steps, yTitle: 'loss, log scale', series: effort('loss', 'loss'), log: true });
  }
  const timed = visible().filter(([arm]) => arm.phases);
  if (timed.length) bars(parent, { title: 'Where the time of a run went', parts: ['eigensolver', 'fits', 'environment, graph, learner'],
    rows: timed.map(([arm]) => ({ name: arm.name, parts: [arm.phases.spectrum, arm.phases.fit, arm.phases.rest] })) });
}

function drawEigenvalues(parent, arm, steps) {
  const known = arm.sights.frames.filter(f => f.eigenvalues.length);
  const count = Math.max(0, ...known.map(f => f.eigenvalues.length));
  const series = [];
  for (let k = 1; k < count; k++) {
    const frames = known.filter(f => f.eigenvalues.length > k && f.eigenvalues[k] > 1e-12);
    series.push({ x: frames.map(f => f.step), y: frames.map(f => f.eigenvalues[k]), name: `λ${k + 1}`, color: paint(VIRIDIS, (dark.matches ? .25 : 0) + .7 * k / count), thin: true });
  }
  const last = known.length ? known[known.length - 1].eigenvalues : [];
  const say = last.length > 1 ? `λ2 (darkest) ends at ${number(last[1])}, λ${last.length} (lightest) at ${number(last[last.length - 1])}.` : undefined;
  if (series.length) chart(parent, { title: `Eigenvalues of ${arm.name}, without λ1 = 0`, ...steps, yTitle: 'λ, log scale', series, log: true, say });
}

function drawMaps() {
  const arm = chosen(), parent = byId('maps');
  parent.replaceChildren();
  if (!arm) return;
  const { sights } = arm, frame = sights.frames[Number(byId('time').value)], end = sights.frames[sights.frames.length - 1];
  const text = `step ${number(frame.step)}: ${number(frame.nodes)} states, ${number(frame.edges)} edges`;
  byId('moment').value = text;
  byId('time').setAttribute('aria-valuetext', text);
  const place = sights.map ? 'Blank: not yet discovered.' : 'Placed by the second and third eigenvector.';
  mapFigure(parent, 'Potential φ (reward)', sights, unpack(frame.potential), place);
  frame.vectors.forEach((vector, k) => mapFigure(parent, `Eigenvector v${k + 2}, times √n`, sights, unpack(vector),
    sights.map ? 'Its sign follows the moment before. Blank: not yet in a spectrum.' : 'Its sign follows the moment before.', { signed: true }));
  mapFigure(parent, 'Visits in the whole run', sights, unpack(sights.visits), 'log₁₀ of 1 + times that a state was left.');
  if (sights.greedy.length || sights.next.length) mapFigure(parent, 'Greedy policy on φ, at the end', sights, unpack(end.potential),
    'The likeliest action, with the advice of φ, while nothing is searched for; none where nothing was learnt.', { arrows: sights.map ? sights.greedy : sights.next });
}

function drawChecks() {
  const parent = byId('checks');
  parent.replaceChildren();
  byId('again').replaceChildren();
  for (const arm of data.arms) {
    if (!arm.checks.length) continue;
    const card = element('div', { class: 'card' }, element('h3', {}, arm.name));
    for (const { name, holds, detail } of arm.checks) {
      const [sign, word, kind] = holds === null ? ['·', 'no verdict', ''] : holds ? ['✓', 'yes', 'yes'] : ['✗', 'no', 'no'];
      card.append(element('div', { class: 'check' }, element('b', { class: kind, role: 'img', 'aria-label': word }, sign),
        element('div', {}, name, element('br'), element('span', {}, detail))));
    }
    parent.append(card);
  }
  byId('valid').hidden = !parent.children.length;
  for (const command of new Set(data.arms.map(arm => arm.command))) byId('again').append(element('pre', {}, command));
  for (const arm of data.arms) byId('again').append(element('details', {}, element('summary', {}, `Resolved scenario of ${arm.name}`), element('pre', {}, arm.resolved)));
}

// Keeps to the last moment if it stood there, else where it was.
function fitSlider() {
  const slider = byId('time'), arm = chosen();
  if (!arm) return;
  const last = Math.max(0, arm.sights.frames.length - 1), follow = slider.value === slider.max;
  slider.max = last;
  slider.value = follow ? last : Math.min(slider.value, last);
}

function drawArms() {
  drawVersus();
  drawFacts();
  drawCurves();
  drawGrowth();
}

// Draws the whole page from `next`, which has the form of the data embedded in the file. A live view calls it again
// and again: the reader's choices stay.
function update(next) {
  data = next;
  drawHead();
  drawLegend();
  drawChecks();
  fitSlider();
  drawArms();
  drawMaps();
}

// --- what the reader does -----------------------------------------------------------------------------------

let playing = null;
function stop() {
  clearInterval(playing);
  playing = null;
  byId('play').textContent = 'Play';
}

byId('play').addEventListener('click', () => {
  if (playing) { stop(); return; }
  const slider = byId('time');
  if (slider.value === slider.max) slider.value = 0;
  byId('play').textContent = 'Pause';
  drawMaps();
  playing = setInterval(() => {
    slider.value = Number(slider.value) + 1;
    drawMaps();
    if (slider.value === slider.max) stop();
  }, 350);
});
byId('arm').addEventListener('change', () => {
  stop();
  byId('time').value = byId('time').max;
  fitSlider();
  drawMaps();
  drawGrowth();
});
byId('time').addEventListener('input', () => { stop(); drawMaps(); });
byId('linear').addEventListener('change', drawCurves);
dark.addEventListener('change', () => update(data));
update(data);
