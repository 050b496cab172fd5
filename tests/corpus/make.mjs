// Makes the corpus of a scene: the same scene as the usual tools would write it.
// node make.mjs FOLDER SCENE.glb...   writes FOLDER/SCENE-VARIANT.glb
import { NodeIO } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import { draco, instance, meshopt, quantize, textureCompress } from '@gltf-transform/functions';
import draco3d from 'draco3dgltf';
import { ktx2 } from 'ktx2-encoder/gltf-transform';
import { MeshoptDecoder, MeshoptEncoder } from 'meshoptimizer';
import { execFileSync } from 'node:child_process';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import sharp from 'sharp';

const programs = join(dirname(fileURLToPath(import.meta.url)), 'node_modules', '.bin');
const [folder, ...scenes] = process.argv.slice(2);
await Promise.all([MeshoptDecoder.ready, MeshoptEncoder.ready]);
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
  'draco3d.decoder': await draco3d.createDecoderModule(),
  'draco3d.encoder': await draco3d.createEncoderModule(),
  'meshopt.decoder': MeshoptDecoder,
  'meshopt.encoder': MeshoptEncoder,
});

// KTX2 with the whole mip chain, as its tools write it.
const basis = (isUASTC) => {
  const imageDecoder = async (buffer) => {
    const decoded = sharp(buffer).ensureAlpha().raw();
    const { data, info } = await decoded.toBuffer({ resolveWithObject: true });
    return { data: new Uint8Array(data), width: info.width, height: info.height };
  };
  const options = { isUASTC, needSupercompression: isUASTC, generateMipmap: true, qualityLevel: 255 };
  return ktx2({ ...options, imageDecoder });
};
const transforms = {
  quantized: [quantize({ quantizePosition: 16, quantizeNormal: 12, quantizeTexcoord: 14 })],
  meshopt: [meshopt({ encoder: MeshoptEncoder, level: 'medium' })],
  filtered: [meshopt({ encoder: MeshoptEncoder, level: 'high' })],
  draco: [draco({ quantizePosition: 16, quantizeNormal: 12, quantizeTexcoord: 14 })],
  sequential: [draco({ method: 'sequential', quantizePosition: 16, quantizeNormal: 12 })],
  instanced: [instance({ min: 2 })],
  webp: [textureCompress({ encoder: sharp, targetFormat: 'webp', lossless: true })],
  etc1s: [basis(false)],
  uastc: [basis(true)],
};
const commands = {
  optimized: ['gltf-transform', (source, out) => ['optimize', source, out]],
  'optimized-draco': [
    'gltf-transform',
    (source, out) => ['optimize', source, out, '--compress', 'draco', '--texture-compress', 'webp'],
  ],
  packed: ['gltfpack', (source, out) => ['-i', source, '-o', out, '-cc', '-ce', 'ext']],
  'packed-khr': ['gltfpack', (source, out) => ['-i', source, '-o', out, '-cc', '-ce', 'khr', '-mi']],
};

for (const scene of scenes) {
  const out = (variant) => join(folder, `${basename(scene, '.glb')}-${variant}.glb`);
  for (const [variant, steps] of Object.entries(transforms)) {
    const document = await io.read(scene);
    await document.transform(...steps);
    await io.write(out(variant), document);
  }
  for (const [variant, [program, options]] of Object.entries(commands)) {
    execFileSync(join(programs, program), options(scene, out(variant)), { stdio: 'pipe' });
  }
}
