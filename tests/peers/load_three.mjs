// node load_three.mjs FILE.glb: loads a file with three.js' GLTFLoader, without a browser. Prints what came out of it as
// JSON; exit code 1 when the loader refuses. Pictures are counted, not decoded: node has no decoder for them.
import fs from 'node:fs';

globalThis.self = globalThis;
globalThis.ProgressEvent ??= class ProgressEvent extends Event {};
globalThis.createImageBitmap = async (blob) => ({ width: 1, height: 1, size: blob.size, close() {} });

const { GLTFLoader } = await import('three/examples/jsm/loaders/GLTFLoader.js');
const { MeshoptDecoder } = await import('three/examples/jsm/libs/meshopt_decoder.module.js');

const bytes = fs.readFileSync(process.argv[2]);
const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
const loader = new GLTFLoader();
loader.setMeshoptDecoder(MeshoptDecoder);
const messages = [];
console.warn = console.error = (...words) => messages.push(words.join(' '));
try {
  const gltf = await loader.parseAsync(buffer, '');
  const counts = { objects: 0, meshes: 0, instanced: 0, triangles: 0, lightmapped: 0, lines: 0 };
  gltf.scene.traverse((object) => {
    counts.objects += 1;
    if (object.isLine) counts.lines += 1;
    if (!object.isMesh) return;
    counts.meshes += 1;
    if (object.isInstancedMesh) counts.instanced += object.count;
    const geometry = object.geometry;
    const corners = geometry.index ? geometry.index.count : geometry.attributes.position.count;
    counts.triangles += Math.floor(corners / 3) * (object.isInstancedMesh ? object.count : 1);
    if (geometry.attributes.uv1) counts.lightmapped += 1;
  });
  console.log(JSON.stringify({ ...counts, animations: gltf.animations.length, messages }));
} catch (error) {
  console.log(JSON.stringify({ error: String(error), messages }));
  process.exitCode = 1;
}
