// Writes a small pack with a made-up tree, whole or with one named fault, so that the judges can be
// judged. Not a tree worth looking at for long: a trunk, limbs, leaf cards, and a crossed quad.

import { createHash } from 'node:crypto';
import { mkdir, readFile, rm, truncate, writeFile } from 'node:fs/promises';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { crc32, deflateSync } from 'node:zlib';

const SLUG = 'sample';
const HEIGHT = 6.4;
const HALF_WIDTH = 2.6;
const CROWN = { centre: [0, 4.1, 0], radii: [2.1, 1.9, 2.1] };
const TILE = 256;

/** Faults that `writeSample` can plant, each to be found by at least one judge. */
export const FAULTS = {
  truncated: 'LOD1 ends in the middle of its geometry',
  'wrong-bounds': 'the maximum of LOD0 positions is too small',
  'wrong-count': 'the manifest says one triangle too many for LOD0',
  'missing-texture': 'the foliage texture is not in the pack',
  unlisted: 'a file that no list names',
  'wrong-hash': 'one byte of a texture differs from the manifest',
  opaque: 'foliage without its alpha cut-out',
  'single-sided': 'foliage drawn from one side only',
  shrunk: 'LOD1 is a third of the size of LOD0',
  black: 'the foliage texture is black',
  white: 'the foliage texture is white',
  empty: 'the foliage texture is transparent everywhere',
};

/** Writes the pack into `parent/sample-<seed>` and returns that folder. */
export async function writeSample(parent, { seed = 1, fault = null, embed = false } = {}) {
  if (fault !== null && !(fault in FAULTS)) throw new Error(`unknown fault ${fault}`);
  const dir = path.join(parent, `${SLUG}-${seed}`);
  await rm(dir, { recursive: true, force: true });
  await mkdir(path.join(dir, 'textures'), { recursive: true });

  const tree = growTree(seed);
  const textures = paintTextures(tree, fault);
  const lods = [lodOfTree(tree, 1), lodOfTree(tree, 4), lodOfQuads()];
  if (fault === 'shrunk') for (const part of Object.values(lods[1])) scalePositions(part, 1 / 3);

  const files = [];
  const add = async (name, bytes) => {
    files.push({ path: name, bytes: bytes.length, sha256: sha256(bytes) });
    await writeFile(path.join(dir, name), bytes);
  };
  const table = [];
  for (const [index, parts] of lods.entries()) {
    const file = `${SLUG}_LOD${index}.glb`;
    await add(file, encodeGlb(parts, embed ? textures : null, index === 0 ? fault : null));
    const count = (part) => (part ? part.indices.length / 3 : 0);
    const [branches, foliage] = [count(parts.bark), count(parts.foliage)];
    const extra = fault === 'wrong-count' && index === 0 ? 1 : 0;
    table.push({
      index,
      file,
      budget: [1000, 300, 4][index],
      triangles: branches + foliage + extra,
      branches_triangles: branches + extra,
      foliage_triangles: foliage,
    });
  }
  for (const [name, bytes] of Object.entries(textures)) {
    if (fault === 'missing-texture' && name.includes('foliage.')) continue;
    if (!embed) await add(name, bytes);
  }
  await add('preview.png', textures['textures/foliage.png']);
  await plantInFiles(dir, fault, files);
  const manifest = {
    format: 'pleach-pack',
    version: 1,
    species: { name: 'Sample', latin: 'Arbor exempli', slug: SLUG },
    seed,
    units: 'm',
    up: '+Y',
    bounds: { min: [-HALF_WIDTH, 0, -HALF_WIDTH], max: [HALF_WIDTH, HEIGHT, HALF_WIDTH] },
    lods: table,
    files,
    warnings: [],
  };
  await writeFile(path.join(dir, 'pack.json'), `${JSON.stringify(manifest, null, 2)}\n`);
  return dir;
}

async function plantInFiles(dir, fault, files) {
  if (fault === 'truncated') {
    const name = `${SLUG}_LOD1.glb`;
    const entry = files.find((file) => file.path === name);
    await truncate(path.join(dir, name), Math.floor(entry.bytes * 0.7));
    const rest = await readFile(path.join(dir, name));
    Object.assign(entry, { bytes: rest.length, sha256: sha256(rest) });
  } else if (fault === 'unlisted') {
    await writeFile(path.join(dir, 'textures', 'left-over.png'), 'x');
  } else if (fault === 'wrong-hash') {
    const entry = files.find((file) => file.path === 'textures/bark.png');
    entry.sha256 = sha256(Buffer.from('something else'));
  }
}

const sha256 = (bytes) => createHash('sha256').update(bytes).digest('hex');

// --- the tree: limbs as segments, leaf cards as centre, two half axes and a shade ---

