// What the components see. Positions are not here: they change 30 times a second and live outside the framework. Lists and
// figures are copied over when a snapshot comes, at most once per painted frame.
import { AlarmBook, type Alarm } from './alarms';
import { api, type Answer } from './api';
import type { Bijection, Command, CommandVerb, Crossing, LiveMessage, Run, SeenObstacle, Snapshot, Thing, Truth, Zone } from './contract';
import { Live, live_url } from './live';
import { Positions } from './positions';
import { link_after, rows_of, type Link, type Row } from './reduce';
import { FleetHistory, History } from './table_history';

const tick_ms = 250;
const commands_max = 400;
/** A refusal is to be read in peace. */
const notice_ms = { refusal: 20_000, news: 8_000 } as const;
const settling_ms = 5_000;
const many = 2_000;
const many_ms = 950;

export interface Notice {
  key: number;
  text: string;
  tone: 'refusal' | 'news';
  at_ms: number;
}

export class Platform {
  /** where everything is drawn; typed arrays, not reactive on purpose */
  readonly positions = new Positions();
  /** the newest snapshot, for whoever paints each frame; not reactive on purpose */
  latest: Snapshot | null = null;
  /** what the emulated world says, newest; null where there is none; not reactive on purpose */
  truth: Truth | null = null;

  zone = $state.raw<Zone | null>(null);
  /** false until the server has said whether there is a zone */
  zone_known = $state(false);
  run = $state.raw<Run | null>(null);
  snapshot = $state.raw<Snapshot | null>(null);
  rows = $state.raw<readonly Row[]>([]);
  things = $state.raw<readonly Thing[]>([]);
  obstacles = $state.raw<readonly SeenObstacle[]>([]);
  /** physical obstacles of the emulated world that can be taken away again */
  plant_obstacles = $state.raw<Truth['obstacles']>([]);
  /** newest first; more than a snapshot holds */
  commands = $state.raw<readonly Command[]>([]);
  bijection = $state.raw<Bijection | null>(null);
  crossings = $state.raw<readonly Crossing[]>([]);
  alarms = $state.raw<readonly Alarm[]>([]);
  link = $state.raw<Link>({ phase: 'connecting', since_ms: performance.now() });
  /** page clock, ticking four times a second */
  now_ms = $state(performance.now());
  server_ms = $state<number | null>(null);
  /** the one that the map marks and that single commands go to; an AIV's or a thing's id */
  selected = $state<string | null>(null);
  /** what the pointer is over, on the map or in a list */
  hovered = $state<string | null>(null);
  /** several AIVs, for commands to all of them */
  chosen = $state.raw<ReadonlySet<string>>(new Set());
  following = $state(false);
  notices = $state.raw<readonly Notice[]>([]);

  /** the last minutes of each AIV, and of the fleet; typed arrays, read when `rows` changes */
  readonly history = new History();
  readonly fleet = new FleetHistory();

  private readonly alarm_book = new AlarmBook();
  private readonly command_book = new Map<string, Command>();
  private last_frame_ms = performance.now();
  private dirty = false;
  private painting = 0;
  private refreshed_ms = -Infinity;
  private notice_count = 0;
  private anchor: string | null = null;
  /** when the first snapshot came, on the server's clock */
  private first_ms: number | null = null;

  /** Starts listening; call the answer to stop. */
  start(): () => void {
    const live = new Live(live_url(location), {
      opened: () => {
        this.positions.restart();
        this.link_event('opened');
      },
      closed: () => this.link_event('closed'),
      message: (message) => this.accept(message),
      positions: (frame) => {
        this.last_frame_ms = performance.now();
        this.positions.accept(frame, this.last_frame_ms);
      },
    });
    const timer = setInterval(() => this.tick(), tick_ms);
    return () => {
      clearInterval(timer);
      cancelAnimationFrame(this.painting);
      live.close();
    };
  }

  get live(): boolean {
    return this.link.phase === 'live';
  }

  /** when the server was last heard, on the page's clock; read it together with now_ms */
  last_frame(): number {
    return Math.min(this.last_frame_ms, this.now_ms);
  }

  /** The AIVs that a command without a name goes to: the chosen ones, or else the selected one. */
  get targets(): readonly string[] {
    if (this.chosen.size > 0) return [...this.chosen];
    return this.rows.some((row) => row.id === this.selected) ? [this.selected!] : [];
  }

