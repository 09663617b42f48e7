// Formats numbers for display. The width stays the same between updates, so that tables do not shift.

const thin = '\u202f';
export const none = '–';

export function speed(mps: number): string {
  return `${mps.toFixed(2)}${thin}m/s`;
}

/** Millimetres below a metre: a divergence of 2 mm must not read as 0.00 m. */
export function length(metres: number): string {
  if (Math.abs(metres) >= 1) return `${metres.toFixed(2)}${thin}m`;
  const mm = metres * 1000;
  return `${mm >= 100 ? mm.toFixed(0) : mm.toFixed(1)}${thin}mm`;
}

export function metres(value: number | null): string {
  return value === null ? none : `${value.toFixed(2)}${thin}m`;
}

export function percent(value: number | null): string {
  return value === null ? none : `${Math.round(value)}${thin}%`;
}

/** A ratio 0…1 as a percentage, never rounded up to 100: 99.96 % of the time is not always. */
export function ratio(value: number): string {
  const tenths = Math.floor(value * 1000 + 1e-9) / 10;
  return `${tenths === 100 ? '100' : tenths.toFixed(1)}${thin}%`;
}

/** < 1 ms, 42 ms, 1.2 s, 3 min 05 s. */
export function duration(ms: number): string {
  if (ms > 0 && ms < 1) return `<\u202f1${thin}ms`;
  if (ms < 1000) return `${Math.round(ms)}${thin}ms`;
  if (ms < 60_000) return `${(Math.floor(ms / 100) / 10).toFixed(1)}${thin}s`;
  const minutes = Math.floor(ms / 60_000);
  const seconds = Math.floor((ms % 60_000) / 1000);
  return `${minutes}${thin}min ${String(seconds).padStart(2, '0')}${thin}s`;
}

/** Wall clock of the server, to the second, local time. */
export function clock(time_ms: number): string {
  const date = new Date(time_ms);
  return [date.getHours(), date.getMinutes(), date.getSeconds()].map((n) => String(n).padStart(2, '0')).join(':');
}

/** Virtual time, to the tenth: hours, minutes, seconds since the run's midnight, UTC. */
export function sim_clock(time_ms: number): string {
  return new Date(Math.floor(time_ms / 100) * 100).toISOString().slice(11, 21);
}

/** How long something has lasted, to the second: 4 s, 3 min 05 s, 2 h 10 min, 3 d 4 h. */
export function lasting(ms: number): string {
  const seconds = Math.max(0, Math.floor(ms / 1000));
  if (seconds < 60) return `${seconds}${thin}s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)}${thin}min ${String(seconds % 60).padStart(2, '0')}${thin}s`;
  if (seconds < 86_400) return `${Math.floor(seconds / 3600)}${thin}h ${String(Math.floor((seconds % 3600) / 60)).padStart(2, '0')}${thin}min`;
  return `${Math.floor(seconds / 86_400)}${thin}d ${Math.floor((seconds % 86_400) / 3600)}${thin}h`;
}

/** The label of a vehicle: its number, or the start of its serial number if it has none. */
export function label(id: string, number: number): string {
  return number > 0 ? String(number) : serial(id).slice(0, 3);
}

export function serial(id: string): string {
  return id.slice(id.indexOf('/') + 1);
}

export function manufacturer(id: string): string {
  const slash = id.indexOf('/');
  return slash < 0 ? '' : id.slice(0, slash);
}
