// --- with #selftest the page operates itself and writes down what it saw ---------------------------------------

// What is said at the arrow key's first stop in `node`, and at its second.
function saidAt(node) {
  const press = key => node.dispatchEvent(new KeyboardEvent('keydown', { key, cancelable: true }));
  const stops = ['ArrowLeft', 'ArrowLeft'].map(key => { press(key); return tip.hidden ? null : tip.textContent; });
  press('Escape');
  return tip.hidden ? stops : null;
}

// What is said in the middle of `node`.
function saidUnder(node) {
  const { left, top, width, height } = node.getBoundingClientRect();
  node.dispatchEvent(new PointerEvent('pointermove', { clientX: left + width / 2, clientY: top + height / 2 }));
  const said = tip.hidden ? '' : tip.textContent, box = tip.getBoundingClientRect();
  node.dispatchEvent(new PointerEvent('pointerleave'));
  return box.left >= 0 && box.right <= innerWidth && tip.hidden ? said : '';
}

// Whether the texts at the ends of curves are in their picture and apart.
function labelsAreFree(svg) {
  const labels = [...svg.querySelectorAll('.label')], right = svg.getBoundingClientRect().right;
  const heights = labels.map(label => Number(label.getAttribute('y'))).sort((a, b) => a - b);
  return labels.every(label => label.getBoundingClientRect().right <= right + 1) && heights.every((y, i) => !i || y - heights[i - 1] > 13);
}

function selfTest() {
  const result = {};
  const slider = byId('time');
  const look = () => byId('maps').querySelector('canvas').toDataURL();
  if (chosen()) {
    const late = look(), moment = byId('moment').value;
    result.sliderStartsAtTheEnd = slider.value === slider.max;
    slider.value = 0;
    slider.dispatchEvent(new Event('input'));
    result.sliderMoves = look() !== late && byId('moment').value !== moment;
    update(data);
    result.updateKeepsTheMoment = slider.value === '0';
    slider.value = slider.max;
    slider.dispatchEvent(new Event('input'));
    result.sliderComesBack = look() === late;
  }
  const first = byId('curves').querySelector('svg'), charts = [...document.querySelectorAll('#curves svg,#growth svg')];
  const labels = [...first.querySelectorAll('.label')].map(label => label.firstChild.data);
  result.curvesHaveLabels = data.arms.every(arm => labels.some(text => text.replace('= ', '').startsWith(arm.label.slice(0, 8))));
  result.labelsAreFree = charts.every(labelsAreFree);
  result.twins = labels.filter(text => text.startsWith('= '));
  const under = saidUnder(first);
  result.pointerTells = under.startsWith('episode') && data.arms.every(arm => under.includes(arm.label));
  result.keysTell = [...document.querySelectorAll('main svg,main canvas')].every(figure => {
    const said = figure.matches('.probe') ? saidAt(figure) : null;
    return said && said.every(Boolean) && (said[0] !== said[1] || !figure.closest('#curves'));
  });
  if (chosen()) [result.policy] = saidAt([...byId('maps').querySelectorAll('canvas')].at(-1));
  result.states = [...byId('each').rows].map(row => row.textContent);
  const curves = () => byId('curves').querySelectorAll('path[data-arm="0"]').length;
  const before = curves(), press = () => byId('legend').querySelector('button').click();
  press();
  result.armSwitchesOff = before >= 2 && curves() === 0;
  update(data);
  result.updateKeepsArmsOff = curves() === 0;
  press();
  result.armComesBack = curves() === before;
  const drawn = () => byId('curves').querySelector('path').getAttribute('d');
  const log = drawn();
  byId('linear').click();
  result.axisSwitches = drawn() !== log;
  byId('linear').click();
  result.figuresHaveText = [...document.querySelectorAll('svg,canvas')].every(f => f.getAttribute('role') === 'img' && f.getAttribute('aria-label'));
  result.numbersAreFinite = !/NaN|undefined|Infinity/.test(document.querySelector('main').innerHTML);
  result.fitsWidth = document.documentElement.scrollWidth <= innerWidth;
  result.noRequests = performance.getEntriesByType('resource').length === 0;
  result.errors = errors;
  document.body.append(element('pre', { id: 'selftest' }, JSON.stringify(result)));
  // A page in a frame, which may be narrower than any window, tells the page around it.
  if (parent !== window) parent.postMessage(JSON.stringify(result), '*');
}

if (location.hash === '#selftest') selfTest();