  select(id: string | null): void {
    this.selected = id;
    this.anchor = id;
    if (id === null) this.following = false;
  }

  select_next(step: 1 | -1, order: readonly Row[] = this.rows): void {
    if (order.length === 0) return;
    const at = order.findIndex((row) => row.id === this.selected);
    const next = at < 0 ? (step > 0 ? 0 : order.length - 1) : (at + step + order.length) % order.length;
    this.select(order[next]!.id);
  }

  choose(id: string, on = !this.chosen.has(id)): void {
    const next = new Set(this.chosen);
    if (on) next.add(id);
    else next.delete(id);
    this.chosen = next;
    this.anchor = id;
  }

  /** From the last one touched to this one, in the order in which they are listed. */
  choose_up_to(id: string, order: readonly Row[]): void {
    const to = order.findIndex((row) => row.id === id);
    const from = order.findIndex((row) => row.id === (this.anchor ?? this.selected));
    if (to < 0) return;
    const [low, high] = from < 0 ? [to, to] : [Math.min(from, to), Math.max(from, to)];
    this.chosen = new Set([...this.chosen, ...order.slice(low, high + 1).map((row) => row.id)]);
  }

  choose_all(rows: readonly Row[]): void {
    this.chosen = new Set(rows.map((row) => row.id));
  }

  /** A press on a row, as in every list: alone it selects, with Ctrl it adds, with Shift it adds all up to it. */
  press(id: string, event: { ctrlKey: boolean; metaKey: boolean; shiftKey: boolean }, order: readonly Row[]): void {
    if (event.shiftKey) this.choose_up_to(id, order);
    else if (event.ctrlKey || event.metaKey) this.choose(id);
    else this.select(this.selected === id ? null : id);
  }

  /** Sends a command; what becomes of it shows in the snapshots. A command that cannot be sent is said loudly. */
  async command(command: CommandVerb, vehicle: string | readonly string[]): Promise<void> {
    const vehicles = typeof vehicle === 'string' && vehicle !== '*' ? [vehicle] : (vehicle as '*' | readonly string[]);
    if (vehicles.length === 0) return this.say('Select an AIV first, or choose several.', 'news');
    const whom = vehicles === '*' ? 'all AIVs' : vehicles.length === 1 ? short(vehicles[0]!) : `${vehicles.length} AIVs`;
    await this.ask(`${title(command)} ${whom}`, api.command(command, vehicles));
  }

  async go(vehicle: string, to: string): Promise<void> {
    await this.ask(`Send ${short(vehicle)} to ${to}`, api.go(vehicle, to));
  }

  /** @param loop  null: the zone's first one, or wherever the ways lead */
  async circulate(vehicle: string, loop: string | null): Promise<void> {
    await this.ask(`Let ${vehicle === '*' ? 'all AIVs' : short(vehicle)} circulate`, api.circulate(vehicle, loop));
  }

  /** Closes a section, or opens it again. */
  async close_section(section: string): Promise<void> {
    const close = !this.is_closed(section);
    await this.ask(`${close ? 'Close' : 'Open'} ${section}`, api.close_section(section, close));
  }
  is_closed(section: string): boolean {
    return this.snapshot?.zone?.closed.includes(section) ?? false;
  }

  async remove_thing(id: string): Promise<void> {
    await this.ask(`Remove ${short(id)}`, api.remove_thing(short(id)));
  }

  /** Waits for an answer of the server; a refusal is said, with what was wanted, and gives null. */
  async ask<T>(what: string, answer: Promise<Answer<T>>): Promise<T | null> {
    const got = await answer;
    if (got.ok) return got.value;
    this.say(`${what}: ${got.sentence}`);
    return null;
  }

  say(text: string, tone: Notice['tone'] = 'refusal'): void {
    const kept = this.notices.filter((notice) => notice.text !== text).slice(-3);
    this.notices = [...kept, { key: ++this.notice_count, text, tone, at_ms: performance.now() }];
  }

  dismiss(key: number): void {
    this.notices = this.notices.filter((notice) => notice.key !== key);
  }

