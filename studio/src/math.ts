// Directions, the dome's projection and the camera's axes.

export type Vec3 = [number, number, number];
export type Axes = [right: Vec3, up: Vec3, back: Vec3];

export const RADIANS = Math.PI / 180;

export const clamp = (value: number, least: number, most: number) => Math.min(most, Math.max(least, value));

export const dot = (a: Vec3, b: Vec3) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export const scaled = (a: Vec3, factor: number): Vec3 => [a[0] * factor, a[1] * factor, a[2] * factor];

export const sum = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

export const unit = (a: Vec3): Vec3 => scaled(a, 1 / (Math.hypot(...a) || 1));

/** An angle in degrees, -180 to 180. */
export const wrapped = (degrees: number) => ((((degrees + 180) % 360) + 360) % 360) - 180;

/** Unit vector of an elevation and an azimuth in degrees: azimuth 0 is +Z, positive towards +X. */
export function direction(elevation: number, azimuth: number): Vec3 {
  const [theta, phi] = [elevation * RADIANS, azimuth * RADIANS];
  return [Math.cos(theta) * Math.sin(phi), Math.sin(theta), Math.cos(theta) * Math.cos(phi)];
}

/** Elevation and azimuth in degrees of a direction of any length. */
export function angles([x, y, z]: Vec3): { elevation: number; azimuth: number } {
  const flat = Math.hypot(x, z);
  return {
    elevation: Math.atan2(y, flat) / RADIANS,
    azimuth: flat < 1e-9 ? 0 : Math.atan2(x, z) / RADIANS,
  };
}

/**
 * Lambert's azimuthal equal-area projection of a unit vector: the middle is +Z, towards the viewer, the circle of
 * radius 1 is the direction away from the viewer. The second coordinate points up.
 */
export function toDisc([x, y, z]: Vec3): [number, number] {
  const flat = Math.hypot(x, y);
  const radius = Math.sqrt(Math.max(0, (1 - z) / 2));
  return flat < 1e-9 ? [radius, 0] : [(x / flat) * radius, (y / flat) * radius];
}

/** The unit vector at a point of the disc; points beyond it count as on its rim. */
export function fromDisc(x: number, y: number): Vec3 {
  const length = Math.hypot(x, y);
  const radius = Math.min(1, length);
  const z = 1 - 2 * radius * radius;
  const flat = Math.sqrt(Math.max(0, 1 - z * z));
  return length < 1e-9 ? [0, 0, 1] : [(x / length) * flat, (y / length) * flat, z];
}

/** The axes of a camera that looks from an azimuth and an elevation in degrees. */
export function axes({ azimuth, elevation }: { azimuth: number; elevation: number }): Axes {
  const back = direction(elevation, azimuth);
  const right: Vec3 = [Math.cos(azimuth * RADIANS), 0, -Math.sin(azimuth * RADIANS)];
  return [right, cross(back, right), back];
}

/** A vector of one camera's axes in world space. */
export const toWorld = (vector: Vec3, [right, up, back]: Axes): Vec3 =>
  sum(sum(scaled(right, vector[0]), scaled(up, vector[1])), scaled(back, vector[2]));

/** A vector in one camera's axes, seen in another's. */
export function turned(vector: Vec3, from: Axes, to: Axes): Vec3 {
  const world = toWorld(vector, from);
  return [dot(world, to[0]), dot(world, to[1]), dot(world, to[2])];
}
