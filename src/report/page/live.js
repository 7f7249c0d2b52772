
// --- the served page ----------------------------------------------------------------------------------------

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
    if (location.hash !== '#selftest') return;
    tell('drawn');
    if (drawn === 2) testPause();
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
      state: state.value, button: button.textContent, moments: Number(byId('time').max) + 1, errors }));
  };
  const testPause = () => {
    button.click();
    tell('paused');
    setTimeout(() => { tell('still'); button.click(); }, 2500);
  };
  source.onopen = () => { failures = 0; };
  source.onmessage = event => { waiting = event.data; draw(); };
  source.onerror = () => {
    failures += 1;
    if (failures < 5) { say('Connection lost; trying again.'); return; }
    source.close();
    say('Connection lost: the run is over, or was stopped. This is the last that came.');
  };
  const finish = () => {
    button.hidden = true;
    say('The run has ended; this is its last state.');
    if (location.hash === '#selftest') tell('end');
  };
  source.addEventListener('end', () => {
    source.close();
    ended = true;
    draw();
    if (waiting === null) finish();
    else say(`Paused at ${where(data)}. The run has ended: go on to see its last state.`);
  });
  button.addEventListener('click', () => {
    button.setAttribute('aria-pressed', !paused());
    button.textContent = paused() ? 'Go on' : 'Pause';
    if (paused()) { sayPaused(); return; }
    draw();
    if (ended) finish();
    else say(`Live: ${where(data)}.`);
  });
  document.addEventListener('visibilitychange', draw);
}

follow();
