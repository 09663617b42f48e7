// What the next press on the map does. Buttons and keys anywhere choose a tool; the Circuit frame carries it out, says
// what to do, and goes back to looking when it is done or Escape is pressed.
import type { Repeat } from './contract';

export type ToolName = 'look' | 'add aiv' | 'add person' | 'draw walk' | 'add obstacle' | 'add plant obstacle' | 'edit tags' | 'close sections' | 'measure' | 'move thing';

class Tool {
  name = $state<ToolName>('look');
  /** what 'move thing' moves */
  target = $state<string | null>(null);
  /** of a person that walks */
  walk_speed = $state(0.2);
  walk_repeat = $state<Repeat>('back and forth');

  choose(name: ToolName): void {
    this.name = this.name === name ? 'look' : name;
    this.target = null;
  }
  move(id: string): void {
    this.name = 'move thing';
    this.target = id;
  }
  done(): void {
    this.name = 'look';
    this.target = null;
  }
}

export const tool = new Tool();
