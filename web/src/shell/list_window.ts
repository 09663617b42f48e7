// Virtual scrolling: the document holds only the visible rows of a long list.

export interface ListWindow {
  first: number;
  /** one past the last row */
  last: number;
  before_px: number;
  after_px: number;
}

/** The rows to render, all of height `row_px`; `spare` rows beyond the visible ones avoid gaps during fast scrolling. */
export function window_of(scroll_px: number, height_px: number, row_px: number, count: number, whole = 100, spare = 6): ListWindow {
  // Short lists are rendered whole, so that the browser's search finds every row.
  if (count <= whole) return { first: 0, last: count, before_px: 0, after_px: 0 };
  const top_row = Math.max(0, Math.min(Math.floor(scroll_px / row_px), count - 1));
  const first = Math.max(0, top_row - spare);
  const last = Math.min(count, top_row + Math.ceil(height_px / row_px) + 1 + spare);
  return { first, last, before_px: first * row_px, after_px: (count - last) * row_px };
}

/** The scroll position that shows a row; unchanged if the row is visible. */
export function scroll_to_show(index: number, scroll_px: number, height_px: number, row_px: number, head_px = 0): number {
  const top = index * row_px;
  if (top < scroll_px) return top;
  const bottom = top + row_px + head_px;
  return bottom > scroll_px + height_px ? bottom - height_px : scroll_px;
}
