// What can be done to a light, without knowing of the page.
import { angles, clamp, direction, dot, turned, unit, type Axes, type Vec3 } from "./math";
import type { Light } from "./messages";

/** Largest values that the page offers. */
export const MOST = { intensity: 4, distance: 10, size: 1 };

export const KINDS: { kind: Light["kind"]; title: string }[] = [
  { kind: "point", title: "Point" },
  { kind: "directional", title: "Directional" },
  { kind: "spot", title: "Spot" },
];

const ROLE_TITLES = { key: "Key", fill: "Fill", rim: "Rim", scene: "Scene" };

export const ROLES: Light["role"][] = ["key", "fill", "rim"];

export const roleTitle = (role: Light["role"]) => ROLE_TITLES[role];

/** The light, seen in this direction from the scene's centre. */
export const towards = (light: Light, vector: Vec3): Light => ({ ...light, direction: unit(vector) });

/** The light in another camera's axes, so that it stays where it is in the scene. */
export const intoAxes = (light: Light, from: Axes, to: Axes): Light => ({
  ...towards(light, turned(light.direction, from, to)),
  aim: light.aim && turned(light.aim, from, to),
});

/** The intensity that people set: the larger of both. */
export const intensityOf = (light: Light) => Math.max(light.diffuse, light.specular);

/** The light with that intensity; the share of highlights stays, also at next to nothing. */
export function withIntensity(light: Light, intensity: number): Light {
  const before = intensityOf(light);
  const after = clamp(intensity, 0, MOST.intensity);
  if (before <= 0) return { ...light, diffuse: after, specular: after };
  const factor = Math.max(after, 1e-4) / before;
  return { ...light, diffuse: light.diffuse * factor, specular: light.specular * factor };
}

/** The share of the highlights: 1 where both intensities are the same, 2 without diffuse light. */
export const highlights = (light: Light) =>
  light.specular <= light.diffuse ? light.specular / (light.diffuse || 1) : 2 - light.diffuse / light.specular;

/** The light with that share of highlights, 0 to 2; its intensity stays. */
export function withHighlights(light: Light, share: number): Light {
  const most = intensityOf(light);
  return { ...light, diffuse: most * Math.min(1, 2 - share), specular: most * Math.min(1, share) };
}

/** A new point light, from the place that is farthest from all others. */
export function added(lights: Light[]): Light {
  const places: [number, number][] = [[40, -45], [40, 45], [15, 0], [45, 165], [45, -165], [-20, 60], [-20, -60]];
  const nearest = ([elevation, azimuth]: [number, number]) =>
    Math.max(-1, ...lights.map((light) => dot(light.direction, direction(elevation, azimuth))));
  const place = places.reduce((a, b) => (nearest(b) < nearest(a) - 1e-6 ? b : a));
  const behind = Math.abs(place[1]) > 90;
  return {
    role: behind ? "rim" : lights.some(({ role }) => role === "key") ? "fill" : "key",
    kind: "point",
    direction: direction(...place),
    distance: 3,
    diffuse: 0.5,
    specular: 0.5,
    color: [1, 1, 1],
    size: 0,
    cone: [15, 30],
    aim: null,
    locked: false,
  };
}

/** "Key light 1". */
export const nameOf = (light: Light, index: number) => `${ROLE_TITLES[light.role]} light ${index + 1}`;

/** Where it stands, in words: "40° up, 45° right of the viewer". */
export function inWords(light: Light): string {
  const { elevation, azimuth } = angles(light.direction);
  const [up, right] = [Math.round(elevation), Math.round(azimuth)];
  const vertical = `${Math.abs(up)}° ${up < 0 ? "down" : "up"}`;
  const side = `${Math.abs(right)}° to the ${right < 0 ? "left" : "right"}`;
  return `${vertical}, ${side}, intensity ${intensityOf(light).toFixed(2)}${light.locked ? ", locked" : ""}`;
}
