// Light, dark, or as the system says; remembered in the browser. The style sheet hears the outcome only.

export type Theme = 'system' | 'light' | 'dark';
const key = 'cosiva.theme';

class ThemeChoice {
  chosen = $state<Theme>('system');
  /** grows whenever colours may have changed: the canvas reads them again */
  revision = $state(0);
  private system_dark = false;

  choose(theme: Theme): void {
    this.chosen = theme;
    try {
      localStorage.setItem(key, theme);
    } catch {
      // Private windows may refuse to remember; the choice then lasts as long as the page.
    }
    this.show();
  }

  next(): void {
    const order: Theme[] = ['system', 'light', 'dark'];
    this.choose(order[(order.indexOf(this.chosen) + 1) % order.length]!);
  }

  system(dark: boolean): void {
    this.system_dark = dark;
    this.show();
  }

  private show(): void {
    document.documentElement.dataset['theme'] = this.chosen === 'dark' || (this.chosen === 'system' && this.system_dark) ? 'dark' : 'light';
    this.revision++;
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
  const system = matchMedia('(prefers-color-scheme: dark)');
  theme.system(system.matches);
  theme.choose(stored === 'light' || stored === 'dark' ? stored : 'system');
  system.addEventListener('change', (event) => theme.system(event.matches));
}
