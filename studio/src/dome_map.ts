// The landscape as a picture: a ramp of one hue with lines of equal F.
import { dot, fromDisc } from "./math";
import type { Mapped } from "./messages";

const LEVELS = 10;
/** Strength of the lines of equal F. */
const LINE = 0.4;
/** Pixels from one line to the next where no light may stand, and the lines' strength. */
const HATCH = { every: 14, wide: 4, strength: 0.22 };

type Rgb = [number, number, number];

const rgb = (css: string): Rgb => (css.match(/[\d.]+/g)?.slice(0, 3).map(Number) ?? [0, 0, 0]) as Rgb;

/**
 * Paints the map over a canvas, whose `color` is that of the best place and `background-color` that of the worst. What lies
 * below a horizon that holds is hatched.
 */
export function paint(canvas: HTMLCanvasElement, map: Mapped | null) {
  const context = canvas.getContext("2d");
  if (!context) return;
  const size = canvas.width;
  context.clearRect(0, 0, size, size);
  if (!map) return;
  const heights = heightsOf(map);
  if (!heights) return;
  const style = getComputedStyle(canvas);
  const [good, bad] = [rgb(style.color), rgb(style.backgroundColor)];
  const image = context.createImageData(size, size);
  for (let y = 0; y < size; y++) {
    for (let x = 0; x < size; x++) {
      const [u, v] = [(2 * (x + 0.5)) / size - 1, (2 * (y + 0.5)) / size - 1];
      if (u * u + v * v > 1) continue;
      const at = 4 * (y * size + x);
      if (map.up && dot(fromDisc(u, -v), map.up) < 0) {
        const share = (x + y) % HATCH.every < HATCH.wide ? HATCH.strength : 0;
        put(image, at, (channel) => bad[channel]! + (good[channel]! - bad[channel]!) * share);
        continue;
      }
      const [height, slope] = sample(map, heights, (u + 1) / 2, (v + 1) / 2, size);
      const level = height * LEVELS;
      const off = Math.abs(level - Math.round(level));
      const line = LINE * Math.max(0, 1 - off / Math.max(1e-6, 0.9 * slope * LEVELS));
      const share = height ** 1.6;
      put(image, at, (channel) => {
        const value = bad[channel]! + (good[channel]! - bad[channel]!) * share;
        return value + (good[channel]! - value) * line;
      });
    }
  }
  context.putImageData(image, 0, 0);
}

/** An opaque pixel. */
function put(image: ImageData, at: number, value: (channel: number) => number) {
  for (let channel = 0; channel < 3; channel++) image.data[at + channel] = value(channel);
  image.data[at + 3] = 255;
}

/** How good each cell is, 0 the worst to 1 the best; cells outside the disc are as those beside them. */
function heightsOf({ values, columns, rows }: Mapped): Float32Array | null {
  const known = values.filter((value): value is number => value !== null);
  if (known.length === 0) return null;
  const [low, high] = known.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)], [Infinity, -Infinity]);
  const range = Math.max(1e-6, high - low);
  const heights = Float32Array.from(values, (value) => (value === null ? NaN : 1 - (value - low) / range));
  for (let round = 0; round < 2; round++) spreadOut(heights, columns, rows);
  return heights;
}

/** Gives cells without a value the mean of their neighbours with one. */
function spreadOut(heights: Float32Array, columns: number, rows: number) {
  const before = heights.slice();
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) {
      if (!Number.isNaN(before[y * columns + x])) continue;
      let [total, count] = [0, 0];
      for (let v = Math.max(0, y - 1); v <= Math.min(rows - 1, y + 1); v++) {
        for (let u = Math.max(0, x - 1); u <= Math.min(columns - 1, x + 1); u++) {
          const value = before[v * columns + u]!;
          if (!Number.isNaN(value)) [total, count] = [total + value, count + 1];
        }
      }
      if (count > 0) heights[y * columns + x] = total / count;
    }
  }
}

/** Height, and its change from pixel to pixel, at shares of the map's width and height. */
function sample({ columns, rows }: Mapped, heights: Float32Array, u: number, v: number, size: number): [number, number] {
  const x = Math.min(columns - 1, Math.max(0, u * columns - 0.5));
  const y = Math.min(rows - 1, Math.max(0, v * rows - 0.5));
  const [left, top] = [Math.min(columns - 2, Math.floor(x)), Math.min(rows - 2, Math.floor(y))];
  const [s, t] = [x - left, y - top];
  const at = top * columns + left;
  const [a, b, c, d] = [heights[at] || 0, heights[at + 1] || 0, heights[at + columns] || 0, heights[at + columns + 1] || 0];
  const [upper, lower] = [a + (b - a) * s, c + (d - c) * s];
  const across = ((b - a) * (1 - t) + (d - c) * t) * (columns / size);
  const down = (lower - upper) * (rows / size);
  return [upper + (lower - upper) * t, Math.hypot(across, down)];
}
