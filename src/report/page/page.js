// --- the page -----------------------------------------------------------------------------------------------

// Everything is drawn from these two: `update` replaces the first, the reader the second.
let data = JSON.parse(byId('data').textContent);
// A page about several worlds has a part for each.
const worlds = [data, ...data.others ?? []];
const hidden = new Set();
const visible = () => data.arms.map((arm, i) => [arm, i]).filter(([arm]) => !hidden.has(arm.name));
const chosen = () => data.arms[Number(byId('arm').value)];

function drawHead() {
  byId('bands').textContent = data.arms.some(arm => arm.seeds.length > 1) ? `Lines and bands: ${data.statistic}. ` : '';
  document.querySelector('h1').textContent = data.title;
  byId('headline').textContent = data.headline;
  byId('about').textContent = `${data.program}. ${data.notes.join(' ')}`;
}

function drawLegend() {
  const before = byId('arm').value;
  byId('legend').replaceChildren();
  byId('arm').replaceChildren();
  data.arms.forEach((arm, i) => {
    const button = element('button', { class: 'arm', type: 'button', 'aria-pressed': !hidden.has(arm.name) }, swatch(i), arm.name);
    button.addEventListener('click', () => {
      if (!hidden.delete(arm.name)) hidden.add(arm.name);
      button.setAttribute('aria-pressed', !hidden.has(arm.name));
      drawArms();
    });
    byId('legend').append(button);
    if (arm.sights) byId('arm').append(element('option', { value: i }, arm.label.includes('seed ') ? arm.label : `${arm.label}, seed ${arm.seeds[0]}`));
  });
  const options = [...byId('arm').options].map(option => option.value);
  // The potential is what one came to see.
  const first = data.arms.findIndex(arm => arm.sights && arm.sights.frames.some(frame => frame.vectors.length));
  byId('arm').value = options.includes(before) ? before : options.includes(String(first)) ? first : options[0];
  byId('seen').hidden = !options.length;
}

// What each arm is, in its own words.
function drawAbout() {
  const parent = byId('arms');
  parent.replaceChildren();
  data.arms.forEach((arm, i) => {
    if (arm.about) parent.append(element('div', {}, element('dt', {}, swatch(i), arm.name), element('dd', {}, arm.about)));
  });
  byId('compared').hidden = !parent.children.length;
}

function drawWorlds() {
  const nav = byId('worlds');
  nav.hidden = worlds.length < 2;
  nav.replaceChildren(element('span', {}, `${worlds.length} worlds:`), ...worlds.map(world => {
    const button = element('button', { type: 'button', 'aria-pressed': world === data }, world.title);
    button.addEventListener('click', () => {
      stop();
      hidden.clear();
      update(world);
      byId('time').value = byId('time').max;
      drawMaps();
    });
    return button;
  }));
}

function drawVersus() {
  const parent = byId('versus');
  parent.replaceChildren();
  const rows = key => visible().map(([arm, i]) => ({ name: arm.name, arm: i, value: arm.versus[key].median ?? arm.versus[key].value ?? null,
    low: arm.versus[key].low, high: arm.versus[key].high }));
  parent.hidden = !data.arms.some(arm => arm.versus);
  if (parent.hidden) return;
  forest(parent, { title: 'Regret against the sparse arm', xTitle: 'regret ÷ that of sparse, log scale', note: 'Medians over seeds, each against sparse with the same seed', rows: rows('ratio'), line: 1, log: true });
  forest(parent, { title: 'Chance of less regret than the sparse arm', xTitle: 'probability of improvement', note: 'Over all pairs of runs', rows: rows('improvement'), line: .5, range: [0, 1] });
}

