// The layout of the page: which frame fills it, which panel is open, what the tables show. The address keeps it, so that a
// link reproduces the view, and so does the browser's storage, so that the next visit finds it.
import { default_view, frame_names, type FrameName, type PanelName, type ViewState } from './url';

const key = 'cosiva.layout';

/** Positions of the borders between the frames, in percent of the page. */
export interface Borders {
  columns: number;
  left: number;
  right: number;
}
export const default_borders: Borders = { columns: 35, left: 60, right: 60 };

class Layout {
  /** the frame that fills the page, or null */
  frame = $state<FrameName | null>(null);
  panel = $state<PanelName | null>(null);
  filter = $state('');
  sort = $state(default_view.sort);
  /** filter of the communications, and whether the diagram shows them */
  agent = $state('');
  search_text = $state('');
  kinds_off = $state.raw<readonly string[]>([]);
  diagram = $state(false);
  columns = $state.raw<Readonly<Record<string, boolean>>>({});
  /** layers of the circuit that are switched off; null: the default */
  layers_off = $state.raw<readonly string[] | null>(null);
  supervision_order = $state<'number' | 'priority'>('number');
  borders = $state.raw<Borders>(default_borders);
  /** whether single letters act as keys; WCAG 2.1.4 demands the choice */
  letters = $state(true);
  help_open = $state(false);
  palette_open = $state(false);
  zones_open = $state(false);

  toggle_frame(name: FrameName): void {
    this.frame = this.frame === name ? null : name;
  }
  toggle_panel(name: PanelName): void {
    this.panel = this.panel === name ? null : name;
  }
  frame_number(n: number): void {
    const name = frame_names[n - 1];
    if (name) this.toggle_frame(name);
  }

  apply(view: Partial<ViewState>): void {
    if (view.frame !== undefined) this.frame = view.frame;
    if (view.panel !== undefined) this.panel = view.panel;
    if (view.filter !== undefined) this.filter = view.filter;
    if (view.sort !== undefined) this.sort = view.sort;
    if (view.agent !== undefined) this.agent = view.agent;
    if (view.search_text !== undefined) this.search_text = view.search_text;
    if (view.kinds_off !== undefined) this.kinds_off = view.kinds_off;
    if (view.diagram !== undefined) this.diagram = view.diagram;
    if (view.layers_off !== undefined) this.layers_off = view.layers_off;
  }

  restore(): void {
    try {
      const stored = JSON.parse(localStorage.getItem(key) ?? '{}') as Partial<Record<string, unknown>>;
      const borders = stored['borders'] as Partial<Borders> | undefined;
      this.borders = { ...default_borders, ...borders };
      this.columns = (stored['columns'] as Record<string, boolean> | undefined) ?? {};
      this.letters = stored['letters'] !== false;
      // A wide screen has room for a panel next to the four frames.
      const persisted = stored['panel'] as PanelName | null | undefined;
      this.panel = persisted === undefined ? (innerWidth >= 1_700 ? 'bijection' : null) : persisted;
      this.supervision_order = stored['order'] === 'priority' ? 'priority' : 'number';
      if (typeof stored['sort'] === 'string') this.sort = stored['sort'];
    } catch {
      // Private windows may refuse storage; the layout then lasts as long as the page.
    }
  }

  persist(): void {
    const stored = { borders: this.borders, columns: this.columns, letters: this.letters, panel: this.panel, order: this.supervision_order, sort: this.sort };
    try {
      localStorage.setItem(key, JSON.stringify(stored));
    } catch {
      // as above
    }
  }
}

export const layout = new Layout();
