// Measures the page and sends the findings as JSON to the page around it.
const width = document.documentElement.clientWidth;
const found = { width, figures: 0, empty: [], outside: [], cut: [], overlapping: [], struck: [], scrolling: [], letters: [] };
const name = (e) => `${e.tagName}.${e.getAttribute('class') || ''} ${(e.textContent || '').trim().slice(0, 40)}`;
const box = (e) => e.getBoundingClientRect();

// Only what scrolls on its own may be wider than the window.
for (const e of document.body.querySelectorAll('*')) {
  const scrolls = e.closest('.scroll');
  const free = !scrolls || scrolls === e || getComputedStyle(scrolls).overflowX === 'visible';
  if (free && !e.closest('svg svg') && box(e).right > width + 1) found.outside.push(`${name(e)}: ${box(e).right}`);
}
if (document.documentElement.scrollWidth > width) found.outside.push(`page: ${document.documentElement.scrollWidth}`);

for (const table of document.querySelectorAll('.scroll > table')) {
  if (table.parentElement.scrollWidth > table.parentElement.clientWidth) found.scrolling.push(table.getAttribute('aria-label'));
}

for (const panel of document.querySelectorAll('svg.panel')) {
  found.figures += 1;
  const frame = box(panel);
  const title = panel.querySelector('.title').textContent;
  const plot = panel.querySelector('svg');
  const inked = [...plot.children].some((mark) => {
    const b = mark.getBBox();
    return b.width + b.height > 0 || /h0/.test(mark.getAttribute('d') || '');
  });
  const note = panel.querySelector('.note');
  if (frame.width < 150 || frame.height < 80 || !(inked || note)) found.empty.push(title);
  for (const text of panel.querySelectorAll(':scope > text')) {
    const b = box(text);
    const inside = b.left > frame.left - 1 && b.right < frame.right + 1 && b.top > frame.top - 1 && b.bottom < frame.bottom + 1;
    if (!inside) found.cut.push(`${title}: ${text.textContent}`);
  }
  // A name that an upright line runs through.
  const upright = [...panel.querySelectorAll('.rule')].map(box).filter((b) => b.width < 4);
  for (const text of panel.querySelectorAll('.words:not(.readout .words)')) {
    const b = box(text);
    const struck = (line) => line.left > b.left && line.right < b.right && line.top < b.bottom && line.bottom > b.top;
    if (upright.some(struck)) found.struck.push(`${title}: ${text.textContent}`);
  }
  // Height of the ticks' letters in the window.
  const tick = panel.querySelector('.tick');
  if (tick) found.letters.push(parseFloat(getComputedStyle(tick).fontSize) * tick.getScreenCTM().d);
  for (const axis of ['x', 'y']) {
    const ticks = [...panel.querySelectorAll(`.tick.${axis}`)].map((t) => [box(t), t.textContent]);
    for (let i = 1; i < ticks.length; i += 1) {
      const [a, b] = [ticks[i - 1][0], ticks[i][0]];
      const apart = a.right <= b.left + 0.5 || b.right <= a.left + 0.5 || a.bottom <= b.top + 2 || b.bottom <= a.top + 2;
      if (!apart) found.overlapping.push(`${title}: ${ticks[i - 1][1]} ${ticks[i][1]}`);
    }
  }
}
parent.postMessage(JSON.stringify(found), '*');
