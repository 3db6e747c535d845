// Runs in the browser: draws one LOD at a time and measures the picture. The judging is done
// outside, in three.mjs.

import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const SIZE = 512;
const THUMB = 256;
const FIELD_OF_VIEW = 25;
/** Share of the picture's width or height that LOD0's box fills. */
const FILL = 0.92;
/** Azimuths in degrees: off the axes, so that a crossed quad is never seen edge on. */
const SIDES = { front: 25, side: 115 };
/** Two backgrounds tell what is tree: it is where the picture does not change with them. */
const LIGHT = new THREE.Color(0xc9ccd0);
const DARK = new THREE.Color(0x303234);

const view = document.querySelector('#view');
const sheet = document.querySelector('#sheet');
const renderer = new THREE.WebGLRenderer({ canvas: view, antialias: true, preserveDrawingBuffer: true });
renderer.setPixelRatio(1);
renderer.setSize(SIZE, SIZE, false);

const scene = new THREE.Scene();
const sun = new THREE.DirectionalLight(0xfff4e0, 2.6);
scene.add(sun, new THREE.HemisphereLight(0xdfe9f5, 0x6b6250, 1.6));
const camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 10_000);

/** The box of LOD0, which frames every LOD alike. */
let frame = null;
const thumbs = [];

async function lod(url, label) {
  // Fetched here: the loader's own fetch reads the body through a stream, and the browser now and
  // then reports such a request as aborted though every byte of it has arrived.
  const bytes = await (await fetch(url)).arrayBuffer();
  const folder = url.slice(0, url.lastIndexOf('/') + 1);
  const tree = (await new GLTFLoader().parseAsync(bytes, folder)).scene;
  const box = new THREE.Box3().setFromObject(tree, true);
  if (box.isEmpty()) throw new Error('the LOD has no geometry');
  frame ??= box;
  scene.add(tree);
  const meshes = [];
  tree.traverse((node) => node.isMesh && meshes.push(node));
  const views = Object.keys(SIDES).map((side) => measure(side, meshes));
  await keepThumbs(label);
  scene.remove(tree);
  const materials = [...new Set(meshes.map((mesh) => mesh.material))].map((material) => ({
    name: material.name,
    alphaTest: material.alphaTest,
    doubleSided: material.side === THREE.DoubleSide,
    metalness: material.metalness ?? 0,
  }));
  return { views, materials };
}

function measure(side, meshes) {
  look(side);
  const whole = matte();
  const triangles = renderer.info.render.triangles;
  const hidden = meshes.filter((mesh) => mesh.material.name !== 'foliage');
  let foliage = null;
  if (hidden.length < meshes.length) {
    for (const mesh of hidden) mesh.visible = false;
    foliage = matte();
    for (const mesh of hidden) mesh.visible = true;
  }
  draw(LIGHT);
  return { side, triangles, area: whole.area, foliage };
}

/** Puts the camera where LOD0's box fills the frame, seen from `side`, a little from above. */
function look(side) {
  const turn = THREE.MathUtils.degToRad(SIDES[side]);
  const out = new THREE.Vector3(Math.sin(turn), 0.15, Math.cos(turn)).normalize();
  const centre = frame.getCenter(new THREE.Vector3());
  camera.position.copy(centre).add(out);
  camera.lookAt(centre);
  camera.updateMatrixWorld();
  const distance = distanceToFit(centre);
  const radius = frame.getSize(new THREE.Vector3()).length() / 2;
  camera.near = Math.max(distance - 1.5 * radius, 0.01 * distance);
  camera.far = distance + 1.5 * radius;
  camera.position.copy(centre).addScaledVector(out, distance);
  camera.updateProjectionMatrix();
  // The sun stands over the viewer's left shoulder, whichever side is shown.
  sun.position.copy(out).applyAxisAngle(new THREE.Vector3(0, 1, 0), -0.7);
  sun.position.y += 0.8;
}

/** How far from the box's centre the camera must be for the box to keep clear of the border. */
function distanceToFit(centre) {
  const [right, up, out] = [0, 1, 2].map((column) =>
    new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, column),
  );
  const reach = FILL * Math.tan(THREE.MathUtils.degToRad(FIELD_OF_VIEW / 2));
  let distance = 0;
  for (let i = 0; i < 8; i += 1) {
    const pick = (axis, bit) => (i & bit ? frame.max[axis] : frame.min[axis]);
    const corner = new THREE.Vector3(pick('x', 1), pick('y', 2), pick('z', 4)).sub(centre);
    const wide = Math.max(Math.abs(corner.dot(right)), Math.abs(corner.dot(up)));
    distance = Math.max(distance, corner.dot(out) + wide / reach);
  }
  return distance;
}

function draw(background) {
  scene.background = background;
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const pixels = new Uint8Array(SIZE * SIZE * 4);
  gl.readPixels(0, 0, SIZE, SIZE, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return pixels;
}

/** Coverage and colour of what is visible now, from its pictures on two backgrounds. */
function matte() {
  const onLight = draw(LIGHT);
  const onDark = draw(DARK);
  // A corner pixel shows the background alone: the frame leaves a margin around LOD0's box.
  const span = sum(onLight, 0) - sum(onDark, 0);
  let covered = 0;
  let solid = 0;
  let white = 0;
  let black = 0;
  let brightness = 0;
  for (let i = 0; i < onLight.length; i += 4) {
    const coverage = 1 - (sum(onLight, i) - sum(onDark, i)) / span;
    covered += coverage;
    if (coverage < 0.99) continue;
    solid += 1;
    const [r, g, b] = onLight.subarray(i, i + 3);
    if (Math.min(r, g, b) >= 250) white += 1;
    if (Math.max(r, g, b) <= 5) black += 1;
    brightness += (r + g + b) / 3;
  }
  const share = (count) => (solid > 0 ? count / solid : 0);
  return {
    area: covered / (SIZE * SIZE),
    white: share(white),
    black: share(black),
    brightness: solid > 0 ? brightness / solid : null,
  };
}

const sum = (pixels, i) => pixels[i] + pixels[i + 1] + pixels[i + 2];

/** Leaves the first side on show for the screenshot and adds a column to the contact sheet. */
async function keepThumbs(label) {
  const column = { label, pictures: [] };
  for (const side of Object.keys(SIDES).reverse()) {
    look(side);
    draw(LIGHT);
    column.pictures.unshift(await createImageBitmap(view));
  }
  thumbs.push(column);
  paintSheet();
}

function paintSheet() {
  sheet.width = THUMB * thumbs.length;
  sheet.height = THUMB * Object.keys(SIDES).length;
  const pen = sheet.getContext('2d');
  pen.font = '12px sans-serif';
  thumbs.forEach(({ label, pictures }, x) => {
    pictures.forEach((picture, y) => pen.drawImage(picture, x * THUMB, y * THUMB, THUMB, THUMB));
    pen.fillText(label, x * THUMB + 8, 16);
  });
}

window.judge = { lod };
