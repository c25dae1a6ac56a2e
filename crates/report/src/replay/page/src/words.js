// Numbers and names as text.

/** A number with a minus sign proper, and none before zero. */
export function fixed(x, digits) {
  if (!Number.isFinite(x)) return "\u2013";
  const text = x.toFixed(digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
}

/** A time since the rotors were freed, with its sign. */
export function signed(t, digits = 2) {
  const text = fixed(t, digits);
  return t > 0 && Number(text) !== 0 ? `+${text}` : text;
}

/** Places of rotors in words, "front right"; with a number where places are shared. */
export function rotorNames(rotors) {
  const reach = Math.max(...rotors.map(({ position_body_m: [x, y] }) => Math.hypot(x, y)), 1e-9);
  const places = rotors.map(({ position_body_m: [x, y] }) => {
    const along = x > 0.2 * reach ? "front" : x < -0.2 * reach ? "rear" : "";
    const aside = y > 0.2 * reach ? "right" : y < -0.2 * reach ? "left" : "";
    return [along, aside].filter(Boolean).join(" ") || "centre";
  });
  const unique = new Set(places).size === places.length;
  return places.map((place, i) => (unique ? place : `${i + 1} ${place}`));
}

/** A step of 1, 2 or 5 times a power of ten at or above x. */
export function roundStep(x) {
  const power = 10 ** Math.floor(Math.log10(x) + 1e-9);
  return [1, 2, 5, 10].map((m) => m * power).find((step) => step >= x * (1 - 1e-9));
}
