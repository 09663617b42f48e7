// Scrolling of lists that are too tall for the browser (some fail at 17 million pixels): above a bound, one pixel of the
// scroll bar represents several of the list. All rows have the same height.

export const tall_max_px = 8_000_000;

export class Scroll {
  constructor(
    private readonly rows: number,
    private readonly row_px: number,
    private readonly height_px: number,
  ) {}

  /** height of the whole list */
  get whole_px(): number {
    return this.rows * this.row_px;
  }
  /** height of the element that gives the scroll bar its length */
  get bar_px(): number {
    return Math.min(this.whole_px, tall_max_px);
  }
  /** pixels of the list per pixel of the scroll bar */
  get scale(): number {
    const bar = this.bar_px - this.height_px;
    return this.whole_px <= tall_max_px || bar <= 0 ? 1 : (this.whole_px - this.height_px) / bar;
  }
  get end_px(): number {
    return Math.max(0, this.whole_px - this.height_px);
  }
  /** The visible rows: the first, one past the last, and the offset of the first above the upper edge. */
  rows_at(top_px: number): { first: number; last: number; shift_px: number } {
    const top = Math.max(0, Math.min(top_px, this.end_px));
    const first = Math.floor(top / this.row_px);
    const last = Math.min(this.rows, Math.ceil((top + this.height_px) / this.row_px) + 1);
    return { first, last, shift_px: top - first * this.row_px };
  }
  /** The scroll position that shows a row completely; unchanged if the row is visible. */
  to_show(index: number, top_px: number): number {
    const row = index * this.row_px;
    if (row < top_px) return row;
    return row + this.row_px > top_px + this.height_px ? row + this.row_px - this.height_px : top_px;
  }
}
