import { describe, expect, it } from 'vitest';
import { agent_label, arrow_of, find_figure, first_agents, in_order, lifelines } from './sequence';
import { path_of, span_of, svg_of, words_of } from './sequence_svg';
import { proxy_of, TraceStore } from './store';
import { csv_line, Export, ndjson_line, summary_of } from './text';
import { AllRows } from './filter';

type Message = [from: string, to: string, kind: string, content?: string, via?: string];
function store_of(...messages: Message[]): TraceStore {
  const store = new TraceStore();
  messages.forEach(([from, to, kind, content = '', via], i) => store.append({ n: i + 1, time_ms: i, from, to, ...(via && { via }), kind, content }));
  return store;
}
const zone_exchange: Message[] = [
  ['physical side', 'AIV_Server', 'zone', 'toml, 2777 bytes'],
  ['AIV_Server', 'Simulator', 'zoneConfiguration'],
  ['Simulator', 'RTM', 'initialise'],
  ['Simulator', 'RTM', 'circuitFactory'],
  ['RTM', 'Simulator', 'circuitFactory'],
  ['Simulator', 'CircuitFactory', 'circuit'],
  ['CircuitFactory', 'Simulator', 'circuit'],
  ['Simulator', 'Circuit', 'draw'],
  ['Circuit', 'Simulator', 'draw'],
];
const heartbeat: Message = ['AIV_Server', '*', 'heartbeat'];
const kinds_of = (store: TraceStore, seqs: readonly number[]) => seqs.map((seq) => store.kind(seq));

