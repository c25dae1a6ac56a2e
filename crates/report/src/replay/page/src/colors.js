// Colours: viridis for J_state (van der Walt and Smith, CC0), Okabe and Ito's for lines, as in the figures.

const VIRIDIS = ["440154", "472d7b", "3b528b", "2c728e", "21908c", "27ad81", "5dc863", "aadc32", "fde725"].map((hex) =>
  [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16)),
);
const LIMIT = [0xc0, 0x1f, 0x2e];

/** Red, green, blue (0 to 255) of a J_state: viridis from 0 to 1, red above the limit. */
export function costColor(j) {
  if (!(j <= 1)) return LIMIT;
  const x = Math.max(0, j) * (VIRIDIS.length - 1);
  const i = Math.min(VIRIDIS.length - 2, Math.floor(x));
  return VIRIDIS[i].map((c, k) => c + (VIRIDIS[i + 1][k] - c) * (x - i));
}

export function costCss(j) {
  const [r, g, b] = costColor(j).map(Math.round);
  return `rgb(${r} ${g} ${b})`;
}

const known = new Map();

/** A colour of the style sheet. */
export function css(name) {
  if (!known.has(name)) known.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  return known.get(name);
}

/** The style sheet has other colours now. */
export function forgetColors() {
  known.clear();
}

/** Colour of a rotor, counted from 0. */
export function rotorColor(i) {
  return css(`rotor-${(i % 8) + 1}`);
}
