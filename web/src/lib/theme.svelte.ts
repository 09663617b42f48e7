// Light, dark, or as the system says; remembered in the browser.

export type Theme = 'system' | 'light' | 'dark';
const key = 'cosiva.theme';

class ThemeChoice {
  chosen = $state<Theme>('system');
  /** grows whenever colours may have changed: the canvas reads them again */
  revision = $state(0);

  choose(theme: Theme): void {
    this.chosen = theme;
    if (theme === 'system') delete document.documentElement.dataset['theme'];
    else document.documentElement.dataset['theme'] = theme;
    try {
      localStorage.setItem(key, theme);
    } catch {
      // Private windows may refuse to remember; the choice then lasts as long as the page.
    }
    this.revision++;
  }

  next(): void {
    const order: Theme[] = ['system', 'light', 'dark'];
    this.choose(order[(order.indexOf(this.chosen) + 1) % order.length]!);
  }
}

export const theme = new ThemeChoice();

export function restore_theme(): void {
  let stored: string | null = null;
  try {
    stored = localStorage.getItem(key);
  } catch {
    // as above
  }
  theme.choose(stored === 'light' || stored === 'dark' ? stored : 'system');
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => theme.revision++);
}
