// The sequence diagram as a self-contained SVG file, with its colours and fonts, for use in a paper.
import { gutter_of, row_px, type Arrow, type Lifeline } from './sequence';
import { summary_of, time_of_day } from './text';

export const head_px = 36;
export interface Colours {
  ground: string;
  ink: string;
  quiet: string;
  line: string;
  accent: string;
}

const escaped = (text: string) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('>', '&gt;').replaceAll('"', '&quot;');
export const cut = (text: string, letters: number) => (text.length <= letters ? text : `${text.slice(0, Math.max(1, letters - 1))}…`);

/** The label of an arrow, shortened to the available length. */
export function words_of(arrow: Pick<Arrow, 'kind' | 'content'>, length_px: number): string {
  return cut(`${arrow.kind}  ${summary_of(arrow.content)}`, Math.floor((Math.max(length_px, 90) - 22) / 5.9));
}

export function svg_of(title: string, lines: readonly Lifeline[], arrows: readonly Arrow[], width: number, colours: Colours): string {
  const top = 34 + head_px;
  const height = top + arrows.length * row_px + 18;
  const parts = [
    `<svg xmlns="http://www.w3.org/2000/svg" width="${Math.ceil(width)}" height="${height}" viewBox="0 0 ${Math.ceil(width)} ${height}" font-family="system-ui, sans-serif" font-size="12">`,
    `<title>${escaped(title)}</title><rect width="100%" height="100%" fill="${colours.ground}"/>`,
    `<text x="14" y="23" font-size="14" font-weight="600" fill="${colours.ink}">${escaped(title)}</text>`,
    `<defs><marker id="tip" markerWidth="9" markerHeight="9" refX="8" refY="4.5" orient="auto"><path d="M0 0.8L8 4.5L0 8.2z" fill="${colours.accent}"/></marker></defs>`,
  ];
  for (const { x, label } of lines) {
    const half = (label.length * 7 + 18) / 2;
    parts.push(
      `<line x1="${x}" x2="${x}" y1="${top - 7}" y2="${height - 8}" stroke="${colours.line}" stroke-dasharray="4 4"/>`,
      `<rect x="${x - half}" y="${top - 33}" width="${2 * half}" height="26" rx="5" fill="${colours.ground}" stroke="${colours.quiet}"/>`,
      `<text x="${x}" y="${top - 15}" text-anchor="middle" font-weight="600" fill="${colours.ink}">${escaped(label)}</text>`,
    );
  }
  arrows.forEach((arrow, i) => {
    const y = top + i * row_px + row_px - 9;
    parts.push(`<text x="10" y="${y + 4}" font-size="11" fill="${colours.quiet}">${time_of_day(arrow.time_ms)}</text>`);
    if (arrow.note) parts.push(`<text x="${gutter_of(width) + 6}" y="${y + 2}" font-style="italic" fill="${colours.quiet}">${escaped(arrow.content)}</text>`);
    for (const leg of arrow.legs)
      parts.push(`<path d="${path_of(leg.x0, leg.x1, y)}" fill="none" stroke="${colours.accent}" stroke-width="1.4"${leg.radio ? ' stroke-dasharray="6 3"' : ''} marker-end="url(#tip)"/>`);
    if (arrow.legs.length === 0) return;
    const span = span_of(arrow);
    parts.push(`<text x="${span.x}" y="${y - 6}" text-anchor="${span.anchor}" font-size="11.5" fill="${colours.ink}" stroke="${colours.ground}" stroke-width="4" paint-order="stroke">${escaped(words_of(arrow, span.length))}</text>`);
  });
  parts.push('</svg>');
  return parts.join('\n');
}

/** The SVG path of an arrow; a message of an agent to itself is a small loop right of its lifeline. */
export function path_of(x0: number, x1: number, y: number): string {
  return x0 === x1 ? `M${x0} ${y - 10}h16q5 0 5 5t-5 5h-14` : `M${x0} ${y}L${x1 + (x1 > x0 ? -1 : 1)} ${y}`;
}
/** The position of a label, centred between sender and receiver. */
export function span_of(arrow: Arrow): { x: number; length: number; anchor: 'start' | 'middle' } {
  const from = arrow.legs[0]!.x0;
  const to = arrow.legs.at(-1)!.x1;
  return from === to ? { x: from + 26, length: 200, anchor: 'start' } : { x: (from + to) / 2, length: Math.abs(to - from), anchor: 'middle' };
}