  acknowledge(key: string | '*'): void {
    this.alarm_book.acknowledge(key);
    this.alarms = this.alarm_book.list();
  }

  private accept(message: LiveMessage): void {
    this.last_frame_ms = performance.now();
    switch (message.type) {
      case 'zone':
        this.zone = message.zone;
        this.zone_known = true;
        return;
      case 'run':
        this.run = message.run;
        return;
      case 'truth': {
        const known = this.truth?.obstacles.map((one) => one.id).join() ?? '';
        this.truth = message;
        if (message.obstacles.map((one) => one.id).join() !== known) this.plant_obstacles = message.obstacles;
        return;
      }
      case 'snapshot':
        this.latest = message.snapshot;
        this.dirty = true;
        if (this.link.phase !== 'live') {
          this.link_event('frame');
          this.refresh();
        } else if (this.painting === 0) {
          // Several may come within one painted frame; the last is shown.
          this.painting = requestAnimationFrame(() => this.refresh());
        }
    }
  }

  private link_event(kind: 'opened' | 'frame' | 'closed' | 'tick'): void {
    this.link = link_after(this.link, { kind, at_ms: performance.now(), last_frame_ms: this.last_frame_ms });
  }

  private tick(): void {
    this.now_ms = performance.now();
    this.link_event('tick');
    const fresh = this.notices.filter((notice) => this.now_ms - notice.at_ms < notice_ms[notice.tone]);
    if (fresh.length !== this.notices.length) this.notices = fresh;
    // A page in the background paints nothing; its lists and alarms go on.
    this.refresh();
  }

  private refresh(): void {
    cancelAnimationFrame(this.painting);
    this.painting = 0;
    const snapshot = this.latest;
    if (!this.dirty || !snapshot) return;

    // Thousands of rows cost a painted frame each time: the map goes on smoothly, the lists follow once a second.
    const now = performance.now();
    if (snapshot.aivs.length > many && now - this.refreshed_ms < many_ms) return;
    this.refreshed_ms = now;
    this.dirty = false;
    this.remember_commands(snapshot.commands);
    const rows = rows_of(snapshot);
    this.history.accept(snapshot);
    this.fleet.accept(snapshot);
    this.snapshot = snapshot;
    this.rows = rows;
    this.things = snapshot.things ?? [];
    this.obstacles = snapshot.obstacles ?? [];
    this.bijection = snapshot.bijection;
    this.crossings = snapshot.crossings;
    this.server_ms = snapshot.time_ms;
    if (this.alarm_book.accept(rows, snapshot)) this.alarms = this.alarm_book.list();
    this.forget_the_gone(snapshot);
  }

  private remember_commands(commands: readonly Command[]): void {
    let changed = false;
    for (const command of commands) {
      const known = this.command_book.get(command.id);
      // A server that was started again counts from one again.
      if (known && known.time_ms === command.time_ms && known.state === command.state && known.accepted_ms === command.accepted_ms) continue;
      this.command_book.set(command.id, command);
      changed = true;
    }
    if (!changed) return;
    const newest = [...this.command_book.values()].sort((a, b) => b.time_ms - a.time_ms || (a.id < b.id ? 1 : -1));
    for (const old of newest.splice(commands_max)) this.command_book.delete(old.id);
    this.commands = newest;
  }

  private forget_the_gone(snapshot: Snapshot): void {
    const present = new Set(snapshot.aivs.map((aiv) => aiv.id));
    if ([...this.chosen].some((id) => !present.has(id))) this.chosen = new Set([...this.chosen].filter((id) => present.has(id)));
    for (const thing of [...(snapshot.things ?? []), ...(snapshot.obstacles ?? [])]) present.add(thing.id);
    if (this.selected !== null && !present.has(this.selected) && this.settled(snapshot)) this.select(null);
  }

  /** A link may name an AIV that the server has yet to hear of: it is waited for, a while. */
  private settled(snapshot: Snapshot): boolean {
    this.first_ms ??= snapshot.time_ms;
    return snapshot.time_ms - this.first_ms > settling_ms || snapshot.time_ms < this.first_ms;
  }
}

function title(word: string): string {
  return word.charAt(0).toUpperCase() + word.slice(1);
}

function short(id: string): string {
  return id.slice(id.indexOf('/') + 1);
}
