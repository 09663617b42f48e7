// Circuits for the made-up platform: the clover of A11, and a yard of long loops for large fleets.

/** A closed track of straights and arcs, each starting where the one before ended. */
class Track {
  constructor(x, y, heading, parts) {
    this.sections = [];
    let from = 0;
    for (const { name, length, curvature } of parts) {
      this.sections.push({ name, length, curvature, start: [x, y, heading], from });
      ({ x, y, heading } = along([x, y, heading], curvature, length));
      from += length;
    }
    this.lap = from;
  }
  pose_at(distance) {
    let s = ((distance % this.lap) + this.lap) % this.lap;
    let section = this.sections[0];
    for (const candidate of this.sections) {
      if (candidate.from > s) break;
      section = candidate;
    }
    s -= section.from;
    return { ...along(section.start, section.curvature, s), section: section.name, s };
  }
}

function along([x, y, h], k, s) {
  if (k === 0) return { x: x + s * Math.cos(h), y: y + s * Math.sin(h), heading: h };
  return { x: x + (Math.sin(h + k * s) - Math.sin(h)) / k, y: y - (Math.cos(h + k * s) - Math.cos(h)) / k, heading: h + k * s };
}

function clover() {
  const r = 0.6;
  const parts = ['east', 'loop_se', 'north', 'loop_ne', 'west', 'loop_nw', 'south', 'loop_sw'].map((name, i) =>
    i % 2 ? { name, length: 1.5 * Math.PI * r, curvature: -1 / r } : { name, length: 1.5, curvature: 0 });
  const d = 0.15;
  return {
    name: 'lacet4', title: 'The clover with four crossings', bounds: [-1.45, -1.45, 1.45, 1.45],
    tracks: [new Track(-0.75, -d, 0, parts)],
    crossings: [[d, -d], [d, d], [-d, d], [-d, -d]].map(([x, y], i) => ({ name: `X${i + 1}`, x, y, radius: 0.13 })),
    tags: 12, beacons: { pitch_m: 0.3, origin: [-1.35, -1.35], columns: 10, rows: 10 },
  };
}

function yard(count) {
  const straight = 28;
  const r = 0.6;
  const loops = Math.max(1, Math.ceil(count / 90));
  const columns = Math.max(1, Math.round(Math.sqrt(loops / 15)));
  const tracks = Array.from({ length: loops }, (_, i) => {
    const column = i % columns;
    const row = Math.floor(i / columns);
    const n = i + 1;
    return new Track(column * 31, row * 1.8, 0, [
      { name: `out${n}`, length: straight, curvature: 0 }, { name: `turn${n}`, length: Math.PI * r, curvature: 1 / r },
      { name: `back${n}`, length: straight, curvature: 0 }, { name: `home${n}`, length: Math.PI * r, curvature: 1 / r },
    ]);
  });
  const rows = Math.ceil(loops / columns);
  return {
    name: 'yard', title: 'A yard of many loops', bounds: [-1.5, -1, (columns - 1) * 31 + straight + 1.5, rows * 1.8 + 0.5],
    tracks, crossings: [], tags: Math.min(200, loops * 4), beacons: null,
  };
}

export function circuit_for(name, count) {
  const made = name === 'yard' || (!name && count > 14) ? yard(count) : clover();
  made.total = made.tracks.reduce((sum, track) => sum + track.lap, 0);
  return made;
}

/** The position on the circuit that is nearest to a point: coarse steps, then fine ones. */
export function nearest_position(circuit, x, y) {
  let best = { track: circuit.tracks[0], distance: 0, off: Infinity };
  for (const track of circuit.tracks) {
    const search = (from, to, step) => {
      for (let distance = from; distance <= to; distance += step) {
        const p = track.pose_at(distance);
        const off = Math.hypot(p.x - x, p.y - y);
        if (off < best.off) best = { track, distance, off };
      }
    };
    search(0, track.lap, 0.1);
    if (best.track === track) search(best.distance - 0.1, best.distance + 0.1, 0.002);
  }
  const p = best.track.pose_at(best.distance);
  return { ...best, section: p.section, s: p.s, x: p.x, y: p.y };
}

