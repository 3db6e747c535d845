// Judges packs by their bytes: the Khronos validator on every GLB, and the manifest against the
// files it lists.

import { createHash } from 'node:crypto';
import { readFile, readdir } from 'node:fs/promises';
import path from 'node:path';
import validator from 'gltf-validator';
import { Score, readGlbJson, readPack, requirePacks } from './pack.mjs';

/**
 * The only remarks below a warning that a pack may cause: issue code -> pattern that the JSON
 * pointer or the message must match.
 */
const ALLOWED_INFOS = {
  // Textures are shared by all LODs, so a GLB names them by relative URI.
  URI_GLB: /^\/images\/\d+/,
  // Wind data may ride in texture coordinates that no material reads.
  UNUSED_OBJECT: /^\/meshes\/0\/primitives\/\d+\/attributes\/TEXCOORD_[1-3]$/,
  // The validator does not know this extension; clients without it ignore it.
  UNSUPPORTED_EXTENSION: /KHR_materials_diffuse_transmission/,
};
const SEVERITIES = ['error', 'warning', 'info', 'hint'];
const INFO = 2;

const dirs = process.argv.slice(2);
requirePacks(dirs, 'node validate.mjs PACK_DIR...');
const score = new Score();
for (const dir of dirs) await judgePack(dir);
score.close();

async function judgePack(dir) {
  let pack;
  try {
    pack = await readPack(dir);
  } catch (error) {
    score.judge(dir, [error.message]);
    return;
  }
  const faults = [...judgeLodTable(pack.manifest), ...(await judgeFiles(pack))];
  score.judge(`${pack.name}/pack.json`, faults);
  for (const lod of pack.manifest.lods) {
    const { faults: found, note } = await judgeGlb(pack, lod).catch((error) => ({
      faults: [error.message],
      note: '',
    }));
    score.judge(`${pack.name}/${lod.file}`, found, note);
  }
}

/** The LOD table by itself: order, sums, budgets. */
function judgeLodTable({ lods, warnings = [] }) {
  const faults = [];
  lods.forEach((lod, i) => {
    if (lod.index !== i) faults.push(`lods[${i}].index is ${lod.index}`);
    if (lod.branches_triangles + lod.foliage_triangles !== lod.triangles) {
      faults.push(`lods[${i}]: branches_triangles + foliage_triangles is not triangles`);
    }
    if (lod.triangles > lod.budget && warnings.length === 0) {
      faults.push(`lods[${i}]: ${lod.triangles} triangles over a budget of ${lod.budget}, no warning`);
    }
    if (i > 0 && lod.triangles >= lods[i - 1].triangles) {
      faults.push(`lods[${i}] has no fewer triangles than the LOD before it`);
    }
  });
  return faults;
}

/** Every listed file is there with its size and hash; nothing else is in the folder. */
async function judgeFiles({ dir, manifest }) {
  const listed = manifest.files ?? [];
  const faults = [];
  for (const { path: name, bytes, sha256 } of listed) {
    const content = await readFile(path.join(dir, name)).catch(() => null);
    if (content === null) {
      faults.push(`${name}: listed but missing`);
      continue;
    }
    if (content.length !== bytes) faults.push(`${name}: ${content.length} bytes, not ${bytes}`);
    if (createHash('sha256').update(content).digest('hex') !== sha256) {
      faults.push(`${name}: sha256 differs`);
    }
  }
  const names = new Set(listed.map((file) => file.path));
  if (names.size !== listed.length) faults.push('files: a path is listed twice');
  for (const name of await filesBelow(dir)) {
    if (name !== 'pack.json' && !names.has(name)) faults.push(`${name}: not listed`);
  }
  return faults;
}

async function filesBelow(dir) {
  const entries = await readdir(dir, { recursive: true, withFileTypes: true });
  return entries
    .filter((entry) => !entry.isDirectory())
    .map((entry) => path.relative(dir, path.join(entry.parentPath ?? entry.path, entry.name)))
    .map((name) => name.split(path.sep).join('/'))
    .sort();
}

async function judgeGlb({ dir, manifest }, lod) {
  const bytes = await readFile(path.join(dir, lod.file));
  const report = await validator.validateBytes(new Uint8Array(bytes), {
    uri: lod.file,
    format: 'glb',
    maxIssues: 0,
    externalResourceFunction: async (uri) => {
      const name = decodeURIComponent(uri);
      if (!manifest.files.some((file) => file.path === name)) {
        throw new Error(`${name} is not in the pack's list of files`);
      }
      return new Uint8Array(await readFile(path.join(dir, name)));
    },
  });
  const faults = report.issues.messages.filter((issue) => !isAllowed(issue)).map(describe);
  const triangles = report.info?.totalTriangleCount;
  if (triangles !== lod.triangles) {
    faults.push(`${triangles} triangles, the manifest says ${lod.triangles}`);
  }
  if (report.issues.numErrors === 0) faults.push(...judgeLayout(readGlbJson(bytes)));
  return { faults, note: `${triangles} triangles, ${bytes.length} bytes` };
}

function isAllowed({ code, severity, pointer = '', message }) {
  const pattern = ALLOWED_INFOS[code];
  return severity === INFO && pattern !== undefined && (pattern.test(pointer) || pattern.test(message));
}

function describe({ code, severity, pointer, message }) {
  return `${SEVERITIES[severity]} ${code} ${pointer ?? ''}: ${message}`;
}

/** The layout that packs promise: one mesh of at most two primitives, opaque bark, cut-out foliage. */
function judgeLayout(gltf) {
  const faults = [];
  if (gltf.meshes?.length !== 1) faults.push(`${gltf.meshes?.length ?? 0} meshes, not 1`);
  const primitives = gltf.meshes?.[0]?.primitives ?? [];
  if (primitives.length < 1 || primitives.length > 2) faults.push(`${primitives.length} primitives`);
  const seen = new Set();
  for (const primitive of primitives) {
    const material = gltf.materials?.[primitive.material] ?? {};
    if (seen.has(material.name)) faults.push(`two primitives of material ${material.name}`);
    seen.add(material.name);
    const mode = material.alphaMode ?? 'OPAQUE';
    if (material.name === 'bark') {
      if (mode !== 'OPAQUE') faults.push(`bark is ${mode}, not OPAQUE`);
    } else if (material.name === 'foliage') {
      if (mode !== 'MASK') faults.push(`foliage is ${mode}, not MASK`);
      if (material.doubleSided !== true) faults.push('foliage is not double-sided');
    } else {
      faults.push(`material ${material.name} is neither bark nor foliage`);
    }
  }
  return faults;
}
