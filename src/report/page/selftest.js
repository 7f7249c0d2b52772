// --- with #selftest the page operates itself and writes down what it saw ---------------------------------------

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
}

if (location.hash === '#selftest') selfTest();
