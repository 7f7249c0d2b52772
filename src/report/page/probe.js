// --- values under the pointer, the finger or the arrow keys ---------------------------------------------------

const tip = element('div', { id: 'tip', role: 'status', hidden: '' });
document.body.append(tip);
let probed = null; // Takes back what is shown.

function unprobe() {
  if (probed) probed();
  probed = null;
  tip.hidden = true;
}

// Makes `node` tell what is in it. `find(x, y)`, in its pixels, and `go(item, key)`, from the item before, which may be null, give an item
// or null; `tell(item)` gives {x, y, lines}; `mark(item)` shows it in the figure, and takes back what it showed if the item is null.
function probe(node, { find, go, tell, mark }) {
  let here = null;
  const clear = () => { here = null; mark(null); };
  const show = item => {
    if (item === null) { unprobe(); return; }
    if (probed !== clear) unprobe();
    probed = clear;
    here = item;
    mark(item);
    const { x, y, lines } = tell(item), box = node.getBoundingClientRect();
    tip.replaceChildren(...lines);
    tip.hidden = false;
    const left = Math.min(box.left + x + 14, document.documentElement.clientWidth - tip.offsetWidth - 8);
    const above = box.top + y - tip.offsetHeight - 14;
    tip.style.left = `${Math.max(8, left)}px`;
    tip.style.top = `${above > 8 ? above : box.top + y + 18}px`;
  };
  const point = event => {
    const box = node.getBoundingClientRect();
    show(find(event.clientX - box.left, event.clientY - box.top));
  };
  node.tabIndex = 0;
  node.classList.add('probe');
  node.addEventListener('pointermove', point);
  node.addEventListener('pointerdown', point);
  // What a finger has shown stays until it touches something else.
  node.addEventListener('pointerleave', event => { if (event.pointerType !== 'touch') unprobe(); });
  node.addEventListener('blur', unprobe);
  node.addEventListener('keydown', event => {
    if (event.key === 'Escape') unprobe();
    if (!event.key.startsWith('Arrow')) return;
    event.preventDefault();
    show(go(here, event.key) ?? here);
  });
}

addEventListener('pointerdown', event => { if (!event.target.closest?.('.probe')) unprobe(); });
addEventListener('scroll', unprobe, { passive: true });

const head = text => element('b', {}, text);
const line = (name, value, ...before) => element('div', {}, ...before, element('span', {}, name), element('span', {}, value));
