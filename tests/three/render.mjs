// Draws the first camera's view of a GLB with three.js in headless Chromium, on its software GL, and
// prints PNG pictures, transparent in the background, as base64 in JSON: node render.mjs CHROMIUM FILE
// WIDTHxHEIGHT. `shipped` is what three.js draws by default; for `specification`, what it adds to the
// BRDF of the glTF specification is taken out of its shaders.
import { readFile } from "node:fs/promises";
import puppeteer from "puppeteer-core";

const [executablePath, file, size] = process.argv.slice(2);
const [width, height] = size.split("x").map(Number);
// The address of the page and its modules, which are answered from this folder.
const ORIGIN = "http://three.invalid";
const html = `<!doctype html><link rel="icon" href="data:,"><script type="importmap">{ "imports": {
  "three": "/node_modules/three/build/three.module.js",
  "three/addons/": "/node_modules/three/examples/jsm/" } }</script>`;
const args = [
  "--no-sandbox",
  "--disable-dev-shm-usage",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--host-resolver-rules=MAP * ~NOTFOUND",
];
const timeout = 60_000;

async function answer(request) {
  const { origin, pathname } = new URL(request.url());
  if (origin !== ORIGIN || request.url().startsWith("blob:")) return request.continue();
  if (pathname === "/") return request.respond({ contentType: "text/html", body: html });
  const body = await readFile(new URL("." + pathname, import.meta.url)).catch(() => undefined);
  return request.respond(body ? { contentType: "text/javascript", body } : { status: 404 });
}

// Runs in the page.
async function draw(glb, width, height) {
  const THREE = await import("three");
  const { GLTFLoader } = await import("three/addons/loaders/GLTFLoader.js");
  const bytes = Uint8Array.from(atob(glb), (character) => character.charCodeAt(0));
  const gltf = await new GLTFLoader().parseAsync(bytes.buffer, "");
  const picture = () => {
    const renderer = new THREE.WebGLRenderer({ alpha: true, preserveDrawingBuffer: true });
    renderer.setSize(width, height);
    renderer.render(gltf.scene, gltf.cameras[0]);
    return renderer.domElement.toDataURL("image/png").split(",")[1];
  };
  const takeOut = (chunk, code) => {
    const text = THREE.ShaderChunk[chunk];
    if (!text.includes(code)) throw new Error(`${chunk} has no '${code}'`);
    THREE.ShaderChunk[chunk] = text.replace(code, "");
  };
  const shipped = picture();
  // Energy of several reflections between the microfacets (Turquin, 2019).
  takeOut("lights_physical_pars_fragment", " * material.multiScatteringCompensation");
  // Roughness where the normals turn within a pixel, against aliasing.
  takeOut("lights_physical_fragment", "material.roughness += geometryRoughness;");
  return { shipped, specification: picture() };
}

const browser = await puppeteer.launch({ executablePath, args, timeout, protocolTimeout: timeout });
try {
  const page = await browser.newPage();
  const errors = [];
  page.on("console", (message) => {
    if (message.type() === "error") errors.push(message.text());
  });
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.setRequestInterception(true);
  page.on("request", (request) => answer(request).catch((error) => errors.push(String(error))));
  await page.goto(ORIGIN, { timeout });
  const pictures = await page.evaluate(draw, (await readFile(file)).toString("base64"), width, height);
  if (errors.length) throw new Error(errors.join("\n"));
  console.log(JSON.stringify(pictures));
} finally {
  await browser.close();
}