describe('the article’s exchanges', () => {
  it('figure 8 is the whole exchange from the configuration to the drawn circuit, and nothing else', () => {
    const store = store_of(heartbeat, ...zone_exchange, ['CoSiVA/AIV1', 'AIV_Server', 'state'], ['AIV_Server', 'Simulator', 'appear', 'CoSiVA/AIV1 gets display number 1']);
    const found = find_figure(store, 'figure 8')!;
    expect(found.seqs).toEqual([1, 2, 3, 4, 5, 6, 7, 8, 9]);
    expect(found.agents).toEqual(['physical side', 'AIV_Server', 'Simulator', 'RTM', 'CircuitFactory', 'Circuit']);
  });
  it('figure 8 is the latest such exchange, and ends where a configuration is refused', () => {
    const store = store_of(...zone_exchange, heartbeat, ['AIV_Server', 'Simulator', 'zoneConfiguration'], ['Simulator', 'RTM', 'initialise'], ['RTM', 'Simulator', 'refused', 'no circuit'], ['Simulator', 'Circuit', 'draw']);
    expect(kinds_of(store, find_figure(store, 'figure 8')!.seqs)).toEqual(['zone', 'zoneConfiguration', 'initialise', 'refused'].slice(1));
  });
  it('figure 9 goes from the arrival over the display number to the first reports, through the proxy', () => {
    const store = store_of(
      ['CoSiVA/AIV2', 'AIV_Server', 'connection', 'ONLINE'], ['CoSiVA/AIV1', 'AIV_Server', 'state'], ['CoSiVA/AIV2', 'AIV_Server', 'state'],
      ['AIV_Server', 'Simulator', 'appear', 'CoSiVA/AIV2 gets display number 2'], ['AIV_Server', 'CoSiVA/AIV2', 'order'], heartbeat, ['CoSiVA/AIV2', 'AIV_Server', 'visualization'],
    );
    const found = find_figure(store, 'figure 9')!;
    expect(kinds_of(store, found.seqs)).toEqual(['connection', 'state', 'appear', 'order', 'visualization']);
    expect(found.proxies).toBe(true);
    expect(found.agents).toEqual(['CoSiVA/AIV2', 'AIV_Server', 'Simulator']);
  });
  it('figure 9 is of the requested AIV; an appearing obstacle is not included', () => {
    const store = store_of(['AIV_Server', 'Simulator', 'appear', 'CoSiVA/AIV1 gets display number 1'], ['AIV_Server', 'Simulator', 'appear', 'CoSiVA/AIV2 is back under display number 2'], ['AIV_Server', 'Simulator', 'appear', 'S1: an obstacle at 1, 2']);
    expect(find_figure(store, 'figure 9')!.seqs[0]).toBe(1);
    expect(find_figure(store, 'figure 9', 'CoSiVA/AIV1')!.seqs[0]).toBe(0);
    expect(find_figure(store, 'figure 9', 'CoSiVA/AIV7')).toBeNull();
  });
  it('figure 11 is the report that moved a twin to a new section, the response of the section, and the reports around it', () => {
    const report = (who: string): Message => [`CoSiVA/${who}`, 'AIV_Server', 'visualization', '{"x":1}'];
    const request = (who: string): Message => ['Simulator', 'Circuit', 'nextAIVposition', `CoSiVA/${who} on south 0.994 m: 0.018 m to travel`];
    const response = (who: string): Message => ['Circuit', 'Simulator', 'position', `CoSiVA/${who} on east 0.012 m: 0.012 m travelled to 1.000, 0.012`];
    const store = store_of(report('AIV1'), report('AIV1'), report('AIV2'), report('AIV1'), request('AIV1'), response('AIV1'), request('AIV2'), response('AIV2'), report('AIV1'), report('AIV2'), report('AIV1'));
    expect(find_figure(store, 'figure 11', 'CoSiVA/AIV1')!.seqs).toEqual([1, 3, 4, 5, 8]);
    const any = find_figure(store, 'figure 11')!;
    expect(any.seqs).toEqual([2, 6, 7, 9]);
    expect(any.agents).toEqual(['CoSiVA/AIV2', 'AIV_Server', 'Simulator', 'Circuit']);
  });
  it('figure 11 is the last three reports if no section has responded yet', () => {
    const report: Message = ['CoSiVA/AIV1', 'AIV_Server', 'visualization', '{"x":1}'];
    const store = store_of(report, report, ['CoSiVA/AIV1', 'AIV_Server', 'virtual_obstacles_ack', 'nothing'], report, report);
    expect(find_figure(store, 'figure 11')!.seqs).toEqual([1, 3, 4]);
  });
  it('figure 9 contains neither V2X messages nor convoys', () => {
    const store = store_of(
      ['CoSiVA/AIV1', 'AIV_Server', 'connection', 'ONLINE'], ['CoSiVA/AIV1', 'CoSiVA/AIV2', 'V2X', '0.400 m/s'],
      ['AIV_Server', 'Simulator', 'appear', 'CoSiVA/AIV1 gets display number 1'], ['CoSiVA/AIV2', 'CoSiVA/AIV1', 'V2X', '0.400 m/s'],
      ['AIV_Server', 'CoSiVA/AIV1', 'convoy', 'convoy of 2 through X1 and X4, behind CoSiVA/AIV2'], ['AIV_Server', 'CoSiVA/AIV1', 'order', 'order 1'],
    );
    expect(find_figure(store, 'figure 9', 'CoSiVA/AIV1')!.seqs).toEqual([0, 2, 5]);
  });
  it('figure 11 contains no V2X messages', () => {
    const report: Message = ['CoSiVA/AIV1', 'AIV_Server', 'visualization', '{"x":1}'];
    const store = store_of(report, ['CoSiVA/AIV1', 'CoSiVA/AIV2', 'V2X', '0.400 m/s'], report, report);
    expect(find_figure(store, 'figure 11')!.seqs).toEqual([0, 2, 3]);
  });
  it('are not found without messages', () => {
    for (const name of ['figure 8', 'figure 9', 'figure 11'] as const) expect(find_figure(store_of(heartbeat), name)).toBeNull();
  });
});

