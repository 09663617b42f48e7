// The zone's waypoints as `cosiva zone check --json` lists them, in driving order.
import assert from 'node:assert/strict';
import { cosiva_json, zone_file } from './platform.mjs';

export class Circuit {
  static async load(name = 'lacet4') {
    const circuit = new Circuit();
    circuit.name = name;
    const answer = await cosiva_json(['zone', 'check', zone_file(name), '--json']);
    circuit.waypoints = answer.waypoints;
    assert.ok(circuit.waypoints.length > 20, `only ${circuit.waypoints.length} waypoints`);
    return circuit;
  }

  /** Index of the last waypoint of `section` at or before `s`. */
  behind(section, s) {
    let best = -1;
    this.waypoints.forEach((waypoint, i) => {
      if (waypoint.section === section && waypoint.s <= s + 1e-9) best = i;
    });
    assert.ok(best >= 0, `no waypoint on ${section} before ${s}`);
    return best;
  }

  /**
   * The waypoint `steps` further along the loop. Sections of the native format follow each other in the file's order.
   */
  at(index, steps = 0) {
    const n = this.waypoints.length;
    return this.waypoints[(((index + steps) % n) + n) % n];
  }

  /** Driving direction at a waypoint [rad]. */
  heading(index) {
    return this.at(index).heading;
  }
}

/** Whether two rectangles (x, y, heading; the same length and width) touch. Separating axes. */
export function bodies_touch(a, b, length, width) {
  const axes = [a.heading, a.heading + Math.PI / 2, b.heading, b.heading + Math.PI / 2];
  const reach = (body, axis) => (length / 2) * Math.abs(Math.cos(axis - body.heading)) + (width / 2) * Math.abs(Math.sin(axis - body.heading));
  return axes.every((axis) => {
    const apart = Math.abs((b.x - a.x) * Math.cos(axis) + (b.y - a.y) * Math.sin(axis));
    return apart <= reach(a, axis) + reach(b, axis);
  });
}