function growTree(seed) {
  const random = randomStream(seed);
  const limbs = Array.from({ length: 9 }, (_, i) => {
    const turn = i * 2.4;
    const y = 1.9 + i * 0.36;
    const reach = 1.7 - i * 0.12;
    return { from: [0, y, 0], to: [Math.cos(turn) * reach, y + 1, Math.sin(turn) * reach] };
  });
  const cards = Array.from({ length: 320 }, () => {
    const out = randomUnit(random);
    const depth = 0.55 + 0.45 * Math.sqrt(random());
    const centre = CROWN.centre.map((c, k) => c + out[k] * CROWN.radii[k] * depth);
    const normal = normalise(out.map((v, k) => v + 0.9 * randomUnit(random)[k]));
    const right = normalise(cross([0, 1, 0], normal));
    return { centre, normal, right, up: cross(normal, right), half: 0.33, shade: 0.75 + 0.5 * random() };
  });
  return { limbs, cards };
}

/** The tree with every `stride`-th card, each grown so that the crown stays as dense. */
function lodOfTree({ limbs, cards }, stride) {
  const bark = newPart();
  const sides = stride === 1 ? 8 : 4;
  const rings = stride === 1 ? 6 : 2;
  for (let i = 0; i < rings; i += 1) {
    const at = (t) => [0, 5 * t, 0];
    const radius = (t) => 0.24 * (1 - t) + 0.05;
    const [a, b] = [i / rings, (i + 1) / rings];
    addTube(bark, at(a), at(b), radius(a), radius(b), sides);
  }
  for (const { from, to } of limbs.filter((_, i) => i % stride === 0)) {
    addTube(bark, from, to, 0.07, 0.02, 4);
  }
  const foliage = newPart();
  const grown = Math.sqrt(stride) * 0.9 + 0.1;
  for (const card of cards.filter((_, i) => i % stride === 0)) {
    addCard(foliage, { ...card, half: card.half * grown }, [0, 0, 0.5, 1]);
  }
  return { bark, foliage };
}

/** Two crossed quads that show the painted tree: the last LOD. */
function lodOfQuads() {
  const foliage = newPart();
  const centre = [0, HEIGHT / 2, 0];
  for (const [normal, right] of [[[0, 0, 1], [1, 0, 0]], [[1, 0, 0], [0, 0, -1]]]) {
    const stretch = HALF_WIDTH / (HEIGHT / 2);
    const card = { centre, normal, right: right.map((v) => v * stretch), up: [0, 1, 0] };
    addCard(foliage, { ...card, half: HEIGHT / 2 }, [0.5, 0, 1, 1]);
  }
  return { foliage };
}

const newPart = () => ({ positions: [], normals: [], tangents: [], uvs: [], indices: [] });

function addVertex(part, position, normal, tangent, uv) {
  part.positions.push(...position);
  part.normals.push(...normal);
  part.tangents.push(...tangent, 1);
  part.uvs.push(...uv);
  return part.positions.length / 3 - 1;
}

function addTube(part, from, to, radiusFrom, radiusTo, sides) {
  const along = normalise(to.map((v, k) => v - from[k]));
  const right = normalise(cross(along, Math.abs(along[1]) > 0.9 ? [0, 0, 1] : [0, 1, 0]));
  const front = cross(right, along);
  const first = part.positions.length / 3;
  for (let i = 0; i <= sides; i += 1) {
    const turn = (i / sides) * 2 * Math.PI;
    const mix = (a, b) => right.map((v, k) => v * a + front[k] * b);
    const normal = mix(Math.cos(turn), Math.sin(turn));
    const tangent = mix(-Math.sin(turn), Math.cos(turn));
    const at = (centre, radius) => centre.map((v, k) => v + normal[k] * radius);
    addVertex(part, at(from, radiusFrom), normal, tangent, [i / sides, 1]);
    addVertex(part, at(to, radiusTo), normal, tangent, [i / sides, 0]);
  }
  for (let i = 0; i < sides; i += 1) {
    const a = first + 2 * i;
    part.indices.push(a, a + 2, a + 1, a + 1, a + 2, a + 3);
  }
}

function addCard(part, { centre, normal, right, up, half }, [u0, v0, u1, v1]) {
  const corner = (x, y) => centre.map((v, k) => v + half * (right[k] * x + up[k] * y));
  const tangent = normalise(right);
  const a = addVertex(part, corner(-1, -1), normal, tangent, [u0, v1]);
  addVertex(part, corner(1, -1), normal, tangent, [u1, v1]);
  addVertex(part, corner(1, 1), normal, tangent, [u1, v0]);
  addVertex(part, corner(-1, 1), normal, tangent, [u0, v0]);
  part.indices.push(a, a + 1, a + 2, a, a + 2, a + 3);
}

function scalePositions(part, factor) {
  part.positions = part.positions.map((v) => v * factor);
}

