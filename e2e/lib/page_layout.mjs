// What a browser can measure of the page's layout: overlaps, cut texts, horizontal scrolling, contrast.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

export const sizes = [[390, 844], [768, 1024], [1366, 768], [1920, 1080]];
const axe_source = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

/** Sentences on controls of the top bar and of the frames' title lines that overlap, are cut, or make the page scroll. */
export function layout_faults(page) {
  return page.evaluate(() => {
    const name = (element) => `“${(element.getAttribute('aria-label') ?? element.textContent).trim().replace(/\s+/g, ' ')}”`;
    const shown = (element) => element.getClientRects().length > 0 && getComputedStyle(element).clipPath === 'none';
    const faults = [];
    if (document.documentElement.scrollWidth > innerWidth) faults.push(`the page is ${document.documentElement.scrollWidth} px wide`);
    for (const line of document.querySelectorAll('.page > header, .frame > header')) {
      const box = line.getBoundingClientRect();
      const controls = [...line.querySelectorAll('button, input, select, time, span.pill, h1, h2, .count')].filter(shown);
      const boxes = controls.map((control) => control.getBoundingClientRect());
      controls.forEach((control, i) => {
        const own = boxes[i];
        const apart = (other) => other.right <= own.left + 1 || other.left >= own.right - 1 || other.bottom <= own.top + 1 || other.top >= own.bottom - 1;
        if (own.width === 0) return;
        if (own.left < box.left - 1 || own.right > box.right + 1 || own.bottom > box.bottom + 1 || own.right > innerWidth + 1) faults.push(`${name(control)} leaves its line`);
        if (!/INPUT|SELECT/.test(control.tagName) && control.scrollWidth > control.clientWidth + 1 && control.clientWidth > 0) faults.push(`${name(control)} is cut`);
        controls.slice(i + 1).forEach((other, k) => {
          if (!control.contains(other) && !apart(boxes[i + 1 + k])) faults.push(`${name(control)} and ${name(other)} overlap`);
        });
      });
    }
    return faults;
  });
}

/** Texts with too little contrast, by axe. */
export async function contrast_faults(page) {
  if (!(await page.evaluate(() => 'axe' in globalThis))) await page.evaluate(axe_source);
  const { violations, passes } = await page.evaluate(() => globalThis.axe.run(document, { runOnly: ['color-contrast'], resultTypes: ['violations'] }));
  assert.ok(passes.length > 0, 'axe evaluated something');
  return violations.flatMap(({ nodes }) => nodes.map((node) => `${node.html.slice(0, 120)} ${node.failureSummary?.split('\n')[1] ?? ''}`));
}

/** The table of states: how many columns it has, which headings are cut, and whether the names stay visible when it is scrolled to its end. */
export function table_layout(page) {
  return page.evaluate(async () => {
    const box = document.querySelector('[data-testid=states-table]');
    const frame = box.closest('.frame').getBoundingClientRect();
    box.scrollLeft = box.scrollWidth;
    await new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)));
    const within = (element) => {
      const { left, right } = element.getBoundingClientRect();
      return left >= frame.left - 1 && right <= frame.right + 1;
    };
    const headings = [...box.querySelectorAll('th')];
    const found = {
      columns: headings.length,
      cut: headings.flatMap((heading) => [...heading.querySelectorAll('button')]).filter((button) => button.scrollWidth > button.clientWidth + 1).map((button) => button.textContent),
      names: [...box.querySelectorAll('tbody td.name')].every(within) && box.querySelectorAll('tbody td.name').length > 0,
      end: within(headings.at(-1)),
    };
    box.scrollLeft = 0;
    return found;
  });
}

/** The sequence diagram: arrows and lifelines that are completely visible, the least size of letters, and whether the newest message is visible. */
export function sequence_layout(page) {
  return page.evaluate(() => {
    const box = document.querySelector('[data-testid=sequence]');
    const frame = box.getBoundingClientRect();
    const head = box.querySelector('svg.heads').getBoundingClientRect();
    const inside = ({ left, right, top, bottom }, from = frame.top) => left >= frame.left - 1 && right <= frame.right + 1 && top >= from - 1 && bottom <= frame.bottom + 1;
    const arrows = [...box.querySelectorAll('[data-arrow]')].filter((arrow) => inside(arrow.querySelector('.band').getBoundingClientRect(), head.bottom));
    const texts = [...box.querySelectorAll('.arrow text:not(.unseen), .heads text')];
    return {
      arrows: arrows.length,
      newest: arrows.some((arrow) => arrow.getAttribute('aria-posinset') === arrow.getAttribute('aria-setsize')),
      lifelines: [...box.querySelectorAll('.heads rect')].filter((rect) => inside(rect.getBoundingClientRect())).length,
      letters_px: Math.min(...texts.map((text) => parseFloat(getComputedStyle(text).fontSize))),
    };
  });
}
