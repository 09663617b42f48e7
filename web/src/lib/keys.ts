// Which key does what: one table for the handler, the help and the list of commands, so that none tells a tale.

export type MapAction = 'fit' | 'zoom in' | 'zoom out' | 'left' | 'right' | 'up' | 'down' | 'layers';
export type FrameAction = 'frame 1' | 'frame 2' | 'frame 3' | 'frame 4';
export type Action =
  | MapAction
  | FrameAction
  | 'stop all'
  | 'stop selected'
  | 'next'
  | 'previous'
  | 'follow'
  | 'search'
  | 'play'
  | 'step'
  | 'long step'
  | 'theme'
  | 'help'
  | 'palette'
  | 'close';

export interface Binding {
  /** as KeyboardEvent.key says them */
  keys: readonly string[];
  action: Action;
  what: string;
  group: 'Fleet' | 'Time' | 'Circuit' | 'Page';
  /** printed in help where it differs from the key */
  printed?: string;
  shift?: true;
  ctrl?: true;
  /** may repeat while it is held */
  repeats?: true;
}

export const bindings: readonly Binding[] = [
  { keys: ['Escape'], shift: true, action: 'stop all', what: 'stop all AIVs, at once, from anywhere', group: 'Fleet', printed: 'Shift Esc' },
  { keys: ['s'], action: 'stop selected', what: 'stop the chosen AIVs, or the selected one', group: 'Fleet' },
  { keys: ['j'], action: 'next', what: 'select the next AIV', group: 'Fleet', repeats: true },
  { keys: ['k'], action: 'previous', what: 'select the previous AIV', group: 'Fleet', repeats: true },
  { keys: ['/'], action: 'search', what: 'search the list of AIVs', group: 'Fleet' },
  { keys: [' '], action: 'play', what: 'pause virtual time, or let it run', group: 'Time', printed: 'Space' },
  { keys: ['.'], action: 'step', what: 'step 0.1 s of virtual time', group: 'Time', repeats: true },
  { keys: [','], action: 'long step', what: 'step 1 s of virtual time', group: 'Time', repeats: true },
  { keys: ['f'], action: 'follow', what: 'follow the selected AIV', group: 'Circuit' },
  { keys: ['Home'], action: 'fit', what: 'show the whole circuit', group: 'Circuit' },
  { keys: ['+', '='], action: 'zoom in', what: 'zoom in; the wheel zooms to the cursor', group: 'Circuit', repeats: true, printed: '+' },
  { keys: ['-'], action: 'zoom out', what: 'zoom out', group: 'Circuit', repeats: true, printed: '−' },
  { keys: ['ArrowLeft'], action: 'left', what: 'move the map; dragging does too', group: 'Circuit', repeats: true, printed: '←' },
  { keys: ['ArrowRight'], action: 'right', what: 'move the map', group: 'Circuit', repeats: true, printed: '→' },
  { keys: ['ArrowUp'], action: 'up', what: 'move the map', group: 'Circuit', repeats: true, printed: '↑' },
  { keys: ['ArrowDown'], action: 'down', what: 'move the map', group: 'Circuit', repeats: true, printed: '↓' },
  { keys: ['l'], action: 'layers', what: 'choose the layers of the circuit', group: 'Circuit' },
  { keys: ['1'], action: 'frame 1', what: 'fill the page with Supervision, or show all four', group: 'Page' },
  { keys: ['2'], action: 'frame 2', what: 'fill the page with States', group: 'Page' },
  { keys: ['3'], action: 'frame 3', what: 'fill the page with the Circuit', group: 'Page' },
  { keys: ['4'], action: 'frame 4', what: 'fill the page with the Traces', group: 'Page' },
  { keys: ['k'], ctrl: true, action: 'palette', what: 'list of all commands', group: 'Page', printed: 'Ctrl K' },
  { keys: ['t'], action: 'theme', what: 'light, dark, or as the system', group: 'Page' },
  { keys: ['?'], action: 'help', what: 'this help', group: 'Page' },
  { keys: ['Escape'], action: 'close', what: 'close, put the tool away, undo the choice', group: 'Page', printed: 'Esc' },
];

export interface KeyPress {
  key: string;
  shiftKey: boolean;
  ctrlKey: boolean;
  altKey: boolean;
  metaKey: boolean;
  repeat: boolean;
  target: EventTarget | null;
}

/** @param letters  false: single characters do nothing (WCAG 2.1.4); keys like Home and Escape stay */
export function key_action(press: KeyPress, letters = true): Action | null {
  // Stop all works everywhere, also while typing: it must never need a second thought.
  if (press.key === 'Escape' && press.shiftKey) return press.repeat ? null : 'stop all';
  if (press.altKey) return null;
  const control = press.ctrlKey || press.metaKey;
  const found = bindings.find((one) => (one.ctrl === true) === control && !one.shift && one.keys.includes(control ? press.key.toLowerCase() : press.key));
  if (!found || (press.repeat && !found.repeats)) return null;
  if (found.ctrl) return found.action;
  if (types_text(press.target)) return found.action === 'close' ? 'close' : null;
  if (press.key.length === 1 && !letters) return null;
  // Space presses the button that has the focus.
  if (press.key === ' ' && presses(press.target)) return null;
  return found.action;
}

/** The key of an action as it is printed; nothing for one without a key. */
export function key_of(action: Action): string | undefined {
  const found = bindings.find((one) => one.action === action);
  return found?.printed ?? found?.keys[0];
}

function types_text(target: EventTarget | null): boolean {
  const tag = (target as Partial<HTMLElement> | null)?.tagName;
  return tag === 'TEXTAREA' || tag === 'SELECT' || (tag === 'INPUT' && !['checkbox', 'radio'].includes((target as HTMLInputElement).type));
}

function presses(target: EventTarget | null): boolean {
  const element = target as Partial<HTMLElement> | null;
  return ['BUTTON', 'INPUT', 'SUMMARY', 'A'].includes(element?.tagName ?? '') || element?.getAttribute?.('role') === 'option';
}
