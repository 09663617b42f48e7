// What the components see. Positions are not here: they change 60 times a second and live in Motion, outside the
// framework. Lists and figures are copied over five times a second, as fast as they can be read.
import type { Bijection, Command, CommandVerb, Crossing, LiveMessage, Snapshot, Zone } from './contract';
import { Live, live_url } from './live';
import { Motion } from './motion';
import { link_after, rows_of, type Link, type Row } from './reduce';

const refresh_ms = 200;
const history_max = 150;

export interface Notice {
  text: string;
  at_ms: number;
}

export class Platform {
  readonly motion = new Motion();
  /** the newest snapshot, for whoever paints each frame; not reactive on purpose */
  latest: Snapshot | null = null;

  zone = $state.raw<Zone | null>(null);
  /** false until the server has said whether there is a zone */
  zone_known = $state(false);
  rows = $state.raw<Row[]>([]);
  commands = $state.raw<readonly Command[]>([]);
  bijection = $state.raw<Bijection | null>(null);
  crossings = $state.raw<readonly Crossing[]>([]);
  link = $state.raw<Link>({ phase: 'connecting', since_ms: performance.now() });
  /** page clock, ticking with the refresh */
  now_ms = $state(performance.now());
  server_ms = $state<number | null>(null);
  selected = $state<string | null>(null);
  following = $state(false);
  notice = $state.raw<Notice | null>(null);
  /** worst divergence [m] and age [ms] over the fleet, one value per refresh */
  divergence_history = $state.raw<readonly number[]>([]);
  age_history = $state.raw<readonly number[]>([]);

  private last_frame_ms = performance.now();
  private dirty = false;

  /** Starts listening; call the answer to stop. */
  start(): () => void {
    const live = new Live(live_url(location), {
      opened: () => this.link_event('opened'),
      closed: () => this.link_event('closed'),
      message: (message) => this.accept(message),
    });
    const timer = setInterval(() => this.refresh(), refresh_ms);
    return () => {
      clearInterval(timer);
      live.close();
    };
  }

  get live(): boolean {
    return this.link.phase === 'live';
  }

  select(id: string | null): void {
    this.selected = id;
    if (id === null) this.following = false;
  }

  select_next(step: 1 | -1): void {
    if (this.rows.length === 0) return;
    const at = this.rows.findIndex((row) => row.id === this.selected);
    const next = at < 0 ? (step > 0 ? 0 : this.rows.length - 1) : (at + step + this.rows.length) % this.rows.length;
    this.select(this.rows[next]!.id);
  }

  /** Sends a command; what becomes of it shows in the snapshots. A command that cannot be sent is said loudly. */
  async command(command: CommandVerb, vehicle: string): Promise<void> {
    const whom = vehicle === '*' ? 'all AIVs' : vehicle;
    try {
      const response = await fetch('api/v1/commands', {
        method: 'POST',
        headers: { 'content-type': 'application/json' },
        body: JSON.stringify({ command, vehicle }),
        signal: AbortSignal.timeout(3_000),
      });
      if (response.ok) return;
      const body = (await response.json().catch(() => null)) as { error?: { message?: string } } | null;
      this.say(`${title(command)} for ${whom} was refused: ${body?.error?.message ?? `HTTP ${response.status}`}`);
    } catch {
      this.say(`${title(command)} for ${whom} was not sent: the server does not answer.`);
    }
  }

  say(text: string): void {
    this.notice = { text, at_ms: performance.now() };
  }

  private accept(message: LiveMessage): void {
    const now = performance.now();
    if (message.type === 'zone') {
      this.zone = message.zone;
      this.zone_known = true;
      return;
    }
    this.last_frame_ms = now;
    this.latest = message.snapshot;
    this.motion.accept(message.snapshot, now);
    this.dirty = true;
    if (this.link.phase !== 'live') {
      this.link_event('frame');
      this.refresh();
    }
  }

  private link_event(kind: 'opened' | 'frame' | 'closed' | 'tick'): void {
    const event = { kind, at_ms: performance.now(), last_frame_ms: this.last_frame_ms };
    this.link = link_after(this.link, event);
  }

  private refresh(): void {
    this.now_ms = performance.now();
    this.link_event('tick');
    if (this.notice && this.now_ms - this.notice.at_ms > 10_000) this.notice = null;
    if (!this.dirty || !this.latest) return;
    this.dirty = false;
    const snapshot = this.latest;
    this.rows = rows_of(snapshot);
    this.commands = snapshot.commands;
    this.bijection = snapshot.bijection;
    this.crossings = snapshot.crossings;
    this.server_ms = snapshot.time_ms;
    if (this.selected !== null && !snapshot.aivs.some((aiv) => aiv.id === this.selected)) this.select(null);
    const present = snapshot.aivs.filter((aiv) => !aiv.lost && aiv.connection === 'ONLINE');
    if (present.length === 0) return;
    const longest = (history: readonly number[], value: number) => [...history.slice(1 - history_max), value];
    this.divergence_history = longest(this.divergence_history, Math.max(...present.map((aiv) => aiv.divergence_m)));
    this.age_history = longest(this.age_history, Math.max(...present.map((aiv) => aiv.age_ms)));
  }
}

function title(word: string): string {
  return word.charAt(0).toUpperCase() + word.slice(1);
}
