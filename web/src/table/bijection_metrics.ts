// The figures of the bijection panel: value, detail, limit and verdict of each.
import { default_limits, type Bijection, type ContractLimits } from '../live/contract';
import * as format from '../live/format';

export interface Figure {
  key: 'matched' | 'divergence' | 'age' | 'commands' | 'events' | 'perceived' | 'brakes' | 'shown' | 'actual';
  label: string;
  value: string;
  detail: string;
  limit: string;
  /** of the last seconds, while the value is of the whole run; `open` while nothing has been measured */
  verdict: 'kept' | 'broken' | 'open';
}

export function figures_of(bijection: Bijection): Figure[] {
  const limits: ContractLimits = { ...default_limits, ...bijection.contract };
  const verdict_of = (count: number, fulfilled: boolean): Figure['verdict'] => (count === 0 ? 'open' : fulfilled ? 'kept' : 'broken');
  const { divergence_m, actual_m, age_ms, commands, events, held } = bijection;
  const expected = Math.max(bijection.physical, bijection.virtual);
  // Only where a camera or another instrument provides true positions.
  const actual: Figure[] = actual_m?.count ? [{
    key: 'actual',
    label: bijection.references?.actual === 'instrument' ? 'Twin to true pose p99' : 'Twin to camera p99',
    value: format.length(actual_m.p99),
    detail: `mean ${format.length(actual_m.mean)}, max ${format.length(actual_m.max)}`,
    limit: `≤ ${format.length(limits.actual_p99_m)}`,
    verdict: verdict_of(1, held.actual),
  }] : [];
  return [
    {
      key: 'matched',
      label: 'Matched',
      value: `${bijection.matched} / ${expected}`,
      detail: `${format.ratio(bijection.matched_ratio)} of the time`,
      limit: 'each has one twin',
      verdict: verdict_of(expected, bijection.matched === expected && bijection.orphans.length === 0),
    },
    {
      key: 'divergence',
      label: 'Divergence p99',
      value: divergence_m.count === 0 ? format.none : format.length(divergence_m.p99),
      detail: `mean ${format.length(divergence_m.mean)}, max ${format.length(divergence_m.max)}`,
      limit: `≤ ${format.length(limits.divergence_p99_m)}`,
      verdict: verdict_of(divergence_m.count, held.divergence),
    },
    ...actual,
    {
      key: 'age',
      label: 'Age p99',
      value: age_ms.count === 0 ? format.none : format.duration(age_ms.p99),
      detail: `mean ${format.duration(age_ms.mean)}, max ${format.duration(age_ms.max)}`,
      limit: `≤ ${format.duration(limits.age_p99_ms)}`,
      verdict: verdict_of(age_ms.count, held.age),
    },
    {
      key: 'commands',
      label: 'Commands p99',
      value: commands.latency_ms.count > 0 ? format.duration(commands.latency_ms.p99) : format.none,
      detail: `${commands.materialised} of ${commands.issued} materialised${commands.failed > 0 ? `, ${commands.failed} failed` : ''}`,
      limit: `≤ ${format.duration(limits.command_p99_ms)}`,
      verdict: verdict_of(commands.latency_ms.count + commands.failed, held.commands),
    },
    {
      key: 'events',
      label: 'Events p99',
      value: events.latency_ms.count > 0 ? format.duration(events.latency_ms.p99) : format.none,
      detail: `${events.count} reflected`,
      limit: `≤ ${format.duration(limits.event_p99_ms)}`,
      verdict: verdict_of(events.latency_ms.count, held.events),
    },
    ...effects_of(bijection, limits),
  ];
}

/** Latencies between virtual and physical objects, in both directions; empty if the server does not report them. */
function effects_of(bijection: Bijection, limits: ContractLimits): Figure[] {
  const effects: Partial<Bijection['effects']> = bijection.effects ?? {};
  const words = [
    ['perceived', 'Virtual perceived p99', effects.perceived_ms, 'change to decision'],
    ['brakes', 'Virtual braked for p99', effects.brakes_ms, 'change to braking'],
    ['shown', 'Obstacle shown p99', effects.shown_ms, 'detection to display'],
  ] as const;
  return words.flatMap(([key, label, figure, what]) => {
    if (!figure || figure.count === undefined) return [];
    const measured = figure.count > 0;
    const verdict = !measured ? 'open' : bijection.held.effects || figure.max <= limits.effect_p99_ms ? 'kept' : 'broken';
    return [{ key, label, value: measured ? format.duration(figure.p99) : format.none, detail: measured ? `${figure.count} × ${what}` : what, limit: `≤ ${format.duration(limits.effect_p99_ms)}`, verdict } as const];
  });
}
