// The key bindings: one table for the handler, the help and the list of commands, so that the three agree.

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
/** Carries out an action, requested by a key, a button or an entry of the list of commands. */
export type Act = (action: Action) => void;

export interface Binding {
  /** values of KeyboardEvent.key */
  keys: readonly string[];
  action: Action;
  what: string;
  group: 'Fleet' | 'Time' | 'Circuit' | 'Page';
  /** shown in the help if it differs from the key */
  printed?: string;
  shift?: true;
  ctrl?: true;
  /** repeats while the key is held */
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
  { keys: ['Escape'], action: 'close', what: 'close, end the tool, clear the selection', group: 'Page', printed: 'Esc' },
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

/** @param letters  false: single characters are ignored (WCAG 2.1.4); keys such as Home and Escape still act */
export function key_action(press: KeyPress, letters = true): Action | null {
  // `stop all` acts everywhere, also in text fields, so that an operator need not check the focus first.
  if (press.key === 'Escape' && press.shiftKey) return press.repeat ? null : 'stop all';
  if (press.altKey) return null;
  const control = press.ctrlKey || press.metaKey;
  const found = bindings.find((one) => (one.ctrl === true) === control && !one.shift && one.keys.includes(control ? press.key.toLowerCase() : press.key));
  if (!found || (press.repeat && !found.repeats)) return null;
  if (found.ctrl) return found.action;
  if (types_text(press.target)) return found.action === 'close' ? 'close' : null;
  if (press.key.length === 1 && !letters) return null;
  // Space presses the focused button.
  if (press.key === ' ' && presses(press.target)) return null;
  return found.action;
}

/** The printed key of an action; empty for an action without a key. */
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
