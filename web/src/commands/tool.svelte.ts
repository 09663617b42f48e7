// The tool for the next press on the map. Buttons and keys choose it; the Circuit frame carries it out, shows a hint, and
// returns to 'none' when the tool is done or Escape is pressed.
import type { Repeat } from '../live/contract';

export type ToolName = 'none' | 'add aiv' | 'add person' | 'draw walk' | 'add obstacle' | 'add plant obstacle' | 'edit tags' | 'close sections' | 'measure' | 'move object';

class Tool {
  name = $state<ToolName>('none');
  /** id of the object that 'move object' moves */
  target = $state<string | null>(null);
  /** speed of a walking person [m/s] */
  walk_speed = $state(0.2);
  walk_repeat = $state<Repeat>('back and forth');

  choose(name: ToolName): void {
    this.name = this.name === name ? 'none' : name;
    this.target = null;
  }
  move(id: string): void {
    this.name = 'move object';
    this.target = id;
  }
  done(): void {
    this.name = 'none';
    this.target = null;
  }
}

export const tool = new Tool();