describe('the layout', () => {
  it('puts persons and vehicles left, the circuit right, numbers in their order', () => {
    expect(in_order(['Circuit', 'CoSiVA/AIV10', 'AIV_Server', 'CoSiVA.virtual/V1', 'operator', 'CoSiVA/AIV2', '*', 'Simulator'])).toEqual(['operator', 'CoSiVA/AIV2', 'CoSiVA/AIV10', 'CoSiVA.virtual/V1', 'AIV_Server', 'Simulator', 'Circuit', '*']);
  });
  it('names CoSiVA vehicles by their serial number and others by their full name', () => {
    expect(['CoSiVA/AIV1', 'CoSiVA.virtual/V1', 'RobotCompany/001', '*'].map(agent_label)).toEqual(['AIV1', 'V1', 'RobotCompany/001', 'everybody']);
  });
  it('widens the diagram to keep the distance between lifelines', () => {
    const { lines, width_px } = lifelines(['CoSiVA/AIV1', 'AIV_Server', 'Simulator', 'RTM', 'CircuitFactory', 'Circuit'], 400, new Set());
    for (let i = 1; i < lines.length; i++) expect(lines[i]!.x - lines[i - 1]!.x).toBeGreaterThanOrEqual(92);
    expect(width_px).toBeGreaterThan(lines.at(-1)!.x + 50);
  });
  it('begins with lifelines that fit without scrolling: at least one vehicle, the server and the simulator', () => {
    const known = in_order(['operator', 'CoSiVA/AIV1', 'CoSiVA/AIV2', 'CoSiVA/AIV3', 'AIV_Server', 'Simulator', 'RTM']);
    const fleet = ['CoSiVA/AIV9', 'CoSiVA/AIV1', 'CoSiVA/AIV2', 'CoSiVA/AIV3']; // of AIV9 there is no message
    expect(first_agents(known, fleet, 348)).toEqual(['CoSiVA/AIV1', 'AIV_Server', 'Simulator']);
    expect(first_agents(known, fleet, 490)).toEqual(['CoSiVA/AIV1', 'CoSiVA/AIV2', 'AIV_Server', 'Simulator']);
    expect(first_agents(known, fleet, 1_400)).toEqual(['CoSiVA/AIV1', 'CoSiVA/AIV2', 'CoSiVA/AIV3', 'operator', 'AIV_Server', 'Simulator']);
    expect(first_agents(known, ['CoSiVA/AIV3'], 500)).toEqual(['CoSiVA/AIV3', 'operator', 'AIV_Server', 'Simulator']);
    for (const width of [348, 490, 1_400]) expect(lifelines(first_agents(known, fleet, width), width, new Set()).width_px).toBe(width);
  });
  it('draws an arrow from sender to receiver; through a proxy the radio part is the outer one', () => {
    const aiv = 'CoSiVA/AIV1';
    const store = store_of([aiv, 'AIV_Server', 'state', '', proxy_of(aiv)], ['AIV_Server', aiv, 'order', '', proxy_of(aiv)], ['AIV_Server', 'Simulator', 'appear'], ['RTM', 'Simulator', 'x'], [aiv, 'AIV_Server', 'state']);
    expect(store.proxied).toEqual(new Set([aiv]));
    const { lines } = lifelines([aiv, 'AIV_Server', 'Simulator'], 900, store.proxied);
    expect(lines.map(({ label }) => label)).toEqual(['AIV1', 'proxy of AIV1', 'AIV_Server', 'Simulator']);
    const x = Object.fromEntries(lines.map((line) => [line.name, line.x]));
    const proxy = x[proxy_of(aiv)]!;
    expect(arrow_of(store, 0, lines).legs).toEqual([{ x0: x[aiv], x1: proxy, radio: true }, { x0: proxy, x1: x['AIV_Server'], radio: false }]);
    expect(arrow_of(store, 1, lines).legs).toEqual([{ x0: x['AIV_Server'], x1: proxy, radio: false }, { x0: proxy, x1: x[aiv], radio: true }]);
    expect(arrow_of(store, 2, lines).legs).toEqual([{ x0: x['AIV_Server'], x1: x['Simulator'], radio: false }]);
    expect(arrow_of(store, 3, lines).legs).toEqual([]);
    expect(span_of(arrow_of(store, 0, lines)).length).toBeCloseTo(x['AIV_Server']! - x[aiv]!, 9);
    // A message that did not pass through the proxy is drawn without the hop.
    expect(arrow_of(store, 4, lines).legs).toEqual([{ x0: x[aiv], x1: x['AIV_Server'], radio: false }]);
  });
  it('draws a message to its own sender as a loop', () => {
    expect(path_of(50, 50, 20)).toContain('q');
    expect(path_of(50, 90, 20)).toBe('M50 20L89 20');
  });
  it('fits the texts over their arrows', () => {
    expect(words_of({ kind: 'order', content: 'x'.repeat(500) }, 200).length).toBeLessThanOrEqual(31);
  });
  it('gives a well-formed file for any content', () => {
    const store = store_of(['CoSiVA/<b>&"', 'AIV_Server', 'state', '</svg><script>']);
    const { lines, width_px } = lifelines(['CoSiVA/<b>&"', 'AIV_Server'], 600, new Set());
    const svg = svg_of('A & B', lines, [arrow_of(store, 0, lines)], width_px, { ground: '#fff', ink: '#000', quiet: '#555', line: '#999', accent: '#00f' });
    expect(svg).not.toContain('<script');
    expect(svg).not.toContain('<b>');
    expect(svg.match(/<svg/g)).toHaveLength(1);
    expect(svg).toContain('A &amp; B');
  });
});

