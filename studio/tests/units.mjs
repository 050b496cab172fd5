// The page's formulas, without a browser.
import assert from "node:assert/strict";
import { build } from "esbuild";
import { fileURLToPath } from "node:url";

/** A module of the page, as Node takes it. */
async function load(name) {
  const entry = fileURLToPath(new URL(`../src/${name}.ts`, import.meta.url));
  const { outputFiles } = await build({ entryPoints: [entry], bundle: true, write: false, format: "esm" });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

const close = (a, b, tolerance = 1e-6) => a.every((value, index) => Math.abs(value - b[index]) < tolerance);

export async function theDomeIsLambertsEqualAreaMap() {
  const { angles, direction, fromDisc, toDisc } = await load("math");
  for (const [elevation, azimuth] of [[0, 0], [40, 45], [-30, -120], [89, 10], [10, 179], [0, 90]]) {
    const vector = direction(elevation, azimuth);
    assert.ok(close(fromDisc(...toDisc(vector)), vector), `${elevation}, ${azimuth}`);
    const back = angles(vector);
    assert.ok(close([back.elevation, back.azimuth], [elevation, azimuth]));
  }
  assert.ok(close(toDisc([0, 0, 1]), [0, 0]));
  assert.ok(close(toDisc([1, 0, 0]), [Math.SQRT1_2, 0]), "from the side: half of the area lies within");
  assert.ok(close(toDisc([0, 1, 0]), [0, Math.SQRT1_2]), "above is up");
  assert.ok(Math.abs(Math.hypot(...toDisc([0, 0, -1])) - 1) < 1e-9);
  assert.ok(close(fromDisc(3, 0), [0, 0, -1]), "beyond the rim is behind");
  // A ring's share of the disc is its share of the sphere.
  const [inner, outer] = [30, 70].map((degrees) => Math.hypot(...toDisc(direction(0, degrees))) ** 2);
  const zone = (Math.cos((30 * Math.PI) / 180) - Math.cos((70 * Math.PI) / 180)) / 2;
  assert.ok(Math.abs(outer - inner - zone) < 1e-9);
}

export async function lightsStayInTheSceneWhenTheCameraTurns() {
  const { axes, direction, toWorld, turned } = await load("math");
  const [from, to] = [axes({ azimuth: 30, elevation: 15 }), axes({ azimuth: -110, elevation: 60 })];
  const vector = direction(25, 70);
  assert.ok(close(toWorld(turned(vector, from, to), to), toWorld(vector, from)));
  assert.ok(close(turned([0, 0, 1], from, from), [0, 0, 1]));
  assert.ok(close(from[2], direction(15, 30)), "the third axis points to the viewer");
}

export async function intensitiesAndColoursAreKept() {
  const { added, highlights, withHighlights, withIntensity } = await load("light");
  const { hexOf, kelvinOf, linearOf, ofKelvin } = await load("colour");
  const light = { ...added([]), diffuse: 0.4, specular: 0.1 };
  const bright = withIntensity(light, 1.2);
  assert.ok(close([bright.diffuse, bright.specular], [1.2, 0.3]));
  const back = withIntensity(withIntensity(light, 0), 0.4);
  assert.ok(close([back.diffuse, back.specular], [0.4, 0.1]), "next to nothing keeps the share of highlights");
  for (const share of [0, 0.5, 1, 1.5, 2]) {
    assert.ok(Math.abs(highlights(withHighlights(light, share)) - share) < 1e-9);
  }
  for (const hex of ["#ffffff", "#ffb46b", "#3366ff"]) assert.equal(hexOf(linearOf(hex)), hex);
  for (const kelvin of [2000, 3200, 5600, 9000]) assert.ok(Math.abs(kelvinOf(ofKelvin(kelvin)) - kelvin) <= 100);
  assert.equal(kelvinOf(linearOf("#00ff00")), null);
  const [r, g, b] = ofKelvin(3200);
  assert.ok(Math.abs(0.2126 * r + 0.7152 * g + 0.0722 * b - 1) < 1e-9 && r > g && g > b);
}

export async function aNewLightComesFromWhereNoneIs() {
  const { added } = await load("light");
  const lights = [];
  for (let count = 0; count < 5; count++) lights.push(added(lights));
  assert.equal(lights[0].role, "key");
  const places = new Set(lights.map(({ direction }) => direction.map((x) => x.toFixed(2)).join()));
  assert.equal(places.size, 5);
}
