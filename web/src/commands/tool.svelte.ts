// The tool for the next press on the map. Buttons and keys choose it; the Circuit frame carries it out, shows a hint, and
// returns to 'select' when the tool is done or Escape is pressed.
import type { Repeat } from '../live/contract';

export type ToolName = 'select' | 'add aiv' | 'add person' | 'draw walk' | 'add obstacle' | 'add plant obstacle' | 'edit tags' | 'close sections' | 'measure' | 'move object';

class Tool {
  name = $state<ToolName>('select');
  /** id of the object that 'move object' moves */
  target = $state<string | null>(null);
  /** speed of a walking person [m/s] */
  walk_speed = $state(0.2);
  walk_repeat = $state<Repeat>('back and forth');

  choose(name: ToolName): void {
    this.name = this.name === name ? 'select' : name;
    this.target = null;
  }
  move(id: string): void {
    this.name = 'move object';
    this.target = id;
  }
  done(): void {
    this.name = 'select';
    this.target = null;
  }
}

export const tool = new Tool();
