// The reactive store that the components read. Positions change 30 times a second and stay outside Svelte's state. Lists
// and figures are updated from a snapshot, at most once per painted frame.
import { AlarmBook, type Alarm } from './alarms';
import { api, type ApiResponse } from './api';
import type { Bijection, Command, CommandName, Crossing, LiveMessage, Run, DetectedObstacle, Snapshot, VirtualObject, GroundTruth, Zone } from './contract';
import { Live, live_url } from './connection';
import { Positions } from './positions';
import { rows_of, type Row } from './rows';
import { FleetHistory, History } from './history';
import { link_after, type Link } from './link_state';
import { updated, type Stop, type StopResponse } from './stops';

const tick_ms = 250;
const commands_max = 400;
/** How often a Stop that is not durable, or not confirmed, is queried. */
const stop_period_ms = 250;
/** How long a notice stays; a refusal stays longer, to be read [ms]. */
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
  /** drawn positions of all objects; typed arrays, deliberately not reactive */
  readonly positions = new Positions();
  /** the newest snapshot, for code that paints each frame; deliberately not reactive */
  latest: Snapshot | null = null;
  /** the newest ground truth of the emulated plant; null without one; deliberately not reactive */
  ground_truth: GroundTruth | null = null;

  zone = $state.raw<Zone | null>(null);
  /** false until the server has sent a zone, or that there is none */
  zone_known = $state(false);
  run = $state.raw<Run | null>(null);
  snapshot = $state.raw<Snapshot | null>(null);
  rows = $state.raw<readonly Row[]>([]);
  virtualObjects = $state.raw<readonly VirtualObject[]>([]);
  obstacles = $state.raw<readonly DetectedObstacle[]>([]);
  /** physical obstacles of the emulated plant that can be removed */
  plant_obstacles = $state.raw<GroundTruth['obstacles']>([]);
  /** newest first; includes commands that have left the snapshot */
  commands = $state.raw<readonly Command[]>([]);
  /** Stops of this page that are not durable, or not confirmed */
  stops = $state.raw<readonly Stop[]>([]);
  bijection = $state.raw<Bijection | null>(null);
  crossings = $state.raw<readonly Crossing[]>([]);
  alarms = $state.raw<readonly Alarm[]>([]);
  link = $state.raw<Link>({ phase: 'connecting', since_ms: performance.now() });
  /** time of the page, updated four times a second */
  now_ms = $state(performance.now());
  server_ms = $state<number | null>(null);
  /** id of the AIV or virtual object that the map highlights and that single commands address */
  selected = $state<string | null>(null);
  /** id of the object under the pointer, on the map or in a list */
  hovered = $state<string | null>(null);
  /** ids of the AIVs that group commands address */
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
  /** where a range selection in the list begins */
  private first: string | null = null;
  /** server time of the first snapshot */
  private first_ms: number | null = null;

  /** Opens the live stream; the returned function closes it. */
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

  /** time of the last received frame, on the page's clock; compare it with now_ms */
  last_frame(): number {
    return Math.min(this.last_frame_ms, this.now_ms);
  }

  /** The AIVs that a command without a vehicle addresses: the chosen ones, otherwise the selected one. */
  get targets(): readonly string[] {
    if (this.chosen.size > 0) return [...this.chosen];
    return this.rows.some((row) => row.id === this.selected) ? [this.selected!] : [];
  }

  select(id: string | null): void {
    this.selected = id;
    this.first = id;
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
    this.first = id;
  }

  /** The ids from the last pressed row to this one, in the order of the list. */
  choose_up_to(id: string, order: readonly Row[]): void {
    const to = order.findIndex((row) => row.id === id);
    const from = order.findIndex((row) => row.id === (this.first ?? this.selected));
    if (to < 0) return;
    const [low, high] = from < 0 ? [to, to] : [Math.min(from, to), Math.max(from, to)];
    this.chosen = new Set([...this.chosen, ...order.slice(low, high + 1).map((row) => row.id)]);
  }

  choose_all(rows: readonly Row[]): void {
    this.chosen = new Set(rows.map((row) => row.id));
  }

  /** Handles a press on a row: plain selects it, with Ctrl adds it, with Shift adds the range up to it. */
  press(id: string, event: { ctrlKey: boolean; metaKey: boolean; shiftKey: boolean }, order: readonly Row[]): void {
    if (event.shiftKey) this.choose_up_to(id, order);
    else if (event.ctrlKey || event.metaKey) this.choose(id);
    else this.select(this.selected === id ? null : id);
  }

  /** Sends a command; the snapshots report its progress. A command that cannot be sent raises a notice. */
  async command(command: CommandName, vehicle: string | readonly string[]): Promise<void> {
    const vehicles = typeof vehicle === 'string' && vehicle !== '*' ? [vehicle] : (vehicle as '*' | readonly string[]);
    if (vehicles.length === 0) return this.report('Select an AIV first, or choose several.', 'news');
    const whom = vehicles === '*' ? 'all AIVs' : vehicles.length === 1 ? short(vehicles[0]!) : `${vehicles.length} AIVs`;
    const sent_ms = performance.now();
    const response = await this.request(`${title(command)} ${whom}`, api.command(command, vehicles));
    if (command === 'stop' && response) await this.follow_stop({ durable: true, ...response, sent_ms });
  }

  /** Queries a Stop until it is durable and confirmed, or the server does not know it any more. */
  private async follow_stop(stop: Stop): Promise<void> {
    this.stops = updated(this.stops, stop);
    while (this.stops.some(({ id }) => id === stop.id)) {
      await new Promise((resolve) => setTimeout(resolve, stop_period_ms));
      const got: ApiResponse<StopResponse> = await api.stop(stop.id);
      if (got.ok) this.stops = updated(this.stops, { ...got.value, sent_ms: stop.sent_ms });
      else if (got.status !== 0) this.stops = this.stops.filter(({ id }) => id !== stop.id);
    }
  }

  async go(vehicle: string, to: string): Promise<void> {
    await this.request(`Send ${short(vehicle)} to ${to}`, api.go(vehicle, to));
  }

  /** @param loop  null: the zone's first loop, or any route if the zone has none */
  async circulate(vehicle: string, loop: string | null): Promise<void> {
    await this.request(`Let ${vehicle === '*' ? 'all AIVs' : short(vehicle)} circulate`, api.circulate(vehicle, loop));
  }

  /** Closes or reopens a section. */
  async close_section(section: string): Promise<void> {
    const close = !this.is_closed(section);
    await this.request(`${close ? 'Close' : 'Open'} ${section}`, api.close_section(section, close));
  }
  is_closed(section: string): boolean {
    return this.snapshot?.zone?.closed.includes(section) ?? false;
  }

  async remove_virtual_object(id: string): Promise<void> {
    await this.request(`Remove ${short(id)}`, api.remove_virtual_object(short(id)));
  }

  /** Awaits a response of the server; a refusal raises a notice that names `what`, and returns null. */
  async request<T>(what: string, response: Promise<ApiResponse<T>>): Promise<T | null> {
    const got = await response;
    if (got.ok) return got.value;
    this.report(`${what}: ${got.sentence}`);
    return null;
  }

  report(text: string, tone: Notice['tone'] = 'refusal'): void {
    const others = this.notices.filter((notice) => notice.text !== text).slice(-3);
    this.notices = [...others, { key: ++this.notice_count, text, tone, at_ms: performance.now() }];
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
      case 'ground_truth': {
        const known = this.ground_truth?.obstacles.map((one) => one.id).join() ?? '';
        this.ground_truth = message;
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
          // Several snapshots may arrive within one painted frame; the last one is shown.
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
    // A page in the background paints nothing, but its lists and alarms are still updated.
    this.refresh();
  }

  private refresh(): void {
    cancelAnimationFrame(this.painting);
    this.painting = 0;
    const snapshot = this.latest;
    if (!this.dirty || !snapshot) return;

    // Updating thousands of rows takes a whole frame: lists then follow once a second, so that the map stays smooth.
    const now = performance.now();
    if (snapshot.aivs.length > many && now - this.refreshed_ms < many_ms) return;
    this.refreshed_ms = now;
    this.dirty = false;
    this.record_commands(snapshot.commands);
    const rows = rows_of(snapshot);
    this.history.accept(snapshot);
    this.fleet.accept(snapshot);
    this.snapshot = snapshot;
    this.rows = rows;
    this.virtualObjects = snapshot.virtualObjects ?? [];
    this.obstacles = snapshot.obstacles ?? [];
    this.bijection = snapshot.bijection;
    this.crossings = snapshot.crossings;
    this.server_ms = snapshot.time_ms;
    if (this.alarm_book.accept(rows, snapshot)) this.alarms = this.alarm_book.list();
    this.forget_the_gone(snapshot);
  }

  private record_commands(commands: readonly Command[]): void {
    let changed = false;
    for (const command of commands) {
      const known = this.command_book.get(command.id);
      // A restarted server numbers its commands from one again.
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
    for (const virtualObject of [...(snapshot.virtualObjects ?? []), ...(snapshot.obstacles ?? [])]) present.add(virtualObject.id);
    if (this.selected !== null && !present.has(this.selected) && this.started(snapshot)) this.select(null);
  }

  /** An address may name an AIV that has not reported yet; its selection is retained for `settling_ms`. */
  private started(snapshot: Snapshot): boolean {
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
