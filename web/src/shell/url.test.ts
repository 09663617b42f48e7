import { describe, expect, it } from 'vitest';
import { default_view, hash_of, view_of, type ViewState } from './url';

const there_and_back = (change: Partial<ViewState>) => view_of(hash_of({ ...default_view, ...change }));

describe('the address', () => {
  it('is empty in the default state', () => expect(hash_of(default_view)).toBe(''));

  it('is readable', () => {
    expect(hash_of({ ...default_view, frame: 'circuit', select: 'CoSiVA/AIV2', follow: true })).toBe('#frame=circuit&select=CoSiVA/AIV2&follow=1');
  });

  it('restores the whole view', () => {
    const view: ViewState = {
      frame: 'states', panel: 'alarms', select: 'MAKER & CO/Ä 7#', follow: true, filter: 'stopped east=1', sort: '-battery', agent: 'CoSiVA/AIV1', search_text: 'node 7', kinds_off: ['virtual_obstacles', 'heartbeat'], diagram: true, theme: 'dark', layers_off: ['tag', 'beacon'],
    };
    expect(there_and_back(view)).toEqual(view);
  });

  it('restores that all layers are shown, which differs from no entry', () => {
    expect(there_and_back({ layers_off: [] }).layers_off).toEqual([]);
    expect(there_and_back({ frame: 'circuit' }).layers_off).toBeNull();
  });

  it('contains the whole view if it contains anything, except the theme of the reader', () => {
    const view = view_of('#frame=circuit');
    expect(view).toMatchObject({ frame: 'circuit', panel: null, select: null, filter: '' });
    expect('theme' in view).toBe(false);
  });

  it('is empty by default, so that the settings stored in the browser apply', () => {
    expect(view_of('')).toEqual({});
    expect(view_of('#')).toEqual({});
  });

  it('ignores errors', () => {
    const view = view_of('#frame=kitchen&panel=../../x&sort=<b>&theme=pink&follow=perhaps&filter=' + 'x'.repeat(1_000));
    expect(view).toMatchObject({ frame: null, panel: null, sort: 'number', follow: false });
    expect(view.filter).toHaveLength(200);
    expect('theme' in view).toBe(false);
  });

  it('contains the filter of the communications', () => {
    expect(hash_of({ ...default_view, frame: 'traces', agent: 'CoSiVA/AIV1', kinds_off: ['virtual_obstacles', 'virtual_obstacles_ack'], diagram: true })).toBe('#frame=traces&agent=CoSiVA/AIV1&without=virtual_obstacles,virtual_obstacles_ack&diagram=1');
  });

  it('does not follow without a selected vehicle', () => expect(hash_of({ ...default_view, follow: true })).toBe(''));
});
