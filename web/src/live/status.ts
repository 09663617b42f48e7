// The five vehicle states of requirement A7 and `lost` for a broken link. Each has a word and a shape besides its colour, so
// that no information depends on colour alone.

export type StateKey = 'normal' | 'stopped' | 'slow' | 'medium' | 'fast' | 'lost';

export interface StateStyle {
  key: StateKey;
  word: string;
  /** SVG path in a 16 × 16 box */
  path: string;
  hollow: boolean;
}

export const state_styles: Readonly<Record<StateKey, StateStyle>> = {
  normal: { key: 'normal', word: 'Normal', path: 'M8 2a6 6 0 1 1 0 12a6 6 0 1 1 0-12z', hollow: false },
  stopped: { key: 'stopped', word: 'Stopped', path: 'M3 3h10v10H3z', hollow: false },
  slow: { key: 'slow', word: 'Slow speed', path: 'M2 4h12L8 14z', hollow: false },
  medium: { key: 'medium', word: 'Medium speed', path: 'M8 1.5L14.5 8L8 14.5L1.5 8z', hollow: false },
  fast: { key: 'fast', word: 'Fast speed', path: 'M8 2l6 10H2z', hollow: false },
  lost: { key: 'lost', word: 'Lost', path: 'M3.5 3.5l9 9m0-9l-9 9', hollow: true },
};

export function state_key(status: string, lost: boolean, connection: string): StateKey {
  if (lost || connection !== 'ONLINE') return 'lost';
  switch (status.toLowerCase()) {
    case 'stopped':
      return 'stopped';
    case 'slow speed':
      return 'slow';
    case 'medium speed':
      return 'medium';
    case 'fast speed':
      return 'fast';
    default:
      return 'normal';
  }
}