function drawFacts() {
  const table = byId('facts');
  byId('statistic').textContent = `Numbers: ${data.statistic}.`;
  const arms = visible();
  table.replaceChildren(element('tr', {}, element('td', {}), ...arms.map(([arm]) => element('th', { scope: 'col' }, arm.label))));
  const known = arms.map(([arm]) => new Map(arm.facts));
  // What an earlier version has not noted is missing.
  for (const name of new Set(data.arms.flatMap(arm => arm.facts.map(([name]) => name)))) {
    table.append(element('tr', {}, element('th', { scope: 'row' }, name), ...known.map(facts => element('td', {}, (facts.get(name) ?? '–').replace(/(?<![^ [])-(?=\d)/g, '−')))));
  }
}

// How the curves of an arm look, and what they are called.
const look = (arm, i) => ({ name: arm.name, label: arm.label, color: color(i), dash: again(i) ? '9 4' : undefined });

function drawCurves() {
  const parent = byId('curves');
  parent.replaceChildren();
  const bands = key => visible().filter(([arm]) => arm[key]).map(([arm, i]) => ({ x: arm.episodes, y: arm[key].middle,
    low: arm.seeds.length > 1 ? arm[key].low : null, high: arm.seeds.length > 1 ? arm[key].high : null, ...look(arm, i), arm: i }));
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
  const discovered = value => seen.map(([arm, i]) => ({ ...over(arm.sights.frames, value), ...look(arm, i) }));
  if (seen.length) {
    chart(parent, { title: 'States discovered', ...steps, yTitle: 'states', series: discovered(f => f.nodes) });
    chart(parent, { title: 'Edges discovered', ...steps, yTitle: 'edges', series: discovered(f => f.edges) });
  }
  const arm = chosen();
  if (arm) drawEigenvalues(parent, arm, steps);
  const effort = key => visible().flatMap(([arm, i]) => {
    const rows = arm.solver.filter(r => r[key] !== null);
    return rows.length ? [{ x: rows.map(r => r.step), y: rows.map(r => r[key]), ...look(arm, i) }] : [];
  });
  const efforts = (title, yTitle, key, log) => {
    const series = effort(key);
    // Of what never happened there is nothing to see.
    if (series.some(s => s.y.some(v => v > 0))) chart(parent, { title, ...steps, yTitle, series, log });
  };
  efforts('Products of the eigensolver', 'products in each refresh', 'applications', false);
  efforts('Solves of the eigensolver', 'solves in each refresh', 'solves', false);
  efforts('Residual of the eigenvectors kept', '‖Lv − λv‖ ÷ λₖ, log scale', 'residual', true);
  efforts('Loss of the network after each fit', 'loss, log scale', 'loss', true);
  const timed = visible().filter(([arm]) => arm.phases);
  if (timed.length) bars(parent, { title: 'Where the time of a run went', parts: ['eigensolver', 'fits', 'environment, graph, learner'],
    rows: timed.map(([arm]) => ({ name: arm.label, parts: [arm.phases.spectrum, arm.phases.fit, arm.phases.rest] })) });
}

function drawEigenvalues(parent, arm, steps) {
  const known = arm.sights.frames.filter(f => f.eigenvalues.length);
  const count = Math.max(0, ...known.map(f => f.eigenvalues.length));
  const series = [];
  for (let k = 1; k < count; k++) {
    const frames = known.filter(f => f.eigenvalues.length > k && f.eigenvalues[k] > 1e-12);
    series.push({ x: frames.map(f => f.step), y: frames.map(f => f.eigenvalues[k]), name: `λ${k + 1}`, label: k === 1 || k === count - 1 ? `λ${k + 1}` : '', color: paint(VIRIDIS, (dark.matches ? .25 : 0) + .7 * k / count), thin: true });
  }
  if (series.length) chart(parent, { title: `Eigenvalues of ${arm.label}, without λ1 = 0`, ...steps, yTitle: 'λ, log scale', series, log: true });
}

function drawMaps() {
  const arm = chosen(), parent = byId('maps');
  parent.replaceChildren();
  if (!arm) return;
  const { sights } = arm, frame = sights.frames[Number(byId('time').value)], end = sights.frames[sights.frames.length - 1];
  const text = `step ${count(frame.step)}: ${count(frame.nodes)} states, ${count(frame.edges)} edges`;
  byId('moment').value = text;
  byId('time').setAttribute('aria-valuetext', text);
  const place = sights.map ? 'Blank: not yet discovered.' : 'Placed by the second and third eigenvector.';
  mapFigure(parent, 'Potential φ (reward)', sights, unpack(frame.potential), place);
  frame.vectors.forEach((vector, k) => mapFigure(parent, `Eigenvector v${k + 2}, times √n`, sights, unpack(vector),
    sights.map ? 'Its sign follows the moment before. Blank: not yet in a spectrum.' : 'Its sign follows the moment before.', { signed: true }));
  mapFigure(parent, 'Visits in the whole run', sights, unpack(sights.visits), 'log₁₀ of 1 + times that a state was left.',
    { text: v => `${count(10 ** v - 1)} times left` });
  if (sights.greedy.length || sights.next.length) mapFigure(parent, 'Greedy policy on φ, at the end', sights, unpack(end.potential),
    'The likeliest action, with the advice of φ, while nothing is searched for; none where nothing was learnt.', { arrows: sights.map ? sights.greedy : sights.next });
  drawStates(sights, frame);
}

// States that a table has rows for.
const ROWS = 200;

// What was seen and learnt in each state of a world that has no map to look at.
function drawStates(sights, frame) {
  byId('states').hidden = Boolean(sights.map);
  if (sights.map) return;
  const table = byId('each'), potential = unpack(frame.potential), visits = unpack(sights.visits);
  const shown = Math.min(ROWS, visits.length);
  byId('listed').textContent = shown < visits.length ? `The first ${shown} of ${count(visits.length)} states, by name` : 'All states, by name';
  table.replaceChildren(element('tr', {}, ...['state', 'potential φ', 'times left', 'action held best', 'leads to'].map(name => element('th', { scope: 'col' }, name))));
  for (let i = 0; i < shown; i++) {
    const action = sights.greedy[i] ?? null, next = sights.next[i] ?? null;
    table.append(element('tr', {}, element('th', { scope: 'row' }, nameOf(sights, i)),
      ...[potential[i] === undefined || potential[i] === null ? '–' : number(potential[i]), count(10 ** visits[i] - 1),
        action === null ? '–' : actionOf(sights, action), next === null ? '–' : nameOf(sights, next)].map(text => element('td', {}, text))));
  }
}

function drawChecks() {
  const parent = byId('checks');
  parent.replaceChildren();
  byId('again').replaceChildren();
  for (const arm of data.arms) {
    if (!arm.checks.length) continue;
    const card = element('div', { class: 'card' }, element('h3', {}, arm.name));
    for (const { name, holds, detail } of arm.checks) {
      const [sign, word, kind] = holds === null ? ['–', 'no verdict', ''] : holds ? ['✓', 'yes', 'yes'] : ['✗', 'no', 'no'];
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
  unprobe();
  drawWorlds();
  drawHead();
  drawAbout();
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
// Charts are drawn as wide as there is room, so that their letters keep their size.
let drawnWidth = byId('curves').clientWidth;
new ResizeObserver(() => {
  const width = byId('curves').clientWidth;
  if (width === drawnWidth) return;
  drawnWidth = width;
  drawArms();
}).observe(byId('curves'));
update(data);
