import { describe, expect, it } from 'vitest';
import { default_view, hash_of, view_of, type ViewState } from './url';

const there_and_back = (change: Partial<ViewState>) => view_of(hash_of({ ...default_view, ...change }));

describe('the address', () => {
  it('is empty while everything is as it comes', () => expect(hash_of(default_view)).toBe(''));

  it('reads well', () => {
    expect(hash_of({ ...default_view, frame: 'circuit', select: 'CoSiVA/AIV2', follow: true })).toBe('#frame=circuit&select=CoSiVA/AIV2&follow=1');
  });

  it('brings back the whole view', () => {
    const view: ViewState = {
      frame: 'states', panel: 'alarms', select: 'MAKER & CO/Ä 7#', follow: true, filter: 'stopped east=1', sort: '-battery', agent: 'CoSiVA/AIV1', search_text: 'node 7', kinds_off: ['virtual_obstacles', 'heartbeat'], diagram: true, theme: 'dark', layers_off: ['tag', 'beacon'],
    };
    expect(there_and_back(view)).toEqual(view);
  });

  it('brings back that all layers are on, which is not the same as saying nothing', () => {
    expect(there_and_back({ layers_off: [] }).layers_off).toEqual([]);
    expect(there_and_back({ frame: 'circuit' }).layers_off).toBeNull();
  });

  it('says all of the view once it says anything, save the theme of the reader', () => {
    const view = view_of('#frame=circuit');
    expect(view).toMatchObject({ frame: 'circuit', panel: null, select: null, filter: '' });
    expect('theme' in view).toBe(false);
  });

  it('says nothing when it is empty: what the browser remembers holds', () => {
    expect(view_of('')).toEqual({});
    expect(view_of('#')).toEqual({});
  });

  it('passes over what is wrong', () => {
    const view = view_of('#frame=kitchen&panel=../../x&sort=<b>&theme=pink&follow=perhaps&filter=' + 'x'.repeat(1_000));
    expect(view).toMatchObject({ frame: null, panel: null, sort: 'number', follow: false });
    expect(view.filter).toHaveLength(200);
    expect('theme' in view).toBe(false);
  });

  it('tells which communications one looks at', () => {
    expect(hash_of({ ...default_view, frame: 'traces', agent: 'CoSiVA/AIV1', kinds_off: ['virtual_obstacles', 'virtual_obstacles_ack'], diagram: true })).toBe('#frame=traces&agent=CoSiVA/AIV1&without=virtual_obstacles,virtual_obstacles_ack&diagram=1');
  });

  it('does not follow nobody', () => expect(hash_of({ ...default_view, follow: true })).toBe(''));
});
