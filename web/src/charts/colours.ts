/** The theme's colours for what is drawn on a canvas. */
const root = document.documentElement;

/** name: of a custom property of theme.css, without its dashes. */
export function colour(name: string): string {
  return getComputedStyle(root).getPropertyValue(`--${name}`).trim();
}
