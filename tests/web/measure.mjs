// SPDX-License-Identifier: GPL-3.0-or-later
//
// Prints what docs/WEB.md says of the page's speed; no test. DATASET is ROOT/NAME below DATA.
//   node measure.mjs BIN PACKAGES DATA DATASET [SECONDS]
// DATA holds another dataset as well: an only one opens by itself, before it is asked for.
import {exact, later, launch, start, thinLine, tidy} from './browser.mjs';

const [data, dataset, seconds = '8'] = process.argv.slice(4);
const [link, , lines] = await start('ready ', 'mote-web', '--spawn', `data=${data}`);
const browser = await launch('--disable-gpu');
later(() => browser.close());

const quantile = (values, part) => values.sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(part * values.length))];

async function measure(name, url) {
    // 1280 x 720 of picture.
    const context = await browser.newContext({viewport: {width: 1280, height: 766}});
    const page = await context.newPage();
    await page.goto(url);
    await page.waitForSelector('.dataset');
    await page.click('#show-data');
    await page.click('#show-look');
    await page.evaluate(() => {
        window.pictures = [];
        document.getElementById('stage').addEventListener('picture', (event) => window.pictures.push({at: performance.now(), ...event.detail}));
    });
    const first = await page.evaluate((wanted) => new Promise((resolve) => {
        const begun = performance.now();
        document.getElementById('stage').addEventListener('picture', () => resolve(performance.now() - begun), {once: true});
        document.querySelector(`li[data-name="${wanted}"] .dataset`).click();
    }), dataset);
    await exact(page);
    const shown = await page.evaluate((duration) => new Promise((resolve) => {
        const stage = document.getElementById('stage');
        window.pictures = [];
        const begun = performance.now();
        const turn = () => {
            if (performance.now() - begun > duration) return resolve(window.pictures);
            stage.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft'}));
            requestAnimationFrame(turn);
        };
        turn();
    }), 1000 * seconds);
    const latencies = shown.map((picture) => picture.latency);
    const mean = (of) => shown.reduce((sum, picture) => sum + of(picture), 0) / shown.length;
    const encodings = [...new Set(shown.map((picture) => picture.encoding))].join(', ');
    console.log(`${name}: first picture ${Math.round(first)} ms; ${(shown.length / seconds).toFixed(1)} pictures a second, `
        + `p50 ${Math.round(quantile(latencies, 0.5))} ms, p99 ${Math.round(quantile(latencies, 0.99))} ms; `
        + `server ${mean((picture) => picture.server).toFixed(1)} ms, decoding ${mean((picture) => picture.decode).toFixed(1)} ms, `
        + `${Math.round(mean((picture) => picture.bytes) / 1000)} kB, ${encodings}, ${shown[shown.length - 1].width} x ${shown[shown.length - 1].height}`);
    await context.close();
}

await measure('loopback', link);
const nextLink = () => new URL(lines().filter((line) => line.startsWith('link ')).pop().slice(5));
const thin = nextLink();
thin.port = await thinLine(Number(thin.port), 20e6 / 8, 50);
await measure('20 Mbit/s, 100 ms', thin.href);
await tidy();
process.exit(0);
