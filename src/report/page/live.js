
// --- the served page ----------------------------------------------------------------------------------------

// Draws the newest data that the server has sent, unless the reader has paused or does not look.
function follow() {
  const state = element('output', { id: 'live' });
  const button = element('button', { type: 'button', class: 'arm', 'aria-pressed': 'false' }, 'Pause');
  document.querySelector('header').append(element('p', {}, button, ' ', state));
  const source = new EventSource('events');
  let waiting = null, drawn = 0, failures = 0, ended = false;
  const say = text => { state.value = text; };
  const paused = () => button.getAttribute('aria-pressed') === 'true';
  const draw = () => {
    if (waiting === null || paused() || document.hidden) return;
    const next = JSON.parse(waiting);
    waiting = null;
    update(next);
    drawn += 1;
    if (!ended) say(`Live: drawn at ${new Date().toLocaleTimeString()}.`);
    if (location.hash === '#selftest') tell('drawn');
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
    say('The run has ended; this is its last state.');
    button.hidden = waiting === null;
    if (location.hash === '#selftest') tell('end');
  });
  button.addEventListener('click', () => {
    button.setAttribute('aria-pressed', !paused());
    button.textContent = paused() ? 'Go on' : 'Pause';
    if (paused()) say('Paused; the run goes on.');
    draw();
  });
  document.addEventListener('visibilitychange', draw);
}

follow();
