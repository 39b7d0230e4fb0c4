/** A polynomial through Chebyshev points: its integral, values, error estimate and roots. */

export const N = 16;
const indices = [...Array(N + 1).keys()];
/** The points x_i, from -1 to 1. */
export const POINTS = indices.map((i) => -Math.cos((Math.PI * i) / N));
// creating a plain array of doubles is faster than creating a typed one
const ROW = indices.map(() => 0.5);
export const blank = () => ROW.slice();
const ends = (i) => (i === 0 || i === N ? 0.5 : 1);
/** Row k gives the coefficient of the Chebyshev polynomial T_k from values at the points. */
const COEFFICIENT = indices.map((k) =>
  indices.map((j) => (2 / N) * ends(k) * ends(j) * Math.cos((Math.PI * k * (N - j)) / N)));
/** Row i gives the integral from -1 to x_i from values at the points. */
export const INTEGRAL = indices.map((i) => {
  const T = (k, x) => Math.cos(k * Math.acos(x));
  const whole = (k, x) => {
    if (k === 0) return x;
    return k === 1 ? (x * x) / 2 : T(k + 1, x) / (2 * (k + 1)) - T(k - 1, x) / (2 * (k - 1));
  };
  return indices.map((j) =>
    indices.reduce((sum, k) => sum + COEFFICIENT[k][j] * (whole(k, POINTS[i]) - whole(k, -1)), 0));
});
const LAST = [COEFFICIENT[N - 1], COEFFICIENT[N]];
const BARYCENTRIC = indices.map((i) => (i % 2 ? -1 : 1) * ends(i));

export function dot(row, values) {
  let sum = 0;
  for (let i = 0; i <= N; i++) sum += row[i] * values[i];
  return sum;
}

/** Integrals from the first point to every point. */
export function integrate(values) {
  const sums = blank();
  sums[0] = 0;
  for (let i = 1; i <= N; i++) sums[i] = dot(INTEGRAL[i], values);
  return sums;
}

/** The polynomial through values at the points, at x. */
export function interpolate(values, x) {
  let above = 0;
  let below = 0;
  for (let i = 0; i <= N; i++) {
    const way = x - POINTS[i];
    if (way === 0) return values[i];
    const weight = BARYCENTRIC[i] / way;
    above += weight * values[i];
    below += weight;
  }
  return above / below;
}

/** Size of the last two coefficients over the greatest value: an estimate of the error. */
export function tail(values) {
  let most = 0;
  for (let i = 0; i <= N; i++) most = Math.max(most, Math.abs(values[i]));
  const rest = Math.abs(dot(LAST[0], values)) + Math.abs(dot(LAST[1], values));
  return most > 0 ? rest / most : 0;
}

/** Root of f between low and high, where its signs differ (Anderson and Bjorck). */
export function root(f, low, high, atLow = f(low), atHigh = f(high)) {
  if (atLow === 0) return low;
  if (atHigh === 0 || atLow * atHigh > 0) return high;
  for (let i = 0; i < 100 && Math.abs(high - low) > 1e-16 + 2e-16 * Math.abs(high); i++) {
    let x = high - (atHigh * (high - low)) / (atHigh - atLow);
    if (!(x > Math.min(low, high) && x < Math.max(low, high))) x = 0.5 * (low + high);
    const value = f(x);
    if (value === 0) return x;
    if (value * atHigh < 0) [low, atLow] = [high, atHigh];
    else {
      const share = 1 - value / atHigh;
      atLow *= share > 0 ? share : 0.5;
    }
    if (x === high) return x;
    [high, atHigh] = [x, value];
  }
  return high;
}
