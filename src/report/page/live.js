
// --- the served page ----------------------------------------------------------------------------------------

const OVER = 'The run has ended; this is its last state.';

// Draws the newest data that the server has sent, unless the reader has paused or does not look.
function follow() {
  const state = element('output', { id: 'live' });
  const button = element('button', { type: 'button', id: 'pause', 'aria-pressed': 'false' }, 'Pause');
  document.querySelector('header').append(element('p', { class: 'live' }, button, state));
  const source = new EventSource('events');
  let waiting = null, drawn = 0, failures = 0, ended = false;
  const say = text => { state.value = text; };
  // Where the run was when it sent this.
  const where = ({ arms: [arm] }) => {
    const step = arm.sights.frames.at(-1)?.step ?? 0, episodes = arm.episodes.at(-1) ?? 0;
    return `step ${count(step)}, ${count(episodes)} episode${episodes === 1 ? '' : 's'} ended`;
  };
  const paused = () => button.getAttribute('aria-pressed') === 'true';
  const draw = () => {
    if (waiting === null || document.hidden) return;
    if (paused()) { sayPaused(); return; }
    if (!ended && !tip.hidden) return; // Somebody is reading a value: the next one will do.
    const next = JSON.parse(waiting);
    waiting = null;
    update(next);
    drawn += 1;
    if (!ended) say(`Live: ${where(next)}, at ${new Date().toLocaleTimeString()}.`);
    if (location.hash === '#selftest') tell('drawn');
  };
  const sayPaused = () => {
    const now = waiting === null ? '' : `; the run is at ${where(JSON.parse(waiting))}`;
    say(`Paused at ${where(data)}${now}.`);
  };
  // With #selftest the page tells on the console what it has done.
  const tell = what => {
    const frames = data.arms[0].frames ?? data.arms[0].sights.frames;
    const episodes = data.arms[0].episodes;
    console.log('selftest ' + JSON.stringify({ what, drawn, step: frames.at(-1).step, episodes: episodes.at(-1),
      state: state.value, moments: Number(byId('time').max) + 1, errors }));
  };
  source.onopen = () => { failures = 0; };
  source.onmessage = event => { waiting = event.data; draw(); };
  source.onerror = () => {
    failures += 1;
    if (failures < 5) { say('Connection lost; trying again.'); return; }
    source.close();
    say('Connection lost: the run is over, or was stopped. This is the last that came.');
  };
  source.addEventListener('end', () => {
    source.close();
    ended = true;
    draw();
    say(waiting === null ? OVER : `Paused at ${where(data)}. The run has ended: go on to see its last state.`);
    button.hidden = waiting === null;
    if (location.hash === '#selftest') tell('end');
  });
  button.addEventListener('click', () => {
    button.setAttribute('aria-pressed', !paused());
    button.textContent = paused() ? 'Go on' : 'Pause';
    if (paused()) { sayPaused(); return; }
    draw();
    say(ended ? OVER : `Live: ${where(data)}.`);
    button.hidden = ended;
  });
  document.addEventListener('visibilitychange', draw);
}

follow();
