// The page's map from outside: where a point of the zone stands on the screen, found by looking, not by asking the page.
import assert from 'node:assert/strict';
import { eventually } from './platform.mjs';

/** Asks the API, as a program would. Answers {status, body}. */
export async function ask(platform, method, what, body) {
  const response = await fetch(`${platform.url}/api/v1/${what}`, {
    method,
    ...(body === undefined ? {} : { headers: { 'content-type': 'application/json' }, body: typeof body === 'string' ? body : JSON.stringify(body) }),
    signal: AbortSignal.timeout(5_000),
  });
  return { status: response.status, body: await response.json().catch(() => null) };
}

export class ZoneMap {
  /** Presses two places of the map with the Person tool, and sees from where the persons then stand how the map lies. */
  static async find(page, platform) {
    const map = new ZoneMap();
    map.page = page;
    map.canvas = page.getByTestId('circuit').first();
    const box = await map.canvas.boundingBox();
    const pressed = [];
    for (const [u, v] of [[0.5, 0.5], [0.42, 0.3]]) {
      const before = new Set((await platform.snapshot()).things.map(({ id }) => id));
      const at = { px: Math.round(box.x + u * box.width), py: Math.round(box.y + v * box.height) };
      await page.getByTestId('tool-add-person').click();
      await page.mouse.click(at.px, at.py);
      const person = await eventually('the person stands in the zone', async () => (await platform.snapshot()).things.find(({ id }) => !before.has(id)), { within_ms: 5_000 });
      pressed.push({ ...at, x: person.x, y: person.y });
      const gone = await ask(platform, 'DELETE', `things/${person.id}`);
      assert.equal(gone.status, 200);
    }
    const [a, b] = pressed;
    map.scale = (b.px - a.px) / (b.x - a.x);
    map.origin = { px: a.px - map.scale * a.x, py: a.py + map.scale * a.y };
    // y grows upwards in the zone, and by the same scale.
    assert.ok(Math.abs((a.py - b.py) / (b.y - a.y) - map.scale) < 0.02 * map.scale, 'one scale for both directions');
    return map;
  }

  pixel({ x, y }) {
    return { px: this.origin.px + this.scale * x, py: this.origin.py - this.scale * y };
  }

  async press(point, options = {}) {
    const { px, py } = this.pixel(point);
    await this.page.mouse.click(px, py, options);
  }
}