export function position_of(circuit, name, s) {
  for (const track of circuit.tracks) {
    const section = track.sections.find((candidate) => candidate.name === name);
    if (section && s >= 0 && s <= section.length) return { track, distance: section.from + s };
  }
  return null;
}

export function draw_zone(circuit, tags, pitch) {
  const primitives = [];
  for (const track of circuit.tracks) {
    for (const section of track.sections) {
      const steps = section.curvature === 0 ? 1 : 40;
      const points = Array.from({ length: steps + 1 }, (_, i) => {
        const p = track.pose_at(section.from + (section.length * i) / steps - (i === steps ? 1e-9 : 0));
        return [round(p.x), round(p.y)];
      });
      primitives.push({ shape: 'polyline', layer: 'road', points, size_m: 0.2, label: section.name, heading: 0 });
      primitives.push({ shape: 'polyline', layer: 'line', kind: steps === 1 ? 'straight' : 'arc', points, size_m: 0.012, label: section.name, heading: 0 });
      const p = track.pose_at(section.from + section.length / 2);
      const [c, s] = [Math.cos(p.heading), Math.sin(p.heading)];
      const at = (ahead, left) => [p.x + c * ahead - s * left, p.y + s * ahead + c * left];
      primitives.push({ shape: 'polygon', layer: 'section', points: [at(0.035, 0), at(-0.025, 0.03), at(-0.025, -0.03)], size_m: 0, label: '', heading: 0 });
      primitives.push({ shape: 'text', layer: 'section', points: [at(0, -0.16)], size_m: 0.06, label: section.name, heading: 0 });
    }
  }
  for (const { name, x, y, radius } of circuit.crossings) {
    const corners = Array.from({ length: 8 }, (_, i) => [x + radius * Math.cos(((i + 0.5) * Math.PI) / 4), y + radius * Math.sin(((i + 0.5) * Math.PI) / 4)]);
    primitives.push({ shape: 'polygon', layer: 'crossing', points: corners, size_m: 0, label: name, heading: 0 });
  }
  const shown = tags.map(({ number, track, distance }) => {
    const p = track.pose_at(distance);
    primitives.push({ shape: 'disc', layer: 'tag', points: [[p.x, p.y]], size_m: 0.02, label: `tag ${number}`, heading: 0 });
    return { number, section: p.section, s: p.s, x: p.x, y: p.y };
  });
  let beacons = null;
  if (circuit.beacons) {
    const { origin, pitch_m, columns, rows } = circuit.beacons;
    const count = (n) => Math.max(2, Math.round(((n - 1) * pitch_m) / pitch) + 1);
    beacons = { pitch_m: pitch, origin, columns: count(columns), rows: count(rows) };
    for (let row = 0; row < beacons.rows; row++) for (let column = 0; column < beacons.columns; column++)
      primitives.push({ shape: 'disc', layer: 'beacon', points: [[origin[0] + column * pitch, origin[1] + row * pitch]], size_m: 0.008, label: `beacon ${1001 + row * beacons.columns + column}`, heading: 0 });
  }
  const stations = circuit.tracks.flatMap((track) => track.sections.filter((_, i) => i % 3 === 1).map((section) => ({ track, section }))).slice(0, 40).map(({ track, section }, i) => {
    const p = track.pose_at(section.from + section.length / 3);
    primitives.push({ shape: 'disc', layer: 'station', kind: i % 4 === 3 ? 'charger' : 'stop', points: [[p.x, p.y]], size_m: 0.036, label: `station ${i + 1}`, heading: 0 });
    return { name: `station ${i + 1}`, kind: i % 4 === 3 ? 'charger' : 'stop', x: p.x, y: p.y, section: section.name, s: section.length / 3 };
  });
  const diagnostics = [{ kind: 'mended', location: 'layouts[0].edges[3]', text: 'its end was 0.4 mm from the next one\u2019s start' }, { kind: 'lost', location: 'zones', text: 'speed zones are not taken' }];
  return {
    stations, loops: ['outer', 'inner'], diagnostics,
    name: circuit.name, bounds: circuit.bounds, vehicle: { length_m: 0.2, width_m: 0.12 }, primitives,
    sections: circuit.tracks.flatMap((track) => track.sections.map(({ name, length }) => ({ name, length_m: length }))),
    tags: shown, beacons,
  };
}
const round = (value) => Math.round(value * 1e4) / 1e4;
