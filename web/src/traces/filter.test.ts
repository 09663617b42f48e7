import { describe, expect, it } from 'vitest';
import type { Trace } from '../live/contract';
import { AllRows, filters, MatchingRows, NamedRows, no_filter, type Filter } from './filter';
import { chunk_rows, TraceStore } from './store';

const kinds = ['state', 'visualization', 'order', 'heartbeat'];
const agents = ['CoSiVA/AIV1', 'CoSiVA/AIV2', 'AIV_Server', 'Simulator', '*'];
/** Varied rows, the same in each run. */
const trace = (n: number): Trace => ({
  n, time_ms: n, from: agents[(n * 7) % 4]!, to: agents[(n * 3 + 1) % 5]!, kind: kinds[(n * 5) % 4]!, content: `Order ${n % 97} at loop_${n % 13}`,
});
function filled(count: number, max?: number): TraceStore {
  const store = new TraceStore(max);
  for (let n = 1; n <= count; n++) store.append(trace(n));
  return store;
}
/** Reference implementation of the filter, slow and simple. */
function expected(store: TraceStore, filter: Filter): number[] {
  const search_text = filter.text.toLowerCase().split(/\s+/).filter((word) => word !== '');
  const found: number[] = [];
  for (let seq = store.first; seq < store.end; seq++) {
    const { from, to, kind, content } = store.trace(seq);
    const names = [from, to, kind].map((name) => name.toLowerCase());
    const fits =
      (filter.agent === '' || from === filter.agent || to === filter.agent) && !filter.kinds_off.has(kind) && (filter.between === null || (filter.between.has(from) && filter.between.has(to))) &&
      search_text.every((word) => content.toLowerCase().includes(word) || names.some((name) => name.includes(word)));
    if (fits || store.is_note(seq)) found.push(seq);
  }
  return found;
}
const seqs_of = (list: { length: number; at(i: number): number }) => Array.from({ length: list.length }, (_, i) => list.at(i));
function search_all(rows: MatchingRows): void {
  while (!rows.complete) rows.search(() => false);
}
const filter = (more: Partial<Filter>): Filter => ({ ...no_filter, ...more });

describe('matching rows', () => {
  it.each<[string, Partial<Filter>]>([
    ['one agent, sender or receiver', { agent: 'CoSiVA/AIV2' }],
    ['kinds left out', { kinds_off: new Set(['heartbeat', 'visualization']) }],
    ['a word of the content, in any case', { text: 'ORDER 42' }],
    ['a word of a name and one of the content', { text: 'aiv1 loop_7' }],
    ['both ends among lifelines', { between: new Set(['CoSiVA/AIV1', 'AIV_Server']) }],
    ['all at once', { agent: 'CoSiVA/AIV1', kinds_off: new Set(['order']), text: 'loop', between: new Set(['CoSiVA/AIV1', 'AIV_Server', 'Simulator']) }],
    ['nothing that there is', { text: 'zeppelin' }],
  ])('are those with %s', (_, more) => {
    const store = filled(2 * chunk_rows + 300);
    store.note('12 messages were lost.', 1);
    const rows = new MatchingRows(store, filter(more));
    search_all(rows);
    expect(seqs_of(rows)).toEqual(expected(store, filter(more)));
  });

  it('exclude a word that begins in one message and ends in the next', () => {
    const store = new TraceStore();
    store.append({ ...trace(1), content: 'ab' });
    store.append({ ...trace(2), content: 'cdabc' });
    store.append({ ...trace(3), content: 'd' });
    const rows = new MatchingRows(store, filter({ text: 'abc' }));
    search_all(rows);
    expect(seqs_of(rows)).toEqual([1]);
  });

  it('are found even if a letter becomes longer in lower case', () => {
    const store = new TraceStore();
    for (let n = 1; n <= chunk_rows; n++) store.append({ ...trace(n), content: n === 9 ? 'İstanbul' : n === 10 ? 'needle' : 'hay' });
    const rows = new MatchingRows(store, filter({ text: 'needle' }));
    search_all(rows);
    expect(seqs_of(rows)).toEqual([9]);
  });

  it('are found newest first, slice by slice, with the list always in order', () => {
    const store = filled(5 * chunk_rows);
    const rows = new MatchingRows(store, filter({ agent: 'CoSiVA/AIV1' }));
    expect(rows.progress).toBe(0);
    rows.search(() => false);
    const first_slice = seqs_of(rows);
    expect(first_slice.at(-1)).toBe(expected(store, filter({ agent: 'CoSiVA/AIV1' })).at(-1));
    expect(rows.progress).toBeCloseTo(0.2, 5);
    rows.search(() => false);
    expect(seqs_of(rows).slice(-first_slice.length)).toEqual(first_slice);
    expect(seqs_of(rows)).toEqual([...seqs_of(rows)].sort((a, b) => a - b));
  });

  it('are appended for new messages, also during a search, including new names', () => {
    const store = filled(3 * chunk_rows);
    const wanted = filter({ text: 'aiv' });
    const rows = new MatchingRows(store, wanted);
    rows.search(() => false);
    for (let n = 1; n <= 600; n++) store.append({ ...trace(n), from: `CoSiVA/AIV${n}`, kind: `kind${n % 3}` });
    search_all(rows);
    expect(seqs_of(rows)).toEqual(expected(store, wanted));
  });

  it('are removed with the rows that the store drops', () => {
    const store = filled(2 * chunk_rows, 2 * chunk_rows);
    const wanted = filter({ agent: 'CoSiVA/AIV2' });
    const rows = new MatchingRows(store, wanted);
    for (let round = 0; round < 6; round++) {
      for (let n = 1; n <= chunk_rows; n++) store.append(trace(n));
      search_all(rows);
      rows.search(() => true);
      expect(seqs_of(rows)).toEqual(expected(store, wanted));
    }
  });

  it('can be queried for the row at an index, or the first after it', () => {
    const store = filled(500);
    const rows = new MatchingRows(store, filter({ agent: 'CoSiVA/AIV1' }));
    search_all(rows);
    for (const seq of [0, 77, 499, 5_000]) expect(rows.index_of(seq)).toBe(seqs_of(rows).filter((one) => one < seq).length);
  });
});

describe('other lists', () => {
  it('contain all rows of the store', () => {
    const store = filled(10);
    const rows = new AllRows(store);
    expect([rows.length, rows.at(3), rows.index_of(3), rows.index_of(99)]).toEqual([10, 3, 3, 10]);
  });
  it('of names lose rows that are no longer stored', () => {
    const store = filled(2 * chunk_rows, chunk_rows);
    const rows = new NamedRows([5, store.first + 1, store.first + 9], store);
    expect(seqs_of(rows)).toEqual([store.first + 1, store.first + 9]);
    expect(rows.index_of(store.first + 2)).toBe(1);
    expect(new NamedRows([], store).length).toBe(0);
  });
  it('without a filter contain everything', () => {
    expect(filters(no_filter)).toBe(false);
    expect(filters(filter({ text: '  ' }))).toBe(false);
    expect(filters(filter({ text: 'a' }))).toBe(true);
  });
});