describe('communications as text', () => {
  it('show flat JSON as text, and other content unchanged', () => {
    expect(summary_of('{"x":-0.68249,"y":1,"speed":0.3}')).toBe('x −0.682, y 1, speed 0.300');
    expect(summary_of('{"a":{"b":1}}')).toBe('{"a":{"b":1}}');
    expect(summary_of('{"cut off')).toBe('{"cut off');
    expect(summary_of('plain')).toBe('plain');
  });
  it('are quoted in CSV where needed, with formulas disarmed', () => {
    const row = { n: 1, time_ms: 0, from: '=cmd()', to: 'a,b', kind: 'report "x"', content: 'two\nlines' };
    expect(csv_line(row)).toBe('1,1970-01-01T00:00:00.000Z,\'=cmd(),"a,b",,"report ""x""","two\nlines"\r\n');
  });
  it('are one message per line in NDJSON, also with a clock far off', () => {
    const row = { n: 1, time_ms: 1e300, from: 'a', to: 'b', kind: 'c', content: 'two\nlines' };
    expect(JSON.parse(ndjson_line(row))).toMatchObject(row);
    expect(ndjson_line(row).trimEnd()).not.toContain('\n');
  });
  it('are exported in slices, without notes, and without messages that arrive meanwhile', async () => {
    const store = new TraceStore();
    for (let n = 1; n <= 1000; n++) store.append({ n, time_ms: n, from: 'a', to: 'b', kind: 'c', content: '' });
    store.note('gap', 0);
    const file = new Export(store, new AllRows(store), 'ndjson');
    let slices = 0;
    while (!file.go_on(() => false)) {
      slices++;
      store.append({ n: 9999, time_ms: 0, from: 'a', to: 'b', kind: 'c', content: 'late' });
    }
    expect(slices).toBeGreaterThan(2);
    expect([file.rows, file.notes, file.progress]).toEqual([1000, 1, 1]);
    const lines = (await file.blob().text()).trimEnd().split('\n').map((line) => (JSON.parse(line) as { n: number }).n);
    expect(lines).toEqual(Array.from({ length: 1000 }, (_, i) => i + 1));
  });
  it('are exported at once if there are none', () => {
    const store = new TraceStore();
    expect(new Export(store, new AllRows(store), 'csv').go_on(() => true)).toBe(true);
  });
});
