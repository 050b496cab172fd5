// A smooth metal ball, on which a light shows by its highlight alone.
import { writeFile } from "node:fs/promises";
import { join } from "node:path";

const [SLICES, STACKS] = [128, 96];

function sphere() {
  const [positions, indices] = [[], []];
  for (let stack = 0; stack <= STACKS; stack++) {
    for (let slice = 0; slice <= SLICES; slice++) {
      const [polar, turn] = [(Math.PI * stack) / STACKS, (2 * Math.PI * slice) / SLICES];
      positions.push(Math.sin(polar) * Math.sin(turn), Math.cos(polar), Math.sin(polar) * Math.cos(turn));
    }
  }
  for (let stack = 0; stack < STACKS; stack++) {
    for (let slice = 0; slice < SLICES; slice++) {
      const a = stack * (SLICES + 1) + slice;
      const b = a + SLICES + 1;
      indices.push(a, b, a + 1, a + 1, b, b + 1);
    }
  }
  return { positions: Float32Array.from(positions), indices: Uint32Array.from(indices) };
}

/** Writes the ball into a folder and gives its path. */
export async function writeBall(folder) {
  const { positions, indices } = sphere();
  const bytes = Buffer.concat([Buffer.from(positions.buffer), Buffer.from(indices.buffer)]);
  const count = positions.length / 3;
  const gltf = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ name: "ball", mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 0 }, indices: 1, material: 0 }] }],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: [0.5, 0.5, 0.5, 1], metallicFactor: 1, roughnessFactor: 0.4 } }],
    accessors: [
      { bufferView: 0, componentType: 5126, count, type: "VEC3", min: [-1, -1, -1], max: [1, 1, 1] },
      { bufferView: 1, componentType: 5125, count: indices.length, type: "SCALAR" },
    ],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: positions.byteLength },
      { buffer: 0, byteOffset: positions.byteLength, byteLength: indices.byteLength },
    ],
    buffers: [{ byteLength: bytes.length, uri: `data:application/octet-stream;base64,${bytes.toString("base64")}` }],
  };
  const path = join(folder, "ball.gltf");
  await writeFile(path, JSON.stringify(gltf));
  return path;
}