// --- textures: one bark tile; a foliage atlas of a leaf spray (left) and the whole tree (right) ---

function paintTextures(tree, fault) {
  const bark = newImage(64, 64, [92, 74, 58, 255]);
  for (let i = 0; i < bark.data.length; i += 4) {
    const x = (i / 4) % 64;
    const ridge = 12 * Math.sin((x / 64) * 16 * Math.PI);
    for (let k = 0; k < 3; k += 1) bark.data[i + k] += ridge;
  }
  const foliage = newImage(2 * TILE, TILE, [74, 106, 42, 0]);
  paintSpray(foliage);
  paintTree(foliage, tree);
  for (let i = 0; i < foliage.data.length; i += 4) {
    if (fault === 'black') foliage.data.fill(0, i, i + 3);
    if (fault === 'white') foliage.data.fill(255, i, i + 3);
    if (fault === 'empty') foliage.data[i + 3] = 0;
  }
  return {
    'textures/bark.png': encodePng(bark),
    'textures/foliage.png': encodePng(foliage),
    'textures/foliage_normal.png': encodePng(newImage(8, 8, [128, 128, 255, 255])),
  };
}

function paintSpray(image) {
  for (let i = 0; i < 11; i += 1) {
    const side = i % 2 === 0 ? 1 : -1;
    const y = 225 - i * 17;
    const shade = 0.85 + 0.03 * i;
    paintLeaf(image, 128 + side * 44, y - 14, side * 0.5, 46, 17, [78, 116, 44], shade);
  }
  paintLeaf(image, 128, 34, 1.57, 30, 14, [78, 116, 44], 1.15);
}

/** The tree as seen along -Z, leaf by leaf, back to front. */
function paintTree(image, { limbs, cards }) {
  const toPixel = ([x, y]) => [
    TILE + ((x + HALF_WIDTH) / (2 * HALF_WIDTH)) * TILE,
    (1 - y / HEIGHT) * TILE,
  ];
  const brown = [92, 74, 58];
  for (let y = 0; y < 5; y += 0.02) {
    const [px, py] = toPixel([0, y]);
    const wide = ((0.24 * (1 - y / 5) + 0.05) / (2 * HALF_WIDTH)) * TILE;
    paintLeaf(image, px, py, 0, wide, 2, brown, 1);
  }
  for (const { from, to } of limbs) {
    for (let t = 0; t < 1; t += 0.02) {
      const [px, py] = toPixel(from.map((v, k) => v + t * (to[k] - v)));
      paintLeaf(image, px, py, 0, 2.5, 2.5, brown, 0.9);
    }
  }
  for (const card of [...cards].sort((a, b) => a.centre[2] - b.centre[2])) {
    const [px, py] = toPixel(card.centre);
    for (let i = 0; i < 5; i += 1) {
      const turn = card.shade * 40 + i * 2.4;
      const [x, y] = [px + 9 * Math.cos(turn), py + 9 * Math.sin(turn)];
      paintLeaf(image, x, y, turn, 7, 3, [78, 116, 44], card.shade);
    }
  }
}

function paintLeaf(image, cx, cy, turn, long, wide, colour, shade) {
  const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
  const reach = Math.ceil(Math.max(long, wide));
  for (let y = Math.floor(cy - reach); y <= cy + reach; y += 1) {
    for (let x = Math.floor(cx - reach); x <= cx + reach; x += 1) {
      const along = ((x - cx) * cos + (y - cy) * sin) / long;
      const across = (-(x - cx) * sin + (y - cy) * cos) / wide;
      if (along ** 2 + across ** 2 > 1) continue;
      setPixel(image, x, y, colour.map((c) => c * shade * (1 - 0.15 * Math.abs(across))));
    }
  }
}

function newImage(width, height, colour) {
  const data = new Uint8ClampedArray(width * height * 4);
  for (let i = 0; i < data.length; i += 1) data[i] = colour[i % 4];
  return { width, height, data };
}

/** Sets an opaque pixel inside the image, but for its outermost texel, which stays clear. */
function setPixel({ width, height, data }, x, y, colour) {
  if (x < 1 || y < 1 || x > width - 2 || y > height - 2) return;
  data.set([...colour, 255], (y * width + x) * 4);
}

// --- file formats ---

function encodePng({ width, height, data }) {
  const rows = Buffer.alloc(height * (1 + width * 4));
  for (let y = 0; y < height; y += 1) {
    rows.set(data.subarray(y * width * 4, (y + 1) * width * 4), y * (1 + width * 4) + 1);
  }
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 6, 0, 0, 0], 8);
  const chunk = (type, body) => {
    const out = Buffer.alloc(body.length + 12);
    out.writeUInt32BE(body.length, 0);
    out.write(type, 4, 'latin1');
    out.set(body, 8);
    out.writeUInt32BE(crc32(out.subarray(4, 8 + body.length)), 8 + body.length);
    return out;
  };
  const magic = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  const body = deflateSync(rows);
  return Buffer.concat([magic, chunk('IHDR', header), chunk('IDAT', body), chunk('IEND', Buffer.alloc(0))]);
}

