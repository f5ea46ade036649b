// SPDX-License-Identifier: GPL-3.0-or-later
//
// Builds the page: node build.mjs SOURCES WORK OUT ROOT PROTOC NPM. Packages, generated code and bundles lie in WORK and
// OUT alone. Where the packages cannot be had, it says so in a sentence and leaves no page: the programs do not need it.
import {execFileSync} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import {pathToFileURL} from 'node:url';
import zlib from 'node:zlib';

const [sources, work, out, root, protoc, npm] = process.argv.slice(2);
const inWork = (...names) => path.join(work, ...names);
const run = (program, words) => execFileSync(program, words, {cwd: work, stdio: ['ignore', 'pipe', 'pipe']});
/// A program of the packages.
const tool = (name) => inWork('node_modules', ...name.split('/'));

function installPackages() {
    const lock = fs.readFileSync(path.join(sources, 'package-lock.json'), 'utf8');
    const stamp = inWork('node_modules', '.lock');
    if (fs.existsSync(stamp) && fs.readFileSync(stamp, 'utf8') === lock) return;
    for (const name of ['package.json', 'package-lock.json']) fs.copyFileSync(path.join(sources, name), inWork(name));
    run(npm, ['ci', '--ignore-scripts', '--no-audit', '--no-fund', '--loglevel=error']);
    fs.writeFileSync(stamp, lock);
}

/// The names of the colour maps, and twelve colours of each.
function colorMaps() {
    const text = fs.readFileSync(path.join(root, 'protocol/scene/color_map_tables.h'), 'utf8');
    const names = [...text.match(/colorMapNames\{([^}]*)\}/)[1].matchAll(/"(\w+)"/g)].map((found) => found[1]);
    const maps = names.map((name) => {
        const bytes = text.match(new RegExp(`${name}Table\\{([^}]*)\\}`))[1].match(/\d+/g).map(Number);
        const last = bytes.length / 3 - 1;
        const colors = Array.from({length: 12}, (_, i) => {
            const at = 3 * Math.round(last * i / 11);
            return '#' + bytes.slice(at, at + 3).map((byte) => byte.toString(16).padStart(2, '0')).join('');
        });
        return [name, colors];
    });
    return `export const colorMaps: Record<string, string[]> = ${JSON.stringify(Object.fromEntries(maps))};\n`;
}

/// What the viewer's first picture says beside what it shows, as a value of the page's.
function annotations() {
    const text = fs.readFileSync(path.join(root, 'protocol/scene/film/sized_script.h'), 'utf8');
    const names = [...text.match(/usualAnnotations\{([^}]*)\}/)[1].matchAll(/"(\w+)"/g)].map((found) =>
        found[1].replace(/_(.)/g, (_, letter) => letter.toUpperCase()));
    return `export const usualAnnotations = {${names.map((name) => `${name}: true`).join(', ')}};\n`;
}

function generate() {
    fs.rmSync(inWork('src'), {recursive: true, force: true});
    fs.cpSync(path.join(sources, 'src'), inWork('src'), {recursive: true});
    fs.copyFileSync(path.join(sources, 'tsconfig.json'), inWork('tsconfig.json'));
    const generated = inWork('src', 'generated');
    fs.mkdirSync(generated);
    run(protoc, [`--plugin=protoc-gen-es=${tool('.bin/protoc-gen-es')}`, `--es_out=${generated}`, '--es_opt=target=ts',
                 '-I', root, 'protocol/options.proto', 'protocol/mote.proto']);
    fs.writeFileSync(path.join(generated, 'color_maps.ts'), colorMaps());
    fs.writeFileSync(path.join(generated, 'annotations.ts'), annotations());
}

async function bundle() {
    const esbuild = await import(pathToFileURL(tool('esbuild/lib/main.js')));
    fs.rmSync(out, {recursive: true, force: true});
    fs.mkdirSync(out, {recursive: true});
    await esbuild.build({
        entryPoints: [inWork('src/page.ts'), inWork('src/worker.ts')],
        bundle: true, minify: true, splitting: true, format: 'esm', target: ['chrome109', 'firefox115', 'safari16.4'],
        outdir: out, chunkNames: 'shared-[hash]', logLevel: 'warning', legalComments: 'none',
    });
    for (const name of ['index.html', 'icon.svg']) fs.copyFileSync(path.join(sources, name), path.join(out, name));
    const style = fs.readFileSync(path.join(sources, 'style.css'), 'utf8');
    fs.writeFileSync(path.join(out, 'style.css'), (await esbuild.transform(style, {loader: 'css', minify: true})).code);
    // The decoder itself, as a file of its own: a page of strict policy takes no data from a URL.
    const zstd = fs.readFileSync(tool('zstddec/dist/zstddec.mjs'), 'utf8').match(/const wasm = "([^"]+)"/);
    fs.writeFileSync(path.join(out, 'zstd.wasm'), Buffer.from(zstd[1], 'base64'));
}

/// Both codings beside each file; returns the bytes of the smaller one.
function compress() {
    let total = 0;
    for (const name of fs.readdirSync(out)) {
        const file = path.join(out, name);
        const bytes = fs.readFileSync(file);
        const packed = zlib.brotliCompressSync(bytes, {params: {[zlib.constants.BROTLI_PARAM_QUALITY]: 11}});
        fs.writeFileSync(file + '.br', packed);
        fs.writeFileSync(file + '.gz', zlib.gzipSync(bytes, {level: 9}));
        total += packed.length;
    }
    return total;
}

fs.mkdirSync(work, {recursive: true});
try {
    installPackages();
} catch (error) {
    const why = String(error.stderr || error.message).trim().split('\n')[0];
    console.log(`The page of mote-web is not built: its packages cannot be installed (${why})`);
    fs.rmSync(out, {recursive: true, force: true});
    process.exit(0);
}
try {
    generate();
    run(process.execPath, [tool('typescript/bin/tsc'), '-p', '.']);
    await bundle();
    fs.writeFileSync(inWork('made'), `${compress()} bytes compressed\n`);
} catch (error) {
    console.error(String(error.stdout || ''), String(error.stderr || error.stack));
    process.exit(1);
}
