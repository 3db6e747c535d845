// A static server on a loopback port: this folder's page, three.js, and one pack at a time.

import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import path from 'node:path';

const HERE = import.meta.dirname;
const TYPES = {
  '.glb': 'model/gltf-binary',
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript',
  '.mjs': 'text/javascript',
  '.png': 'image/png',
};

/** Starts the server: `origin`, `setPack(dir)` (what `/pack/` shows), `close()`. */
export async function serve() {
  const roots = { three: path.join(HERE, 'node_modules', 'three'), pack: null };
  const server = createServer(async (request, response) => {
    const name = locate(roots, request.url);
    const body = name === null ? null : await readFile(name).catch(() => null);
    if (request.url === '/favicon.ico') response.writeHead(204).end();
    else if (body === null) response.writeHead(404).end();
    else {
      response.writeHead(200, {
        'Content-Type': TYPES[path.extname(name)] ?? 'application/octet-stream',
        'Content-Length': body.length,
        'Cache-Control': 'no-store',
      });
      response.end(body);
    }
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return {
    origin: `http://127.0.0.1:${server.address().port}`,
    setPack: (dir) => {
      roots.pack = dir;
    },
    close: () => {
      server.closeAllConnections();
      server.close();
    },
  };
}

/** The file behind a request, or null where there is none to show. */
function locate(roots, url) {
  // The URL class resolves `..`, so that no name leaves its root; `%2e%2f` is decoded after it.
  const parts = new URL(url, 'http://loopback').pathname.slice(1).split('/').map(decodeURIComponent);
  if (parts.some((part) => part === '..' || part.includes('/'))) return null;
  if (parts.length === 1 && /^page\.(html|mjs)$/.test(parts[0])) return path.join(HERE, parts[0]);
  const root = roots[parts[0]];
  return root ? path.join(root, ...parts.slice(1)) : null;
}
