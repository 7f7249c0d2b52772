// --- texts beside what they name ------------------------------------------------------------------------------

const FONT = '13px system-ui, -apple-system, "Segoe UI", Helvetica, Arial, sans-serif';
const pen = document.createElement('canvas').getContext('2d');
function textWidth(text) {
  pen.font = FONT;
  return pen.measureText(text).width;
}

// The text, or as much of it as has room.
function fitted(text, width) {
  if (textWidth(text) <= width) return text;
  let kept = text.length;
  while (kept > 1 && textWidth(text.slice(0, kept) + '…') > width) kept -= 1;
  return text.slice(0, kept).trimEnd() + '…';
}

// The text in lines that have room, broken behind commas; in four of them as much as has room.
function wrapped(text, width) {
  const lines = [];
  for (const word of text.split(/(?<=,) /)) {
    const longer = lines.length ? `${lines.at(-1)} ${word}` : word;
    if (lines.length && (textWidth(longer) <= width || lines.length === 4)) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines.map(line => fitted(line, width));
}

// Heights from `top` to `bottom` in the order of the wanted ones, each `gaps` below the one before at least, as near to the wanted ones
// as can be: neighbours that are too near share the mean of what they want.
function spread(wanted, gaps, top, bottom) {
  const order = wanted.map((_, i) => i).sort((a, b) => wanted[a] - wanted[b] || a - b);
  let room = 0;
  const below = order.map((i, rank) => room += rank ? gaps[i] : 0);
  const blocks = [], mean = block => block.sum / block.count;
  order.forEach((i, rank) => {
    blocks.push({ sum: wanted[i] - below[rank], count: 1 });
    while (blocks.length > 1 && mean(blocks.at(-2)) > mean(blocks.at(-1))) {
      const last = blocks.pop();
      blocks.at(-1).sum += last.sum;
      blocks.at(-1).count += last.count;
    }
  });
  const placed = new Array(wanted.length);
  let rank = 0;
  for (const block of blocks) {
    const from = Math.min(Math.max(mean(block), top), Math.max(top, bottom - room));
    for (let k = 0; k < block.count; k++, rank++) placed[order[rank]] = from + below[rank];
  }
  return placed;
}

// Series that are the same in every point hide each other: they share a line.
function twins(series) {
  const groups = new Map();
  for (const s of series) {
    const key = JSON.stringify([s.x, s.y]);
    groups.set(key, [...groups.get(key) ?? [], s]);
  }
  return [...groups.values()];
}
