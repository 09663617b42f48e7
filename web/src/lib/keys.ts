// Which key does what. Letters act alone, so they are left alone while someone types, and with Ctrl, Alt or Meta held.

export type MapAction = 'fit' | 'zoom in' | 'zoom out' | 'left' | 'right' | 'up' | 'down' | 'layers';
export type Action = MapAction | 'stop all' | 'stop selected' | 'next' | 'previous' | 'follow' | 'theme' | 'help' | 'close';

const single: Readonly<Record<string, Action>> = {
  Home: 'fit', '+': 'zoom in', '=': 'zoom in', '-': 'zoom out', ArrowLeft: 'left', ArrowRight: 'right', ArrowUp: 'up', ArrowDown: 'down',
  l: 'layers', s: 'stop selected', j: 'next', k: 'previous', f: 'follow', t: 'theme', '?': 'help', Escape: 'close',
};

export interface KeyPress {
  key: string;
  shiftKey: boolean;
  ctrlKey: boolean;
  altKey: boolean;
  metaKey: boolean;
  repeat: boolean;
  target: EventTarget | null;
}

export function key_action(press: KeyPress): Action | null {
  // Stop all works everywhere, also while typing: it must never need a second thought.
  if (press.key === 'Escape' && press.shiftKey) return press.repeat ? null : 'stop all';
  if (press.ctrlKey || press.altKey || press.metaKey || types_text(press.target)) return null;
  const action = single[press.key] ?? null;
  return press.repeat && (action === 'stop selected' || action === 'theme' || action === 'help') ? null : action;
}

function types_text(target: EventTarget | null): boolean {
  const tag = (target as Partial<HTMLElement> | null)?.tagName;
  return tag === 'TEXTAREA' || tag === 'SELECT' || (tag === 'INPUT' && (target as HTMLInputElement).type !== 'checkbox');
}