function encodeGlb(parts, embedded, fault) {
  const chunks = [];
  let length = 0;
  const bufferViews = [];
  const accessors = [];
  const addView = (bytes, target) => {
    const padded = Buffer.concat([bytes, Buffer.alloc(-bytes.length & 3)]);
    bufferViews.push({ buffer: 0, byteOffset: length, byteLength: bytes.length, ...target });
    chunks.push(padded);
    length += padded.length;
    return bufferViews.length - 1;
  };
  const addAccessor = (array, type, width, target, extra = {}) => {
    const bufferView = addView(Buffer.from(array.buffer), { target });
    const componentType = array instanceof Float32Array ? 5126 : 5125;
    accessors.push({ bufferView, componentType, count: array.length / width, type, ...extra });
    return accessors.length - 1;
  };
  const names = Object.keys(parts);
  const primitives = names.map((name, material) => {
    const part = parts[name];
    const positions = new Float32Array(part.positions);
    const floats = (values, type, width) => addAccessor(new Float32Array(values), type, width, 34962);
    return {
      attributes: {
        POSITION: addAccessor(positions, 'VEC3', 3, 34962, extent(positions, fault)),
        NORMAL: floats(part.normals, 'VEC3', 3),
        // Tangents go with a normal map; without one the validator calls them unused.
        ...(name === 'foliage' && { TANGENT: floats(part.tangents, 'VEC4', 4) }),
        TEXCOORD_0: floats(part.uvs, 'VEC2', 2),
      },
      indices: addAccessor(new Uint32Array(part.indices), 'SCALAR', 1, 34963),
      material,
    };
  });
  const wanted = { bark: ['bark'], foliage: ['foliage', 'foliage_normal'] };
  const imageNames = names.flatMap((name) => wanted[name]).map((name) => `textures/${name}.png`);
  const images = imageNames.map((uri) =>
    embedded ? { bufferView: addView(embedded[uri], {}), mimeType: 'image/png' } : { uri },
  );
  const texture = (name) => ({ index: imageNames.indexOf(`textures/${name}.png`) });
  const materials = names.map((name) => ({
    name,
    pbrMetallicRoughness: { baseColorTexture: texture(name), metallicFactor: 0, roughnessFactor: 0.9 },
    ...(name === 'foliage' && {
      normalTexture: texture('foliage_normal'),
      doubleSided: fault !== 'single-sided',
      ...(fault !== 'opaque' && { alphaMode: 'MASK', alphaCutoff: 0.5 }),
    }),
  }));
  return wrapGlb({
    asset: { version: '2.0', generator: 'pleach tests/clients' },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, name: SLUG }],
    meshes: [{ name: SLUG, primitives }],
    materials,
    textures: images.map((_, source) => ({ sampler: 0, source })),
    samplers: [{ magFilter: 9729, minFilter: 9987 }],
    images,
    accessors,
    bufferViews,
    buffers: [{ byteLength: length }],
  }, Buffer.concat(chunks));
}

function extent(positions, fault) {
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  positions.forEach((value, i) => {
    min[i % 3] = Math.min(min[i % 3], value);
    max[i % 3] = Math.max(max[i % 3], value);
  });
  if (fault === 'wrong-bounds') max[1] = Math.fround(max[1] * 0.9);
  return { min, max };
}

function wrapGlb(json, binary) {
  const text = Buffer.from(JSON.stringify(json));
  const padded = Buffer.concat([text, Buffer.alloc(-text.length & 3, ' ')]);
  const word = (...values) => Buffer.from(new Uint32Array(values).buffer);
  return Buffer.concat([
    word(0x46546c67, 2, 12 + 8 + padded.length + 8 + binary.length),
    word(padded.length, 0x4e4f534a), padded,
    word(binary.length, 0x004e4942), binary,
  ]);
}

// --- numbers ---

function randomStream(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

function randomUnit(random) {
  const y = 2 * random() - 1;
  const turn = 2 * Math.PI * random();
  const wide = Math.sqrt(1 - y * y);
  return [Math.cos(turn) * wide, y, Math.sin(turn) * wide];
}

const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

function normalise(v) {
  const length = Math.hypot(...v) || 1;
  return v.map((x) => x / length);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [parent, fault = null] = process.argv.slice(2);
  if (!parent) {
    console.error(`usage: node sample.mjs DIR [FAULT]\nfaults: ${Object.keys(FAULTS).join(' ')}`);
    process.exit(2);
  }
  console.log(await writeSample(parent, { fault }));
}
