// The effect of a press, Enter or Delete for each tool: a pure step from the current sketch to the next one and to a request
// for the server. No clock, canvas or framework.
import type { Point, Zone, ZoneEdit } from '../live/contract';
import { distance, nearest_on_tracks, path_length, section_at, spread_out } from './geometry';
import type { Hit } from './hit_index';
import type { ToolName } from '../commands/tool.svelte';

/** The unfinished drawing of a tool. */
export interface Sketch {
  /** points of a walk or of a measurement */
  points: readonly Point[];
  /** the chosen tag of 'edit tags' */
  tag: number | null;
}
export const empty_sketch: Sketch = { points: [], tag: null };

export type Doing =
  | { what: 'add aiv' | 'add person' | 'add obstacle' | 'add plant obstacle'; at: Point }
  | { what: 'move object'; at: Point }
  | { what: 'add walk'; path: readonly Point[] }
  | { what: 'edit zone'; edit: ZoneEdit }
  | { what: 'close or open'; section: string }
  | { what: 'report'; text: string };

export interface Step {
  sketch: Sketch;
  doing?: Doing;
  /** true when the tool is done */
  done?: boolean;
}

/** A press closer than this to the last point counts as a double press [m]. */
const apart_m = 0.01;
/** Greatest distance of a tag from a road [m]; the server refuses more. */
export const tag_reach_m = 0.3;

export function press(tool: ToolName, sketch: Sketch, at: Point, hit: Hit | null, zone: Zone | null): Step {
  switch (tool) {
    case 'add aiv':
    case 'add person':
    case 'add obstacle':
    case 'add plant obstacle':
    case 'move object':
      return { sketch: empty_sketch, doing: { what: tool, at }, done: true };
    case 'draw walk':
    case 'measure':
      return { sketch: { ...sketch, points: spread_out([...sketch.points, at], apart_m) } };
    case 'edit tags':
      return press_tag(sketch, at, hit, zone);
    case 'close sections': {
      const section = zone && section_at(zone, at[0], at[1], 0.02);
      return section ? { sketch, doing: { what: 'close or open', section } } : { sketch };
    }
    case 'none':
      return { sketch };
  }
}

function press_tag(sketch: Sketch, at: Point, hit: Hit | null, zone: Zone | null): Step {
  if (hit?.kind === 'tag') return { sketch: { ...sketch, tag: Number(hit.id) } };
  if (!zone) return { sketch };
  const nearest = nearest_on_tracks(zone, at[0], at[1]);
  // A press away from all roads only clears the choice.
  if (!nearest || nearest.distance > tag_reach_m / 2) return { sketch: { ...sketch, tag: null } };
  const number = next_tag_number(zone);
  return { sketch: { ...sketch, tag: number }, doing: { what: 'edit zone', edit: { addTags: [{ number, x: nearest.x, y: nearest.y }] } } };
}

/** Finishes the drawing, after Enter or a double press. */
export function finish(tool: ToolName, sketch: Sketch): Step {
  if (tool === 'measure') return { sketch: empty_sketch };
  if (tool !== 'draw walk') return { sketch };
  if (sketch.points.length === 0) return { sketch, doing: { what: 'report', text: 'Press the start of the walk on the map, then its next points.' } };
  if (sketch.points.length === 1) return { sketch, doing: { what: 'report', text: 'A walk needs a second point: press the next point of the path.' } };
  return { sketch: empty_sketch, doing: { what: 'add walk', path: sketch.points }, done: true };
}

/** Deletes the chosen tag or the last drawn point. */
export function erase(tool: ToolName, sketch: Sketch): Step {
  if (tool === 'edit tags') {
    if (sketch.tag === null) return { sketch };
    return { sketch: { ...sketch, tag: null }, doing: { what: 'edit zone', edit: { removeTags: [sketch.tag] } } };
  }
  return { sketch: { ...sketch, points: sketch.points.slice(0, -1) } };
}

/** The position of a dragged tag on the road nearest to the pointer; null if that is too far. */
export function drop_tag(number: number, at: Point, zone: Zone): { position: Point | null; doing: Doing } {
  const nearest = nearest_on_tracks(zone, at[0], at[1]);
  if (!nearest || nearest.distance > tag_reach_m) {
    return { position: null, doing: { what: 'report', text: `Tag ${number} was not moved: a tag must be on a path, and there is none within ${tag_reach_m} m of that position.` } };
  }
  return { position: [nearest.x, nearest.y], doing: { what: 'edit zone', edit: { moveTags: [{ number, x: nearest.x, y: nearest.y }] } } };
}

export function renumber(zone: Zone, from: number, to: number): Doing {
  const tag = zone.tags.find((one) => one.number === from);
  if (!tag) return { what: 'report', text: `Tag ${from} no longer exists.` };
  if (!Number.isInteger(to) || to < 1) return { what: 'report', text: 'A tag has a whole number from 1 on.' };
  if (zone.tags.some((one) => one.number === to)) return { what: 'report', text: `There is a tag ${to} already. Choose another number.` };
  return { what: 'edit zone', edit: { removeTags: [from], addTags: [{ number: to, section: tag.section, s: tag.s }] } };
}

export function next_tag_number(zone: Zone): number {
  const taken = new Set((zone.tags ?? []).map((tag) => tag.number));
  let number = 1;
  while (taken.has(number)) number++;
  return number;
}

/** The text of the hint bar. */
export function hint(tool: ToolName, sketch: Sketch, target: string | null): string {
  switch (tool) {
    case 'none':
      return '';
    case 'add aiv':
      return 'Press the start of the virtual AIV on the circuit.';
    case 'add person':
      return 'Press the position of the person.';
    case 'add obstacle':
      return 'Press the position of the virtual obstacle.';
    case 'add plant obstacle':
      return 'Press the position of the physical obstacle; AIVs detect it when they come near.';
    case 'move object':
      return `Press where ${target?.slice(target.indexOf('/') + 1) ?? 'it'} goes.`;
    case 'draw walk':
      return sketch.points.length === 0 ? 'Press where the walk begins.' : sketch.points.length === 1 ? 'Press where the person goes next.' : `${sketch.points.length} points, ${path_length(sketch.points).toFixed(2)} m. Press once more, or end with a double press or Enter.`;
    case 'edit tags':
      return sketch.tag === null ? 'Press a tag to select it, or a path to add a new one.' : `Tag ${sketch.tag}: drag it along the circuit, or press Delete to remove it.`;
    case 'close sections':
      return 'Press a section to close it: no vehicle enters it any more, and affected vehicles get another route. Press it again to open it.';
    case 'measure':
      return sketch.points.length < 2 ? 'Press two points or more; the distances are shown next to them.' : `${path_length(sketch.points).toFixed(3)} m in total. Enter restarts.`;
  }
}

/** The keyboard alternative, shown next to the hint while the map has the focus. */
export function keys_hint(tool: ToolName): string {
  const ends = tool === 'draw walk' ? ', twice at one position to end' : tool === 'measure' ? ', twice at one position to restart' : '';
  return `Arrow keys move the cross, with Shift finely; Enter presses${ends}.`;
}

/** Handles Enter at the crosshair: a second Enter at the same position finishes the drawing. */
export function enter(tool: ToolName, sketch: Sketch, at: Point, hit: Hit | null, zone: Zone | null): Step {
  const last = sketch.points.at(-1);
  const again = last !== undefined && distance(last, at) < apart_m && sketch.points.length > 1;
  return again ? finish(tool, sketch) : press(tool, sketch, at, hit, zone);
}
