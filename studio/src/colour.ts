// Colours of lights for the screen: linear RGB, temperatures and sRGB.
import { clamp, type Vec3 } from "./math";

/** Temperatures that the slider offers, kelvin. */
export const KELVIN = { least: 1800, most: 12000 };

const encode = (x: number) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
const decode = (x: number) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);

/** The brightest sRGB colour of this hue, `#rrggbb`. */
export function hexOf(linear: Vec3): string {
  const largest = Math.max(...linear, 1e-9);
  const digits = (channel: number) =>
    Math.round(255 * encode(clamp(channel / largest, 0, 1))).toString(16).padStart(2, "0");
  return `#${linear.map(digits).join("")}`;
}

/** Linear RGB of `#rrggbb`, of luminance 1; white of black. */
export function linearOf(hex: string): Vec3 {
  const channel = (at: number) => decode(parseInt(hex.slice(at, at + 2), 16) / 255);
  return ofLuminanceOne([channel(1), channel(3), channel(5)]);
}

function ofLuminanceOne(linear: Vec3): Vec3 {
  const luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  return luminance > 0 ? [linear[0] / luminance, linear[1] / luminance, linear[2] / luminance] : [1, 1, 1];
}

/** Linear RGB of a black body, of luminance 1; after Tanner Helland's fit of its sRGB values. */
export function ofKelvin(temperature: number): Vec3 {
  const t = temperature / 100;
  const red = t <= 66 ? 255 : 329.7 * (t - 60) ** -0.1332;
  const green = t <= 66 ? 99.47 * Math.log(t) - 161.12 : 288.12 * (t - 60) ** -0.0755;
  const blue = t >= 66 ? 255 : t <= 19 ? 0 : 138.52 * Math.log(t - 10) - 305.04;
  const channel = (value: number) => decode(clamp(value, 0, 255) / 255);
  return ofLuminanceOne([channel(red), channel(green), channel(blue)]);
}

/** The temperature whose colour is that, kelvin; none where no black body has it. */
export function kelvinOf(linear: Vec3): number | null {
  const largest = Math.max(...linear, 1e-9);
  let best = { temperature: 0, distance: Infinity };
  for (let temperature = KELVIN.least; temperature <= KELVIN.most; temperature += 50) {
    const body = ofKelvin(temperature);
    const most = Math.max(...body);
    const distance = Math.hypot(...body.map((x, i) => encode(x / most) - encode(Math.max(0, linear[i]!) / largest)));
    if (distance < best.distance) best = { temperature, distance };
  }
  return best.distance < 0.03 ? best.temperature : null;
}
